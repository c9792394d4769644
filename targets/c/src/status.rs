//! What became of a call.

use core::ffi::CStr;

/// What became of a call. `compass_last_error` says more about the last one that failed.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CompassStatus {
    /// The call succeeded.
    Ok = 0,
    /// A pointer is null that must not be.
    Null = 1,
    /// The pointer is no Compass: compass_new did not make it, compass_end ended it, or its memory was overwritten or moved.
    Handle = 2,
    /// The memory is not aligned to COMPASS_ALIGNMENT bytes, or another pointer not to its type.
    Alignment = 3,
    /// The memory is too short: see compass_memory_bytes.
    Memory = 4,
    /// A setting lies outside its range, or the settings were not made by compass_settings.
    Settings = 5,
    /// The bytes are no site file, or a damaged one.
    Site = 6,
    /// The sites have more than COMPASS_MAX_LAYERS layers.
    Layers = 7,
    /// The camera number is above 1, or the numbers make no lens, no image size or no rotation.
    Camera = 8,
    /// A frame is missing, is of a camera that was not set, or has another size than its camera.
    Frame = 9,
    /// Up vector or height is not finite or outside its range, or the prior does not say what is known.
    Prior = 10,
    /// A step before this one is missing: cameras and site, then see, then locate, then track once.
    Order = 11,
    /// The frames show too few vertical lines, or no sky where the prior leaves the side open: up is unknown.
    Up = 12,
    /// The up vector lies along the optical axis of camera 0, which leaves no heading.
    Axis = 13,
    /// No pose was found.
    Nowhere = 14,
    /// Seconds or motion are not finite, or seconds are negative.
    Motion = 15,
    /// No site that was added has this floor and layer.
    Floor = 16,
    /// The position lies outside the plan.
    Outside = 17,
    /// The position lies inside a wall or glazing.
    Occupied = 18,
}

impl CompassStatus {
    /// All, by their numbers.
    const ALL: [Self; 19] = [
        Self::Ok,
        Self::Null,
        Self::Handle,
        Self::Alignment,
        Self::Memory,
        Self::Settings,
        Self::Site,
        Self::Layers,
        Self::Camera,
        Self::Frame,
        Self::Prior,
        Self::Order,
        Self::Up,
        Self::Axis,
        Self::Nowhere,
        Self::Motion,
        Self::Floor,
        Self::Outside,
        Self::Occupied,
    ];

    /// The status with this number.
    pub(crate) fn new(number: i32) -> Option<Self> {
        Self::ALL.get(usize::try_from(number).ok()?).copied()
    }

    /// The sentence of the header.
    pub(crate) const fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"The call succeeded.",
            Self::Null => c"A pointer is null that must not be.",
            Self::Handle => {
                c"The pointer is no Compass: compass_new did not make it, compass_end ended it, or its memory was overwritten or moved."
            }
            Self::Alignment => {
                c"The memory is not aligned to COMPASS_ALIGNMENT bytes, or another pointer not to its type."
            }
            Self::Memory => c"The memory is too short: see compass_memory_bytes.",
            Self::Settings => {
                c"A setting lies outside its range, or the settings were not made by compass_settings."
            }
            Self::Site => c"The bytes are no site file, or a damaged one.",
            Self::Layers => c"The sites have more than COMPASS_MAX_LAYERS layers.",
            Self::Camera => {
                c"The camera number is above 1, or the numbers make no lens, no image size or no rotation."
            }
            Self::Frame => {
                c"A frame is missing, is of a camera that was not set, or has another size than its camera."
            }
            Self::Prior => {
                c"Up vector or height is not finite or outside its range, or the prior does not say what is known."
            }
            Self::Order => {
                c"A step before this one is missing: cameras and site, then see, then locate, then track once."
            }
            Self::Up => {
                c"The frames show too few vertical lines, or no sky where the prior leaves the side open: up is unknown."
            }
            Self::Axis => {
                c"The up vector lies along the optical axis of camera 0, which leaves no heading."
            }
            Self::Nowhere => c"No pose was found.",
            Self::Motion => c"Seconds or motion are not finite, or seconds are negative.",
            Self::Floor => c"No site that was added has this floor and layer.",
            Self::Outside => c"The position lies outside the plan.",
            Self::Occupied => c"The position lies inside a wall or glazing.",
        }
    }
}

/// A status as C gives it: any number. The header calls it `CompassStatus`.
#[repr(transparent)]
#[derive(Debug, Clone, Copy)]
pub struct AnyStatus(pub(crate) i32);

#[cfg(test)]
mod tests {
    use super::*;
    use std::{format, fs};

    #[test]
    fn numbers_are_in_order() {
        for (number, status) in (0..).zip(CompassStatus::ALL) {
            assert_eq!((status as i32, CompassStatus::new(number)), (number, Some(status)));
        }
        assert_eq!([-1, 19, i32::MAX].map(CompassStatus::new), [None; 3]);
    }

    /// The header is made of the comments, and a test compares it with them.
    #[test]
    fn sentences_are_those_of_the_header() {
        let header = concat!(env!("CARGO_MANIFEST_DIR"), "/include/compass.h");
        let header = fs::read_to_string(header).unwrap();
        for status in CompassStatus::ALL {
            let line = format!("  // {}\n", status.text().to_str().unwrap());
            assert!(header.contains(&line), "{line}");
        }
    }
}
