//! The object: a locator in the caller's memory, and what was last seen with it.
//!
//! The memory holds three things that do not overlap: the [`Compass`], the locator, and the words that the locator works in.
//! Between calls `seen` borrows the locator, so that nothing else may: it is dropped before [`Compass::locator`] lends the
//! locator anew.

use crate::failure::Failure;
use crate::prior::{CompassPrior, Up};
use crate::status::CompassStatus;
use crate::types::{
    COMPASS_MAX_LAYERS, COMPASS_MAX_PIXELS, CompassCamera, CompassEstimate, CompassFix, CompassFrame,
    CompassMotion, CompassPose, CompassScan,
};
use compass_core::locator::Seen;
use compass_core::pose::FloorLayer;
use compass_core::vision::camera::CAMERAS;
use compass_core::{
    Bearing, Fix, Locator, Metres, Point, Rig, Scan, Settings, Site, Track, Turn, UpHint, View,
};
use core::ptr::NonNull;

/// Alignment of the memory, bytes.
pub const COMPASS_ALIGNMENT: usize = 8;
/// Bytes of memory for frames of 368 x 360 pixels with the settings of COMPASS_PRESET_BOARD, on any machine.
pub const COMPASS_MEMORY_368X360: usize = 446_000;

/// The locator, which owns what lies behind it.
type Pipeline = Locator<'static, &'static mut [u32], (), COMPASS_MAX_LAYERS>;

/// Where the locator begins.
const LOCATOR_AT: usize = size_of::<Compass>().next_multiple_of(align_of::<Pipeline>());
/// Where the words of the locator's memory begin.
const WORDS_AT: usize = (LOCATOR_AT + size_of::<Pipeline>()).next_multiple_of(align_of::<u32>());

const _: () =
    assert!(align_of::<Compass>() <= COMPASS_ALIGNMENT && align_of::<Pipeline>() <= COMPASS_ALIGNMENT);
const _: () = assert!(memory_bytes(368, 360, &Settings::BOARD) <= COMPASS_MEMORY_368X360);
// What the comment of the preset says.
const _: () = assert!(memory_bytes(1472, 1440, &Settings::FULL) <= 9_200_000);

/// Begins every object that is in use.
const MAGIC: u32 = u32::from_le_bytes(*b"CMPS");

/// A Compass, in memory that the caller lends.
#[derive(Debug)]
pub struct Compass {
    magic: u32,
    /// Where it was made.
    address: usize,
    locator: NonNull<Pipeline>,
    views: [Option<View>; CAMERAS],
    /// As the locator has them, for names and plans while it is borrowed.
    layers: [Option<FloorLayer<'static>>; COMPASS_MAX_LAYERS],
    seen: Option<Seen<'static, Pipeline>>,
    /// Of the frames that were seen.
    fix: Option<Fix<'static>>,
    /// Whether they were taken into the track.
    is_tracked: bool,
    track: Track,
    pub(crate) failure: Option<Failure>,
}

/// Bytes of memory for two cameras with images of at most this size.
pub(crate) const fn memory_bytes(width: u16, height: u16, settings: &Settings) -> usize {
    WORDS_AT + size_of::<u32>() * settings.memory_words(width, height)
}

/// Whether images of this size can be asked for.
pub(crate) const fn is_size(width: u16, height: u16) -> bool {
    width as u32 * height as u32 <= COMPASS_MAX_PIXELS
}

impl Compass {
    /// Makes one.
    ///
    /// # Errors
    /// [`CompassStatus::Memory`], [`CompassStatus::Alignment`].
    ///
    /// # Safety
    /// `memory` points to as many bytes, which nobody else uses until [`end`](Self::end) or a next `begin`.
    pub(crate) unsafe fn begin(
        memory: NonNull<u8>,
        bytes: usize,
        settings: Settings,
    ) -> Result<NonNull<Self>, CompassStatus> {
        if !memory.addr().get().is_multiple_of(COMPASS_ALIGNMENT) {
            return Err(CompassStatus::Alignment);
        }
        let fits = bytes <= isize::MAX as usize && memory.addr().checked_add(bytes).is_some();
        let Some(rest) = bytes.checked_sub(WORDS_AT).filter(|_| fits) else {
            return Err(CompassStatus::Memory);
        };
        let count = rest / size_of::<u32>();
        // SAFETY: the bytes are the caller's, at least WORDS_AT of them, and no object is larger than isize::MAX.
        let (locator, words) = unsafe { (memory.add(LOCATOR_AT).cast(), memory.add(WORDS_AT).cast::<u32>()) };
        // SAFETY: aligned, since the memory and WORDS_AT are; within the caller's bytes; written before they are read; and
        // lent to the locator alone.
        let words = unsafe {
            words.write_bytes(0, count);
            core::slice::from_raw_parts_mut(words.as_ptr(), count)
        };
        let pipeline = Locator::without_rig(settings, words).map_err(|_| CompassStatus::Memory)?;
        let compass = memory.cast::<Self>();
        // SAFETY: aligned and within the caller's bytes, as above. Field by field, since a track is large for a stack.
        unsafe {
            locator.write(pipeline);
            let place = compass.as_ptr();
            (&raw mut (*place).address).write(compass.addr().get());
            (&raw mut (*place).locator).write(locator);
            (&raw mut (*place).views).write([None; CAMERAS]);
            (&raw mut (*place).layers).write([None; COMPASS_MAX_LAYERS]);
            (&raw mut (*place).seen).write(None);
            (&raw mut (*place).fix).write(None);
            (&raw mut (*place).is_tracked).write(false);
            (&raw mut (*place).track).write(Track::new());
            (&raw mut (*place).failure).write(None);
            (&raw mut (*place).magic).write(MAGIC);
        }
        Ok(compass)
    }

