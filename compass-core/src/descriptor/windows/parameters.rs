//! What the finder looks for.

/// Width in pixels of the image for which lengths are stated.
pub const REFERENCE_WIDTH: u16 = 1472;

/// Pixels up to this level are not scene but the black around the lens's image.
pub const BLACK: u8 = 12;

/// What the finder looks for. Lengths in pixels of an image [`REFERENCE_WIDTH`] wide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameters {
    /// Percentile of the rows' scores above which a row may belong to the band.
    pub band_percentile: u8,
    /// Least slope |dy| / |dx| of an upright segment, 1/1024: by default the tangent of 30 degrees.
    pub slope: u16,
    /// Shortest segment.
    pub min_length: u16,
    /// Farthest that segments of one edge lie apart along x.
    pub gap: u16,
    /// Narrowest window.
    pub min_width: u16,
    /// Widest window.
    pub max_width: u16,
    /// Height the two edges of a window share, in percent of the shorter one.
    pub shared_percent: u8,
    /// Percentile of the band's pixels above which the mean of a window lies.
    pub brightness_percentile: u8,
    /// Narrowest strip of wall beside a window; otherwise a quarter of the window's width.
    pub min_flank: u16,
    /// By how much a window outshines the wall beside it, in percent of the wall's brightness.
    pub contrast_percent: u8,
    /// Intersection over union in percent above which the worse of two proposals goes.
    pub overlap_percent: u8,
    /// Share of red pixels in percent above which a proposal goes.
    pub red_percent: u8,
    /// Radius in percent of the lens's image beyond which there are no windows.
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
    /// The same with lengths in pixels of an image of `width`, none below 1.
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
