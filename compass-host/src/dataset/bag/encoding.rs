//! The encodings of `sensor_msgs/msg/Image`, by the names of `image_encodings.hpp`, in one table.

use crate::image_file::{Pixels, Samples};

/// How the bytes of a row are pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    /// Samples of 8 or 16 bits: the number of channels, and those that are red, green and blue; gray if all are one.
    Channels { count: usize, wide: bool, rgb: [usize; 3] },
    /// One sample of 8 or 16 bits under a mosaic of filters: the colour of the first two pixels of the first two rows.
    Bayer { wide: bool, pattern: [[Colour; 2]; 2] },
    /// Packed 4:2:2; luma begins at this byte of two.
    Luma422 { first: usize },
    /// A plane of luma, before planes of chroma that are not read: this many rows of bytes per two rows of pixels.
    LumaPlane { rows_of_two: usize },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Colour {
    R,
    G,
    B,
}
use Colour::{B, G, R};

const GRAY: [usize; 3] = [0; 3];
const RGB: [usize; 3] = [0, 1, 2];
const BGR: [usize; 3] = [2, 1, 0];

const fn channels(count: usize, wide: bool, rgb: [usize; 3]) -> Form {
    Form::Channels { count, wide, rgb }
}

const fn bayer(wide: bool, pattern: [[Colour; 2]; 2]) -> Form {
    Form::Bayer { wide, pattern }
}

/// All encodings that are read. Types of `OpenCV` have its order, blue first; alpha is ignored.
const TABLE: [(&str, Form); 40] = [
    ("mono8", channels(1, false, GRAY)),
    ("8UC1", channels(1, false, GRAY)),
    ("mono16", channels(1, true, GRAY)),
    ("16UC1", channels(1, true, GRAY)),
    ("rgb8", channels(3, false, RGB)),
    ("bgr8", channels(3, false, BGR)),
    ("8UC3", channels(3, false, BGR)),
    ("rgba8", channels(4, false, RGB)),
    ("bgra8", channels(4, false, BGR)),
    ("8UC4", channels(4, false, BGR)),
    ("8UC2", channels(2, false, GRAY)),
    ("rgb16", channels(3, true, RGB)),
    ("bgr16", channels(3, true, BGR)),
    ("16UC3", channels(3, true, BGR)),
    ("rgba16", channels(4, true, RGB)),
    ("bgra16", channels(4, true, BGR)),
    ("16UC4", channels(4, true, BGR)),
    ("bayer_rggb8", bayer(false, [[R, G], [G, B]])),
    ("bayer_bggr8", bayer(false, [[B, G], [G, R]])),
    ("bayer_gbrg8", bayer(false, [[G, B], [R, G]])),
    ("bayer_grbg8", bayer(false, [[G, R], [B, G]])),
    ("bayer_rggb16", bayer(true, [[R, G], [G, B]])),
    ("bayer_bggr16", bayer(true, [[B, G], [G, R]])),
    ("bayer_gbrg16", bayer(true, [[G, B], [R, G]])),
    ("bayer_grbg16", bayer(true, [[G, R], [B, G]])),
    ("yuv422", Form::Luma422 { first: 1 }),
    ("uyvy", Form::Luma422 { first: 1 }),
    ("UYVY", Form::Luma422 { first: 1 }),
    ("yuv422_yuy2", Form::Luma422 { first: 0 }),
    ("yuyv", Form::Luma422 { first: 0 }),
    ("YUYV", Form::Luma422 { first: 0 }),
    ("yuy2", Form::Luma422 { first: 0 }),
    ("YUY2", Form::Luma422 { first: 0 }),
    ("nv12", Form::LumaPlane { rows_of_two: 3 }),
    ("NV12", Form::LumaPlane { rows_of_two: 3 }),
    ("nv21", Form::LumaPlane { rows_of_two: 3 }),
    ("NV21", Form::LumaPlane { rows_of_two: 3 }),
    ("i420", Form::LumaPlane { rows_of_two: 3 }),
    ("nv24", Form::LumaPlane { rows_of_two: 6 }),
    ("NV24", Form::LumaPlane { rows_of_two: 6 }),
];

/// The image of a message.
pub(super) struct Encoded<'a> {
    pub(super) encoding: &'a str,
    pub(super) width: u32,
    pub(super) height: u32,
    /// Bytes from one row to the next.
    pub(super) step: usize,
    /// Whether the high byte of 16-bit samples comes first.
    pub(super) is_bigendian: bool,
    pub(super) data: &'a [u8],
}

