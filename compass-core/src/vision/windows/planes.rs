//! The two planes of the cues: brightness as rank within the frame, and texture.

use super::tuning::{BAND_DEG, GLARE, LEAST_TEXTURE, TEXTURE_PERCENT};
use crate::vision::panorama::Resolution;

/// Replaces the gray levels of a panorama by their ranks in the frame, 1 (darkest) to 255, and 0 where unknown; fills
/// `texture` with the vertical gradient scaled to 0 to 255 (255: the 90th percentile of the frame, or over-exposed).
#[inline(always)]
#[expect(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    reason = "bytes index 256 entries, and shares are clamped to 255"
)]
pub(super) fn normalize(gray: &mut [u8], texture: &mut [u8], resolution: Resolution) {
    let rows = resolution.rows();
    erode(gray, texture, rows);
    vertical_gradient(gray, texture, rows);
    let band = band(resolution);
    let mut levels = [0_u32; 256];
    let mut gradients = [0_u32; 256];
    for (gray, texture) in gray.chunks_exact(rows).zip(texture.chunks_exact(rows)) {
        let known =
            gray.get(band.clone()).unwrap_or(&[]).iter().zip(texture.get(band.clone()).unwrap_or(&[]));
        for (level, gradient) in known.filter(|(level, _)| **level > 0) {
            levels[usize::from(*level)] += 1;
            gradients[usize::from(*gradient)] += 1;
        }
    }
    let ranks = ranks(&levels);
    let full = percentile(&gradients).max(LEAST_TEXTURE);
    let shares: [u8; 256] = core::array::from_fn(|gradient| (255 * gradient / full).min(255) as u8);
    for (level, texture) in gray.iter_mut().zip(texture) {
        *texture = if *level >= GLARE { 255 } else { shares[usize::from(*texture)] };
        *level = ranks[usize::from(*level)];
    }
}

/// Rows that ranks and the texture scale are computed from.
fn band(resolution: Resolution) -> core::ops::Range<usize> {
    resolution.row_of(BAND_DEG)..resolution.row_of(-BAND_DEG)
}

/// Erodes the known cells by one: cells beside excluded pixels may be partly red. `lost` is scratch.
///
/// Words of cells without an unknown one are skipped.
fn erode(gray: &mut [u8], lost: &mut [u8], rows: usize) {
    lost.fill(0);
    let cells = gray.len();
    let unknown = words(gray).filter(|(_, word)| word.contains(&0)).flat_map(|(start, word)| {
        let at = move |(offset, level): (usize, &u8)| (*level == 0).then_some(start + offset);
        word.iter().enumerate().filter_map(at)
    });
    for at in unknown {
        let row = at % rows.max(1);
        let above = if row > 0 { at - 1 } else { at };
        let below = if row + 1 < rows { at + 1 } else { at };
        let left = if at >= rows { at - rows } else { at + cells - rows };
        let right = if at + rows < cells { at + rows } else { at + rows - cells };
        for beside in [at, above, below, left, right] {
            if let Some(lost) = lost.get_mut(beside) {
                *lost = 1;
            }
        }
    }
    for (start, word) in words(lost).filter(|(_, word)| word.iter().any(|lost| *lost != 0)) {
        for (level, lost) in gray.iter_mut().skip(start).zip(word) {
            *level = if *lost == 0 { *level } else { 0 };
        }
    }
}

/// Cells tested together.
const WORD: usize = 8;

/// Cells in words, each with the index of its first cell; the last may be shorter.
fn words(cells: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    cells.chunks(WORD).enumerate().map(|(word, cells)| (word * WORD, cells))
}

/// |level above - level below|; 0 where one of the three cells is unknown.
#[inline(always)]
fn vertical_gradient(gray: &[u8], texture: &mut [u8], rows: usize) {
    for (gray, texture) in gray.chunks_exact(rows).zip(texture.chunks_exact_mut(rows)) {
        texture.fill(0);
        let triples = gray.iter().zip(gray.iter().skip(1)).zip(gray.iter().skip(2));
        for (out, ((above, here), below)) in texture.iter_mut().skip(1).zip(triples) {
            let known = *above != 0 && *here != 0 && *below != 0;
            *out = if known { above.abs_diff(*below) } else { 0 };
        }
    }
}

/// The mid-rank of every gray level in the histogram, 1 to 255; level 0 has rank 0.
#[expect(clippy::cast_possible_truncation, reason = "ranks are at most 255")]
fn ranks(counts: &[u32; 256]) -> [u8; 256] {
    let twice = (2 * counts.iter().sum::<u32>()).max(1);
    let mut below = 0;
    let mut ranks = [0; 256];
    for (rank, count) in ranks.iter_mut().zip(counts).skip(1) {
        // Fewer than 2^20 cells: products fit.
        *rank = (1 + 254 * (2 * below + count) / twice) as u8;
        below += count;
    }
    ranks
}

/// The percentile [`TEXTURE_PERCENT`] of a histogram.
fn percentile(counts: &[u32; 256]) -> usize {
    let wanted = counts.iter().sum::<u32>() / 100 * TEXTURE_PERCENT;
    let mut below = 0;
    counts
        .iter()
        .position(|count| {
            below += count;
            below >= wanted
        })
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    #[test]
    fn brightness_becomes_rank() {
        let resolution = Resolution::COARSE;
        let (columns, rows) = (resolution.columns(), resolution.rows());
        // A quarter of all columns is bright, whatever its level.
        for bright in [60, 120, 240] {
            let mut gray: vec::Vec<u8> =
                (0..resolution.cells()).map(|i| if i / rows < columns / 4 { bright } else { 40 }).collect();
            let mut texture = vec![9; gray.len()];
            normalize(&mut gray, &mut texture, resolution);
            assert_eq!((gray[10 * rows + 40], gray[columns / 2 * rows + 40]), (223, 96));
            assert!(texture.iter().all(|t| *t == 0));
        }
    }

    #[test]
    fn over_exposed_is_textured() {
        let resolution = Resolution::COARSE;
        let rows = resolution.rows();
        let mut gray: vec::Vec<u8> =
            (0..resolution.cells()).map(|i| GLARE - u8::from(i / rows % 7 == 3)).collect();
        let exposed: vec::Vec<_> = gray.iter().map(|level| *level >= GLARE).collect();
        let mut texture = vec![9; gray.len()];
        normalize(&mut gray, &mut texture, resolution);
        assert!(
            texture.iter().zip(exposed).all(|(texture, exposed)| *texture == if exposed { 255 } else { 0 })
        );
    }

    #[test]
    fn texture_is_the_change_between_rows() {
        let resolution = Resolution::COARSE;
        let rows = resolution.rows();
        let mut gray: vec::Vec<u8> =
            (0..resolution.cells()).map(|i| if i % rows < 70 { 90 } else { 110 }).collect();
        let mut texture = vec![9; gray.len()];
        normalize(&mut gray, &mut texture, resolution);
        let strong: vec::Vec<_> = (0..rows).filter(|row| texture[5 * rows + row] > 0).collect();
        assert_eq!(strong, [69, 70]);
    }

    #[test]
    fn unknown_cells_grow_by_one() {
        let mut gray = vec![100; 7 * 5];
        gray[2] = 0;
        let mut lost = vec![0; 7 * 5];
        erode(&mut gray, &mut lost, 5);
        let zeros: vec::Vec<_> = (0..35).filter(|i| gray[*i] == 0).collect();
        assert_eq!(zeros, [1, 2, 3, 7, 32], "above, itself, below, right, and left around the circle");
    }
}
