//! The stages of `compass-core`, one checksum each.
//!
//! The host, emulated Cortex-M boards and emulated ARM Linux all run this list on the same bytes. The
//! core uses no floating point, so the checksums must be equal everywhere, bit for bit.
//!
//! A stage reads the [`Inputs`] and what earlier stages left in the [`Workspace`], and leaves its own
//! output there. Taking the checksum is a separate function, so that a target can count what the stage
//! alone costs. To add a stage, give its output a field of [`Workspace`] and append it to [`STAGES`].
#![no_std]
#![forbid(unsafe_code)]

use compass_core::num::{BINS, Turn, Unit};
use crc::{CRC_32_ISO_HDLC, Crc};

/// Angles of the trigonometry stages.
const ANGLES: usize = 2 * BINS;

/// What every target computes on.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// A packed floor plan; empty while no stage reads one.
    pub plan: &'a [u8],
}

impl Inputs<'static> {
    /// The sample that is compared between targets.
    pub const SAMPLE: Self = Self { plan: &[] };
}

/// The output of each stage; no stage allocates.
#[derive(Debug)]
pub struct Workspace {
    turns: [Turn; ANGLES],
    directions: [(Unit, Unit); ANGLES],
}

impl Workspace {
    /// An empty workspace, usable in a `static`.
    #[must_use]
    pub const fn new() -> Self {
        Self { turns: [Turn::ZERO; ANGLES], directions: [(Unit::ZERO, Unit::ZERO); ANGLES] }
    }
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}

/// One entry of the list.
#[derive(Debug, Clone, Copy)]
pub struct Stage {
    /// Name in the report, without spaces.
    pub name: &'static str,
    /// Computes the stage's output.
    pub run: fn(&Inputs<'_>, &mut Workspace),
    /// The [`checksum`] of every bit of that output.
    pub checksum: fn(&Workspace) -> u32,
}

/// All stages, in the order in which they must run.
pub const STAGES: &[Stage] = &[
    Stage { name: "turns", run: turns, checksum: |w| checksum(w.turns.iter().map(|turn| turn.to_bits())) },
    Stage {
        name: "cos_sin",
        run: cos_sin,
        checksum: |w| checksum(w.directions.iter().flat_map(|&(c, s)| [bits(c), bits(s)])),
    },
];

/// Runs all stages and reports the name and checksum of each.
pub fn run(inputs: &Inputs<'_>, workspace: &mut Workspace, report: &mut dyn FnMut(&str, u32)) {
    for stage in STAGES {
        (stage.run)(inputs, workspace);
        report(stage.name, (stage.checksum)(workspace));
    }
}

/// CRC-32 (the one of zip and PNG) of the words in little-endian order.
#[must_use]
pub fn checksum(words: impl IntoIterator<Item = u32>) -> u32 {
    static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut digest = CRC.digest();
    for word in words {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

const fn bits(value: Unit) -> u32 {
    value.to_bits().cast_unsigned()
}

/// Each whole degree, and a thousandth of a turn past it.
fn turns(_: &Inputs<'_>, workspace: &mut Workspace) {
    for (degrees, pair) in (0..).zip(workspace.turns.chunks_exact_mut(2)) {
        let whole = Turn::from_ratio(degrees, 360);
        pair.copy_from_slice(&[whole, whole + Turn::from_ratio(1, 1000)]);
    }
}

/// Cosine and sine of the [`turns`].
fn cos_sin(_: &Inputs<'_>, workspace: &mut Workspace) {
    for (direction, turn) in workspace.directions.iter_mut().zip(&workspace.turns) {
        *direction = turn.cos_sin();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksum_is_the_one_of_zip() {
        let words = [*b"1234", *b"5678"].map(u32::from_le_bytes);
        assert_eq!(checksum(words), 0x9ae0_daaf);
    }

    #[test]
    fn stages_have_distinct_names_and_repeat() {
        for (i, stage) in STAGES.iter().enumerate() {
            assert!(STAGES[..i].iter().all(|earlier| earlier.name != stage.name));
            assert!(!stage.name.contains(' '));
        }
        let mut workspace = Workspace::new();
        let mut sums = [[0; STAGES.len()]; 2];
        for sums in &mut sums {
            let mut left = sums.iter_mut();
            run(&Inputs::SAMPLE, &mut workspace, &mut |_, sum| *left.next().unwrap() = sum);
        }
        assert_eq!(sums[0], sums[1]);
    }
}
