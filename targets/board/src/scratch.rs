//! Memory that the steps use one after the other.

use bytemuck::Pod;
use compass_core::vision::boundary::{self, CELLS, RangeLikelihoods};
use compass_core::pose::Rows;
use compass_core::pose::evidence::EvidenceTable;
use compass_core::vision::segments::{self, pixels, trail_len};
use compass_core::vision::windows::{self, Column, Upright, WindowBox};
use compass_core::vision::panorama::Resolution;

/// Headings that the search tries.
pub(crate) const HEADINGS: usize = 40;
const UPRIGHTS: usize = 256;
const BOXES: usize = 1024;

/// Words of scratch that frames of this size need, the most that any step takes: `ring` is [`Resolution::COARSE`] for
/// lenses of less than 3 pixels a degree, else [`Resolution::FINE`].
#[must_use]
pub const fn words(width: u16, height: u16, ring: Resolution) -> usize {
    let (width, height) = (width as u32, height as u32);
    let detector = of::<u16>(pixels(width, height))
        + of::<u8>(pixels(width, height))
        + of::<u32>(trail_len(width, height));
    let ring = 2 * of::<u8>(ring.cells())
        + of::<Column>(ring.columns() + 1)
        + of::<Upright>(UPRIGHTS)
        + of::<WindowBox>(BOXES);
    let search = of::<u8>(CELLS) + of::<RangeLikelihoods>(1) + of::<EvidenceTable>(1) + of::<Rows<HEADINGS>>(1);
    let most = if detector > ring { detector } else { ring };
    // The raster of ranges takes two times CELLS, less than any ring does.
    if search > most { search } else { most }
}

const _: () = assert!(CELLS <= Resolution::COARSE.cells(), "the raster of ranges fits where the ring was");

/// Words that hold so many elements.
const fn of<T>(count: usize) -> usize {
    (count * size_of::<T>()).div_ceil(size_of::<u32>())
}

/// For the segments of a frame.
pub(crate) fn detector(words: &mut [u32], width: u32, height: u32) -> Option<segments::Workspace<'_>> {
    let mut rest = Rest(words);
    Some(segments::Workspace {
        cells: rest.take(pixels(width, height))?,
        smoothed: rest.take(pixels(width, height))?,
        trail: rest.take(trail_len(width, height))?,
    })
}

/// For the windows.
pub(crate) fn ring(words: &mut [u32], ring: Resolution) -> Option<windows::Buffers<'_>> {
    let mut rest = Rest(words);
    Some(windows::Buffers {
        gray: rest.take(ring.cells())?,
        texture: rest.take(ring.cells())?,
        columns: rest.take(ring.columns() + 1)?,
        uprights: rest.take(UPRIGHTS)?,
        boxes: rest.take(BOXES)?,
    })
}

/// For the ranges; the support lies where the [search](Search::new) finds it.
pub(crate) fn raster(words: &mut [u32]) -> Option<boundary::Buffers<'_>> {
    let mut rest = Rest(words);
    let support = rest.take(CELLS)?;
    Some(boundary::Buffers { edges: rest.take(CELLS)?, support })
}

/// The support as the ranges left it.
pub(crate) fn support(words: &[u32]) -> Option<&[u8]> {
    bytemuck::must_cast_slice(words).get(..CELLS)
}

/// For the search.
#[derive(Debug)]
pub(crate) struct Search<'a> {
    pub(crate) support: &'a [u8],
    pub(crate) ranges: &'a mut RangeLikelihoods,
    pub(crate) table: &'a mut EvidenceTable,
    pub(crate) rows: &'a mut Rows<HEADINGS>,
}

impl<'a> Search<'a> {
    pub(crate) fn new(words: &'a mut [u32]) -> Option<Self> {
        let mut rest = Rest(words);
        Some(Self { support: rest.take(CELLS)?, ranges: rest.one()?, table: rest.one()?, rows: rest.one()? })
    }
}

/// Words not yet taken.
struct Rest<'a>(&'a mut [u32]);

impl<'a> Rest<'a> {
    /// So many elements, with whatever they hold.
    fn take<T: Pod>(&mut self, count: usize) -> Option<&'a mut [T]> {
        const { assert!(align_of::<T>() <= align_of::<u32>(), "words are aligned for it") };
        let (part, rest) = core::mem::take(&mut self.0).split_at_mut_checked(of::<T>(count))?;
        self.0 = rest;
        let bytes: &mut [u8] = bytemuck::must_cast_slice_mut(part);
        bytemuck::try_cast_slice_mut(bytes.get_mut(..count * size_of::<T>())?).ok()
    }

    fn one<T: Pod>(&mut self) -> Option<&'a mut T> {
        self.take(1)?.first_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    extern crate std;

    #[test]
    fn every_step_fits_and_one_word_less_does_not() {
        for (width, height, resolution) in
            [(368, 360, Resolution::COARSE), (736, 720, Resolution::FINE), (64, 48, Resolution::FINE)]
        {
            let fits = |words: &mut [u32]| {
                detector(words, width.into(), height.into()).is_some()
                    && ring(words, resolution).is_some()
                    && raster(words).is_some()
                    && Search::new(words).is_some()
            };
            let mut memory = std::vec![0; words(width, height, resolution)];
            assert!(fits(&mut memory));
            memory.pop();
            assert!(!fits(&mut memory));
        }
    }
}
