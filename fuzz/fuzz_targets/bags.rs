//! Files of bags of any bytes.
#![no_main]

use compass_fuzz::file;
use compass_host::calibration::Calibration;
use compass_host::dataset::recording::Recording;
use compass_host::input::{Limits, set_limits};
use libfuzzer_sys::fuzz_target;
use std::sync::Once;

fuzz_target!(|data: &[u8]| {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let mut limits = Limits::DEFAULT;
        (limits.message_bytes, limits.unpacked_bytes, limits.frame_pixels) = (1 << 20, 1 << 20, 1 << 20);
        set_limits(limits);
    });
    let path = file("bag", data);
    if let Ok(recording) = Recording::read(&path, None, &Calibration::nominal()) {
        for shot in recording.shots.iter().take(4) {
            shot.images.iter().flatten().for_each(|image| drop(image.read()));
        }
    }
});
