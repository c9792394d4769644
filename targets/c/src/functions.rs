//! The functions of the header.
//!
//! What all of them ask of the caller is what the header says once: pointers that are not null point to what their type or
//! the length beside them says, memory and sites stay lent, and one thread at a time uses a [`Compass`].
#![expect(clippy::missing_safety_doc, reason = "said once, above and at the head of the header")]

use crate::compass::{self, Compass};
use crate::failure::Failure;
use crate::prior::CompassPrior;
use crate::settings::{AnyPreset, CompassSettings};
use crate::status::{AnyStatus, CompassStatus};
use crate::types::{
    CompassCamera, CompassEstimate, CompassFix, CompassFrame, CompassMotion, CompassPose, CompassScan,
};
use core::ffi::{c_char, c_void};
use core::fmt::{self, Write as _};
use core::ptr::{self, NonNull};
use core::slice;

/// Version of this header: major times 10000 + minor times 100 + patch.
pub const COMPASS_VERSION: u32 = 100;

/// Version of the library: COMPASS_VERSION of the header that it was built with.
#[unsafe(no_mangle)]
pub const extern "C" fn compass_version() -> u32 {
    COMPASS_VERSION
}

/// What a status means: a sentence that needs no freeing, for any number.
#[unsafe(no_mangle)]
pub extern "C" fn compass_status_text(status: AnyStatus) -> *const c_char {
    CompassStatus::new(status.0).map_or(c"This is no CompassStatus.", CompassStatus::text).as_ptr()
}

/// Settings to start from; for a number that is no preset, settings that are refused.
#[unsafe(no_mangle)]
pub extern "C" fn compass_settings(preset: AnyPreset) -> CompassSettings {
    CompassSettings::of(preset)
}

/// Bytes of memory for two cameras with images of at most this size. 0 if settings are null or refused, or an image has
/// more than COMPASS_MAX_PIXELS.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_memory_bytes(
    width: u16,
    height: u16,
    settings: *const CompassSettings,
) -> usize {
    // SAFETY: the caller vouches for the settings.
    let settings = unsafe { input(settings, "settings") }.and_then(|settings| settings.check());
    match settings {
        Ok(settings) if compass::is_size(width, height) => compass::memory_bytes(width, height, &settings),
        _ => 0,
    }
}

/// Begins: a Compass in this memory, which it uses until compass_end. COMPASS_ALIGNMENT says how the memory is aligned,
/// compass_memory_bytes how much it takes. `*compass` is null on failure. MEMORY,
/// SETTINGS.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_new(
    memory: *mut c_void,
    bytes: usize,
    settings: *const CompassSettings,
    compass: *mut *mut Compass,
) -> CompassStatus {
    // SAFETY: the caller vouches for all; the settings are copied.
    let given = unsafe { (output(compass, "compass", ptr::null_mut()), input(settings, "settings")) };
    let settings = match given {
        (Ok(()), Ok(settings)) => settings.check(),
        (Err(failure), _) | (_, Err(failure)) => Err(failure),
    };
    let settings = match settings {
        Ok(settings) => settings,
        Err(failure) => return failure.status(),
    };
    let Some(memory) = NonNull::new(memory.cast::<u8>()) else { return CompassStatus::Null };
    // SAFETY: the caller vouches for the memory.
    match unsafe { Compass::begin(memory, bytes, settings) } {
        Ok(begun) => {
            // SAFETY: written before, so it is neither null nor misaligned.
            unsafe { compass.write(begun.as_ptr()) };
            CompassStatus::Ok
        }
        Err(status) => status,
    }
}

/// Ends: the memory is the caller's again, and later calls are refused as long as it is not lent anew.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_end(compass: *mut Compass) -> CompassStatus {
    // SAFETY: the caller vouches for it.
    match unsafe { Compass::at_mut(compass) } {
        Ok(compass) => {
            compass.end();
            CompassStatus::Ok
        }
        Err(status) => status,
    }
}

