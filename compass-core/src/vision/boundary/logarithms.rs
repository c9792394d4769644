//! Tables of logarithms and exponentials for the logits of boundaries.
//!
//! micromath computes their entries: its relative error, below 0.003, is far below the quantum of the tables.

use crate::base::num::{index_of, round_to_i16, truncate_to_i32};
use bytemuck::{Pod, Zeroable};
use micromath::F32Ext;

/// Bits of the mantissa in the index of a logarithm: relative steps of 1/64.
const MANTISSA_BITS: u32 = 6;
/// Shift from the bits of an `f32` to the index of a logarithm.
const SHIFT: u32 = 23 - MANTISSA_BITS;
/// Index of 1.0 before it is moved to 0.
const ONE: u32 = 1.0_f32.to_bits() >> SHIFT;
/// Powers of 2 of the table of logarithms: 1 to 2048.
const POWERS: usize = 11;
const LOGARITHMS: usize = POWERS << MANTISSA_BITS;
/// Shift from the bits of an `f32` to the index of a squared significance: 32 steps for each power of 2.
const SQUARE_SHIFT: u32 = 18;
/// Index of the least squared significance, 2^-12, before it is moved to 0.
const LEAST_SQUARE: u32 = (1.0_f32 / 4096.0).to_bits() >> SQUARE_SHIFT;
/// Squared significances from 2^-12 to 2^20.
const SQUARES: usize = 32 * 32;
/// Entries of a table of exponentials for each nat.
const PER_NAT: i32 = 32;
/// Least logarithm in the table of exponentials, nats.
const LEAST: i32 = -16;
const EXPONENTIALS: usize = 40 * PER_NAT as usize;

/// Logarithms in 1/256 nat of 1 to 2048, and exponentials of -16 to 24 nats.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Logarithms {
    logarithms: [i16; LOGARITHMS],
    significances: [i16; SQUARES],
    exponentials: [f32; EXPONENTIALS],
}

impl Logarithms {
    /// Fills the tables.
    pub(super) fn fill(&mut self) {
        for (index, slot) in (0_u32..).zip(&mut self.logarithms) {
            // The middle of the values of an index.
            let value = f32::from_bits(((ONE + index) << SHIFT) | 1 << (SHIFT - 1));
            *slot = round_to_i16(256.0 * F32Ext::ln(value));
        }
        for (index, slot) in (0_u32..).zip(&mut self.significances) {
            let square = f32::from_bits(((LEAST_SQUARE + index) << SQUARE_SHIFT) | 1 << (SQUARE_SHIFT - 1));
            *slot = round_to_i16(256.0 * F32Ext::ln(1.0 + libm::sqrtf(square)));
        }
        for (index, slot) in (0_u16..).zip(&mut self.exponentials) {
            *slot = F32Ext::exp((f32::from(index) + 0.5) / PER_NAT as f32 + LEAST as f32);
        }
    }

    /// The index of a logarithm of at least 1.
    #[inline(always)]
    pub(super) const fn index(value: f32) -> u32 {
        (value.to_bits() >> SHIFT).wrapping_sub(ONE)
    }

    /// The logarithm of an [index](Self::index), 1/256 nat; those beyond the table have its last.
    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "clamped to the table")]
    pub(super) fn at(&self, index: u32) -> i32 {
        i32::from(self.logarithms[(index as usize).min(LOGARITHMS - 1)])
    }

    /// The index of a squared significance for [`significance`](Self::significance).
    #[inline(always)]
    pub(super) const fn square_index(square: f32) -> u32 {
        // Squares below the table have its first entry.
        (square.to_bits() >> SQUARE_SHIFT).saturating_sub(LEAST_SQUARE)
    }

    /// `ln(1 + t)` for the [index](Self::square_index) of t^2, 1/256 nat. A root less than `ln(1 + sqrt(t^2))` takes.
    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "clamped to the table")]
    pub(super) fn significance(&self, index: u32) -> i32 {
        i32::from(self.significances[(index as usize).min(SQUARES - 1)])
    }

    /// The logarithm of a value of at least 1, 1/256 nat.
    #[inline(always)]
    pub(super) fn ln(&self, value: f32) -> i32 {
        self.at(Self::index(value))
    }

    /// e to the power of a value in 1/65536 nat, clamped to -16 to 24 nats.
    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "clamped to the table")]
    pub(super) fn exp(&self, value: i32) -> f32 {
        let index = (value >> 11) - LEAST * PER_NAT;
        self.exponentials[index_of(index.max(0)).min(EXPONENTIALS - 1)]
    }
}

/// A value in nats as 1/65536 nat.
pub(super) const fn to_logit(nats: f32) -> i32 {
    truncate_to_i32(nats * 65_536.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::boxed::Box;

    #[test]
    fn entries_are_within_their_quantum() {
        let mut tables: Box<Logarithms> = Box::new(bytemuck::Zeroable::zeroed());
        tables.fill();
        for k in 0..4000_u16 {
            let value = 1.0 + f32::from(k) * f32::from(k) / 8000.0;
            let exact = f64::from(value).ln();
            let found = f64::from(tables.ln(value)) / 256.0;
            assert!((found - exact).abs() < 1.0 / 128.0 + 0.005, "ln {value}: {found}, not {exact}");
        }
        for k in 0..3000_u16 {
            let significance = f32::from(k) * f32::from(k) / 9000.0;
            let found = tables.significance(Logarithms::square_index(significance * significance));
            let exact = f64::from(significance).ln_1p();
            assert!((f64::from(found) / 256.0 - exact).abs() < 0.02, "{significance}: {found}");
        }
        for k in -1000..1500 {
            let nats = f64::from(k) / 64.0;
            let found = f64::from(tables.exp(to_logit(nats as f32)));
            assert!((found.ln() - nats).abs() < 1.0 / 64.0 + 0.003, "exp {nats}: {found}");
        }
        assert_eq!(tables.exp(i32::MAX), tables.exp(to_logit(23.999)));
        assert_eq!(tables.ln(f32::INFINITY), tables.ln(2047.9));
    }
}
