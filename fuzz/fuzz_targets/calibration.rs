//! Calibrations and map descriptions of any text.
#![no_main]

use compass_fuzz::file;
use compass_host::Calibration;
use compass_host::plan_import::{PlanOptions, load};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let path = file("text.yaml", data);
    if let Ok(calibration) = Calibration::load(&path) {
        let _ = calibration.rig([Some((640, 480)); 2]);
    }
    let _ = load(&PlanOptions::new(path));
});