/// Says why the last call with this Compass failed, with names and numbers: which camera, which sizes, how many bytes are
/// missing. Writes at most `bytes` bytes with the zero at the end, and returns the length of the whole sentence without it;
/// 0 if the last call succeeded. `buffer` may be null if `bytes` is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_last_error(
    compass: *const Compass,
    buffer: *mut c_char,
    bytes: usize,
) -> usize {
    let room = if buffer.is_null() { 0 } else { bytes.min(isize::MAX as usize) };
    let mut text = Text { buffer, room, length: 0 };
    // SAFETY: the caller vouches for it.
    let written = match unsafe { Compass::at(compass) } {
        Ok(compass) => compass.failure.map_or(Ok(()), |failure| write!(text, "{failure}")),
        Err(status) => status.text().to_str().map_or(Ok(()), |sentence| text.write_str(sentence)),
    };
    // Writing never fails, only the room ends.
    let _ = written;
    text.finish()
}

/// Adds all layers of all floors of a site file (`compass map build`), which is read in place: it must stay as it is until
/// compass_end. Checksums are compared, which reads the file twice. On failure none is added. Frames must be seen anew. SITE,
/// LAYERS.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_add_site(
    compass: *mut Compass,
    site: *const c_void,
    bytes: usize,
) -> CompassStatus {
    let act = |compass: &mut Compass| {
        if site.is_null() {
            return Err(Failure::Null("site"));
        }
        // More than any object has is read as an empty file, which is refused.
        let bytes = if bytes > isize::MAX as usize { 0 } else { bytes };
        // SAFETY: not null, and the caller vouches for the length, and that the bytes stay.
        compass.add_site(unsafe { slice::from_raw_parts(site.cast(), bytes) })
    };
    // SAFETY: the caller vouches for it.
    unsafe { call(compass, act) }
}

/// Sets a camera, number 0 or 1; null takes it away. If it is refused the former stays. Frames must be seen anew.
/// CAMERA, MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_set_camera(
    compass: *mut Compass,
    number: u8,
    camera: *const CompassCamera,
) -> CompassStatus {
    let act = |compass: &mut Compass| {
        // SAFETY: the caller vouches for it.
        let camera = unsafe { optional(camera, "camera") }?;
        compass.set_camera(number, camera.as_ref())
    };
    // SAFETY: the caller vouches for it.
    unsafe { call(compass, act) }
}

/// Looks at the frames of one moment: those of all cameras that were set, null for a camera that was not. They are not used
/// after the call. Of the prior `up_kind` and `up` are read. FRAME, PRIOR, ORDER, UP, AXIS.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_see(
    compass: *mut Compass,
    frame_0: *const CompassFrame,
    frame_1: *const CompassFrame,
    prior: *const CompassPrior,
) -> CompassStatus {
    let act = |compass: &mut Compass| {
        compass.forget_look();
        // SAFETY: the caller vouches for all.
        let prior = unsafe { input(prior, "prior") }?;
        // SAFETY: the caller vouches for both, and for their pixels until the call ends.
        unsafe {
            let frames = [optional(frame_0, "frame_0")?, optional(frame_1, "frame_1")?];
            compass.see(frames, &prior)
        }
    };
    // SAFETY: the caller vouches for it.
    unsafe { call(compass, act) }
}

/// Finds the pose that explains best what was seen, over all layers. May be called again with another prior, of which all
/// but `up_kind` and `up` are read. On failure `fix->count` is 0. PRIOR, ORDER, NOWHERE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_locate(
    compass: *mut Compass,
    prior: *const CompassPrior,
    fix: *mut CompassFix,
) -> CompassStatus {
    let act = |compass: &mut Compass| {
        // SAFETY: the caller vouches for both.
        let prior = unsafe {
            output(fix, "fix", CompassFix::NONE)?;
            input(prior, "prior")?
        };
        let found = compass.locate(&prior)?;
        // SAFETY: written before.
        unsafe { fix.write(found) };
        if found.count > 0 { Ok(()) } else { Err(Failure::Nowhere) }
    };
    // SAFETY: the caller vouches for it.
    unsafe { call(compass, act) }
}

/// Takes the frames that were just located into the belief over the sequence, once, also after NOWHERE: `seconds` since the
/// frames tracked before, 0 for the first; `motion` as measured since then, or null. On failure `estimate->probability` is
/// 0. ORDER, MOTION, NOWHERE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_track(
    compass: *mut Compass,
    seconds: f32,
    motion: *const CompassMotion,
    estimate: *mut CompassEstimate,
) -> CompassStatus {
    let act = |compass: &mut Compass| {
        // SAFETY: the caller vouches for both.
        let motion = unsafe {
            output(estimate, "estimate", CompassEstimate::NONE)?;
            optional(motion, "motion")?
        };
        let believed = compass.track(seconds, motion.as_ref())?.ok_or(Failure::Nowhere)?;
        // SAFETY: written before.
        unsafe { estimate.write(believed) };
        Ok(())
    };
    // SAFETY: the caller vouches for it.
    unsafe { call(compass, act) }
}

