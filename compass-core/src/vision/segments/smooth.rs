//! Gaussian smoothing, 5 x 5 pixels, sigma 1 pixel, in integers.

use crate::base::raster::GrayImage;

/// Kernel weights at distance 2, 1 and 0, in 1/128 of the sum: a Gaussian of sigma 1.
const WEIGHTS: [u16; 3] = [7, 31, 52];

/// Smooths row `y` of `image` into `out`; the border is reflected without repeating the edge pixel.
///
/// The result is within one gray level of the exact, rounded sum. `column` is scratch of the image's width.
#[inline(always)]
pub(super) fn smooth_row(image: &GrayImage<'_>, y: usize, column: &mut [u16], out: &mut [u8]) {
    let height = image.height() as usize;
    let row = |offset: isize| image.row(mirror(y.cast_signed() + offset, height));
    let rows = [row(-2), row(-1), row(0), row(1), row(2)];
    let width = out.len().min(column.len());
    let [a, b, c, d, e] = rows.map(|r| r.get(..width).unwrap_or(&[]));
    let [w0, w1, w2] = WEIGHTS;
    for (((((sum, a), b), c), d), e) in column.iter_mut().zip(a).zip(b).zip(c).zip(d).zip(e) {
        let [a, b, c, d, e] = [a, b, c, d, e].map(|p| u16::from(*p));
        *sum = w0 * (a + e) + w1 * (b + d) + w2 * c;
    }
    let column = column.get(..width).unwrap_or_default();
    let inner = out.get_mut(2..width.saturating_sub(2)).unwrap_or(&mut []);
    let window = |k: usize| column.get(k..).unwrap_or(&[]);
    for (((((out, a), b), c), d), e) in
        inner.iter_mut().zip(window(0)).zip(window(1)).zip(window(2)).zip(window(3)).zip(window(4))
    {
        *out = weigh([*a, *b, *c, *d, *e]);
    }
    for x in (0..width.min(2)).chain(width.saturating_sub(2).max(2)..width) {
        let at = |offset: isize| column.get(mirror(x.cast_signed() + offset, width)).copied().unwrap_or(0);
        if let Some(out) = out.get_mut(x) {
            *out = weigh([at(-2), at(-1), at(0), at(1), at(2)]);
        }
    }
}

/// Rounds the weighted sum of five column sums (at most 128 * 255) to a pixel.
///
/// Each product keeps its upper 16 bits, so that eight lanes fit a vector of 128 bits. The truncation, at most 3/128 of a
/// level, is compensated in the mean.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    reason = "the weights sum to 128, so that the mean of gray levels is at most 255"
)]
fn weigh([a, b, c, d, e]: [u16; 5]) -> u8 {
    const fn product(sum: u16, weight: u16) -> u16 {
        ((sum as u32 * ((weight as u32) << 9)) >> 16) as u16
    }
    let [w0, w1, w2] = WEIGHTS;
    ((product(a + e, w0) + product(b + d, w1) + product(c, w2) + 64 + 1) >> 7) as u8
}

/// Reflects an index into `0..length`, without repeating the edge.
fn mirror(index: isize, length: usize) -> usize {
    let last = length.cast_signed() - 1;
    let index = index.abs();
    let index = if index > last { 2 * last - index } else { index };
    index.clamp(0, last.max(0)).cast_unsigned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn smooth(pixels: &[u8], width: usize, height: usize) -> Vec<u8> {
        let image = GrayImage::new(pixels, width as u32, height as u32).unwrap();
        let mut column = std::vec![0; width];
        let mut out = std::vec![0; width * height];
        for (y, row) in out.chunks_exact_mut(width).enumerate() {
            smooth_row(&image, y, &mut column, row);
        }
        out
    }

    #[test]
    fn keeps_flat_images() {
        for level in [0, 1, 128, 255] {
            assert!(smooth(&[level; 77], 11, 7).iter().all(|p| *p == level));
        }
    }

    proptest! {
        #[test]
        fn is_within_a_level_of_the_exact_sum(width in 1_usize..24, height in 1_usize..9, seed in any::<[u8; 32]>()) {
            let pixels: Vec<u8> =
                (0..width * height).map(|i| seed[i % 32].wrapping_mul(i as u8 | 1).wrapping_add(seed[(i / 32) % 32])).collect();
            let out = smooth(&pixels, width, height);
            const KERNEL: [u32; 5] = [14, 62, 104, 62, 14];
            for (i, p) in out.iter().enumerate() {
                let (x, y) = ((i % width) as isize, (i / width) as isize);
                let mut sum = 0_u32;
                for (v, wv) in KERNEL.iter().enumerate() {
                    for (u, wu) in KERNEL.iter().enumerate() {
                        let at = mirror(y + v as isize - 2, height) * width + mirror(x + u as isize - 2, width);
                        sum += wu * wv * u32::from(pixels[at]);
                    }
                }
                // Truncation subtracts at most 3/128 of a level, the compensation adds 1/128.
                let exact = f64::from(sum) / 65_536.0;
                prop_assert!((f64::from(*p) - exact).abs() <= 0.5 + 2.0 / 128.0, "{} {}", p, exact);
            }
        }
    }
}
