//! Text in a font that is compiled in, so that the output does not depend on installed fonts.
//!
//! plotters' own glyph drawing drops the left side bearing of each letter, so this module places the glyphs.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, PxScaleFont, ScaleFont, point};

use super::error::DrawError;

/// Noto Sans, SIL Open Font License 1.1.
fn font() -> Result<&'static FontRef<'static>, DrawError> {
    static FONT: OnceLock<Option<FontRef<'static>>> = OnceLock::new();
    let font = FONT.get_or_init(|| FontRef::try_from_slice(notosans::REGULAR_TTF).ok());
    font.as_ref().ok_or_else(|| "the compiled-in font is unusable".into())
}

/// The font at this size of the em square in pixels.
fn at_size(em: f64) -> Result<PxScaleFont<&'static FontRef<'static>>, DrawError> {
    let font = font()?;
    let units = font.units_per_em().ok_or("the compiled-in font has no size")?;
    // ab_glyph scales by the line height, which is more than the em square.
    Ok(font.as_scaled(em as f32 * font.height_unscaled() / units))
}

/// The width of a line of text in pixels, for an em square of `em` pixels.
pub(super) fn text_width(text: &str, em: f64) -> Result<f64, DrawError> {
    set(text, em, |_, _, _| ())
}

/// Calls `dot` with each pixel (x right, y down, from the start of the baseline) that the text covers
/// and how much of it (0..=1); returns the width of the text.
pub(super) fn set(text: &str, em: f64, mut dot: impl FnMut(i32, i32, f64)) -> Result<f64, DrawError> {
    let font = at_size(em)?;
    let mut x = 0.0;
    let mut before = None;
    for letter in text.chars() {
        let glyph = font.glyph_id(letter);
        x += before.map_or(0.0, |before| font.kern(before, glyph));
        before = Some(glyph);
        let placed = glyph.with_scale_and_position(font.scale(), point(x, 0.0));
        if let Some(outline) = font.outline_glyph(placed) {
            let corner = outline.px_bounds().min;
            let (left, top) = (corner.x as i32, corner.y as i32);
            outline.draw(|x, y, share| dot(left + x as i32, top + y as i32, f64::from(share)));
        }
        x += font.h_advance(glyph);
    }
    Ok(f64::from(x))
}

/// Breaks a text at spaces into lines of at most `width` pixels; a longer word keeps a line of its own.
pub(super) fn wrap(text: &str, em: f64, width: f64) -> Result<Vec<String>, DrawError> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        if let Some(line) = lines.last_mut() {
            let longer = format!("{line} {word}");
            if text_width(&longer, em)? <= width {
                *line = longer;
                continue;
            }
        }
        lines.push(word.to_owned());
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn font_has_every_letter_the_figures_use() {
        for letter in "azAZ09.,:;()|/°θ\u{2212}_%=+".chars() {
            assert_ne!(font().unwrap().glyph_id(letter).0, 0, "{letter}");
        }
    }

    #[test]
    fn text_has_the_width_of_its_letters() {
        let one = text_width("m", 32.0).unwrap();
        let three = text_width("mmm", 32.0).unwrap();
        assert!(one > 25.0 && (three / one - 3.0).abs() < 0.01, "{one} {three}");
    }

    #[test]
    fn letters_keep_their_side_bearings() {
        let mut columns = Vec::new();
        set("||", 100.0, |x, _, share| columns.extend((share > 0.5).then_some(x))).unwrap();
        columns.sort_unstable();
        columns.dedup();
        let advance = text_width("|", 100.0).unwrap();
        let margin = f64::from(columns[0]);
        assert!(margin > advance / 4.0, "{margin} of {advance}");
    }

    #[test]
    fn wrap_keeps_every_word_within_the_width() {
        let lines = wrap("ten bins of 360 agree on the hit type", 32.0, 250.0).unwrap();
        assert!(lines.len() > 1);
        assert_eq!(lines.join(" "), "ten bins of 360 agree on the hit type");
        assert!(lines.iter().all(|l| text_width(l, 32.0).unwrap() <= 250.0), "{lines:?}");
    }
}
