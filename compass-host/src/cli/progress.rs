//! Progress bars on standard error; hidden when it is not a terminal.

use compass_host::progress::{Progress, Steps};
use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// Shows the library's progress as bars.
pub(super) struct Bars;

/// A sign of life during work whose length nobody knows; it disappears when dropped.
pub(super) struct Waiting(ProgressBar);

impl Waiting {
    pub(super) fn for_work(what: &'static str) -> Self {
        let bar = ProgressBar::new_spinner().with_message(what);
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }
}

impl Drop for Waiting {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// A bar that disappears when its work ends.
struct Bar(ProgressBar);

impl Progress for Bars {
    fn begin(&self, total: usize, what: &'static str) -> Box<dyn Steps> {
        let style = ProgressStyle::with_template("{msg} [{bar:40}] {pos}/{len} {eta}");
        let bar = ProgressBar::new(total as u64).with_message(what);
        Box::new(Bar(style.map_or_else(|_| bar.clone(), |style| bar.clone().with_style(style))))
    }
}

impl Steps for Bar {
    fn step(&self) {
        self.0.inc(1);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
