//! Frames of any pixels, with any prior.
#![no_main]

use compass_core::{Bearing, Frame, GrayImage, HeightPrior, Locator, Prior, Settings, Site, UpHint};
use compass_fuzz::{SIZE, rig, site};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Some((numbers, pixels)) = data.split_first_chunk::<17>() else { return };
    let number =
        |at: usize| f32::from_le_bytes([numbers[at], numbers[at + 1], numbers[at + 2], numbers[at + 3]]);
    let up = Bearing::new(number(0), number(4), number(8));
    let Some(length) = (!pixels.is_empty()).then_some(pixels.len()) else { return };
    let [width, height] = SIZE.map(u32::from);
    let frame = |start: usize| -> Vec<u8> {
        (0..(width * height) as usize).map(|at| pixels[(start + at) % length]).collect()
    };
    let (front, back) = (frame(0), frame(length / 2));
    let site = Site::new(site()).expect("the sample");
    let mut memory = vec![0; Settings::BOARD.memory_words(SIZE[0], SIZE[1])];
    let Ok(mut locator) = Locator::<'_, _>::new(&site, rig(), Settings::BOARD, &mut memory[..]) else {
        return;
    };
    let heights = if numbers[16] & 1 == 0 { HeightPrior::UNKNOWN } else { HeightPrior::camera(number(12)) };
    let up = if numbers[16] & 2 == 0 { UpHint::Up(up) } else { UpHint::Axis(up) };
    let gray = |pixels| GrayImage::new(pixels, width, height).ok().map(Frame::from);
    if let Ok(fix) = locator.locate(&[gray(&front), gray(&back)], &Prior::new(up, heights)) {
        assert!((0.0..=1.0).contains(&fix.probability()));
    }
});
