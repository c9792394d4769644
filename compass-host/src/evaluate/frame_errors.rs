//! One frame of an evaluation with its errors, as the report shows it.

/// One frame for the report. Errors are infinite without a pose, and not a number without a truth.
#[derive(Debug, Clone)]
pub struct FrameErrors {
    /// The time of the frame.
    pub timestamp_ns: u64,
    /// Where it truly was, metres.
    pub truth: Option<[f64; 2]>,
    /// Where it was found by itself, on the floor that is shown.
    pub single: Option<[f64; 2]>,
    /// Where the track had it, on the floor that is shown.
    pub track: Option<[f64; 2]>,
    /// Position and heading error by row of the table: metres.
    pub metres: Vec<f64>,
    /// The same in degrees.
    pub degrees: Vec<f64>,
    /// By how many nats the single answer leads.
    pub margin: f64,
    /// Why nothing was seen.
    pub problem: Option<String>,
}
