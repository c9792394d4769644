//! Progress reports of work that may take longer than a second.

/// Receives the progress of work.
///
/// The library calls it from several threads at once.
pub trait Progress: Sync {
    /// Begins work of `total` steps; the work ends when the returned value is dropped.
    ///
    /// `what` is a short English phrase for people, such as `casting candidates`.
    fn begin(&self, total: usize, what: &'static str) -> Box<dyn Steps>;
}

/// Work in progress.
pub trait Steps: Send + Sync {
    /// Reports that one more step is done.
    fn step(&self);
}

/// Discards all progress.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _: usize, _: &'static str) -> Box<dyn Steps> {
        Box::new(Self)
    }
}

impl Steps for Silent {
    fn step(&self) {}
}
