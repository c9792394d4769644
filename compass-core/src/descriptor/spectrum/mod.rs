//! Spectra in fixed point: a radix-2 FFT and circular correlation of 360 bins through it.

mod correlate;
mod fft;

pub use correlate::{CORRELATION_POINTS, Correlator, Extent};
pub use fft::{Complex, FFT_SNR_DB, FFT_WORST_LSB, MAX_POINTS, forward, inverse};
