//! How long the stages of a piece of work take.

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

    /// Begins a stage anew: what went before belongs to none.
    pub fn restart(&mut self) {
        self.last = Instant::now();
    }

    /// Takes over stages that were timed elsewhere.
    pub fn extend(&mut self, stages: impl IntoIterator<Item = (&'static str, f64)>) {
        self.stages.extend(stages);
        self.restart();
    }

    /// What the stages took.
    pub fn stages(&self) -> &BTreeMap<&'static str, f64> {
        &self.stages
    }
}
