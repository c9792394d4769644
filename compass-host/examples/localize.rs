//! Finds where in a building a pair of fisheye frames was taken.
//!
//! ```text
//! cargo run --release -p compass-host --example localize -- SITE CALIBRATION CAM0 CAM1
//! ```
//!
//! SITE is what `compass map build` writes, CALIBRATION a Kalibr camera chain, CAM0 and CAM1 are images of the two
//! cameras at one moment. Prints the poses that explain the frames best, the likeliest first.

use compass_host::{Calibration, Frame, HeightPrior, Locator, Mount, Settings, SiteFile, localize};
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
    let rig = Calibration::load(calibration)?.rig(sizes)?;

    // A locator holds all memory: a program that localizes many frames makes it once.
    let site = SiteFile::read(site)?;
    let mut locator = Locator::new(&site.floors(), rig, Settings::FULL)?;
    let fix = localize(&mut locator, frames.each_ref().map(Some), Mount::Auto, HeightPrior::UNKNOWN)?;

    println!("probability that the first pose is within 1 m: {:.2}", fix.probability());
    for pose in fix.poses() {
        let layer = locator.layers().get(usize::from(pose.layer));
        println!(
            "floor {}  x {:.2} m  y {:.2} m  heading {:.1} degrees  {:.1} nats",
            layer.map_or("unknown", |layer| layer.name),
            pose.at.x,
            pose.at.y,
            f64::from(pose.heading.to_microdegrees()) / 1e6,
            pose.score,
        );
    }
    Ok(())
}
