//! Executed instructions, counted exactly.
//!
//! Under QEMU's `-icount shift=7` each instruction advances the emulated clock by 2^7 ns. The 25 MHz
//! timer of the MPS2 boards ticks every 40 ns, 3.2 times an instruction, so rounding its reading to
//! whole instructions is exact. The 100 Hz counter of the same boards supplies the bits above the
//! timer's 32. Cycles are not modelled: these figures say nothing about milliseconds.
//!
//! References: Arm DUI 0479 (CMSDK timer), Arm DAI 0400 (MPS2 FPGA system registers).

use core::arch::asm;

/// CMSDK TIMER0: counts down at 25 MHz.
const TIMER0_CTRL: *mut u32 = 0x4000_0000 as *mut u32;
const TIMER0_VALUE: *mut u32 = 0x4000_0004 as *mut u32;
const TIMER0_RELOAD: *mut u32 = 0x4000_0008 as *mut u32;
/// FPGAIO CLK100HZ: counts up at 100 Hz.
const CLK100HZ: *const u32 = 0x4002_8014 as *const u32;

/// Timer ticks per tick of the 100 Hz counter.
const TICKS_PER_CENTISECOND: u64 = 250_000;
/// Nanoseconds per timer tick.
const TICK_NS: u64 = 40;
/// The emulator's `-icount shift`.
const SHIFT: u32 = 7;

/// A timer that proved to count instructions.
#[derive(Debug)]
pub struct Counter {
    overhead: u64,
}

impl Counter {
    /// Starts the timer and checks it on a loop of known length.
    ///
    /// # Panics
    /// If the clock does not advance by 2^7 ns an instruction: started without `-icount shift=7`, or
    /// on another board.
    #[must_use]
    pub fn start() -> Self {
        const TURNS: u32 = 1_000_000;
        // Two instructions a turn; call, argument and return.
        const EXPECTED: u64 = 2 * TURNS as u64 + 4;
        // SAFETY: the registers of a timer nothing else uses.
        unsafe {
            TIMER0_RELOAD.write_volatile(u32::MAX);
            TIMER0_VALUE.write_volatile(u32::MAX);
            TIMER0_CTRL.write_volatile(1);
        }
        let counter = Self { overhead: raw(|| ()).1 };
        let ((), counted) = counter.count(|| spin(TURNS));
        assert!(
            counted.abs_diff(EXPECTED) <= 8,
            "{EXPECTED} instructions count as {counted}: run with -icount shift=7 on mps2-an500 or mps2-an386"
        );
        counter
    }

    /// What `f` returns, and the instructions it executed.
    pub fn count<T>(&self, f: impl FnOnce() -> T) -> (T, u64) {
        let (value, counted) = raw(f);
        (value, counted.saturating_sub(self.overhead))
    }
}

/// As [`Counter::count`], reading the clock included.
#[inline(never)]
fn raw<T>(f: impl FnOnce() -> T) -> (T, u64) {
    // SAFETY: reading these registers has no side effect.
    let centiseconds = || unsafe { CLK100HZ.read_volatile() };
    let ticks = || !unsafe { TIMER0_VALUE.read_volatile() };
    let (coarse_start, fine_start) = (centiseconds(), ticks());
    let value = f();
    let (fine_end, coarse_end) = (ticks(), centiseconds());
    let fine = u64::from(fine_end.wrapping_sub(fine_start));
    let coarse = u64::from(coarse_end.wrapping_sub(coarse_start)) * TICKS_PER_CENTISECOND;
    // The coarse count is off by less than one of its ticks, far below half a turn of the timer.
    let wraps = (coarse.saturating_sub(fine) + (1 << 31)) >> 32;
    let nanoseconds = ((wraps << 32) + fine) * TICK_NS;
    (value, (nanoseconds + (1 << (SHIFT - 1))) >> SHIFT)
}

/// Two instructions a turn.
#[inline(never)]
fn spin(turns: u32) {
    // SAFETY: touches one register and the flags.
    unsafe {
        asm!("2: subs {n}, #1", "bne 2b", n = inout(reg) turns => _, options(nomem, nostack));
    }
}
