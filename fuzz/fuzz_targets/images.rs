//! Images of any bytes, as frames and as plans.
#![no_main]

use compass_host::image_file::decode;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(pixels) = decode(data, 1 << 20) {
        assert!(u64::from(pixels.width) * u64::from(pixels.height) <= 1 << 20);
    }
});
