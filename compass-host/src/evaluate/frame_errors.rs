//! The errors of one frame, as the report shows them.

/// One frame for the report. Errors are infinite without a pose, and NaN without ground truth.
#[derive(Debug, Clone)]
pub struct FrameErrors {
    /// The time of the frame.
    pub timestamp_ns: u64,
    /// True position, metres.
    pub truth: Option<[f64; 2]>,
    /// Position from the single frame, on the floor that is shown.
    pub single: Option<[f64; 2]>,
    /// Position from the track, on the floor that is shown.
    pub track: Option<[f64; 2]>,
    /// Position errors by row of the error table, metres.
    pub metres: Vec<f64>,
    /// Heading errors by row of the error table, degrees.
    pub degrees: Vec<f64>,
    /// Lead of the single frame's pose over the best one elsewhere, nats.
    pub margin: f64,
    /// Why the frame gave no evidence.
    pub problem: Option<String>,
}
