//! Readers of other people's code on a stranger's file: their panic is an error of the file.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether a reader is at work on this thread, whose panic nobody needs to be told.
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// What a reader returns; `None` if it panics, of which nothing is printed.
pub(crate) fn guarded<T>(read: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            if !IS_GUARDED.get() {
                before(panic);
            }
        }));
    });
    let outer = IS_GUARDED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(read));
    IS_GUARDED.set(outer);
    result.ok()
}

/// The problem with a file whose reader panics.
pub(crate) const GAVE_UP: &str = "the reader gave up";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_no_result() {
        let at = |slice: &[u8], at: usize| slice[at];
        assert_eq!(guarded(|| at(&[1, 2], 1)), Some(2));
        assert_eq!(guarded(|| guarded(|| at(&[1], 3))), Some(None));
        assert!(!IS_GUARDED.get());
    }
}