impl Encoded<'_> {
    /// Gray or red, green and blue; of YUV the luma.
    pub(super) fn pixels(&self) -> Result<Pixels, String> {
        let Some((_, form)) = TABLE.iter().find(|(name, _)| *name == self.encoding) else {
            let mut known: Vec<_> = TABLE.iter().map(|(name, _)| name.to_lowercase()).collect();
            known.sort_unstable();
            known.dedup();
            return Err(format!("encoding '{}' is not known, only {}", self.encoding, known.join(", ")));
        };
        let (width, height) = (self.width as usize, self.height as usize);
        self.check(width * bytes_per_pixel(*form), height)?;
        let samples = match *form {
            Form::Channels { count, wide, rgb } => self.channels(count, wide, rgb),
            Form::Bayer { wide, pattern } => Samples::Rgb(demosaiced(&self.plane(wide), width, pattern)),
            Form::Luma422 { first } => {
                let rows = self.rows(2 * width);
                Samples::Gray(rows.flat_map(|row| row.iter().copied().skip(first).step_by(2)).collect())
            }
            Form::LumaPlane { rows_of_two } => {
                let needed = (height * rows_of_two).div_ceil(2) * self.step.min(width);
                if self.data.len() < needed {
                    return Err(self.too_few(height));
                }
                Samples::Gray(self.plane(false))
            }
        };
        Ok(Pixels { width: self.width, height: self.height, samples })
    }

    /// Checks that there are `height` rows of `row` bytes; the last one may lack its padding.
    fn check(&self, row: usize, height: usize) -> Result<(), String> {
        if self.step < row {
            return Err(format!(
                "a step of {} bytes is too short for {} pixels in {}",
                self.step, self.width, self.encoding
            ));
        }
        let needed = self.step.checked_mul(height - 1).and_then(|bytes| bytes.checked_add(row));
        if needed.is_some_and(|needed| self.data.len() >= needed) {
            Ok(())
        } else {
            Err(self.too_few(height))
        }
    }

    fn too_few(&self, rows: usize) -> String {
        format!("{} bytes of data are too few for {rows} rows of {} bytes", self.data.len(), self.step)
    }

    /// The rows without their padding.
    fn rows(&self, bytes: usize) -> impl Iterator<Item = &[u8]> {
        self.data.chunks(self.step).take(self.height as usize).map(move |row| &row[..bytes])
    }

    /// One channel of 8 bits, or the high bytes of one of 16.
    fn plane(&self, wide: bool) -> Vec<u8> {
        let bytes = if wide { 2 } else { 1 };
        let high = if wide && !self.is_bigendian { 1 } else { 0 };
        let rows = self.rows(bytes * self.width as usize);
        rows.flat_map(|row| row.iter().copied().skip(high).step_by(bytes)).collect()
    }

    fn channels(&self, count: usize, wide: bool, rgb: [usize; 3]) -> Samples {
        let bytes = if wide { 2 } else { 1 };
        let high = if wide && !self.is_bigendian { 1 } else { 0 };
        let rows = self.rows(bytes * count * self.width as usize);
        let pixels = rows.flat_map(|row| row.chunks_exact(bytes * count));
        if rgb == GRAY {
            return Samples::Gray(pixels.map(|pixel| pixel[high]).collect());
        }
        Samples::Rgb(pixels.flat_map(|pixel| rgb.map(|channel| pixel[bytes * channel + high])).collect())
    }
}

const fn bytes_per_pixel(form: Form) -> usize {
    match form {
        Form::Channels { count, wide, .. } => count * if wide { 2 } else { 1 },
        Form::Bayer { wide, .. } => {
            if wide {
                2
            } else {
                1
            }
        }
        Form::Luma422 { .. } => 2,
        Form::LumaPlane { .. } => 1,
    }
}

