//! Frames of two cameras, paired in time.

use std::collections::{BTreeMap, BTreeSet};

/// Half the spacing of frames when there is only one, nanoseconds.
const ALONE_NS: u64 = 25_000_000;

/// The frames of one camera by time, nanoseconds.
pub(super) type List<T> = BTreeMap<u64, T>;

/// Pairs each frame of cam0 with the nearest frame of cam1 in time, if that is within half the spacing of the frames, of
/// the camera with more of them; frames without such a partner stay single. In order of time, which is cam0's where it has a frame.
pub(super) fn pair<T: Clone>([cam0, cam1]: &[List<T>; 2]) -> Vec<(u64, [Option<T>; 2])> {
    let reach = half_spacing(cam0).min(half_spacing(cam1));
    let partner = |of: &List<T>, time: u64| nearest(of, time).filter(|other| other.abs_diff(time) <= reach);
    let (mut pairs, mut used) = (Vec::new(), BTreeSet::new());
    for (&time, frame) in cam0 {
        // Only mutual nearest neighbours, so that no frame is used twice.
        let other = partner(cam1, time).filter(|&other| nearest(cam0, other) == Some(time));
        used.extend(other);
        pairs.push((time, [Some(frame.clone()), other.and_then(|other| cam1.get(&other).cloned())]));
    }
    for (&time, frame) in cam1.iter().filter(|(time, _)| !used.contains(*time)) {
        pairs.push((time, [None, Some(frame.clone())]));
    }
    pairs.sort_by_key(|(time, _)| *time);
    pairs
}

/// The time of the nearest frame, the earlier one of two.
fn nearest<T>(list: &List<T>, time: u64) -> Option<u64> {
    let before = list.range(..=time).next_back();
    let after = list.range(time..).next();
    before.into_iter().chain(after).map(|(&other, _)| other).min_by_key(|other| other.abs_diff(time))
}

/// Half the median time between frames.
fn half_spacing<T>(list: &List<T>) -> u64 {
    let times: Vec<u64> = list.keys().copied().collect();
    let mut gaps: Vec<u64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    gaps.sort_unstable();
    gaps.get(gaps.len() / 2).map_or(ALONE_NS, |gap| gap / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(times: &[u64]) -> List<u64> {
        times.iter().map(|&time| (time, time)).collect()
    }

    #[test]
    fn frames_pair_with_the_nearest() {
        let expected = [
            (0, [Some(0), Some(3)]),
            (100, [Some(100), Some(104)]),
            (200, [Some(200), None]),
            (300, [Some(300), Some(260)]),
            (420, [None, Some(420)]),
        ];
        assert_eq!(pair(&[of(&[0, 100, 200, 300]), of(&[3, 104, 260, 420])]), expected);
        assert_eq!(pair(&[of(&[]), of(&[5])]), [(5, [None, Some(5)])]);
        let lost = pair(&[of(&[0, 200, 300]), of(&[0, 100, 200, 300])]);
        assert_eq!(lost[1], (100, [None, Some(100)]), "its partner is missing");
        assert_eq!(lost.len(), 4);
    }
}
