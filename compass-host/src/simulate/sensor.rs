//! From radiance to bytes: blur and glow, exposure, noise and the tone curve.

use super::style::Look;
use image::RgbImage;
use rand::Rng;

/// Side of the blocks in which glow is computed, as a share of the image's width.
const GLOW_BLOCKS: usize = 92;

/// Entries of the tone curve from 0 to [`BRIGHTEST`].
const TONES: usize = 4096;

/// All brighter values are white.
const BRIGHTEST: f32 = 1.5;

/// Linear light, three samples a pixel, row by row.
pub(super) struct Exposure {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) light: Vec<[f32; 3]>,
    /// Transmission of the lens, 0 beyond the image circle.
    pub(super) vignette: Vec<f32>,
}

impl Exposure {
    /// The image that the sensor records.
    pub(super) fn develop(mut self, look: &Look, rng: &mut impl Rng) -> RgbImage {
        let gain = self.gain(look);
        self.light.iter_mut().flatten().for_each(|v| *v = (*v * gain).min(2.0));
        self.soften();
        self.glow();
        let curve = curve();
        let (shot, read) = (0.004 * look.noise, 0.006 * look.noise);
        let mut bytes = Vec::with_capacity(self.light.len() * 3);
        for (pixel, vignette) in self.light.iter().zip(&self.vignette) {
            let grain = gauss(rng);
            for (value, grain) in pixel.iter().zip(grain) {
                // Stray light and the black level keep the rim from being perfectly black.
                let value = (value * vignette + 0.0012).min(BRIGHTEST);
                let noisy = value + grain * (shot * shot * 4.0 * value + read * read * value.min(0.1)).sqrt();
                let at = noisy.clamp(0.0, BRIGHTEST) / BRIGHTEST * (TONES - 1) as f32;
                bytes.push(curve[at as usize]);
            }
        }
        let (width, height) = (self.width as u32, self.height as u32);
        RgbImage::from_raw(width, height, bytes).expect("three bytes a pixel")
    }

    /// Automatic exposure: brings the mean, with highlights limited, to the style's target.
    fn gain(&self, look: &Look) -> f32 {
        let (mut sum, mut count) = (0.0_f64, 0_u32);
        for (pixel, _) in self.light.iter().zip(&self.vignette).filter(|(_, v)| **v > 0.5) {
            sum += f64::from(pixel[1].min(1.0));
            count += 1;
        }
        let mean = sum / f64::from(count.max(1));
        if mean > 1e-4 { look.exposure / mean as f32 } else { 1.0 }
    }

    /// The lens' blur: 1 2 1 along both axes.
    fn soften(&mut self) {
        let (width, height) = (self.width, self.height);
        for along in [1, width] {
            let before = self.light.clone();
            for y in 0..height {
                for x in 0..width {
                    let at = y * width + x;
                    let inner = if along == 1 { x > 0 && x + 1 < width } else { y > 0 && y + 1 < height };
                    if inner {
                        let (a, b, c) = (before[at - along], before[at], before[at + along]);
                        self.light[at] = std::array::from_fn(|i| 0.2 * a[i] + 0.6 * b[i] + 0.2 * c[i]);
                    }
                }
            }
        }
    }

    /// Excess brightness bleeds into its surroundings.
    fn glow(&mut self) {
        let side = self.width.div_ceil(GLOW_BLOCKS).max(1);
        let (columns, rows) = (self.width.div_ceil(side), self.height.div_ceil(side));
        let mut blocks = vec![[0.0_f32; 3]; columns * rows];
        let share = 1.0 / (side * side) as f32;
        for (at, (pixel, vignette)) in self.light.iter().zip(&self.vignette).enumerate() {
            let block = &mut blocks[at / self.width / side * columns + at % self.width / side];
            for (sum, value) in block.iter_mut().zip(pixel) {
                *sum += (value - 0.8).max(0.0) * vignette * share;
            }
        }
        let near = blur(&blocks, columns, rows, 2);
        let far = blur(&near, columns, rows, 7);
        for at in 0..self.light.len() {
            let place = |v: usize| ((v as f32 + 0.5) / side as f32 - 0.5).max(0.0);
            let (x, y) = (place(at % self.width), place(at / self.width));
            let (a, b) = (sample(&near, columns, rows, x, y), sample(&far, columns, rows, x, y));
            for (i, value) in self.light[at].iter_mut().enumerate() {
                *value += 0.06 * a[i] + 0.1 * b[i];
            }
        }
    }
}

/// Three rounds of a box of this radius along both axes.
fn blur(blocks: &[[f32; 3]], columns: usize, rows: usize, radius: usize) -> Vec<[f32; 3]> {
    let mut values = blocks.to_vec();
    for _ in 0..3 {
        for horizontal in [true, false] {
            let before = values.clone();
            for y in 0..rows {
                for x in 0..columns {
                    let (at, len) = if horizontal { (x, columns) } else { (y, rows) };
                    let (first, last) = (at.saturating_sub(radius), (at + radius).min(len - 1));
                    let mut sum = [0.0; 3];
                    for k in first..=last {
                        let from = before[if horizontal { y * columns + k } else { k * columns + x }];
                        sum = std::array::from_fn(|i| sum[i] + from[i]);
                    }
                    values[y * columns + x] = sum.map(|v| v / (2 * radius + 1) as f32);
                }
            }
        }
    }
    values
}

/// A value interpolated between blocks.
fn sample(blocks: &[[f32; 3]], columns: usize, rows: usize, x: f32, y: f32) -> [f32; 3] {
    let (column, row) = ((x as usize).min(columns - 1), (y as usize).min(rows - 1));
    let (fx, fy) = ((x - column as f32).min(1.0), (y - row as f32).min(1.0));
    let (right, below) = ((column + 1).min(columns - 1), (row + 1).min(rows - 1));
    let at = |x: usize, y: usize| blocks[y * columns + x];
    let (a, b, c, d) = (at(column, row), at(right, row), at(column, below), at(right, below));
    std::array::from_fn(|i| {
        let (top, bottom) = (a[i] + (b[i] - a[i]) * fx, c[i] + (d[i] - c[i]) * fx);
        top + (bottom - top) * fy
    })
}

/// Three approximately standard normal numbers, each the sum of five bytes.
fn gauss(rng: &mut impl Rng) -> [f32; 3] {
    let bytes: [[u8; 8]; 2] = [rng.next_u64().to_le_bytes(), rng.next_u64().to_le_bytes()];
    let bytes = bytes.as_flattened();
    // Mean 637.5, variance 5 (256^2 - 1) / 12.
    std::array::from_fn(|i| {
        let sum: u32 = bytes[5 * i..5 * i + 5].iter().map(|&byte| u32::from(byte)).sum();
        (sum as f32 - 637.5) / 165.24
    })
}

/// sRGB with a shoulder, so that highlights roll off.
fn curve() -> Vec<u8> {
    let tone = |k: usize| {
        let v = k as f32 / (TONES - 1) as f32 * BRIGHTEST;
        let v = if v < 0.6 { v } else { 0.6 + 0.4 * (1.0 - libm::expf(-(v - 0.6) / 0.32)) };
        let srgb = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::powf(v, 1.0 / 2.4) - 0.055 };
        (srgb * 258.0).round().clamp(0.0, 255.0) as u8
    };
    (0..TONES).map(tone).collect()
}
