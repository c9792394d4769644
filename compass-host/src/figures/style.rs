//! The common style of all figures: sizes, colours, number formats.
//!
//! A figure is 1600 px wide and meant for a 16 cm text width: 100 px are 1 cm, so the text of 30 px
//! prints at 8.5 points.

use compass_core::base::scan::Hit;
use plotters::style::RGBColor;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};

/// Width of every figure in pixels.
pub const WIDTH_PX: u32 = 1600;

/// Rays that meet a wall (the walls of a plan are black).
pub const WALL: RGBColor = RGBColor(0x4d, 0x4d, 0x4d);
/// Glazing: rays that meet it, and the plan's windows.
pub const WINDOW: RGBColor = RGBColor(0x00, 0x72, 0xb2);
/// Rays that meet nothing.
pub const OPEN: RGBColor = RGBColor(0xf0, 0xa8, 0x20);
/// Bins on whose hit type two descriptors agree.
pub const AGREE: RGBColor = RGBColor(0x00, 0x9e, 0x73);
/// Bins on whose hit type they differ.
pub const DISAGREE: RGBColor = RGBColor(0xc8, 0x10, 0x2e);

/// Bins that were not observed.
pub(super) const UNKNOWN: RGBColor = RGBColor(0xe2, 0xe2, 0xe2);
/// The plan's walls.
pub(super) const PLAN_WALL: RGBColor = RGBColor(0, 0, 0);
/// The robot, and the pose found.
pub(super) const FOUND: RGBColor = RGBColor(0xd8, 0x1b, 0x60);
/// The true pose.
pub(super) const TRUTH: RGBColor = RGBColor(0, 0, 0);
/// Text, frames and ticks.
pub(super) const INK: RGBColor = RGBColor(0x1a, 0x1a, 0x1a);
/// Grid lines.
pub(super) const GRID: RGBColor = RGBColor(0xc8, 0xc8, 0xc8);
/// Candidates without a score, thresholds.
pub(super) const MUTED: RGBColor = RGBColor(0x9a, 0x9a, 0x9a);
/// Paper.
pub(super) const PAPER: RGBColor = RGBColor(0xff, 0xff, 0xff);

/// Em size of captions, legends and axis labels.
pub(super) const TEXT_PX: f64 = 30.0;
/// Em size of the numbers along axes.
pub(super) const TICK_PX: f64 = 26.0;

/// Curve colours, which differ in dash as well (Paul Tol's muted set, without the hit colours).
const SERIES: [(RGBColor, Option<[f64; 2]>); 5] = [
    (RGBColor(0x33, 0x22, 0x88), None),
    (RGBColor(0xcc, 0x55, 0x66), Some([18.0, 9.0])),
    (RGBColor(0x22, 0x88, 0x77), Some([6.0, 7.0])),
    (RGBColor(0x88, 0x88, 0x22), Some([30.0, 9.0])),
    (RGBColor(0xaa, 0x44, 0x99), Some([12.0, 14.0])),
];

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pen {
    pub(super) colour: RGBColor,
    pub(super) width: f64,
    /// Lengths of dash and gap in pixels; `None` for a solid line.
    pub(super) dash: Option<[f64; 2]>,
}

impl Pen {
    /// A solid line.
    pub(super) const fn solid(colour: RGBColor, width: f64) -> Self {
        Self { colour, width, dash: None }
    }

    /// The line of the n-th curve of a figure.
    pub(super) const fn series(n: usize) -> Self {
        let (colour, dash) = SERIES[n % SERIES.len()];
        Self { colour, width: 4.0, dash }
    }
}

/// The hit types in the order in which legends name them.
pub(super) const HITS: [Hit; 3] = [Hit::Wall, Hit::Window, Hit::Open];

/// The fixed colour of a hit type.
pub(super) const fn hit_colour(hit: Hit) -> RGBColor {
    match hit {
        Hit::Wall => WALL,
        Hit::Window => WINDOW,
        Hit::Open => OPEN,
    }
}

/// The name of a hit type.
pub(super) const fn hit_name(hit: Hit) -> &'static str {
    match hit {
        Hit::Wall => "wall",
        Hit::Window => "window",
        Hit::Open => "open",
    }
}

/// The colour on paper that has `strength` (0..=1) of the given one: opaque, so that neighbours
/// may overlap without a seam.
pub(super) fn tint(colour: RGBColor, strength: f64) -> RGBColor {
    let mix = |c: u8| (255.0 - (255.0 - f64::from(c)) * strength).round() as u8;
    RGBColor(mix(colour.0), mix(colour.1), mix(colour.2))
}

/// Viridis at `t` in 0..=1; grey for NaN.
pub(super) fn viridis(t: f64) -> RGBColor {
    if t.is_nan() { MUTED } else { ViridisRGB.get_color(t.clamp(0.0, 1.0)) }
}

/// Multiples of 1, 2 or 5 times a power of ten within `from..=to`, about `count` of them.
pub(super) fn nice_ticks(from: f64, to: f64, count: usize) -> Vec<f64> {
    let step = nice_step((to - from) / count.max(1) as f64);
    let first = (from / step - 1e-9).ceil() as i64;
    let last = (to / step + 1e-9).floor() as i64;
    (first..=last).map(|n| n as f64 * step).collect()
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `raw`; 1 if `raw` is not a positive finite number.
pub(super) fn nice_step(raw: f64) -> f64 {
    if !raw.is_finite() || raw <= 0.0 {
        return 1.0;
    }
    let power = 10f64.powf(raw.log10().floor());
    let mantissa = raw / power;
    let nice = [1.0, 2.0, 5.0].into_iter().find(|&m| m >= mantissa - 1e-9).unwrap_or(10.0);
    nice * power
}

/// A number for display: no trailing zeros, a true minus sign.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text.strip_prefix('-') {
        Some("0") => "0".to_owned(),
        Some(magnitude) => format!("\u{2212}{magnitude}"),
        None => text.to_owned(),
    }
}

/// A score with three decimals and a true minus sign.
pub(super) fn score(value: f64) -> String {
    format!("{value:.3}").replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(nice_ticks(0.0, 10.0, 5), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(nice_ticks(-1.3, 1.3, 3), [-1.0, 0.0, 1.0]);
        assert!(nice_ticks(2.0, 2.0, 5).iter().all(|&t| t == 2.0), "an empty range does not hang");
    }

    #[test]
    fn numbers_are_plain() {
        assert_eq!(number(2.0), "2");
        assert_eq!(number(0.25), "0.25");
        assert_eq!(number(-0.5), "\u{2212}0.5");
        assert_eq!(number(-0.0), "0");
    }
}
