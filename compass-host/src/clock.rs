//! Times of the stages of a computation.

use std::collections::BTreeMap;
use std::time::Instant;

/// Milliseconds by stage.
#[derive(Debug)]
pub struct Clock {
    last: Instant,
    stages: BTreeMap<&'static str, f64>,
}

impl Clock {
    /// Begins the first stage.
    pub fn start() -> Self {
        Self { last: Instant::now(), stages: BTreeMap::new() }
    }

    /// Ends the stage of this name and begins the next.
    pub fn stage(&mut self, name: &'static str) {
        self.stages.insert(name, self.last.elapsed().as_secs_f64() * 1e3);
        self.restart();
    }

    /// Restarts the current stage: the time before it is discarded.
    pub fn restart(&mut self) {
        self.last = Instant::now();
    }

    /// Adds stages that were timed elsewhere.
    pub fn extend(&mut self, stages: impl IntoIterator<Item = (&'static str, f64)>) {
        self.stages.extend(stages);
        self.restart();
    }

    /// The times by stage.
    pub fn stages(&self) -> &BTreeMap<&'static str, f64> {
        &self.stages
    }
}
