//! A drawing surface in final pixels: plotters' bitmap backend at twice the size, then halved, so
//! that every edge is smooth and positions may be fractions of a pixel.

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::error::{DrawError, Drawn};
use super::style::{INK, PAPER, Pen, TEXT_PX};
use super::text::{set, text_width};

/// Samples per pixel and axis.
const SUPER: u32 = 2;

/// Heights of the font above and below the baseline, in em: capitals, the tallest letters, descenders.
const CAPITAL: f64 = 0.714;
const ASCENT: f64 = 0.8;
const DESCENT: f64 = 0.24;

/// A point in pixels: x right, y down.
pub(super) type Px = [f64; 2];

/// A rectangle in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rect {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Rect {
    pub(super) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(super) fn height(&self) -> f64 {
        self.bottom - self.top
    }

    pub(super) fn centre(&self) -> Px {
        [(self.left + self.right) / 2.0, (self.top + self.bottom) / 2.0]
    }

    /// The rectangle with this much taken off each side.
    pub(super) fn inset(&self, left: f64, top: f64, right: f64, bottom: f64) -> Self {
        Self {
            left: self.left + left,
            top: self.top + top,
            right: self.right - right,
            bottom: self.bottom - bottom,
        }
    }
}

/// Horizontal, then vertical alignment of a text at its position.
pub(super) type Anchor = (HPos, VPos);
/// Text to the right of its position.
pub(super) const LEFT: Anchor = (HPos::Left, VPos::Center);
/// Text to the left of its position.
pub(super) const RIGHT: Anchor = (HPos::Right, VPos::Center);
/// Text around its position.
pub(super) const CENTRE: Anchor = (HPos::Center, VPos::Center);

/// A picture under way.
pub(super) struct Canvas<'a> {
    area: DrawingArea<BitMapBackend<'a>, Shift>,
}

impl Canvas<'_> {
    /// A line through all points.
    pub(super) fn line(&self, points: &[Px], pen: Pen) -> Drawn {
        if points.len() < 2 {
            return Ok(());
        }
        let style = pen.colour.stroke_width(scaled(pen.width).max(1) as u32);
        let points = points.iter().map(sample);
        match pen.dash {
            None => self.area.draw(&PathElement::new(points.collect::<Vec<_>>(), style))?,
            Some([dash, gap]) => {
                self.area.draw(&DashedPathElement::new(points, scaled(dash), scaled(gap), style))?;
            }
        }
        Ok(())
    }

    /// A filled polygon.
    pub(super) fn polygon(&self, points: &[Px], colour: RGBColor) -> Drawn {
        let points: Vec<_> = points.iter().map(sample).collect();
        Ok(self.area.draw(&Polygon::new(points, colour.filled()))?)
    }

    /// A filled rectangle.
    pub(super) fn fill(&self, rect: Rect, colour: RGBColor) -> Drawn {
        let [left, top] = [scaled(rect.left), scaled(rect.top)];
        let [right, bottom] = [scaled(rect.right), scaled(rect.bottom)];
        if right <= left || bottom <= top {
            return Ok(());
        }
        // The bitmap backend omits the last column and row of a filled rectangle.
        Ok(self.area.draw(&Rectangle::new([(left, top), (right, bottom)], colour.filled()))?)
    }

    /// The outline of a rectangle.
    pub(super) fn outline(&self, rect: Rect, pen: Pen) -> Drawn {
        let Rect { left, top, right, bottom } = rect;
        let half = pen.width / 2.0;
        for edge in [[[left, top], [right, top]], [[left, bottom], [right, bottom]]] {
            self.line(&edge.map(|[x, y]| [if x == left { x - half } else { x + half }, y]), pen)?;
        }
        self.line(&[[left, top], [left, bottom]], pen)?;
        self.line(&[[right, top], [right, bottom]], pen)
    }

    /// A filled disc.
    pub(super) fn disc(&self, centre: Px, radius: f64, colour: RGBColor) -> Drawn {
        Ok(self.area.draw(&Circle::new(sample(&centre), scaled(radius), colour.filled()))?)
    }

    /// A circle: a disc with paper inside.
    pub(super) fn ring(&self, centre: Px, radius: f64, width: f64, colour: RGBColor) -> Drawn {
        self.disc(centre, radius, colour)?;
        self.disc(centre, radius - width, PAPER)
    }

    /// One line of text.
    pub(super) fn text(&self, at: Px, em: f64, (horizontal, vertical): Anchor, text: &str) -> Drawn {
        let width = text_width(text, em)?;
        let left = match horizontal {
            HPos::Left => 0.0,
            HPos::Center => -width / 2.0,
            HPos::Right => -width,
        };
        let baseline = match vertical {
            VPos::Top => ASCENT * em,
            VPos::Center => CAPITAL / 2.0 * em,
            VPos::Bottom => -DESCENT * em,
        };
        let (x, y) = sample(&[at[0] + left, at[1] + baseline]);
        self.glyphs(em, text, |right, down| (x + right, y + down))
    }

    /// One line of text that reads upwards, centred on its position.
    pub(super) fn upright_text(&self, [x, y]: Px, text: &str) -> Drawn {
        let width = text_width(text, TEXT_PX)?;
        let (x, y) = sample(&[x + CAPITAL / 2.0 * TEXT_PX, y + width / 2.0]);
        self.glyphs(TEXT_PX, text, |right, down| (x + down, y - right))
    }

    /// Draws glyphs, each of their samples moved by `place`.
    fn glyphs(&self, em: f64, text: &str, place: impl Fn(i32, i32) -> (i32, i32)) -> Drawn {
        let mut drawn = Ok(());
        set(text, em * f64::from(SUPER), |right, down, share| {
            if drawn.is_ok() {
                drawn = self.area.draw_pixel(place(right, down), &INK.mix(share.min(1.0)));
            }
        })?;
        Ok(drawn?)
    }

    /// Paints each sample of a rectangle by its position: `ink` gets the sample's square.
    pub(super) fn paint(&self, rect: Rect, ink: impl Fn(Rect) -> Option<RGBColor>) -> Drawn {
        let edge = |sample: i32| f64::from(sample) / f64::from(SUPER);
        for y in scaled(rect.top)..scaled(rect.bottom) {
            for x in scaled(rect.left)..scaled(rect.right) {
                let square = Rect { left: edge(x), top: edge(y), right: edge(x + 1), bottom: edge(y + 1) };
                if let Some(colour) = ink(square) {
                    self.area.draw_pixel((x, y), &colour)?;
                }
            }
        }
        Ok(())
    }
}

