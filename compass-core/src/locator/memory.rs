//! One block of memory, laid out for one stage after the other.

use super::error::Error;
use super::settings::{Settings, Smoothing};
use crate::base::num::CellNats;
use crate::pose::PoolEntry;
use crate::pose::evidence::EvidenceTable;
use crate::vision::attitude::Arc;
use crate::vision::boundary::{self, CELLS, RASTER_CELLS};
use crate::vision::camera::{CAMERAS, Rig};
use crate::vision::panorama::Resolution;
use crate::vision::segments::{self, MAX_SIDE, Segment, pixels, trail_len};
use crate::vision::windows::{self, Column, VerticalSegment, Window, WindowBox};
use bytemuck::Pod;
use core::mem;

/// Bytes of a word of memory.
const WORD_BYTES: usize = size_of::<u32>();

/// A width and height, at most those that the detector takes: sizes in words fit 32 bits.
const fn bounded([width, height]: [u16; 2]) -> [u16; 2] {
    const MOST: u16 = 8192;
    const _: () = assert!(MOST as u32 == MAX_SIDE);
    [if width > MOST { MOST } else { width }, if height > MOST { MOST } else { height }]
}

/// Words that hold this many elements.
const fn of<T>(count: usize) -> usize {
    (count * size_of::<T>()).div_ceil(WORD_BYTES)
}

const fn larger(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}

impl Settings {
    /// Words of memory that a rig of one or two cameras with images of at most this size takes.
    #[must_use]
    pub const fn memory_words(&self, width: u16, height: u16) -> usize {
        Layout::new(self, [[width, height]; CAMERAS]).words()
    }

    /// Words of memory that a rig takes.
    #[must_use]
    pub fn memory_words_of(&self, rig: &Rig) -> usize {
        self.layout(rig).words()
    }

    pub(super) fn layout(&self, rig: &Rig) -> Layout {
        Layout::new(
            self,
            [0, 1].map(|camera| rig.view(camera).map_or([0; 2], |view| [view.width, view.height])),
        )
    }

    pub(super) fn check(&self, rig: &Rig, words: usize) -> Result<(), Error> {
        self.check_ranges()?;
        for (number, camera) in (0..).zip(0..CAMERAS) {
            let side = rig.view(camera).map_or(0, |view| view.width.max(view.height));
            if u32::from(side) > MAX_SIDE {
                return Err(Error::Side { camera: number, most: MAX_SIDE });
            }
        }
        let missing = self.layout(rig).words().saturating_sub(words);
        if missing == 0 { Ok(()) } else { Err(Error::Memory { missing_bytes: missing * WORD_BYTES }) }
    }
}

/// How much of everything there is. What a stage hands on lies first, then what stages use one after the other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    settings: Settings,
    sizes: [[u16; 2]; CAMERAS],
}

impl Layout {
    /// For images of these widths and heights, 0 for a camera that is not there.
    pub(super) const fn new(settings: &Settings, sizes: [[u16; 2]; CAMERAS]) -> Self {
        Self { settings: settings.bounded(), sizes: [bounded(sizes[0]), bounded(sizes[1])] }
    }

    /// Words of all of it.
    pub(super) const fn words(&self) -> usize {
        let detect = larger(self.detector_words(0), self.detector_words(1));
        let (look, boundary) = (self.windows_words(), self.boundary_words());
        let scratch =
            larger(larger(detect, look), larger(larger(boundary, self.arc_words()), self.search_words()));
        self.kept_words() + scratch
    }

    /// Width and height of a camera's images.
    const fn size(&self, camera: usize) -> [u16; 2] {
        let [front, back] = self.sizes;
        if camera == 0 { front } else { back }
    }

    const fn pixels(&self, camera: usize) -> usize {
        let [width, height] = self.size(camera);
        pixels(width as u32, height as u32)
    }

    /// Pixels of the larger image, and its widest row.
    const fn most_pixels(&self) -> usize {
        larger(self.pixels(0), self.pixels(1))
    }

    const fn widest(&self) -> usize {
        larger(self.size(0)[0] as usize, self.size(1)[0] as usize)
    }

    /// Segments and windows, and smoothed frames if they are kept.
    const fn kept_words(&self) -> usize {
        let smoothed =
            if self.keeps_smoothed() { of::<u8>(self.pixels(0)) + of::<u8>(self.pixels(1)) } else { 0 };
        CAMERAS * of::<Segment>(self.settings.segments) + of::<Window>(self.settings.windows) + smoothed
    }

