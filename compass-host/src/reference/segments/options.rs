//! Parameters and results of the detector.

/// A straight edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// One end in pixels.
    pub start: [f64; 2],
    /// The other end in pixels; the order does not encode which side is bright.
    pub end: [f64; 2],
    /// Pixels whose gradient agrees with the segment; without validation its length in pixels.
    pub score: f64,
}

/// Parameters; the defaults are those of the published program.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Least magnitude `|dx| + |dy|` of an edge, in gray levels times 8.
    pub gradient_threshold: i32,
    /// The excess of an anchor over its neighbours across the edge, in the same unit.
    pub anchor_threshold: i32,
    /// Stride of the anchor search, in pixels.
    pub scan_interval: usize,
    /// Pixels in the fitted window; more than a walk can start with, `outlier_limit` + 3.
    pub minimum_length: usize,
    /// Mean squared distance from the line below which a window is straight, in pixels squared.
    pub fit_error: f64,
    /// Distance from the line below which a pixel belongs to it, in pixels.
    pub inlier_distance: f64,
    /// Consecutive outliers after which a walk still continues.
    pub outlier_limit: usize,
    /// Pixels by which the window slides.
    pub window_slide: usize,
    /// Gaps to bridge, in pixels, in the order tried; empty to never jump.
    pub jump_lengths: Vec<i32>,
    /// Ratio of the structure tensor's eigenvalues above which a jump lands on an edge.
    pub eigenvalue_ratio: f64,
    /// Angle between that edge and the segment below which the jump is taken, in degrees.
    pub jump_angle_deg: f64,
    /// Greatest angle between a pixel's gradient and the segment's normal, in radians.
    pub validation_angle_rad: f64,
    /// Whether segments are validated.
    pub validate: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            gradient_threshold: 30,
            anchor_threshold: 8,
            scan_interval: 2,
            minimum_length: 15,
            fit_error: 0.2,
            inlier_distance: 1.5,
            outlier_limit: 3,
            window_slide: 2,
            jump_lengths: vec![5, 7, 9],
            eigenvalue_ratio: 10.0,
            jump_angle_deg: 10.0,
            validation_angle_rad: 0.15,
            validate: true,
        }
    }
}
