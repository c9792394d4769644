//! Localizes a recording, frame by frame and as a sequence, and compares the poses with the ground truth.
//!
//! frames -> one [`Record`] each, on all cores, kept in a [`Journal`] so that an interrupted run continues ->
//! the [track](sequence::follow) -> [`Row`]s of errors, one per localization method.
//!
//! Each frame is also localized in two more ways. The *oracle* runs the same search on evidence computed from the plan
//! at the true pose: its failures are the search's own. The *paper's* method is the five-channel cosine of the
//! observed descriptor.

mod coverage;
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

pub use coverage::Coverage;
pub use error::EvaluateError;
pub use evidence_file::Evidence;
pub use frame_errors::FrameErrors;
pub use job::Job;
pub use journal::{Fingerprint, Journal};
pub use oracle::{perfect, sharp};
pub use paper::Paper;
pub use record::{Found, PAPER, Record};
pub use row::{Judge, Misses, Row};
pub use run::localize;
pub use worker::Worker;
