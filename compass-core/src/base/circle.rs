//! One value per direction, and modular arithmetic of bins.

use super::num::BINS;
use bytemuck::TransparentWrapper;

/// One value per bin of 1 degree, counter-clockwise; bin 360 is bin 0 again.
///
/// Accessors take any `usize` modulo 360, so that no caller takes a remainder: write the bin `offset` before `bin` as
/// `bin + BINS - offset`. Loops over all bins in order use the [array](Self::bins).
///
/// ```
/// use compass_core::base::circle::Circle;
///
/// let circle = Circle::from_fn(|bin| 2 * bin);
/// assert_eq!((circle.get(1), circle.get(359), circle.get(361)), (2, 718, 2));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, TransparentWrapper)]
#[repr(transparent)]
pub struct Circle<T>([T; BINS]);

impl<T> Circle<T> {
    /// Makes a circle of the values of bins 0 to 359.
    #[must_use]
    pub const fn new(bins: [T; BINS]) -> Self {
        Self(bins)
    }

    /// Views an array as a circle.
    #[must_use]
    #[inline]
    pub fn of(bins: &[T; BINS]) -> &Self {
        Self::wrap_ref(bins)
    }

    /// Calls `value` for bins 0 to 359.
    #[must_use]
    #[inline]
    pub fn from_fn(value: impl FnMut(usize) -> T) -> Self {
        Self(core::array::from_fn(value))
    }

    /// The values of bins 0 to 359.
    #[must_use]
    pub const fn bins(&self) -> &[T; BINS] {
        &self.0
    }
}

impl<T: Copy> Circle<T> {
    /// The value of a bin, taken modulo 360.
    #[must_use]
    #[inline]
    #[expect(clippy::indexing_slicing, reason = "the remainder is below `BINS`")]
    pub const fn get(&self, bin: usize) -> T {
        self.0[bin % BINS]
    }
}

/// The two neighbours of a bin, before and after it, each below 360.
///
/// ```
/// assert_eq!(compass_core::base::circle::beside(0), [359, 1]);
/// ```
#[must_use]
#[inline]
pub const fn beside(bin: usize) -> [usize; 2] {
    [(bin + BINS - 1) % BINS, (bin + 1) % BINS]
}

/// Number of bins between two bins along the shorter arc, at most 180.
///
/// ```
/// assert_eq!(compass_core::base::circle::distance(350, 15), 25);
/// ```
#[must_use]
#[inline]
pub const fn distance(a: usize, b: usize) -> usize {
    let bins = a.abs_diff(b) % BINS;
    if bins < BINS - bins { bins } else { BINS - bins }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn bins_are_taken_modulo_360(bin in 0_usize..3 * BINS) {
            let circle = Circle::from_fn(|bin| bin);
            prop_assert_eq!(circle.get(bin), bin % BINS);
            prop_assert_eq!(beside(bin).map(|bin| circle.get(bin)), [(bin + 359) % 360, (bin + 1) % 360]);
        }

        #[test]
        fn distance_is_along_the_shorter_arc(a in 0_usize..BINS, b in 0_usize..BINS) {
            let shorter = distance(a, b);
            prop_assert!(shorter <= 180 && ((a + shorter) % BINS == b || (b + shorter) % BINS == a));
            prop_assert_eq!(shorter, distance(b + BINS, a));
        }
    }
}
