//! Stack use since reset, by the paint that the start-up code left on unused stack.

use cortex_m_rt::STACK_PAINT_VALUE;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Bytes between the top of the stack and the deepest word that was ever overwritten.
#[must_use]
pub fn high_water_mark() -> usize {
    let (top, limit) = (&raw const _stack_start, &raw const _stack_end);
    let mut deepest = limit;
    // SAFETY: both symbols bound the stack region, aligned to words; the words below the stack pointer
    // belong to nobody, and volatile reads keep the compiler from reasoning about them.
    while deepest < top && unsafe { deepest.read_volatile() } == STACK_PAINT_VALUE {
        deepest = deepest.wrapping_add(1);
    }
    top as usize - deepest as usize
}
