//! Fixed-point spectra: radix-2 FFT, and circular cross-correlation of 360 bins by FFT.

mod correlate;
mod fft;

pub use correlate::{CORRELATION_POINTS, Correlator, Extent};
pub use fft::{Complex, FFT_SNR_DB, FFT_WORST_LSB, MAX_POINTS, forward, inverse};
