//! Frames of two cameras, paired in time as they arrive.

/// Pairs the newest frames of two cameras; with one camera each frame is by itself.
#[derive(Debug)]
pub struct Pairing<T> {
    wanted: [bool; 2],
    within_ns: u64,
    waiting: [Option<(u64, T)>; 2],
    /// Frames that were given up because a newer one came before a partner.
    lonely: u64,
}

impl<T> Pairing<T> {
    /// `wanted`: the cameras there are; `within_ns`: largest difference of stamps in a pair, nanoseconds.
    #[must_use]
    pub const fn new(wanted: [bool; 2], within_ns: u64) -> Self {
        Self { wanted, within_ns, waiting: [None, None], lonely: 0 }
    }

    /// Takes a frame of camera 0 or 1; gives the pair that it completes, with the stamp of camera 0 where there is one.
    pub fn take(&mut self, camera: usize, stamp: u64, frame: T) -> Option<(u64, [Option<T>; 2])> {
        if self.wanted != [true; 2] {
            let mut alone = [None, None];
            alone[camera] = Some(frame);
            return Some((stamp, alone));
        }
        let other = 1 - camera;
        let is_near = |(theirs, _): &(u64, T)| theirs.abs_diff(stamp) <= self.within_ns;
        if self.waiting[other].as_ref().is_some_and(is_near) {
            let (theirs, partner) = self.waiting[other].take()?;
            self.lonely += u64::from(self.waiting[camera].take().is_some());
            let mut pair = [None, None];
            (pair[camera], pair[other]) = (Some(frame), Some(partner));
            return Some((if camera == 0 { stamp } else { theirs }, pair));
        }
        self.lonely += u64::from(self.waiting[camera].replace((stamp, frame)).is_some());
        None
    }

    /// Number of frames that found no partner.
    #[must_use]
    pub const fn lonely(&self) -> u64 {
        self.lonely
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_pair_within_the_tolerance() {
        let mut pairing = Pairing::new([true; 2], 5);
        assert_eq!(pairing.take(0, 100, 'a'), None);
        assert_eq!(pairing.take(1, 104, 'b'), Some((100, [Some('a'), Some('b')])));
        assert_eq!(pairing.take(1, 200, 'c'), None);
        assert_eq!(pairing.take(1, 300, 'd'), None, "c waits no longer");
        assert_eq!(pairing.take(0, 206, 'e'), None, "6 ns from c, which is gone, and 94 from d");
        assert_eq!(pairing.take(0, 296, 'f'), Some((296, [Some('f'), Some('d')])));
        assert_eq!(pairing.lonely(), 2);
        // Clocks that were set back pair again.
        assert_eq!(pairing.take(0, 10, 'g'), None);
        assert_eq!(pairing.take(1, 9, 'h'), Some((10, [Some('g'), Some('h')])));
    }

    #[test]
    fn one_camera_waits_for_nobody() {
        let mut pairing = Pairing::new([false, true], 5);
        assert_eq!(pairing.take(1, 7, 'a'), Some((7, [None, Some('a')])));
    }
}
