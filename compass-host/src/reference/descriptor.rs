//! The five channels (paper: multi-channel scene signature).

use super::march::{R_MAX_M, Scan};
use compass_core::base::scan::Hit;

/// Five channels of 360 bins.
pub type Channels = [[f64; 360]; 5];

/// Fills the five channels from a scan.
#[must_use]
pub fn descriptor(scan: &Scan) -> Channels {
    let r = |j: i32| scan.range_m[j.rem_euclid(360) as usize];
    let mut channels = [[0.0; 360]; 5];
    for j in 0..360_i32 {
        let bin = j as usize;
        channels[0][bin] = r(j) / R_MAX_M;
        channels[1][bin] = hit_value(scan.hit[bin]);
        let slope = (r(j + 1) - r(j - 1)).abs() / 2.0;
        channels[2][bin] = (slope / 5.0).min(1.0);
        channels[3][bin] = 1.0 / (1.0 + r(j));
        let window: Vec<f64> = (j - 5..=j + 5).map(r).collect();
        let mean = window.iter().sum::<f64>() / 11.0;
        let variance = window.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 11.0;
        channels[4][bin] = variance.sqrt() / 10.0;
    }
    channels
}

/// 1.0 wall, 0.5 window, 0.0 open.
#[must_use]
pub fn hit_value(hit: Hit) -> f64 {
    match hit {
        Hit::Wall => 1.0,
        Hit::Window => 0.5,
        Hit::Open => 0.0,
    }
}
