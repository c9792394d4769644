//! Why a node cannot run.

use thiserror::Error;

/// Why a node cannot run.
#[derive(Debug, Error)]
#[error("{what}: {why}")]
pub struct NodeError {
    what: String,
    why: String,
}

pub(super) fn failed(what: impl Into<String>, why: impl Into<String>) -> NodeError {
    NodeError { what: what.into(), why: why.into() }
}
