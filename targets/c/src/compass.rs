//! The functions of the header.

use crate::types::{
    COMPASS_MAX_LAYERS, CompassCamera, CompassEstimate, CompassFix, CompassFrame, CompassMotion, CompassRoom,
    CompassScan, CompassStatus,
};
use compass_board::{Frame, Locator, layers, words};
use compass_core::vision::attitude::UpHint;
use compass_core::vision::camera::{Bearing, Rig, View};
use compass_core::pose::FloorLayer;
use compass_core::pose::locate::Fix;
use compass_core::base::num::{Metres, Point, Turn};
use compass_core::map::plan::Plan;
use compass_core::base::raster::{BitMask, GrayImage};
use compass_core::base::scan::Scan;
use compass_core::map::site::{Floor, Site};
use compass_core::map::site_map::SiteMap;
use compass_core::pose::track::Track;
use compass_core::vision::sample::ExclusionMask;
use compass_core::vision::panorama::Resolution;
use core::slice;
use heapless::Vec;

/// All that COMPASS knows, in memory that the caller lends.
#[derive(Debug)]
pub struct Compass {
    layers: Vec<FloorLayer<'static>, COMPASS_MAX_LAYERS>,
    views: [Option<View>; 2],
    fix: Option<Fix>,
    track: Track,
    locator: Locator<Lent>,
}

/// The part of the caller's memory behind the [`Compass`].
#[derive(Debug)]
struct Lent(Option<&'static mut [u32]>);

impl AsRef<[u32]> for Lent {
    fn as_ref(&self) -> &[u32] {
        self.0.as_deref().unwrap_or_default()
    }
}

impl AsMut<[u32]> for Lent {
    fn as_mut(&mut self) -> &mut [u32] {
        self.0.as_deref_mut().unwrap_or_default()
    }
}

/// A constant of zeros: writing it takes neither stack nor flash.
const NOTHING_SEEN: Locator<Lent> = Locator::new(Lent(None));

/// Bytes of memory for frames of 368 x 360 pixels.
pub const COMPASS_MEMORY_368X360: usize = 482_000;
const _: () = assert!(COMPASS_MEMORY_368X360 >= compass_memory_bytes(368, 360, false));

/// Bytes of memory for frames of this size; `fine` tells whether the lenses have 3 pixels a degree or more, that is a
/// focal length of 172 or more.
#[unsafe(no_mangle)]
pub const extern "C" fn compass_memory_bytes(width: u16, height: u16, fine: bool) -> usize {
    let ring = if fine { Resolution::FINE } else { Resolution::COARSE };
    size_of::<Compass>() + size_of::<u32>() * words(width, height, ring)
}

/// Begins: a Compass in this memory, which must be aligned to 8 bytes and is used as long as the Compass is. Null if it
/// is too short even without frames, not aligned, or null. There is nothing to be freed.
///
/// # Safety
/// `memory` is null or points to as many bytes, which nobody else uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_new(memory: *mut u8, bytes: usize) -> *mut Compass {
    let compass = memory.cast::<Compass>();
    let Some(rest) = bytes.checked_sub(size_of::<Compass>()) else { return core::ptr::null_mut() };
    if compass.is_null() || !compass.is_aligned() || bytes > isize::MAX as usize {
        return core::ptr::null_mut();
    }
    // SAFETY: the caller's bytes, long enough and aligned: field by field the Compass, which is too large to be made on
    // the stack first, and behind it the words of scratch. Its size is a multiple of its alignment and so of a word's.
    unsafe {
        (&raw mut (*compass).layers).write(Vec::new());
        (&raw mut (*compass).views).write([None; 2]);
        (&raw mut (*compass).fix).write(None);
        (&raw mut (*compass).track).write(Track::new());
        (&raw mut (*compass).locator).write(NOTHING_SEEN);
        let (scratch, words) = (compass.add(1).cast::<u32>(), rest / size_of::<u32>());
        scratch.write_bytes(0, words);
        *(*compass).locator.scratch_mut() = Lent(Some(slice::from_raw_parts_mut(scratch, words)));
    }
    compass
}

