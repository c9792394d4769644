//! Why frames leave no pose that is sure, in words for a person.

use crate::frame::Frame;
use crate::site_file::SiteFloor;
use compass_core::Fix;
use compass_core::pose::probability_of;
use std::fmt::Write as _;

/// Median gray level below which a frame is dark.
const DARK: u8 = 20;
/// Median gray level above which a frame is overexposed.
const BRIGHT: u8 = 235;
/// Difference of pixels two apart, gray levels, that a hundredth of them reach in a frame with detail.
///
/// The least of 155 real, rendered and simulated frames is 9; a real one blurred with a deviation of 8 pixels of 1472 has 7.
const DETAIL: u8 = 8;
/// Distance of candidates, millimetres, above which a map is coarse.
const COARSE_MM: u32 = 1000;
/// Every which row is looked at.
const STRIDE: usize = 4;

/// What is wrong with frames that show little: dark, overexposed, or without detail. `None` if nothing is.
///
/// The black border outside the image circle does not count.
#[must_use]
pub fn of_frames(frames: [Option<&Frame>; 2]) -> Option<String> {
    let mut text = String::new();
    for (number, frame) in frames.into_iter().enumerate() {
        if let Some(fault) = frame.and_then(fault) {
            let _ =
                write!(text, "{}the frame of cam{number} {fault}", if text.is_empty() { "" } else { ", " });
        }
    }
    (!text.is_empty()).then_some(text)
}

/// What is wrong with a frame.
fn fault(frame: &Frame) -> Option<String> {
    let (mut levels, mut differences) = ([0_usize; 256], [0_usize; 256]);
    let gray = frame.gray();
    for row in (0..frame.height() as usize).step_by(STRIDE).map(|y| gray.row(y)) {
        let seen = row.iter().zip(row.iter().skip(2)).filter(|(a, b)| **a > 0 || **b > 0);
        for (a, b) in seen {
            levels[usize::from(*a)] += 1;
            differences[usize::from(a.abs_diff(*b))] += 1;
        }
    }
    let median = percentile(&levels, 50);
    let detail = percentile(&differences, 99);
    match median {
        None => Some("is black".to_owned()),
        Some(median) if median < DARK => Some(format!("is dark (median gray level {median} of 255)")),
        Some(median) if median > BRIGHT => {
            Some(format!("is overexposed (median gray level {median} of 255)"))
        }
        _ => {
            (detail? < DETAIL).then(|| "shows no detail (blurred, or nothing but a blank surface)".to_owned())
        }
    }
}

/// The level below which a share of a histogram lies; `None` of an empty one.
fn percentile(counts: &[usize; 256], percent: usize) -> Option<u8> {
    let whole: usize = counts.iter().sum();
    let mut below = 0;
    let level = counts.iter().position(|count| {
        below += count;
        below * 100 > whole * percent
    })?;
    u8::try_from(level).ok()
}

/// What is wrong with the maps of a site: candidates so far apart that the search may pass over the place between them.
///
/// Found within 1 m by spacing: `docs/measured.md`, "Spacing of the candidates".
#[must_use]
pub fn of_maps(floors: &[SiteFloor<'_>]) -> Option<String> {
    let widest = floors.iter().map(|floor| floor.map.header().spacing_mm).max()?;
    (widest > COARSE_MM).then(|| {
        let metres = f64::from(widest) / 1000.0;
        format!("the candidates of the map are {metres} m apart, and places between them may be missed: build it with --spacing 0.5")
    })
}

/// A reason with what else is wrong.
#[must_use]
pub fn with_fault(reason: String, fault: Option<String>) -> String {
    match fault {
        Some(fault) => format!("{reason}; {fault}"),
        None => reason,
    }
}

/// Why the likeliest pose does not reach a probability.
#[must_use]
pub fn of_fix(fix: &Fix<'_>, least_probability: f64) -> String {
    let Some(best) = fix.best() else {
        return if fix.prior().is_unknown() {
            "the frames show nothing that a plan could explain".to_owned()
        } else {
            "nothing explains the frames where the pose is said to be".to_owned()
        };
    };
    let margin = fix.margin();
    // Without any alternative the margin would be the score.
    if f64::from(probability_of(best.score, best.score)) < least_probability {
        let score: f64 = best.score.to_num();
        return format!(
            "no place of the plan explains much of what the frames show (at best {score:.0} nats): another building, a plan \
             that is out of date, or the walls are hidden"
        );
    }
    let lead: f64 = margin.to_num();
    if fix.rival().is_some_and(|rival| best.score.saturating_sub(rival) <= margin) {
        return format!(
            "with another side up the frames fit another place nearly as well ({lead:.0} nats less): tell --mount or --up"
        );
    }
    let Some(second) = fix.poses().get(1) else {
        return "the likeliest pose is not likely enough".to_owned();
    };
    format!(
        "another place explains the frames nearly as well ({lead:.0} nats less): x {:.2} m, y {:.2} m, heading {:.0} degrees",
        second.at.x.to_num::<f64>(),
        second.at.y.to_num::<f64>(),
        f64::from(second.heading.to_microdegrees()) / 1e6
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{Rgb, RgbImage};

    fn frame(level: impl Fn(u32, u32) -> u8) -> Frame {
        Frame::from_rgb(RgbImage::from_fn(64, 64, |x, y| Rgb([level(x, y); 3]))).unwrap()
    }

    #[test]
    fn faults_are_named_and_good_frames_pass() {
        let stripes = frame(|x, _| if x % 8 < 4 { 60 } else { 180 });
        assert_eq!(of_frames([Some(&stripes), None]), None);
        let dark = frame(|x, _| if x % 8 < 4 { 2 } else { 8 });
        assert!(
            of_frames([Some(&stripes), Some(&dark)])
                .unwrap()
                .starts_with("the frame of cam1 is dark (median")
        );
        let [black, blank, bright] = [0, 120, 250].map(|level| frame(|_, _| level));
        let text = of_frames([Some(&black), Some(&blank)]).unwrap();
        assert!(text.contains("cam0 is black, the frame of cam1 shows no detail"), "{text}");
        assert!(of_frames([Some(&bright), None]).unwrap().contains("overexposed"));
        // A border does not count.
        let bordered = frame(|x, y| {
            if y < 40 {
                0
            } else if x % 8 < 4 {
                60
            } else {
                180
            }
        });
        assert_eq!(of_frames([Some(&bordered), None]), None);
    }
}
