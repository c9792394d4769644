//! Which way is up where nobody tells: each direction that may be is tried on the site, and the plan decides.

use crate::locator::{SeeError, Seen, Segmented, see};
use compass_core::base::num::Nats;
use compass_core::base::pose::Separation;
use compass_core::vision::camera::Bearing;
use compass_core::{Fix, HeightPrior, PosePrior};

/// Frames, seen with the up vector that explains them best.
#[derive(Debug)]
pub struct Placed<'l, 'a> {
    /// The up vector in cam0, of length 1.
    pub up: Bearing,
    /// What the frames show with it.
    pub seen: Seen<'l, 'a>,
    /// Where that is.
    pub fix: Fix<'a>,
}

/// Finds the pose of frames with each of these up vectors, of any length in the axes of cam0, and keeps the one with which the site explains the frames best.
/// The others count as rivals in margin and probability. `within` restricts the search.
///
/// The segments are those that were found: only what depends on up is done for each.
///
/// # Errors
/// [`SeeError::Up`] if none of them defines a heading.
pub fn locate_by_plan<'l, 'a>(
    mut segmented: Segmented<'l, '_, 'a>,
    candidates: &[Bearing],
    heights: HeightPrior,
    within: &PosePrior,
) -> Result<Placed<'l, 'a>, SeeError> {
    if let [up] = candidates {
        let (up, mut seen) = look(segmented, up)?;
        let fix = seen.locate_within(heights, within);
        return Ok(Placed { up, seen, fix });
    }
    let tried = candidates.iter().filter_map(|up| {
        let (up, mut seen) = look(segmented.by_ref(), up).ok()?;
        Some(Tried { with: up, fix: seen.locate_within(heights, within) })
    });
    let (up, fix) = best(tried.collect()).ok_or(SeeError::Up)?;
    let (up, seen) = look(segmented, &up)?;
    Ok(Placed { up, seen, fix })
}

/// The up vector at length 1, and what the frames show with it.
fn look<'l, 'a>(segmented: Segmented<'l, '_, 'a>, up: &Bearing) -> Result<(Bearing, Seen<'l, 'a>), SeeError> {
    let levelled = segmented.level(up)?;
    Ok((levelled.frame().up(), see(levelled)))
}

/// The result of frames with one of several up vectors.
#[derive(Debug)]
pub(crate) struct Tried<'a, T> {
    /// What the caller needs of it.
    pub(crate) with: T,
    /// Where it leads.
    pub(crate) fix: Fix<'a>,
}

impl<T> Tried<'_, T> {
    /// The score by which up vectors are compared.
    fn score(&self) -> Option<Nats> {
        self.fix.exchanged_score()
    }

    /// Whether both lead to the same pose, which then is right with either up vector.
    fn agrees(&self, other: &Self) -> bool {
        let poses = self.fix.pose().zip(other.fix.pose());
        poses.is_some_and(|(a, b)| Separation::ALTERNATIVES.joins(&a, &b))
    }
}

/// The result that explains its frames best, of several for the same frames; of equal ones the first. The best of those
/// that lead elsewhere is its rival.
pub(crate) fn best<T>(mut tried: Vec<Tried<'_, T>>) -> Option<(T, Fix<'_>)> {
    let first = (0..tried.len()).reduce(|a, b| if tried[b].score() > tried[a].score() { b } else { a })?;
    let best = tried.swap_remove(first);
    let rival = tried.iter().filter(|other| !other.agrees(&best)).filter_map(Tried::score).max();
    // The share by which it leads, of the score that margin and probability refer to.
    let rival = rival.zip(best.score().zip(best.fix.best())).map(|(rival, (exchanged, pose))| {
        let [rival, exchanged, score] = [rival, exchanged, pose.score].map(|score| score.to_num::<f64>());
        Nats::saturating_from_num(if exchanged > 0.0 { score * rival / exchanged } else { score })
    });
    let Tried { with, fix } = best;
    let fix = match rival {
        Some(score) => fix.with_rival(score),
        None => fix,
    };
    Some((with, fix))
}