    const fn keeps_smoothed(&self) -> bool {
        matches!(self.settings.smoothing, Smoothing::Kept)
    }

    const fn mask_bytes(&self, camera: usize) -> usize {
        let [width, height] = self.size(camera);
        if self.settings.lens_field_mask { (width as usize).div_ceil(8) * height as usize } else { 0 }
    }

    const fn detector_words(&self, camera: usize) -> usize {
        let [width, height] = self.size(camera);
        let smoothed = if self.keeps_smoothed() { 0 } else { of::<u8>(self.pixels(camera)) };
        of::<u16>(self.pixels(camera))
            + smoothed
            + of::<u32>(trail_len(width as u32, height as u32))
            + of::<u8>(self.mask_bytes(camera))
    }

    const fn arc_words(&self) -> usize {
        of::<Arc>(CAMERAS * self.settings.segments)
    }

    /// A frame smoothed anew, with the row that smoothing takes.
    const fn smoothing_words(&self) -> usize {
        match self.settings.smoothing {
            Smoothing::Again => of::<u8>(self.most_pixels()) + of::<u16>(self.widest()),
            Smoothing::Off | Smoothing::Kept => 0,
        }
    }

    const fn windows_words(&self) -> usize {
        let ring = self.settings.panorama;
        2 * of::<u8>(ring.cells())
            + of::<Column>(ring.columns() + 1)
            + of::<VerticalSegment>(self.settings.vertical_segments)
            + of::<WindowBox>(self.settings.boxes)
            + self.smoothing_words()
    }

    const fn boundary_words(&self) -> usize {
        of::<CellNats>(CELLS) + of::<u8>(CELLS) + of::<boundary::Work>(1)
    }

    const fn search_words(&self) -> usize {
        of::<CellNats>(CELLS)
            + of::<EvidenceTable>(1)
            + self.settings.headings.words()
            + of::<PoolEntry>(self.settings.pool)
    }

    /// What stages hand on, and the rest.
    #[inline(never)]
    pub(super) fn split<'m>(&self, memory: &'m mut [u32]) -> Option<(Kept<'m>, Rest<'m>)> {
        let mut rest = Rest(memory);
        let segments = [rest.take(self.settings.segments)?, rest.take(self.settings.segments)?];
        let windows = rest.take(self.settings.windows)?;
        let [near, far] = if self.keeps_smoothed() { [self.pixels(0), self.pixels(1)] } else { [0; CAMERAS] };
        let smoothed = [rest.take(near)?, rest.take(far)?];
        Some((Kept { segments, windows, smoothed }, rest))
    }

    /// For the segments of a camera's frame, with the bytes of the mask of its lens's field.
    #[inline(never)]
    pub(super) fn detector<'m>(&self, memory: &'m mut [u32], camera: usize) -> Option<Detector<'m>> {
        let (kept, mut rest) = self.split(memory)?;
        let [width, height] = self.size(camera);
        let count = pixels(width.into(), height.into());
        let ([first, second], [near, far]) = (kept.segments, kept.smoothed);
        let (found, kept) = if camera == 0 { (first, near) } else { (second, far) };
        let cells = rest.take(count)?;
        let smoothed = if self.keeps_smoothed() { kept } else { rest.take(count)? };
        let trail = rest.take(trail_len(width.into(), height.into()))?;
        let mask = rest.take(self.mask_bytes(camera))?;
        Some(Detector { workspace: segments::Workspace { cells, smoothed, trail }, mask, found })
    }

    /// The segments, and room for as many arcs.
    #[inline(never)]
    pub(super) fn arcs<'m>(
        &self,
        memory: &'m mut [u32],
    ) -> Option<([&'m mut [Segment]; CAMERAS], &'m mut [Arc])> {
        let (kept, mut rest) = self.split(memory)?;
        Some((kept.segments, rest.take(CAMERAS * self.settings.segments)?))
    }

    /// For the windows.
    #[inline(never)]
    pub(super) fn windows<'m>(&self, memory: &'m mut [u32], ring: Resolution) -> Option<Look<'m>> {
        let (kept, mut rest) = self.split(memory)?;
        let buffers = windows::Buffers {
            gray: rest.take(ring.cells())?,
            texture: rest.take(ring.cells())?,
            columns: rest.take(ring.columns() + 1)?,
            vertical_segments: rest.take(self.settings.vertical_segments)?,
            boxes: rest.take(self.settings.boxes)?,
        };
        Some(Look { kept, buffers, smoothing: self.smoothing(&mut rest)? })
    }

    /// For the boundaries; the evidence lies where the [search](Self::search) finds it.
    #[inline(never)]
    pub(super) fn boundary<'m>(&self, memory: &'m mut [u32]) -> Option<Boundary<'m>> {
        let (_, mut rest) = self.split(memory)?;
        let evidence = rest.take(CELLS)?;
        let gray = rest.take(RASTER_CELLS)?;
        let work = rest.one()?;
        Some(Boundary { evidence, gray, work })
    }

    #[inline(never)]
    fn smoothing<'m>(&self, rest: &mut Rest<'m>) -> Option<Scratch<'m>> {
        match self.settings.smoothing {
            Smoothing::Again => Some((rest.take(self.most_pixels())?, rest.take(self.widest())?)),
            Smoothing::Off | Smoothing::Kept => Some((&mut [], &mut [])),
        }
    }

    /// For the search, beside the boundaries.
    #[inline(never)]
    pub(super) fn search<'m>(&self, memory: &'m mut [u32]) -> Option<Search<'m>> {
        let (_, mut rest) = self.split(memory)?;
        Some(Search {
            evidence: rest.take(CELLS)?,
            table: rest.one()?,
            rows: rest.words(self.settings.headings.words())?,
            pool: rest.take(self.settings.pool)?,
        })
    }
}