/// Adds all layers of all floors of a site file (`compass map build`), which is read in place: it must stay as it is as
/// long as the Compass is used. Checksums are compared, which reads the file once. Site, Full (then none is added).
///
/// # Safety
/// Pointers are null or point to what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_add_site(
    compass: *mut Compass,
    site: *const u8,
    bytes: usize,
) -> CompassStatus {
    // SAFETY: the caller vouches for both.
    let (Some(compass), Some(site)) = (unsafe { (compass.as_mut(), bytes_at(site, bytes)) }) else {
        return CompassStatus::Argument;
    };
    let Ok(site) = Site::new(site) else { return CompassStatus::Site };
    if site.verify().is_err() {
        return CompassStatus::Site;
    }
    compass.add(layers(&site))
}

/// Adds one floor: its site map, and the packed plan it was made from, like a site file. Site, Full.
///
/// # Safety
/// Pointers are null or point to what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_add_floor(
    compass: *mut Compass,
    map: *const u8,
    map_bytes: usize,
    plan: *const u8,
    plan_bytes: usize,
) -> CompassStatus {
    // SAFETY: the caller vouches for all.
    let given = unsafe { (compass.as_mut(), bytes_at(map, map_bytes), bytes_at(plan, plan_bytes)) };
    let (Some(compass), Some(map), Some(plan)) = given else { return CompassStatus::Argument };
    let (Ok(map), Ok(plan)) = (SiteMap::new(map), Plan::new(plan)) else { return CompassStatus::Site };
    if map.verify().is_err() || plan.verify().is_err() || Floor::new("floor", map, plan, None).is_err() {
        return CompassStatus::Site;
    }
    compass.add(core::iter::once(FloorLayer { map, number: 0, plan, floor: 0 }))
}

/// What surrounds a position in a layer's plan, cast with 360 rays; `x` and `y` as in CompassPose. Argument, Outside,
/// Occupied.
///
/// # Safety
/// Pointers are null or point to what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_describe(
    compass: *const Compass,
    layer: u8,
    x: i64,
    y: i64,
    heading: u32,
    scan: *mut CompassScan,
) -> CompassStatus {
    // SAFETY: the caller vouches for both.
    let (Some(compass), Some(out)) = (unsafe { (compass.as_ref(), scan.as_mut()) }) else {
        return CompassStatus::Argument;
    };
    let Some(floor_layer) = compass.layers.get(usize::from(layer)) else { return CompassStatus::Argument };
    let mut scan = Scan::OPEN;
    let at = Point::new(Metres::from_bits(x), Metres::from_bits(y));
    match floor_layer.plan.scan(at, Turn::from_bits(heading), &mut scan) {
        Ok(()) => {
            *out = CompassScan::from(&scan);
            CompassStatus::Ok
        }
        Err(error) => error.into(),
    }
}

/// Tells a camera, number 0 or 1; null takes it away. Argument for numbers that make no lens, no rotation or no size.
///
/// # Safety
/// Pointers are null or point to what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_set_camera(
    compass: *mut Compass,
    number: u8,
    camera: *const CompassCamera,
) -> CompassStatus {
    // SAFETY: the caller vouches for both.
    let (Some(compass), camera) = (unsafe { (compass.as_mut(), camera.as_ref()) }) else {
        return CompassStatus::Argument;
    };
    let view = camera.map(CompassCamera::view);
    let sound = view.is_none_or(|view| view.is_some_and(|view| Rig::new([Some(view), None]).is_ok()));
    match compass.views.get_mut(usize::from(number)) {
        Some(place) if sound => {
            *place = view.flatten();
            CompassStatus::Ok
        }
        _ => CompassStatus::Argument,
    }
}

/// Looks at the two frames, of all cameras that were set; `up` is roughly the upward direction in the axes of camera 0,
/// three numbers: a vector of any length. Argument, Camera, Memory, Up.
///
/// # Safety
/// Pointers are null or point to what they say; frames are as large as their cameras say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_see(
    compass: *mut Compass,
    frames: *const CompassFrame,
    up: *const f32,
) -> CompassStatus {
    // SAFETY: the caller vouches for all.
    let given = unsafe {
        (compass.as_mut(), frames.cast::<[CompassFrame; 2]>().as_ref(), up.cast::<[f32; 3]>().as_ref())
    };
    let (Some(compass), Some(frames), Some([x, y, z])) = given else { return CompassStatus::Argument };
    compass.fix = None;
    let Ok(rig) = Rig::new(compass.views) else { return CompassStatus::Camera };
    let mut lent = [None; 2];
    for ((lent, frame), view) in lent.iter_mut().zip(frames).zip(&compass.views) {
        if let Some(view) = view {
            // SAFETY: the caller vouches for the size.
            *lent = unsafe { frame_at(frame, view) };
        }
    }
    let up = UpHint::Up(Bearing::new(*x, *y, *z));
    compass.locator.see(&rig, &lent, up).map_or_else(CompassStatus::from, |()| CompassStatus::Ok)
}

