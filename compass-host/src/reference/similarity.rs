//! Cosine similarity over all shifts, by direct sums.

use super::descriptor::Channels;

/// The cosine of two descriptors at a shift: channel values times the roots of their weights, concatenated to one
/// vector each; `centred` removes each channel's mean first. 0 when a norm is 0.
#[must_use]
pub fn cosine(query: &Channels, other: &Channels, shift: usize, weights: &[f64; 5], centred: bool) -> f64 {
    let certain = [1.0; 360];
    masked_cosine(query, other, shift, weights, centred, &certain)
}

/// [`cosine`] with the query's bins weighted by their confidence; means and norms are over the same bins.
#[must_use]
pub fn masked_cosine(
    query: &Channels,
    other: &Channels,
    shift: usize,
    weights: &[f64; 5],
    centred: bool,
    confidence: &[f64; 360],
) -> f64 {
    let total: f64 = confidence.iter().sum();
    let (mut product, mut a, mut b) = (0.0, 0.0, 0.0);
    for (c, weight) in weights.iter().enumerate() {
        let turned: Vec<f64> = (0..360).map(|i| other[c][(i + shift) % 360]).collect();
        let mean = |v: &[f64]| -> f64 {
            if centred { v.iter().zip(confidence).map(|(v, m)| v * m).sum::<f64>() / total } else { 0.0 }
        };
        let (query_mean, other_mean) = (mean(&query[c]), mean(&turned));
        for i in 0..360 {
            let (q, d) = (query[c][i] - query_mean, turned[i] - other_mean);
            product += weight * confidence[i] * q * d;
            a += weight * confidence[i] * q * q;
            b += weight * confidence[i] * d * d;
        }
    }
    if a <= 0.0 || b <= 0.0 { 0.0 } else { product / (a.sqrt() * b.sqrt()) }
}

/// All 360 scores, and the first shift with the best one.
#[must_use]
pub fn scores(query: &Channels, other: &Channels, weights: &[f64; 5], centred: bool) -> (Vec<f64>, usize) {
    let scores: Vec<f64> = (0..360).map(|s| cosine(query, other, s, weights, centred)).collect();
    let best = (0..360).fold(0, |best, s| if scores[s] > scores[best] { s } else { best });
    (scores, best)
}
