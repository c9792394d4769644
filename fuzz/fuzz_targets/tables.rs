//! Trajectories and readings of any text.
#![no_main]

use compass_fuzz::file;
use compass_host::dataset::imu::Readings;
use compass_host::dataset::trajectory::Trajectory;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let path = file("table.csv", data);
    if let Ok(trajectory) = Trajectory::read(&path) {
        let _ = (trajectory.at(1_000_000_000), trajectory.span());
    }
    if let Ok(readings) = Readings::read(&path) {
        let _ = readings.gravity(None);
    }
});
