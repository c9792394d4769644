//! Cosine similarity of two descriptors at a heading shift, in exact integers.
//!
//! The paper's score is the plain cosine over all five channels. The centred cosine (the weighted correlation coefficient)
//! removes the mean of each channel: hit types agree by chance at 54 % of the bins, which raises the plain cosine of any
//! two descriptors but not the centred one.
//!
//! With w the channel weights, m the confidence of the query's bins and s the shift:
//!
//! | | numerator | squared norm of one side |
//! |---|---|---|
//! | plain | `sum_ch w sum_i m q d` | `sum_ch w sum_i m v^2` |
//! | centred | `sum_ch w (M sum_i m q d - sum_i m q sum_i m d)`, `M = sum_i m` | `sum_ch w (M sum_i m v^2 - (sum_i m v)^2)` |
//!
//! where d is taken at bin i + s. Bins of confidence 0 do not change the score. The score is the numerator over the
//! product of the norms, and 0 if a norm is 0.

mod cosine;
mod profile;
mod query;
mod weights;

pub use crate::base::confidence::Confidence;
pub use profile::{Candidate, Profile};
pub use query::{Peak, Query};
pub use weights::{Similarity, Weights};

use crate::base::num::Score;

/// Accuracy bound of a score against that of the real-valued descriptors: 2^-10, below 0.001.
pub const SCORE_ERROR: Score = Score::from_bits(1 << 20);
