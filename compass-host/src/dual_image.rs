//! Both lenses in one image, as decoders of Theta and `.insv` files give them.

use crate::calibration::Calibration;
use crate::frame::Frame;

/// How the images of two lenses lie in one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Halves {
    /// cam0 to the left, cam1 to the right.
    LeftRight,
    /// cam0 above, cam1 below.
    TopBottom,
}

impl Halves {
    /// What was done, for a message.
    #[must_use]
    pub const fn note(self) -> &'static str {
        match self {
            Self::LeftRight => {
                "both lenses are in one image: its left half is taken for cam0, its right half for cam1"
            }
            Self::TopBottom => {
                "both lenses are in one image: its upper half is taken for cam0, its lower half for cam1"
            }
        }
    }

    /// How an image of this size is two of the calibrated shape, if it is not one.
    fn of(calibration: &Calibration, (width, height): (u32, u32)) -> Option<Self> {
        let has_shape_of =
            |size: (u32, u32)| calibration.cameras.iter().flatten().any(|camera| camera.has_shape_of(size));
        if has_shape_of((width, height)) {
            None
        } else if width % 2 == 0 && has_shape_of((width / 2, height)) {
            Some(Self::LeftRight)
        } else if height % 2 == 0 && has_shape_of((width, height / 2)) {
            Some(Self::TopBottom)
        } else {
            None
        }
    }

    /// The half of a camera.
    fn half(self, frame: &Frame, camera: usize) -> Frame {
        let (width, height) = (frame.width(), frame.height());
        let second = u32::from(camera == 1);
        match self {
            Self::LeftRight => frame.cropped([second * (width / 2), 0], [width / 2, height]),
            Self::TopBottom => frame.cropped([0, second * (height / 2)], [width, height / 2]),
        }
    }
}

/// Takes the halves of images that show both lenses: each camera its own, and the other camera the other one where it
/// has no image and the calibration places it.
#[must_use]
pub fn split(calibration: &Calibration, frames: [Option<Frame>; 2]) -> ([Option<Frame>; 2], Option<Halves>) {
    let halves = frames.each_ref().map(|frame| {
        let frame = frame.as_ref()?;
        Halves::of(calibration, (frame.width(), frame.height()))
    });
    let found = halves[0].or(halves[1]);
    let other = |camera: usize| {
        let (frame, halves) = (frames[1 - camera].as_ref()?, halves[1 - camera]?);
        (frames[camera].is_none() && calibration.places_both()).then(|| halves.half(frame, camera))
    };
    let others = [other(0), other(1)];
    let [first, second] = frames;
    let own = |camera: usize, frame: Option<Frame>| match (frame, halves[camera]) {
        (Some(frame), Some(halves)) => Some(halves.half(&frame, camera)),
        (frame, _) => frame,
    };
    let [first_other, second_other] = others;
    ([own(0, first).or(first_other), own(1, second).or(second_other)], found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{Rgb, RgbImage};

    /// A frame whose halves have the gray levels 0 and 255.
    fn frame(width: u32, height: u32, is_second: impl Fn(u32, u32) -> bool) -> Frame {
        let colour = |x, y| Rgb([if is_second(x, y) { 255 } else { 0 }; 3]);
        Frame::from_rgb(RgbImage::from_fn(width, height, colour)).unwrap()
    }

    fn only_gray(frame: Option<&Frame>) -> Option<((u32, u32), u8)> {
        let frame = frame?;
        let gray = frame.gray().pixels().to_vec();
        assert!(gray.iter().all(|value| *value == gray[0]));
        Some(((frame.width(), frame.height()), gray[0]))
    }

    #[test]
    fn halves_are_taken_by_their_shape() {
        // Calibrated for 736 x 720 pixels.
        let calibration = Calibration::nominal();
        let wide = || frame(368, 180, |x, _| x >= 184);
        let tall = || frame(184, 360, |_, y| y >= 180);
        let front = Some(((184, 180), 0));
        let back = Some(((184, 180), 255));
        for (frames, expected) in [
            ([Some(wide()), Some(wide())], Some(Halves::LeftRight)),
            ([Some(wide()), None], Some(Halves::LeftRight)),
            ([None, Some(wide())], Some(Halves::LeftRight)),
            ([Some(tall()), None], Some(Halves::TopBottom)),
        ] {
            let (frames, found) = split(&calibration, frames);
            assert_eq!(found, expected);
            assert_eq!(frames.each_ref().map(|frame| only_gray(frame.as_ref())), [front, back]);
        }
        let single = frame(184, 180, |_, _| false);
        let (frames, found) = split(&calibration, [Some(single), None]);
        assert_eq!((found, frames.map(|frame| frame.is_some())), (None, [true, false]));
    }
}
