//! Stack use, by painting the unused stack.

use cortex_m::register::msp;
use cortex_m_rt::STACK_PAINT_VALUE;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Bytes between the top of the stack and the deepest word that was ever overwritten, since reset or the last
/// [`paint`].
#[must_use]
pub fn high_water_mark() -> usize {
    &raw const _stack_start as usize - deepest() as usize
}

/// Bytes of stack in use by the caller and its callers.
#[must_use]
#[inline(always)]
pub fn depth() -> usize {
    &raw const _stack_start as usize - msp::read() as usize
}

/// Bytes reserved for the painting function itself.
const OWN: usize = 64;

/// Paints all unused stack.
#[inline(never)]
pub fn paint() {
    let top = msp::read();
    let mut word = (&raw const _stack_end).cast_mut();
    while (word as usize) + OWN < top as usize {
        // SAFETY: the bytes between the end of static memory and the stack pointer are unused; there are no interrupts
        // that would push onto them, and volatile writes are not moved.
        unsafe { word.write_volatile(STACK_PAINT_VALUE) };
        word = word.wrapping_add(1);
    }
}

/// The deepest word without paint.
fn deepest() -> *const u32 {
    let (top, limit) = (&raw const _stack_start, &raw const _stack_end);
    let mut deepest = limit;
    // SAFETY: both symbols bound the stack region, aligned to words; the words below the stack pointer are unused, and
    // volatile reads keep the compiler from reasoning about them.
    while deepest < top && unsafe { deepest.read_volatile() } == STACK_PAINT_VALUE {
        deepest = deepest.wrapping_add(1);
    }
    deepest
}
