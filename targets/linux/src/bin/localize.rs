//! The results of the firmware of the same name, on the host or on (emulated) ARM Linux: `localize SITE SHOT...`.

use compass_core::locator::Error as LocatorError;
use compass_core::map::site::Site;
use compass_core::vision::shot::Shot;
use compass_golden::Shots;
use std::error::Error;
use std::process::ExitCode;
use std::sync::Mutex;

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("localize: {error}");
            ExitCode::from(2)
        }
    }
}

/// Whether all poses are known.
fn run() -> Result<bool, Box<dyn Error>> {
    static SHOTS: Mutex<Shots> = Mutex::new(Shots::new());
    let mut paths = std::env::args().skip(1);
    let (Some(path), 1..) = (paths.next(), paths.len()) else {
        return Err("usage: localize SITE SHOT...".into());
    };
    let in_file = |path: &str, error: &dyn Error| format!("{path}: {error}");
    let bytes = std::fs::read(&path).map_err(|e| in_file(&path, &e))?;
    let site =
        Site::new(&bytes).and_then(|site| site.verify().map(|()| site)).map_err(|e| in_file(&path, &e))?;
    let mut shots = SHOTS.lock().expect("nobody else holds it");
    let mut known = true;
    for path in paths {
        let bytes = std::fs::read(&path).map_err(|e| in_file(&path, &e))?;
        let shot = Shot::new(&bytes)
            .and_then(|shot| shot.verify().map(|()| shot))
            .map_err(|e| in_file(&path, &e))?;
        println!("shot {path}");
        match shots.locate(&site, &shot, &mut ()) {
            Ok(found) => {
                println!("{found}");
                known &= found.is_known();
            }
            Err(LocatorError::Up) => {
                println!("pose none: {}", LocatorError::Up);
                known = false;
            }
            Err(error) => return Err(in_file(&path, &error).into()),
        }
    }
    Ok(known)
}
