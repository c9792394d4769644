//! Parameters of the finder.

/// Width in pixels of the image that the lengths of [`Parameters`] refer to.
pub const REFERENCE_WIDTH: u16 = 1472;

/// Largest gray level of the black surround of the image circle.
pub const BLACK: u8 = 12;

/// Parameters of the finder. Lengths are in pixels of an image [`REFERENCE_WIDTH`] wide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameters {
    /// Percentile of the scores of rows above which a row can belong to the band.
    pub band_percentile: u8,
    /// Smallest slope |dy| / |dx| of an upright segment, 1/1024. Default: tangent of 30 degrees.
    pub slope: u16,
    /// Smallest length of a segment.
    pub min_length: u16,
    /// Largest distance along x of segments of one edge.
    pub gap: u16,
    /// Smallest width of a window.
    pub min_width: u16,
    /// Largest width of a window.
    pub max_width: u16,
    /// Smallest common height of the two edges of a window, percent of the shorter edge.
    pub shared_percent: u8,
    /// Percentile of the gray levels of the band that the mean of a window must exceed.
    pub brightness_percentile: u8,
    /// Smallest width of the strip of wall beside a window, which is else a quarter of the window.
    pub min_flank: u16,
    /// Smallest brightness difference of a window and the wall beside it, percent of that of the wall.
    pub contrast_percent: u8,
    /// Intersection over union, percent, above which the worse of two proposals is suppressed.
    pub overlap_percent: u8,
    /// Share of red pixels, percent, above which a proposal is rejected.
    pub red_percent: u8,
    /// Largest radius of a window, percent of that of the image circle.
    pub radius_percent: u8,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            band_percentile: 50,
            slope: 591,
            min_length: 29,
            gap: 8,
            min_width: 12,
            max_width: 400,
            shared_percent: 50,
            brightness_percentile: 60,
            min_flank: 6,
            contrast_percent: 10,
            overlap_percent: 30,
            red_percent: 15,
            radius_percent: 95,
        }
    }
}

impl Parameters {
    /// The parameters with lengths scaled to an image of this width, at least 1 pixel.
    #[expect(clippy::cast_possible_truncation, reason = "clamped to 16 bits")]
    pub(super) fn scaled(self, width: u32) -> Self {
        let scale = |length: u16| {
            let length = u64::from(length) * u64::from(width) / u64::from(REFERENCE_WIDTH);
            length.clamp(1, u64::from(u16::MAX)) as u16
        };
        Self {
            min_length: scale(self.min_length),
            gap: scale(self.gap),
            min_width: scale(self.min_width),
            max_width: scale(self.max_width),
            min_flank: scale(self.min_flank),
            ..self
        }
    }
}