    /// The object that a pointer from C points to, if one was begun there and is in use.
    ///
    /// # Errors
    /// [`CompassStatus::Null`], [`CompassStatus::Handle`].
    ///
    /// # Safety
    /// `compass` is null or points to memory that can be read; what [`begin`](Self::begin) asks for still holds if an object
    /// was begun there, and no other reference to it is in use.
    pub(crate) unsafe fn at<'c>(compass: *const Self) -> Result<&'c Self, CompassStatus> {
        if compass.is_null() {
            return Err(CompassStatus::Null);
        }
        if !compass.is_aligned() {
            return Err(CompassStatus::Handle);
        }
        // SAFETY: aligned, and the caller vouches for the memory. Whatever it holds are numbers.
        let (magic, address) =
            unsafe { ((&raw const (*compass).magic).read(), (&raw const (*compass).address).read()) };
        if magic != MAGIC || address != compass.addr() {
            return Err(CompassStatus::Handle);
        }
        // SAFETY: one was begun here, and the caller vouches that it is as it was left.
        Ok(unsafe { &*compass })
    }

    /// Like [`at`](Self::at), to change it.
    ///
    /// # Errors
    /// Like `at`.
    ///
    /// # Safety
    /// Like `at`.
    pub(crate) unsafe fn at_mut<'c>(compass: *mut Self) -> Result<&'c mut Self, CompassStatus> {
        // SAFETY: as the caller vouches for; the reference ends here.
        unsafe { Self::at(compass) }?;
        // SAFETY: it is one, and the caller vouches that no other reference is in use.
        Ok(unsafe { &mut *compass })
    }

    /// Gives the memory back: later calls are refused.
    pub(crate) fn end(&mut self) {
        self.forget_look();
        self.magic = 0;
    }

    /// The locator. What was seen before is forgotten, since it borrows it.
    fn locator(&mut self) -> &'static mut Pipeline {
        self.forget_look();
        // SAFETY: `begin` wrote it, and nobody else knows where it is. Answers of former calls are gone: those that were
        // kept lay in `seen`, and no caller below keeps another.
        unsafe { &mut *self.locator.as_ptr() }
    }

    pub(crate) fn forget_look(&mut self) {
        self.seen = None;
        self.fix = None;
        self.is_tracked = false;
    }

    /// Forgets the sequence.
    pub(crate) fn forget_track(&mut self) {
        self.track = Track::new();
    }

    /// Adds all layers of all floors of a site.
    pub(crate) fn add_site(&mut self, bytes: &'static [u8]) -> Result<(), Failure> {
        let site = Site::new(bytes)?;
        site.verify()?;
        let locator = self.locator();
        locator.add_site(&site)?;
        self.layers.iter_mut().zip(locator.layers()).for_each(|(place, layer)| *place = Some(*layer));
        Ok(())
    }

