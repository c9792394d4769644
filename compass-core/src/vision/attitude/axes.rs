//! The building's axes: two horizontal vanishing points at right angles.

use super::arc::{Arc, degrees};
use crate::vision::camera::Bearing;
use crate::vision::level_frame::LevelFrame;

/// Votes per degree.
const PER_DEGREE: usize = 4;
const VOTES: usize = 90 * PER_DEGREE;
/// Arcs whose horizontal point lies within this of an axis are its inliers, degrees.
const TOLERANCE_DEG: f32 = 2.0;
/// Arcs that point to the zenith within this tell no horizontal direction: sine of 10 degrees.
const UPRIGHT_SIN: f32 = 0.173_648_2;

/// Directions of a building's walls.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Axes {
    /// Azimuth of one axis, degrees counter-clockwise from the heading, 0 to 90; the other is at right angles.
    pub azimuth_deg: f32,
    /// Arcs along each.
    pub inliers: [u16; 2],
    /// Share of the weight of all horizontal arcs that lies along the two.
    pub share: f32,
}

impl Axes {
    /// Unit vectors in camera 0 along the two axes.
    #[must_use]
    pub fn directions(&self, level: &LevelFrame) -> [Bearing; 2] {
        let azimuth = self.azimuth_deg * (core::f32::consts::PI / 180.0);
        [azimuth, azimuth + core::f32::consts::FRAC_PI_2].map(|azimuth| level.bearing(azimuth, 0.0))
    }

    /// The axis, 0 or 1, that a horizontal arc runs along.
    #[must_use]
    pub fn axis_of(&self, arc: &Arc, level: &LevelFrame) -> Option<usize> {
        let turn = vanishing_azimuth(arc, level)? - self.azimuth_deg;
        let off = modulo(turn + 45.0, 90.0) - 45.0;
        (off.abs() <= TOLERANCE_DEG).then(|| usize::from(modulo(turn + 45.0, 180.0) >= 90.0))
    }
}

/// The pair of horizontal directions at right angles that most arcs run along; `None` if there is no horizontal arc.
///
/// The great circle of a horizontal line meets the horizon in its vanishing point: one vote per arc, modulo 90
/// degrees. Facades at 45 degrees vote for a pair of their own.
#[must_use]
pub fn building_axes(arcs: &[Arc], level: &LevelFrame) -> Option<Axes> {
    let mut votes = [0.0_f32; VOTES];
    let mut all = 0.0;
    for (arc, azimuth) in horizontal(arcs, level) {
        let at = (modulo(azimuth, 90.0) * PER_DEGREE as f32) as usize % VOTES;
        if let Some(vote) = votes.get_mut(at) {
            *vote += arc.weight;
        }
        all += arc.weight;
    }
    let reach = TOLERANCE_DEG as usize * PER_DEGREE;
    let around = |at: usize| -> f32 {
        (0..=2 * reach).filter_map(|k| votes.get((at + VOTES + k - reach) % VOTES)).sum()
    };
    let best = (0..VOTES).max_by(|a, b| around(*a).total_cmp(&around(*b)))?;
    let rough = (best as f32 + 0.5) / PER_DEGREE as f32;
    let (mut turn, mut along) = (0.0, 0.0);
    for (arc, azimuth) in horizontal(arcs, level) {
        let off = modulo(azimuth - rough + 45.0, 90.0) - 45.0;
        if off.abs() <= TOLERANCE_DEG {
            turn += off * arc.weight;
            along += arc.weight;
        }
    }
    if along <= 0.0 {
        return None;
    }
    let azimuth_deg = modulo(rough + turn / along, 90.0);
    let axes = Axes { azimuth_deg, inliers: [0; 2], share: along / all };
    let count = |axis| arcs.iter().filter(|arc| axes.axis_of(arc, level) == Some(axis)).count();
    let inliers = [0, 1].map(|axis| u16::try_from(count(axis)).unwrap_or(u16::MAX));
    Some(Axes { inliers, ..axes })
}

/// Arcs that can be of horizontal lines, with the azimuth of their vanishing point.
fn horizontal<'a>(arcs: &'a [Arc], level: &'a LevelFrame) -> impl Iterator<Item = (&'a Arc, f32)> + 'a {
    arcs.iter().filter_map(|arc| Some((arc, vanishing_azimuth(arc, level)?)))
}

/// The azimuth in degrees of an arc's point on the horizon; `None` if it can be of an upright line.
fn vanishing_azimuth(arc: &Arc, level: &LevelFrame) -> Option<f32> {
    let up: Bearing = level.up();
    // The great circle of an upright line holds the zenith.
    if arc.normal.dot(&up).abs() < UPRIGHT_SIN {
        return None;
    }
    let (azimuth, _) = level.direction(&arc.normal.cross(&up));
    Some(degrees(azimuth))
}

/// The remainder in 0 to `period`.
fn modulo(value: f32, period: f32) -> f32 {
    let rest = value - period * libm::floorf(value / period);
    if rest >= period { 0.0 } else { rest }
}
