//! Times of the stages of a computation.

use std::collections::BTreeMap;
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
use std::time::Instant;

/// A moment. WebAssembly by itself has no clock: there all work takes no time.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    #[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
    at: Instant,
}

impl Moment {
    /// The present.
    #[must_use]
    pub fn now() -> Self {
        Self {
            #[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
            at: Instant::now(),
        }
    }

    /// Milliseconds since then.
    #[must_use]
    pub fn milliseconds(self) -> f64 {
        #[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
        return self.at.elapsed().as_secs_f64() * 1e3;
        #[cfg(all(target_family = "wasm", target_os = "unknown"))]
        return 0.0;
    }
}

/// Milliseconds by stage.
#[derive(Debug)]
pub struct Clock {
    last: Moment,
    stages: BTreeMap<&'static str, f64>,
}

impl Clock {
    /// Begins the first stage.
    pub fn start() -> Self {
        Self { last: Moment::now(), stages: BTreeMap::new() }
    }

    /// Ends the stage of this name and begins the next.
    pub fn stage(&mut self, name: &'static str) {
        self.stages.insert(name, self.last.milliseconds());
        self.restart();
    }

    /// Restarts the current stage: the time before it is discarded.
    pub fn restart(&mut self) {
        self.last = Moment::now();
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
