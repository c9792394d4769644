//! Progress of long work, as the page is told it.

use compass_host::{Progress, Steps};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Tells the page, at most a hundred times.
pub(crate) struct Told;

struct Work {
    total: usize,
    done: AtomicUsize,
}

impl Progress for Told {
    fn begin(&self, total: usize, _: &'static str) -> Box<dyn Steps> {
        Box::new(Work { total, done: AtomicUsize::new(0) })
    }
}

impl Steps for Work {
    fn step(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        let percent = |done: usize| 100 * done / self.total.max(1);
        if percent(done) != percent(done - 1) {
            tell(percent(done) as u32);
        }
    }
}

#[cfg(target_family = "wasm")]
fn tell(percent: u32) {
    #[link(wasm_import_module = "page")]
    unsafe extern "C" {
        safe fn progress(percent: u32);
    }
    progress(percent);
}

#[cfg(not(target_family = "wasm"))]
fn tell(_: u32) {}
