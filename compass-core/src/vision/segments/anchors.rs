//! Anchors: local maxima of the gradient magnitude across the edge, from which drawing starts.

use super::cell::{MAGNITUDE_SHIFT, VERTICAL, strength};
use super::draw::Drawing;
use super::gradient::triples;
use super::parameters::MAX_SIDE;
use super::walk::Position;
use crate::base::num::{count_as_i32, index_of};

/// Anchors lie on every other row and column.
const INTERVAL: usize = 2;
/// Columns whose anchors in one row fill a word.
const BAND: usize = 32 * INTERVAL;

/// Words of an image's anchors: one bit for every other pixel of every other row.
pub(super) const fn words(width: usize, height: usize) -> usize {
    width.div_ceil(BAND) * (height / INTERVAL)
}

/// Marks the anchors of an image: of every other pixel of every other row, those that exceed both neighbours across the
/// edge by `threshold`. Returns whether there is an anchor.
///
/// Words are ordered by band of columns, then by row.
#[inline(always)]
pub(super) fn mark(cells: &[u16], width: usize, threshold: u16, anchors: &mut [u32]) -> bool {
    let rows = cells.len() / width / INTERVAL;
    let row_of = |y: usize| cells.get(y * width..(y + 1) * width).unwrap_or(&[]);
    let mut any = 0;
    for row in 0..rows {
        let y = INTERVAL * row + 1;
        let triple = [row_of(y - 1), row_of(y), row_of(y + 1)];
        for (band, start) in (0..width).step_by(BAND).enumerate() {
            let end = (start + BAND + 2).min(width);
            let word = mark_band(triple.map(|r| r.get(start..end).unwrap_or(&[])), threshold);
            any |= word;
            if let Some(slot) = anchors.get_mut(band * rows + row) {
                *slot = word;
            }
        }
    }
    any != 0
}

/// Tests every other cell of the middle row, except the first and the last.
#[inline(always)]
fn mark_band([above, row, below]: [&[u16]; 3], threshold: u16) -> u32 {
    let mut marked = [0_u16; BAND];
    // Cells are below 2^15, so that differences fit.
    let signed = |cell: u16| strength(cell).cast_signed();
    let threshold = (threshold << MAGNITUDE_SHIFT).clamp(1, i16::MAX as u16).cast_signed();
    let rows = triples(above).zip(triples(row)).zip(triples(below));
    for ((marked, bit), (([_, up, _], [left, here, right]), [_, down, _])) in
        marked.iter_mut().zip(&BITS).zip(rows)
    {
        let across = signed(left).max(signed(right));
        let along = signed(up).max(signed(down));
        let rival = if here & VERTICAL != 0 { across } else { along };
        *marked = if signed(here) - rival >= threshold { *bit } else { 0 };
    }
    let (low, high) = marked.split_at(BAND / 2);
    let gather = |half: &[u16]| u32::from(half.iter().fold(0, |word, bit| word | bit));
    gather(low) | gather(high) << 16
}

/// Bit of each cell of a band in its half word.
#[expect(clippy::indexing_slicing, reason = "i is below `BAND`")]
const BITS: [u16; BAND] = {
    let mut bits = [0; BAND];
    let mut i = 0;
    while i < BAND {
        bits[i] = 1 << (i / INTERVAL % 16);
        i += INTERVAL;
    }
    bits
};

/// Rows of anchors summarized by one word.
const BLOCK: usize = 32;
/// Blocks of the highest image.
const MAX_BLOCKS: usize = MAX_SIDE as usize / INTERVAL / BLOCK;

/// Draws from all anchors, column by column.
pub(super) fn visit(drawing: &mut Drawing<'_, '_>, anchors: &[u32]) {
    let rows = index_of(drawing.cells.height) / INTERVAL;
    for (band, words) in anchors.chunks_exact(rows.max(1)).enumerate() {
        // Most columns of a block have no anchor: the union of its words skips them.
        let mut blocks = [0; MAX_BLOCKS];
        for (block, words) in blocks.iter_mut().zip(words.chunks(BLOCK)) {
            *block = words.iter().fold(0, |any, word| any | word);
        }
        let any = blocks.iter().fold(0, |any, block| any | block);
        for column in (0..32).filter(|c| any >> c & 1 == 1) {
            let x = count_as_i32(band * BAND + INTERVAL * column + 1);
            let with_anchor = |word: &u32| word >> column & 1 == 1;
            for (first, words) in blocks
                .iter()
                .zip(words.chunks(BLOCK))
                .enumerate()
                .filter(|(_, (b, _))| with_anchor(b))
                .map(|(i, (_, words))| (i * BLOCK, words))
            {
                for (row, _) in words.iter().enumerate().filter(|(_, word)| with_anchor(word)) {
                    if !drawing.draw_from(Position { x, y: count_as_i32(INTERVAL * (first + row) + 1) }) {
                        return;
                    }
                }
            }
        }
    }
}