/// Forgets the sequence: the next frames that are tracked are the first.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_forget(compass: *mut Compass) -> CompassStatus {
    let act = |compass: &mut Compass| {
        compass.forget_track();
        Ok(())
    };
    // SAFETY: the caller vouches for it.
    unsafe { call(compass, act) }
}

/// What surrounds a pose in its plan, cast with 360 rays: floor, layer, x, y and heading of the pose are read. FLOOR,
/// OUTSIDE, OCCUPIED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn compass_describe(
    compass: *mut Compass,
    pose: *const CompassPose,
    scan: *mut CompassScan,
) -> CompassStatus {
    let act = |compass: &mut Compass| {
        aligned(scan, "scan")?;
        // SAFETY: the caller vouches for it.
        let pose = unsafe { input(pose, "pose") }?;
        let described = compass.describe(&pose)?;
        // SAFETY: neither null nor misaligned, and the caller vouches for the rest.
        unsafe { scan.write(described) };
        Ok(())
    };
    // SAFETY: the caller vouches for it.
    unsafe { call(compass, act) }
}

/// Acts on a Compass, and keeps why that failed.
///
/// # Safety
/// As [`Compass::at_mut`].
unsafe fn call(
    compass: *mut Compass,
    act: impl FnOnce(&mut Compass) -> Result<(), Failure>,
) -> CompassStatus {
    // SAFETY: the caller vouches for it.
    let compass = match unsafe { Compass::at_mut(compass) } {
        Ok(compass) => compass,
        Err(status) => return status,
    };
    compass.failure = act(compass).err();
    compass.failure.map_or(CompassStatus::Ok, |failure| failure.status())
}

/// Whether something can lie there.
fn aligned<T>(pointer: *const T, name: &'static str) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::Null(name));
    }
    if pointer.is_aligned() { Ok(()) } else { Err(Failure::Alignment(name)) }
}

/// A copy of what the caller gives.
///
/// # Safety
/// The pointer is null or points to a `T`.
unsafe fn input<T: Copy>(pointer: *const T, name: &'static str) -> Result<T, Failure> {
    aligned(pointer, name)?;
    // SAFETY: neither null nor misaligned, and the caller vouches for the rest.
    Ok(unsafe { pointer.read() })
}

/// A copy of what the caller gives, if it gives something.
///
/// # Safety
/// The pointer is null or points to a `T`.
unsafe fn optional<T: Copy>(pointer: *const T, name: &'static str) -> Result<Option<T>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller vouches for it.
    unsafe { input(pointer, name) }.map(Some)
}

/// Begins an answer as one that says nothing: what lies there need not be initialised, and no older answer stays.
///
/// # Safety
/// The pointer is null or points to room for a `T`.
unsafe fn output<T>(pointer: *mut T, name: &'static str, nothing: T) -> Result<(), Failure> {
    aligned(pointer, name)?;
    // SAFETY: neither null nor misaligned, and the caller vouches for the rest.
    unsafe { pointer.write(nothing) };
    Ok(())
}

/// Text in the caller's buffer, cut off where the room for it and a zero ends.
struct Text {
    buffer: *mut c_char,
    room: usize,
    /// Of all that was written, whether it fitted or not.
    length: usize,
}

impl Text {
    /// Ends the text with a zero; its whole length.
    fn finish(self) -> usize {
        if let Some(last) = self.room.checked_sub(1) {
            // SAFETY: within the room.
            unsafe { self.buffer.add(self.length.min(last)).write(0) };
        }
        self.length
    }
}

impl fmt::Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            if self.length + 1 < self.room {
                // SAFETY: within the room.
                unsafe { self.buffer.add(self.length).write(byte as c_char) };
            }
            self.length += 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_is_that_of_the_package() {
        let parts = env!("CARGO_PKG_VERSION").split('.').map(|part| part.parse::<u32>().unwrap());
        assert_eq!(parts.fold(0, |version, part| 100 * version + part), compass_version());
    }
}
