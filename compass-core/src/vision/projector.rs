//! Projection of bearings of the level frame into one camera of a rig, on a coarse grid of nodes.

use super::level_frame::{LevelFrame, NOMINAL_RANGE_M};
use super::sample::{ExclusionMask, SUBPIXEL};
use crate::base::raster::GrayImage;
use crate::vision::camera::{Bearing, Rig, View};

/// Bearings further than this from a camera's axis are left to nobody: cosine of 95 degrees.
pub(crate) const RIM_COS: f32 = -0.087_155_74;
/// Nodes that trail by more border on no cell that is this camera's: between opposite corners of 4 by 4 degrees a lead
/// changes by at most twice the sine of 5.7 degrees, and by very little for the cameras' distance.
const BEHIND: f32 = -0.22;

/// One camera of a rig and what is looked at with it.
#[derive(Clone, Copy)]
pub(crate) struct CameraView<'a> {
    /// All cameras that are in use: the one nearest to a bearing by its axis has it.
    pub(crate) rig: &'a Rig,
    /// Number of the camera.
    pub(crate) camera: usize,
    /// Axes that azimuths and elevations are measured in.
    pub(crate) level: LevelFrame,
    /// Its image.
    pub(crate) image: &'a GrayImage<'a>,
    /// Pixels that say nothing.
    pub(crate) excluded: ExclusionMask<'a>,
}

/// Where bearings of the level frame fall in one camera's image.
pub(crate) struct Projector<'a> {
    view: &'a View,
    rival: Option<&'a View>,
    level: LevelFrame,
}

/// A point of the projection grid: position in 1/256 px, and how much nearer to this camera's axis than to the
/// other's it is (cosines times 2^14).
#[derive(Clone, Copy, Default)]
pub(crate) struct Node {
    pub(crate) x: i32,
    pub(crate) y: i32,
    pub(crate) lead: i32,
    pub(crate) usable: bool,
}

impl<'a> Projector<'a> {
    /// `None` if the rig has no such camera.
    #[inline]
    pub(crate) fn new(&CameraView { rig, camera, level, .. }: &CameraView<'a>) -> Option<Self> {
        Some(Self { view: rig.view(camera)?, rival: rig.view(1 - camera.min(1)), level })
    }

    /// From sine and cosine of azimuth and elevation.
    pub(crate) fn node(&self, azimuth: (f32, f32), elevation: (f32, f32)) -> Node {
        let bearing = self.level.bearing_of(azimuth, elevation);
        let seen_from = |view: &View| -> Bearing {
            let b = view.rotation.tr_mul(&(bearing * NOMINAL_RANGE_M - view.position));
            b / libm::sqrtf(b.dot(&b))
        };
        let mine = seen_from(self.view);
        // Leaving the rim of the field counts as losing to the other camera.
        let within = (mine.z - RIM_COS) * 8.0;
        let lead = |lead: f32| (lead * 16_384.0) as i32;
        if mine.z <= RIM_COS - 0.05 {
            return Node { lead: lead(within), ..Node::default() };
        }
        let ahead = self.rival.map_or(1.0, |rival| mine.z - seen_from(rival).z);
        // The lens is what costs: where the other camera is far ahead nothing will be looked up.
        let pixel = if ahead > BEHIND { self.view.camera.project(&mine) } else { None };
        let scale = (1 << SUBPIXEL) as f32;
        // Within 2^13 pixels, so that weights of 9 bits fit as well.
        let fixed = |v: f32| (v.clamp(-8_192.0, 8_192.0) * scale) as i32;
        Node {
            x: pixel.map_or(0, |p| fixed(p.x)),
            y: pixel.map_or(0, |p| fixed(p.y)),
            lead: lead(if ahead < within { ahead } else { within }),
            usable: pixel.is_some(),
        }
    }
}
