//! Drawing of scans, descriptors and scores on any `embedded-graphics` display (feature `draw`).
//!
//! Drawings are clipped to the given area. The caller gives the colours, so that monochrome and colour displays are
//! supported alike.

use crate::base::num::{BINS, ChannelValue, Score, Turn};
use crate::base::scan::{Hit, MAX_STEPS, Scan};
use crate::descriptor::Descriptor;
use embedded_graphics::Drawable as _;
use embedded_graphics::Pixel;
use embedded_graphics::draw_target::{DrawTarget, DrawTargetExt as _};
use embedded_graphics::geometry::{Point, Size};
use embedded_graphics::pixelcolor::PixelColor;
use embedded_graphics::primitives::{Line, Primitive as _, PrimitiveStyle, Rectangle};

/// One colour per hit type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HitColors<C> {
    /// Colour of walls.
    pub wall: C,
    /// Colour of windows.
    pub window: C,
    /// Colour of open bins.
    pub open: C,
}

impl<C: PixelColor> HitColors<C> {
    const fn of(&self, hit: Hit) -> C {
        match hit {
            Hit::Wall => self.wall,
            Hit::Window => self.window,
            Hit::Open => self.open,
        }
    }
}

/// Draws a scan as a top view: the robot in the middle of `area`, its heading up, one pixel per bin.
///
/// `full_scale` is the range in march steps of 0.02 m at the border of the area; hits beyond it are not drawn.
///
/// # Errors
/// The error of the display.
#[expect(clippy::cast_possible_truncation, reason = "at most the radius of the area")]
pub fn scan<D: DrawTarget>(
    display: &mut D,
    area: Rectangle,
    scan: &Scan,
    full_scale: u16,
    colors: &HitColors<D::Color>,
) -> Result<(), D::Error> {
    let radius = i64::from(area.size.width.min(area.size.height) / 2);
    let centre = area.center();
    let full_scale = i64::from(full_scale.clamp(1, MAX_STEPS));
    let pixels = scan.steps.iter().zip(&scan.hit).enumerate().filter_map(|(bin, (&steps, &hit))| {
        if i64::from(steps) > full_scale {
            return None;
        }
        let (cos, sin) = Turn::from_bin(bin).cos_sin();
        let along = |unit: i32| (((i64::from(steps) * radius / full_scale) * i64::from(unit)) >> 30) as i32;
        // Heading up, counter-clockwise to the left.
        let at = centre + Point::new(-along(sin.to_bits()), -along(cos.to_bits()));
        Some(Pixel(at, colors.of(hit)))
    });
    display.clipped(&area).draw_iter(pixels)
}

/// Draws the five channels of a descriptor as bar charts in rows, bin 0 at the left, 1.0 at full height.
///
/// # Errors
/// The error of the display.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "rows lie within the area, whose size fits 32 bits with sign"
)]
pub fn descriptor<D: DrawTarget>(
    display: &mut D,
    area: Rectangle,
    descriptor: &Descriptor,
    color: D::Color,
) -> Result<(), D::Error> {
    let height = area.size.height / descriptor.levels.len() as u32;
    for (row, channel) in (0..).zip(&descriptor.levels) {
        let top_left = area.top_left + Point::new(0, (row * height) as i32);
        let chart = Rectangle::new(top_left, Size::new(area.size.width, height));
        // One pixel row is left free between two charts.
        let bar =
            |level: ChannelValue| (i64::from(height.saturating_sub(1)) * i64::from(level.to_bits())) >> 14;
        bars(display, chart, |bin| channel.get(bin).map_or(0, |&level| bar(level)), color)?;
    }
    Ok(())
}

/// Draws the scores of 360 headings as a bar chart, heading 0 at the left, 1.0 at full height. Scores of 0 and less have
/// no bar.
///
/// # Errors
/// The error of the display.
pub fn scores<D: DrawTarget>(
    display: &mut D,
    area: Rectangle,
    scores: &[Score; BINS],
    color: D::Color,
) -> Result<(), D::Error> {
    let bar = |score: Score| (i64::from(area.size.height) * i64::from(score.to_bits().max(0))) >> 30;
    bars(display, area, |bin| scores.get(bin).map_or(0, |&score| bar(score)), color)
}

/// Draws one bar per pixel column: the highest of the bins in the column.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "bars lie within twice the area, whose size fits 32 bits with sign"
)]
fn bars<D: DrawTarget>(
    display: &mut D,
    area: Rectangle,
    bar: impl Fn(usize) -> i64,
    color: D::Color,
) -> Result<(), D::Error> {
    let width = area.size.width as usize;
    let mut clipped = display.clipped(&area.intersection(&display.bounding_box()));
    for column in 0..width {
        let (from, to) = (column * BINS / width, ((column + 1) * BINS).div_ceil(width));
        let height = (from..to.max(from + 1)).map(&bar).max().unwrap_or(0) as i32;
        if height > 0 {
            let foot = area.top_left + Point::new(column as i32, area.size.height as i32 - 1);
            let line = Line::new(foot, foot - Point::new(0, height - 1));
            line.into_styled(PrimitiveStyle::with_stroke(color, 1)).draw(&mut clipped)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_graphics::mock_display::MockDisplay;
    use embedded_graphics::pixelcolor::BinaryColor;

    fn display() -> MockDisplay<BinaryColor> {
        let mut display = MockDisplay::new();
        display.set_allow_overdraw(true);
        display
    }

    #[test]
    fn a_wall_ahead_is_drawn_above_the_middle() {
        let mut some = Scan::OPEN;
        (some.steps[0], some.hit[0]) = (50, Hit::Wall);
        (some.steps[90], some.hit[90]) = (100, Hit::Window);
        let colors = HitColors { wall: BinaryColor::On, window: BinaryColor::Off, open: BinaryColor::On };
        let mut display = display();
        scan(&mut display, Rectangle::new(Point::zero(), Size::new(9, 9)), &some, 100, &colors).unwrap();
        display.assert_pattern(&["         ", "         ", "    #    ", "         ", ".        "]);
    }

    #[test]
    fn scores_are_drawn_as_bars() {
        let mut some = [Score::ZERO; BINS];
        some[0..90].fill(Score::ONE);
        some[180..270].fill(Score::ONE / 2);
        some[270..].fill(-Score::ONE);
        let mut display = display();
        scores(&mut display, Rectangle::new(Point::zero(), Size::new(4, 4)), &some, BinaryColor::On).unwrap();
        display.assert_pattern(&["#   ", "#   ", "# # ", "# # "]);
    }

    #[test]
    fn descriptors_are_drawn_in_five_rows() {
        let mut display = display();
        let area = Rectangle::new(Point::zero(), Size::new(6, 20));
        descriptor(&mut display, area, &Descriptor::from(&Scan::OPEN), BinaryColor::On).unwrap();
        // All open: range is full, the rest is empty or nearly so.
        assert_eq!(display.affected_area(), Rectangle::new(Point::new(0, 1), Size::new(6, 3)));
    }
}
