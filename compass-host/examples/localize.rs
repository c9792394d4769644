//! Finds where in a building a pair of fisheye frames was taken.
//!
//! ```text
//! cargo run --release -p compass-host --example localize -- SITE CALIBRATION CAM0 CAM1
//! ```
//!
//! SITE is what `compass map build` writes, CALIBRATION a Kalibr camera chain, CAM0 and CAM1 are images of the two
//! cameras at one moment. Prints the poses that explain the frames best, the likeliest first.

use compass_host::{Calibration, Eyes, Frame, Locator, Mount, SiteFile, localize};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [site, calibration, cam0, cam1] = &paths[..] else {
        return Err("usage: localize SITE CALIBRATION CAM0 CAM1".into());
    };

    // The rig is made for the sizes of the frames: the calibration scales to them.
    let frames = [Frame::read(cam0)?, Frame::read(cam1)?];
    let sizes = frames.each_ref().map(|frame| Some((frame.width(), frame.height())));
    let mut eyes = Eyes::new(Calibration::load(calibration)?.rig(sizes)?);

    // Eyes and locator hold all buffers: a program that localizes many frames makes them once.
    let site = SiteFile::read(site)?;
    let floors = site.floors();
    let mut locator = Locator::new(&floors)?;
    let fix = localize(&mut locator, &mut eyes, frames.each_ref().map(Some), Mount::Auto, None)?;

    println!("probability that the first pose is within 1 m: {:.2}", fix.probability());
    for pose in fix.answer.modes() {
        let layer = locator.layers().get(usize::from(pose.layer));
        let floor = layer.and_then(|layer| floors.get(usize::from(layer.floor)));
        println!(
            "floor {}  x {:.2} m  y {:.2} m  heading {:.1} degrees  {:.1} nats",
            floor.and_then(|floor| floor.name()).unwrap_or("unnamed"),
            pose.at.x,
            pose.at.y,
            f64::from(pose.heading.to_microdegrees()) / 1e6,
            f64::from(pose.score) / 16.0,
        );
    }
    Ok(())
}
