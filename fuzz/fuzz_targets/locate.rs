//! The search on a damaged site.
#![no_main]

use compass_core::vision::shot::Shot;
use compass_core::{Frame, HeightPrior, Locator, Prior, Settings, Site, UpHint};
use compass_fuzz::{SIZE, edited, sealed, shot, site};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let site = sealed(edited(site(), data));
    let packed = shot();
    let (Ok(site), Ok(shot)) = (Site::new(&site), Shot::new(&packed)) else { return };
    let [width, height] = SIZE;
    let mut memory = vec![0; Settings::BOARD.memory_words(width, height)];
    let Ok(mut locator) = Locator::<'_, _>::new(&site, shot.header().rig, Settings::BOARD, &mut memory[..])
    else {
        return;
    };
    let frames = shot.images().map(|image| image.map(|(gray, _)| Frame::from(gray)));
    let prior = Prior::new(UpHint::Up(shot.header().up), HeightPrior::camera(1.5));
    if let Ok(fix) = locator.locate(&frames, &prior) {
        assert!((0.0..=1.0).contains(&fix.probability()));
    }
});