/// Red, green and blue of each pixel: its own sample, and the mean of the nearest ones of the other colours (bilinear).
fn demosaiced(samples: &[u8], width: usize, pattern: [[Colour; 2]; 2]) -> Vec<u8> {
    let height = samples.len() / width;
    let mut rgb = Vec::with_capacity(3 * samples.len());
    for y in 0..height {
        for x in 0..width {
            let (mut sums, mut counts) = ([0_u16; 3], [0_u16; 3]);
            for v in y.saturating_sub(1)..=(y + 1).min(height - 1) {
                for u in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                    let colour = pattern[v % 2][u % 2] as usize;
                    sums[colour] += u16::from(samples[v * width + u]);
                    counts[colour] += 1;
                }
            }
            let own = pattern[y % 2][x % 2] as usize;
            for colour in 0..3 {
                let mean = (sums[colour] + counts[colour] / 2) / counts[colour].max(1);
                rgb.push(if colour == own { samples[y * width + x] } else { mean as u8 });
            }
        }
    }
    rgb
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The samples of two rows of two pixels, `step` bytes apart.
    fn samples(encoding: &str, step: usize, is_bigendian: bool, data: &[u8]) -> Result<Vec<u8>, String> {
        let encoded = Encoded { encoding, width: 2, height: 2, step, is_bigendian, data };
        encoded.pixels().map(|pixels| match pixels.samples {
            Samples::Gray(samples) | Samples::Rgb(samples) => samples,
        })
    }

    fn little(encoding: &str, step: usize, data: &[u8]) -> Vec<u8> {
        samples(encoding, step, false, data).unwrap()
    }

    #[test]
    fn channels_are_gray_or_red_green_blue() {
        for encoding in ["mono8", "8UC1"] {
            assert_eq!(little(encoding, 3, &[1, 2, 99, 3, 4]), [1, 2, 3, 4]);
        }
        let colours = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
        let swapped = [3, 2, 1, 6, 5, 4, 9, 8, 7, 12, 11, 10];
        assert_eq!(little("rgb8", 6, &colours), colours);
        let padded: Vec<u8> =
            colours.chunks(6).flat_map(|row| [&row[..3], &[0], &row[3..], &[9, 99, 99]].concat()).collect();
        assert_eq!(little("rgba8", 10, &padded), colours);
        for encoding in ["bgr8", "8UC3"] {
            assert_eq!(little(encoding, 6, &colours), swapped);
        }
        for encoding in ["bgra8", "8UC4"] {
            assert_eq!(little(encoding, 10, &padded), swapped);
        }
    }

    #[test]
    fn sixteen_bits_keep_the_high_ones() {
        let data = [9, 1, 9, 2, 9, 3, 9, 4];
        for encoding in ["mono16", "16UC1"] {
            assert_eq!(little(encoding, 4, &data), [1, 2, 3, 4]);
            assert_eq!(samples(encoding, 4, true, &data).unwrap(), [9; 4]);
        }
        let wide: Vec<u8> = (1..=12).flat_map(|value| [200, value]).collect();
        assert_eq!(little("rgb16", 12, &wide), (1..=12).collect::<Vec<_>>());
        assert_eq!(little("16UC3", 12, &wide)[..3], [3, 2, 1]);
        assert_eq!(little("bgra16", 16, &[wide.clone(), vec![0; 8]].concat())[..3], [3, 2, 1]);
    }

    #[test]
    fn of_yuv_the_luma_is_taken() {
        for encoding in ["yuv422_yuy2", "yuyv"] {
            assert_eq!(little(encoding, 5, &[1, 90, 2, 91, 0, 3, 92, 4, 93, 0]), [1, 2, 3, 4]);
        }
        for encoding in ["yuv422", "uyvy"] {
            assert_eq!(little(encoding, 4, &[90, 1, 91, 2, 92, 3, 93, 4]), [1, 2, 3, 4]);
        }
        for encoding in ["nv21", "nv12"] {
            assert_eq!(little(encoding, 2, &[1, 2, 3, 4, 90, 91]), [1, 2, 3, 4]);
        }
        assert_eq!(little("nv24", 2, &[1, 2, 3, 4, 90, 91, 92, 93, 94, 95, 96, 97]), [1, 2, 3, 4]);
    }

    #[test]
    fn mosaics_give_every_pixel_its_colours() {
        for (encoding, data) in [
            ("bayer_rggb8", [10, 20, 30, 40]),
            ("bayer_bggr8", [40, 30, 20, 10]),
            ("bayer_gbrg8", [30, 40, 10, 20]),
            ("bayer_grbg8", [20, 10, 40, 30]),
        ] {
            let found = little(encoding, 2, &data);
            // One red, one blue, and greens of 20 and 30.
            for (pixel, own) in found.as_chunks::<3>().0.iter().zip(data) {
                let green = if [20, 30].contains(&own) { own } else { 25 };
                assert_eq!(*pixel, [10, green, 40], "{encoding}");
            }
            let wide: Vec<u8> = data.iter().flat_map(|value| [7, *value]).collect();
            assert_eq!(little(&encoding.replace('8', "16"), 4, &wide), found);
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (encoding, step, data, named) in [
            ("32FC1", 8, &[0; 16][..], "encoding '32FC1' is not known, only 16uc1"),
            ("rgb8", 5, &[0; 12], "a step of 5 bytes"),
            ("mono16", 3, &[0; 12], "a step of 3 bytes"),
            ("rgb8", 6, &[0; 11], "11 bytes of data"),
            ("rgb8", usize::MAX, &[0; 12], "12 bytes of data"),
            ("nv21", 2, &[0; 5], "5 bytes of data"),
        ] {
            let problem = samples(encoding, step, false, data).unwrap_err();
            assert!(problem.contains(named), "{named}: {problem}");
        }
    }
}
