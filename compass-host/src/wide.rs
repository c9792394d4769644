//! Run-time selection of the widest SIMD of the machine.
//!
//! The core is plain Rust, and its results do not depend on the vector instructions it is compiled for: integers are
//! exact, and the compiler neither reorders nor fuses float operations. So the host may compile the same code twice.

/// Defines functions that are compiled twice, for any machine and for one with AVX2, and dispatched at run time.
///
/// A callee gets AVX2 only where it is inlined into the body: `#[inline(always)]` down to the hot loops.
macro_rules! wide {
    ($($(#[$meta:meta])* $vis:vis fn $name:ident $(<$($life:lifetime),+>)? (
        $($argument:ident: $type:ty),* $(,)?
    ) $(-> $result:ty)? $body:block)+) => {$(
        $(#[$meta])*
        $vis fn $name $(<$($life),+>)? ($($argument: $type),*) $(-> $result)? {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn wide $(<$($life),+>)? ($($argument: $type),*) $(-> $result)? $body
                if std::arch::is_x86_feature_detected!("avx2") {
                    // SAFETY: the function is safe except that it needs AVX2, and the machine has it.
                    return unsafe { wide($($argument),*) };
                }
            }
            $body
        }
    )+};
}

pub(crate) use wide;

#[cfg(test)]
mod tests {
    wide! {
        fn longer<'a>(one: &'a [u8], other: &'a [u8]) -> &'a [u8] {
            if one.len() < other.len() { other } else { one }
        }

        fn double(cells: &mut [u8]) {
            cells.iter_mut().for_each(|cell| *cell *= 2);
        }
    }

    #[test]
    fn arguments_and_results_pass_through() {
        let mut cells: Vec<u8> = (0..100).collect();
        double(&mut cells);
        assert!(cells.iter().zip(0..).all(|(cell, i)| *cell == 2 * i));
        assert_eq!(longer(&cells, &[1]), cells);
    }
}
