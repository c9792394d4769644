//! Writing a shot.

use super::layout::{HEADER_BYTES, Words};
use super::{Header, Image, ShotError};
use crate::base::crc::{Sink, Summed};

/// Metadata and images of a shot, checked and ready to be written.
///
/// ```
/// # use compass_core::vision::camera::Equidistant;
/// # use compass_core::{Bearing, BitMask, Camera, GrayImage, Intrinsics, Rig, View};
/// use compass_core::base::crc::Sink;
/// use compass_core::vision::shot::{Header, Shot, Writer};
///
/// struct Bytes(Vec<u8>);
/// # impl Sink for Bytes {
/// #     type Error = core::convert::Infallible;
/// #     fn append(&mut self, bytes: &[u8]) -> Result<(), Self::Error> {
/// #         Ok(self.0.extend_from_slice(bytes))
/// #     }
/// # }
///
/// // One camera of 8 x 2 pixels.
/// let intrinsics = Intrinsics { fx: 2.5, fy: 2.5, cx: 3.5, cy: 0.5 };
/// let view = View::new(Camera::Equidistant(Equidistant::new(intrinsics).unwrap()), 8, 2);
/// let rig = Rig::new([Some(view), None]).unwrap();
/// let header = Header { time_ns: 7, rig, up: -Bearing::y(), height_m: Some(1.6) };
/// let image = (GrayImage::new(&[9; 16], 8, 2).unwrap(), BitMask::new(&[0; 2], 8, 2).unwrap());
/// let Ok(Bytes(bytes)) = Writer::new(&header, [Some(image), None])?.write(Bytes(Vec::new()));
/// let shot = Shot::new(&bytes)?;
/// shot.verify()?;
/// assert_eq!((shot.header().time_ns, shot.images()[0].unwrap().0.pixels()), (7, &[9; 16][..]));
/// # Ok::<(), compass_core::vision::shot::ShotError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Writer<'a> {
    header: Header,
    images: [Option<Image<'a>>; 2],
}

impl<'a> Writer<'a> {
    /// Checks the metadata, and the images against the rig: one per camera, of the size of its view.
    ///
    /// # Errors
    /// [`ShotError::Image`], [`ShotError::Up`], [`ShotError::Height`], [`ShotError::LensParameters`].
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
