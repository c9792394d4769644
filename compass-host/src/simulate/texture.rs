//! Textures that are anchored in the map: hashes, smooth noise and lines at a spacing.

/// A well mixed number from a seed and three whole coordinates.
pub(super) fn hash(seed: u32, at: [i32; 3]) -> u32 {
    let mut h = seed ^ 0x9e37_79b9;
    for v in at {
        h = (h ^ v.cast_unsigned()).wrapping_mul(0x85eb_ca6b);
        h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
        h ^= h >> 16;
    }
    h
}

/// A hash as a number from 0 to 1.
pub(super) fn unit(hash: u32) -> f32 {
    (hash >> 8) as f32 / 16_777_216.0
}

/// Smooth noise from -1 to 1 with features of length 1.
pub(super) fn noise(seed: u32, [x, y, z]: [f32; 3]) -> f32 {
    // Turned, so that the lattice does not show as squares on walls that run along the axes.
    let at = [0.48 * x + 0.64 * y + 0.6 * z, -0.8 * x + 0.6 * y, -0.36 * x - 0.48 * y + 0.8 * z];
    let low = at.map(f32::floor);
    let cell = low.map(|v| v as i32);
    let [x, y, z] = [0, 1, 2].map(|i| {
        let f = at[i] - low[i];
        f * f * (3.0 - 2.0 * f)
    });
    let corner = |dx: i32, dy: i32, dz: i32| {
        unit(hash(seed, [cell[0].wrapping_add(dx), cell[1].wrapping_add(dy), cell[2].wrapping_add(dz)]))
    };
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let face = |dz: i32| {
        let south = mix(corner(0, 0, dz), corner(1, 0, dz), x);
        let north = mix(corner(0, 1, dz), corner(1, 1, dz), x);
        mix(south, north, y)
    };
    2.0 * mix(face(0), face(1), z) - 1.0
}

/// Noise of features as long as `length` metres, faded out where a pixel covers more than that.
pub(super) fn grain(seed: u32, at: [f32; 3], length: f32, footprint: f32) -> f32 {
    let fade = (1.5 - footprint / length).clamp(0.0, 1.0);
    if fade == 0.0 { 0.0 } else { fade * noise(seed, at.map(|v| v / length)) }
}

/// How much of a pixel, `footprint` metres wide, is covered by lines `width` wide at multiples of
/// `spacing`: 0 to 1.
pub(super) fn line(u: f32, spacing: f32, width: f32, footprint: f32) -> f32 {
    let distance = (u - (u / spacing).round() * spacing).abs();
    let half = footprint.max(1e-4) / 2.0;
    let covered = (distance + half).min(width / 2.0) - (distance - half).max(-width / 2.0);
    (covered / (2.0 * half)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_smooth_and_centred() {
        let values: Vec<f32> = (0..4000).map(|i| noise(1, [i as f32 * 0.05, 0.3, -7.7])).collect();
        assert!(values.windows(2).all(|v| (v[0] - v[1]).abs() < 0.2));
        assert!((values.iter().sum::<f32>() / 4000.0).abs() < 0.1);
        assert!(values.iter().any(|v| *v < -0.4) && values.iter().any(|v| *v > 0.4));
    }

    #[test]
    fn lines_keep_their_share_when_seen_from_afar() {
        for footprint in [0.001, 0.01, 0.1] {
            let mean =
                (0..10_000).map(|i| line(i as f32 * 0.001, 1.0, 0.02, footprint)).sum::<f32>() / 10_000.0;
            assert!((mean - 0.02).abs() < 0.002, "{footprint}: {mean}");
        }
    }
}
