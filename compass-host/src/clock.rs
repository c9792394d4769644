//! How long the stages of a piece of work take.

use std::collections::BTreeMap;
use std::time::Instant;

/// Milliseconds by stage.
#[derive(Debug)]
pub(crate) struct Clock {
    last: Instant,
    stages: BTreeMap<&'static str, f64>,
}

impl Clock {
    /// Begins the first stage.
    pub(crate) fn start() -> Self {
        Self { last: Instant::now(), stages: BTreeMap::new() }
    }

    /// Ends the stage of this name and begins the next.
    pub(crate) fn stage(&mut self, name: &'static str) {
        self.stages.insert(name, self.last.elapsed().as_secs_f64() * 1e3);
        self.restart();
    }

    /// Begins a stage anew: what went before belongs to none.
    pub(crate) fn restart(&mut self) {
        self.last = Instant::now();
    }

    /// What the stages took.
    pub(crate) fn stages(&self) -> &BTreeMap<&'static str, f64> {
        &self.stages
    }
}