/// What stages hand on.
#[derive(Debug)]
pub(super) struct Kept<'m> {
    pub(super) segments: [&'m mut [Segment]; CAMERAS],
    pub(super) windows: &'m mut [Window],
    /// Empty unless they are kept.
    pub(super) smoothed: [&'m mut [u8]; CAMERAS],
}

/// For the segments of a frame.
#[derive(Debug)]
pub(super) struct Detector<'m> {
    pub(super) workspace: segments::Workspace<'m>,
    /// Empty without a mask.
    pub(super) mask: &'m mut [u8],
    pub(super) found: &'m mut [Segment],
}

/// For the windows.
#[derive(Debug)]
pub(super) struct Look<'m> {
    pub(super) kept: Kept<'m>,
    pub(super) buffers: windows::Buffers<'m>,
    pub(super) smoothing: Scratch<'m>,
}

/// A frame smoothed anew, and the row that smoothing takes.
pub(super) type Scratch<'m> = (&'m mut [u8], &'m mut [u16]);

/// For the boundaries.
#[derive(Debug)]
pub(super) struct Boundary<'m> {
    pub(super) evidence: &'m mut [CellNats],
    pub(super) gray: &'m mut [u8],
    pub(super) work: &'m mut boundary::Work,
}

impl<'m> Boundary<'m> {
    pub(super) fn buffers(self) -> boundary::Buffers<'m> {
        boundary::Buffers { gray: self.gray, work: self.work, evidence: self.evidence }
    }
}

/// For the search.
#[derive(Debug)]
pub(super) struct Search<'m> {
    pub(super) evidence: &'m mut [CellNats],
    pub(super) table: &'m mut EvidenceTable,
    pub(super) rows: &'m mut [u32],
    pub(super) pool: &'m mut [PoolEntry],
}

/// Words not yet taken.
#[derive(Debug)]
pub(super) struct Rest<'m>(&'m mut [u32]);

impl<'m> Rest<'m> {
    fn words(&mut self, count: usize) -> Option<&'m mut [u32]> {
        let (part, rest) = mem::take(&mut self.0).split_at_mut_checked(count)?;
        self.0 = rest;
        Some(part)
    }

    /// This many elements, with whatever they hold.
    fn take<E: Pod>(&mut self, count: usize) -> Option<&'m mut [E]> {
        const { assert!(align_of::<E>() <= align_of::<u32>(), "words are aligned for it") };
        let bytes: &mut [u8] = bytemuck::must_cast_slice_mut(self.words(of::<E>(count))?);
        bytemuck::try_cast_slice_mut(bytes.get_mut(..count * size_of::<E>())?).ok()
    }

    fn one<E: Pod>(&mut self) -> Option<&'m mut E> {
        self.take(1)?.first_mut()
    }
}
