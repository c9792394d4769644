//! Writing a shot.

use super::layout::{HEADER_BYTES, Words};
use super::{Header, Image, ShotError};
use crate::base::crc::{Sink, Summed};

/// Metadata and images of a shot, checked and ready to be written.
#[derive(Debug, Clone, Copy)]
pub struct Writer<'a> {
    header: Header,
    images: [Option<Image<'a>>; 2],
}

impl<'a> Writer<'a> {
    /// Checks the metadata, and the images against the rig: one per camera, of the size of its view.
    ///
    /// # Errors
    /// [`ShotError::Image`], [`ShotError::Up`], [`ShotError::Height`].
    pub fn new(header: &Header, images: [Option<Image<'a>>; 2]) -> Result<Self, ShotError> {
        header.check()?;
        for (number, image) in images.iter().enumerate() {
            let expected = header.rig.view(number).map(|view| [view.width, view.height].map(u32::from));
            let gray = image.map(|(gray, _)| [gray.width(), gray.height()]);
            let mask = image.map(|(_, mask)| [mask.width(), mask.height()]);
            if expected != gray || expected != mask {
                return Err(ShotError::Image);
            }
        }
        Ok(Self { header: *header, images })
    }

    /// Bytes of the whole shot, saturating at `usize::MAX`.
    #[must_use]
    pub fn shot_bytes(&self) -> usize {
        let ends = HEADER_BYTES + size_of::<u32>();
        let images = self.images.iter().flatten();
        let bytes = images.flat_map(|(gray, mask)| {
            (0..mask.height()).map(|y| mask.row(y).len()).chain([gray.pixels().len()])
        });
        bytes.fold(ends, usize::saturating_add)
    }

    /// Writes the shot and returns the sink.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn write<S: Sink>(&self, sink: S) -> Result<S, S::Error> {
        let mut out = Summed::new(sink);
        out.append(&Words::new(&self.header).to_bytes())?;
        for (gray, mask) in self.images.iter().flatten() {
            out.append(gray.pixels())?;
            (0..mask.height()).try_for_each(|y| out.append(mask.row(y)))?;
        }
        out.finish()
    }
}
