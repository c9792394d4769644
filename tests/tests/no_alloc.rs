//! Vision allocates nothing per frame: after a first pair of frames all buffers exist.

use compass_core::Settings;
use compass_core::vision::camera::Bearing;
use compass_host::calibration::Calibration;
use compass_host::dataset::tum::Pose;
use compass_host::frame::Frame;
use compass_host::locator::{Locator, see};
use compass_host::up::Mount;
use compass_tests::sample_frames;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// Counts the allocations of each thread.
struct Counting;

thread_local! {
    static REQUESTS: Cell<usize> = const { Cell::new(0) };
}

fn count() {
    // A terminating thread has no counter any more.
    let _ = REQUESTS.try_with(|requests| requests.set(requests.get() + 1));
}

// SAFETY: every call is forwarded unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller upholds the contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller upholds the contract.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller upholds the contract.
        unsafe { System.realloc(block, layout, size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the caller upholds the contract.
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Number of allocations by `work` on this thread.
fn requests<T>(work: impl FnOnce() -> T) -> (usize, T) {
    let before = REQUESTS.get();
    let result = work();
    (REQUESTS.get() - before, result)
}

fn pose(turn_deg: f64, roll_deg: f64) -> Pose {
    Pose::looking(1, [4.12, 17.77, 1.6], 288.6 + turn_deg, 4.0, roll_deg)
}

#[test]
fn the_counter_counts() {
    assert_eq!(requests(|| Vec::<u64>::with_capacity(7)).0, 1);
    assert_eq!(requests(|| vec![0_u8; 7]).0, 1);
    assert_eq!(requests(|| 7).0, 0);
}

#[test]
fn frames_are_seen_without_allocation() {
    for size in [(736, 720), (368, 360)] {
        let load =
            |pose: &Pose| sample_frames(pose, size).map(|image| Frame::from_rgb(image).expect("good sides"));
        let poses = [pose(0.0, 187.0), pose(110.0, 172.0)];
        let pairs = poses.each_ref().map(load);
        let calibration = Calibration::nominal();
        let rig = |sizes| calibration.rig(sizes).unwrap();
        let mut locator = Locator::without_site(rig([Some(size); 2]), Settings::FULL);
        let mut found = 0;
        let mut look = |pair: &[Frame; 2], mount: Mount| {
            let frames = pair.each_ref().map(Some);
            let (segments, segmented) = requests(|| locator.segment(frames).unwrap());
            let mut segmented = segmented;
            let (vertical, up) = requests(|| mount.vertical(&mut segmented));
            // Without windows to tell up from down, the work was done as well.
            let up = up.map_or(Bearing::new(0.0, 1.0, 0.0), |vertical| vertical.up);
            let (windows, seen) = requests(|| see(segmented.level(&up).unwrap()).windows().len());
            println!("{size:?} {mount:?}: {segments}, {vertical} and {windows} requests; {seen} windows");
            found += seen;
            [segments, vertical, windows]
        };
        let _ = look(&pairs[0], Mount::Inverted);
        for (pair, mount) in
            [(&pairs[0], Mount::Inverted), (&pairs[1], Mount::Inverted), (&pairs[1], Mount::Auto)]
        {
            assert_eq!(look(pair, mount), [0; 3], "{size:?} {mount:?}");
        }
        assert!(found > 0, "the work was done");
        // One camera alone.
        let alone = [None, Some(&pairs[1][1])];
        let mut locator = Locator::without_site(rig([None, Some(size)]), Settings::FULL);
        let (count, ()) = requests(|| {
            let mut segmented = locator.segment(alone).unwrap();
            let up = Mount::Inverted.vertical(&mut segmented).unwrap().up;
            see(segmented.level(&up).unwrap());
        });
        assert_eq!(count, 0);
    }
}