/// Finds the pose that explains best what was seen, over all layers. Argument, Order (nothing was seen), Nowhere.
///
/// # Safety
/// Pointers are null or point to what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_locate(
    compass: *mut Compass,
    room: *const CompassRoom,
    fix: *mut CompassFix,
) -> CompassStatus {
    // SAFETY: the caller vouches for all.
    let given = unsafe { (compass.as_mut(), room.as_ref(), fix.as_mut()) };
    let (Some(compass), Some(room), Some(out)) = given else { return CompassStatus::Argument };
    let (room, effort) = room.parts();
    match compass.locator.locate(&compass.layers, room, effort) {
        Ok(fix) => {
            *out = CompassFix::from(&fix);
            let found = fix.answer.best().is_some();
            compass.fix = Some(fix);
            if found { CompassStatus::Ok } else { CompassStatus::Nowhere }
        }
        Err(error) => error.into(),
    }
}

/// Takes the frames that were just located into the belief over the sequence: `seconds` since the frames before, 0 for
/// the first; `motion` as measured since then, or null. Argument, Order (nothing was located), Nowhere.
///
/// # Safety
/// Pointers are null or point to what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_track(
    compass: *mut Compass,
    seconds: f32,
    motion: *const CompassMotion,
    estimate: *mut CompassEstimate,
) -> CompassStatus {
    // SAFETY: the caller vouches for all.
    let given = unsafe { (compass.as_mut(), estimate.as_mut(), motion.as_ref()) };
    let (Some(compass), Some(out), motion) = given else { return CompassStatus::Argument };
    let Some(fix) = &compass.fix else { return CompassStatus::Order };
    let motion = motion.map(Into::into);
    match compass.locator.track(&mut compass.track, &compass.layers, fix, seconds, motion) {
        Ok(Some(estimate)) => {
            *out = CompassEstimate::from(&estimate);
            CompassStatus::Ok
        }
        Ok(None) => CompassStatus::Nowhere,
        Err(error) => error.into(),
    }
}

/// Forgets the sequence. Argument.
///
/// # Safety
/// Pointers are null or point to what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_forget(compass: *mut Compass) -> CompassStatus {
    // SAFETY: the caller vouches for it.
    let Some(compass) = (unsafe { compass.as_mut() }) else { return CompassStatus::Argument };
    compass.track = Track::new();
    CompassStatus::Ok
}

impl Compass {
    /// Adds layers, all or none.
    fn add(&mut self, layers: impl Iterator<Item = FloorLayer<'static>>) -> CompassStatus {
        let before = self.layers.len();
        let floors = self.layers.last().map_or(0, |floor_layer| floor_layer.floor + 1);
        for floor_layer in layers {
            if self.layers.push(FloorLayer { floor: floors + floor_layer.floor, ..floor_layer }).is_err() {
                self.layers.truncate(before);
                return CompassStatus::Full;
            }
        }
        CompassStatus::Ok
    }
}

/// Bytes that the caller lends for as long as the library is used; `None` for null.
///
/// # Safety
/// The caller's word for it.
unsafe fn bytes_at(start: *const u8, length: usize) -> Option<&'static [u8]> {
    if start.is_null() || length > isize::MAX as usize {
        return None;
    }
    // SAFETY: not null, and the caller vouches for the length.
    Some(unsafe { slice::from_raw_parts(start, length) })
}

/// What a camera saw; `None` without a frame.
///
/// # Safety
/// Frame and mask are null or of the view's size.
unsafe fn frame_at(frame: &CompassFrame, view: &View) -> Option<Frame<'static>> {
    let (width, height) = (u32::from(view.width), u32::from(view.height));
    // SAFETY: the caller vouches for the size.
    let gray = unsafe { bytes_at(frame.gray, width as usize * height as usize) }?;
    // SAFETY: as before; rows begin at whole bytes.
    let red = unsafe { bytes_at(frame.red, width.div_ceil(8) as usize * height as usize) };
    let red = match red {
        Some(bits) => ExclusionMask::Mask(BitMask::new(bits, width, height).ok()?),
        None => ExclusionMask::Unknown,
    };
    Some(Frame { gray: GrayImage::new(gray, width, height).ok()?, red })
}