/// Draws a picture of the given size and returns it as a PNG file.
pub(super) fn to_png(
    width: u32,
    height: u32,
    draw: impl FnOnce(&Canvas<'_>) -> Drawn,
) -> Result<Vec<u8>, DrawError> {
    let mut samples = vec![255; (width * SUPER) as usize * (height * SUPER) as usize * 3];
    {
        let backend = BitMapBackend::with_buffer(&mut samples, (width * SUPER, height * SUPER));
        let canvas = Canvas { area: backend.into_drawing_area() };
        draw(&canvas)?;
        canvas.area.present()?;
    }
    let pixels = halve(&samples, width as usize);
    let mut png = Vec::new();
    PngEncoder::new(&mut png).write_image(&pixels, width, height, ExtendedColorType::Rgb8)?;
    Ok(png)
}

/// Pixels to samples, rounded.
fn scaled(px: f64) -> i32 {
    (px * f64::from(SUPER)).round() as i32
}

fn sample(&[x, y]: &Px) -> (i32, i32) {
    (scaled(x), scaled(y))
}

/// The mean of each square of samples.
fn halve(samples: &[u8], width: usize) -> Vec<u8> {
    let side = SUPER as usize;
    let row = width * side * 3;
    let mut pixels = Vec::with_capacity(samples.len() / (side * side));
    for rows in samples.chunks_exact(row * side) {
        for x in 0..width {
            for channel in 0..3 {
                let values = (0..side * side)
                    .map(|n| u32::from(rows[(n / side) * row + (x * side + n % side) * 3 + channel]));
                pixels.push((values.sum::<u32>() / (SUPER * SUPER)) as u8);
            }
        }
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halve_takes_the_mean_of_each_square() {
        let samples = [0, 10, 20, 4, 14, 24, 8, 18, 28, 4, 14, 24];
        assert_eq!(halve(&samples, 1), [4, 14, 24]);
    }
}
