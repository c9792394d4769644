//! Localizing a recording, frame by frame and as a sequence, and holding the answers against the truth.
//!
//! frames -> one [`Record`] each, on all cores, kept in a [`Journal`] so that an interrupted run continues ->
//! the [track](sequence::follow) -> [`Row`]s of errors, one for each way of localizing.
//!
//! Beside the answer from the frame there are two more for each frame. The *oracle* is the same search with evidence
//! that the plan itself gives at the true pose: what it loses the matcher loses. The *paper's* is the five-channel
//! cosine of the descriptor of what was seen.

mod error;
mod evidence_file;
pub mod frame_errors;
mod job;
mod journal;
pub mod judged;
pub mod largest_errors;
mod oracle;
mod paper;
mod record;
pub mod report;
mod row;
mod run;
pub mod sequence;
mod worker;

pub use error::EvaluateError;
pub use evidence_file::Evidence;
pub use frame_errors::FrameErrors;
pub use job::Job;
pub use journal::{Fingerprint, Journal};
pub use oracle::sharp;
pub use paper::Paper;
pub use record::{Found, PAPER, Record};
pub use row::{Judge, Misses, Row};
pub use run::localize;
pub use worker::Worker;
