//! Executed instructions, counted exactly.
//!
//! Under QEMU's `-icount shift=7` each instruction advances the emulated clock by 2^7 ns. A timer of the
//! board ticks every 31 to 50 ns, more than twice an instruction, so rounding its reading to
//! whole instructions is exact. The 100 Hz counter of the same boards supplies the bits above the
//! timer's. Cycles are not modelled: these figures say nothing about milliseconds.
//!
//! References: Arm DUI 0479 (CMSDK timer), Arm DAI 0400, 0505 and 0547 (FPGA system registers of the boards).

use core::arch::asm;

/// The clocks of a board.
struct Clocks {
    /// A timer that counts down.
    control: usize,
    /// What starts it.
    enable: u32,
    reload: usize,
    value: usize,
    bits: u32,
    /// Picoseconds per tick.
    tick_ps: u64,
    /// FPGAIO CLK100HZ: counts up at 100 Hz.
    clk100hz: usize,
}

/// The clocks of the board that the image is built for. On secure boards peripherals are at their secure addresses.
const CLOCKS: Clocks = match env!("COMPASS_BOARD").as_bytes() {
    b"an505" => Clocks { tick_ps: 50_000, clk100hz: 0x5030_2014, ..cmsdk_timer(0x5000_0000) },
    // SysTick; the timers of this board have another interface.
    b"an547" => Clocks {
        control: 0xe000_e010,
        enable: 0b101,
        reload: 0xe000_e014,
        value: 0xe000_e018,
        bits: 24,
        tick_ps: 31_250,
        clk100hz: 0x5930_2014,
    },
    _ => cmsdk_timer(0x4000_0000),
};

/// CMSDK TIMER0 of the older boards.
const fn cmsdk_timer(base: usize) -> Clocks {
    Clocks {
        control: base,
        enable: 1,
        reload: base + 8,
        value: base + 4,
        bits: 32,
        tick_ps: 40_000,
        clk100hz: 0x4002_8014,
    }
}

/// The last reading before the timer wraps.
const LAST: u64 = (1 << CLOCKS.bits) - 1;
/// Picoseconds per tick of the 100 Hz counter.
const CENTISECOND_PS: u64 = 10_000_000_000;
/// Picoseconds per instruction: the emulator's `-icount shift=7`.
const INSTRUCTION_PS: u64 = 1000 << 7;

/// A timer that was verified to count instructions.
#[derive(Debug)]
pub struct Counter {
    overhead: u64,
}

/// The readings of the clocks at one instant.
#[derive(Debug, Clone, Copy)]
pub struct Reading {
    coarse: u32,
    fine: u64,
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
        // Two instructions per iteration; call, argument and return.
        const EXPECTED: u64 = 2 * TURNS as u64 + 4;
        // SAFETY: the registers of a timer that nothing else uses.
        unsafe {
            (CLOCKS.reload as *mut u32).write_volatile(LAST as u32);
            (CLOCKS.value as *mut u32).write_volatile(LAST as u32);
            (CLOCKS.control as *mut u32).write_volatile(CLOCKS.enable);
        }
        let mut counter = Self { overhead: 0 };
        counter.overhead = counter.count(|| ()).1;
        let ((), counted) = counter.count(|| spin(TURNS));
        assert!(
            counted.abs_diff(EXPECTED) <= 8,
            "{EXPECTED} instructions count as {counted}: run with -icount shift=7 on {}",
            env!("COMPASS_BOARD")
        );
        counter
    }

    /// Runs `f`; returns its result and the instructions it executed.
    pub fn count<T>(&self, f: impl FnOnce() -> T) -> (T, u64) {
        let start = now();
        let value = f();
        (value, self.since(start))
    }

    /// The instructions executed since a reading.
    #[must_use]
    #[inline(always)]
    pub fn since(&self, start: Reading) -> u64 {
        between(start, now()).saturating_sub(self.overhead)
    }
}

/// Reads the clocks.
#[must_use]
#[inline(never)]
pub fn now() -> Reading {
    // SAFETY: reading these registers has no side effect.
    let read = |register: usize| unsafe { (register as *const u32).read_volatile() };
    Reading { coarse: read(CLOCKS.clk100hz), fine: LAST - u64::from(read(CLOCKS.value)) }
}

/// Instructions between two readings, reading the clocks included.
fn between(start: Reading, end: Reading) -> u64 {
    let fine = end.fine.wrapping_sub(start.fine) & LAST;
    let coarse = u64::from(end.coarse.wrapping_sub(start.coarse)) * CENTISECOND_PS / CLOCKS.tick_ps;
    // The coarse count is off by less than one of its ticks, far below half a period of the timer.
    let turns = (coarse.saturating_sub(fine) + LAST / 2) >> CLOCKS.bits;
    let picoseconds = ((turns << CLOCKS.bits) + fine) * CLOCKS.tick_ps;
    (picoseconds + INSTRUCTION_PS / 2) / INSTRUCTION_PS
}

/// Two instructions per iteration.
#[inline(never)]
fn spin(turns: u32) {
    // SAFETY: touches one register and the flags.
    unsafe {
        asm!("2: subs {n}, #1", "bne 2b", n = inout(reg) turns => _, options(nomem, nostack));
    }
}