    /// Sets a camera, or takes it away; the former stays if the new one is refused.
    pub(crate) fn set_camera(&mut self, number: u8, camera: Option<&CompassCamera>) -> Result<(), Failure> {
        let view = camera.map(|camera| camera.view(number)).transpose()?;
        let mut views = self.views;
        *views.get_mut(usize::from(number)).ok_or(Failure::CameraNumber(number))? = view;
        if views.iter().any(Option::is_some) {
            let rig = Rig::new(views).map_err(|error| Failure::Camera(number, error))?;
            self.locator().set_rig(rig)?;
        } else {
            self.forget_look();
        }
        self.views = views;
        Ok(())
    }

    /// Looks at the frames of both cameras.
    ///
    /// # Safety
    /// Like [`CompassFrame::borrow`], until the call ends.
    pub(crate) unsafe fn see(
        &mut self,
        given: [Option<CompassFrame>; CAMERAS],
        prior: &CompassPrior,
    ) -> Result<(), Failure> {
        self.forget_look();
        if self.views.iter().all(Option::is_none) {
            return Err(Failure::Order("no camera was set: compass_set_camera"));
        }
        let up = prior.up()?;
        let mut frames = [None; CAMERAS];
        for (number, ((frame, given), view)) in (0..).zip(frames.iter_mut().zip(given).zip(&self.views)) {
            if let Some(given) = given {
                // SAFETY: the caller vouches for it.
                *frame = Some(unsafe { given.borrow(number, view.as_ref()) }?);
            }
        }
        let mut segmented = self.locator().segment(&frames)?;
        let levelled = match up {
            Up::Exact(up) => segmented.level(&up)?,
            Up::Near(up) => segmented.level_near(UpHint::Up(up))?,
            Up::Unknown => {
                let up = segmented.vertical(UpHint::Axis(-Bearing::y()))?.up;
                let is_up = segmented.sky_is_above(&up)?.ok_or(Failure::NoSky)?;
                segmented.level(&if is_up { up } else { -up })?
            }
        };
        self.seen = Some(levelled.see());
        Ok(())
    }

    /// Finds the pose.
    pub(crate) fn locate(&mut self, prior: &CompassPrior) -> Result<CompassFix, Failure> {
        self.fix = None;
        if self.layers.iter().all(Option::is_none) {
            return Err(Failure::Order("no site was added: compass_add_site"));
        }
        let heights = prior.heights()?;
        let floors =
            self.layers.iter().flatten().map(|layer| layer.floor.saturating_add(1)).max().unwrap_or(0);
        let place = prior.place(floors)?;
        let seen = self.seen.as_mut().ok_or(Failure::Order("no frames were seen: compass_see"))?;
        let fix = seen.locate_within(heights, &place);
        Ok(CompassFix::new(self.fix.insert(fix), &self.layers))
    }

    /// Takes the fix into the track.
    pub(crate) fn track(
        &mut self,
        seconds: f32,
        motion: Option<&CompassMotion>,
    ) -> Result<Option<CompassEstimate>, Failure> {
        if self.is_tracked {
            return Err(Failure::Order("these frames were tracked already: compass_see the next"));
        }
        let (Some(seen), Some(fix)) = (&mut self.seen, &self.fix) else {
            return Err(Failure::Order("no pose was looked for: compass_locate"));
        };
        if !(seconds.is_finite() && seconds >= 0.0) {
            return Err(Failure::Motion("seconds are negative, infinite or not a number"));
        }
        let motion = motion.map(CompassMotion::check).transpose()?;
        let estimate = seen.track(&mut self.track, fix, seconds, motion);
        self.is_tracked = true;
        Ok(estimate.map(|estimate| CompassEstimate::new(&estimate, &self.layers)))
    }

    /// What surrounds a pose in its plan.
    pub(crate) fn describe(&self, pose: &CompassPose) -> Result<CompassScan, Failure> {
        let CompassPose { floor, layer, .. } = *pose;
        let found = self.layers.iter().flatten().find(|found| (found.floor, found.number) == (floor, layer));
        let plan = found.ok_or(Failure::Floor { floor, layer })?.plan;
        let at = Point::new(Metres::from_bits(pose.x), Metres::from_bits(pose.y));
        let mut scan = Scan::OPEN;
        plan.scan(at, Turn::from_bits(pose.heading), &mut scan)?;
        Ok(CompassScan::from(&scan))
    }
}
