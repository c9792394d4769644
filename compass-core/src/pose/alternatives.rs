//! Selection of the best poses that are separated: non-maximum suppression over position and heading.

use super::search::{FloorLayer, pose_of};
use crate::base::num::Nats;
use crate::base::order;
use crate::base::pose::{MAX_ALTERNATIVES, ScoredPose, Separation};

/// The best pose and its alternatives, by descending score.
#[derive(Debug, Clone)]
pub struct Alternatives {
    poses: heapless::Vec<ScoredPose, MAX_ALTERNATIVES>,
}

impl Alternatives {
    /// No pose.
    pub(crate) const fn nothing() -> Self {
        Self { poses: heapless::Vec::new() }
    }

    /// The best pose and its alternatives, at most [`MAX_ALTERNATIVES`]. Any two are on different floors, or at least 1 m
    /// or 20 degrees apart.
    #[must_use]
    pub fn poses(&self) -> &[ScoredPose] {
        &self.poses
    }

    /// The best pose.
    #[must_use]
    pub fn best(&self) -> Option<&ScoredPose> {
        self.poses.first()
    }

    /// Difference of the best and the second best score. Without a second pose it is the best score itself, which is
    /// relative to a table of zeros; without any pose it is 0.
    #[must_use]
    pub fn margin(&self) -> Nats {
        let score = |at: usize| self.poses.get(at).map_or(Nats::ZERO, |pose| pose.score);
        score(0).saturating_sub(score(1))
    }
}

/// Sorts [refined](super::refine()) poses by score and keeps the best ones that are separated by
/// [`Separation::ALTERNATIVES`] (non-maximum suppression).
///
/// Two layers of one floor share coordinates: of one pose on both, the better layer remains. Poses whose layer does not
/// exist and poses of score [`Nats::MIN`] are dropped.
///
/// # Cost
/// A heap sort of `poses`, then at most [`MAX_ALTERNATIVES`] comparisons per pose.
///
/// ```
/// # use compass_core::Site;
/// # let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/vectors/sample.site"))?;
/// # let site = Site::new(&bytes)?;
/// # let floor = site.floor(0).unwrap();
/// # use compass_core::pose::{EvidenceTable, FloorLayer, PoolEntry, Rows, plane_of, refine, search, select_alternatives};
/// # use compass_core::{Nats, Scan, ScoredPose, Turn};
/// # let map = *floor.map();
/// # let layer = FloorLayer { map, number: 0, plan: floor.plan(0).unwrap(), floor: 0, name: floor.name() };
/// # let mut scan = Scan::OPEN;
/// # map.get(7).unwrap().scan(&mut scan);
/// # let mut table = Box::new(EvidenceTable::EMPTY);
/// # for (bin, (steps, hit)) in scan.steps.iter().zip(scan.hit).enumerate() {
/// #     table.set(plane_of(*steps, hit), bin, Nats::ONE);
/// # }
/// // Three poses: the second is turned by 5 degrees, the third by 90.
/// let scored = |degrees, score| ScoredPose {
///     layer: 0,
///     at: map.position(7).unwrap(),
///     heading: Turn::from_degrees(degrees),
///     score: Nats::from_num(score),
/// };
/// let mut poses = [scored(0, 30), scored(5, 20), scored(90, 10)];
/// let alternatives = select_alternatives(&[layer], &mut poses);
/// assert_eq!(alternatives.poses(), [scored(0, 30), scored(90, 10)]);
/// assert_eq!(alternatives.margin(), Nats::from_num(20));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[must_use]
pub fn select_alternatives(layers: &[FloorLayer<'_>], poses: &mut [ScoredPose]) -> Alternatives {
    order::sort_by_key(poses, ScoredPose::order);
    let mut kept: heapless::Vec<ScoredPose, MAX_ALTERNATIVES> = heapless::Vec::new();
    for scored in poses.iter().filter(|scored| scored.score > Nats::MIN) {
        let Some(pose) = pose_of(layers, scored) else { continue };
        let is_near = |other: &ScoredPose| {
            pose_of(layers, other).is_some_and(|other| Separation::ALTERNATIVES.joins(&pose, &other))
        };
        if !kept.iter().any(is_near) && kept.push(*scored).is_err() {
            break;
        }
    }
    Alternatives { poses: kept }
}
