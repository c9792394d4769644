//! Projection of bearings of the level frame into one camera of a rig, at the nodes of a coarse grid.

use super::level_frame::{LevelFrame, NOMINAL_RANGE_M};
use super::sample::{ExclusionMask, SUBPIXEL};
use crate::base::num::truncate_to_i32;
use crate::base::raster::GrayImage;
use crate::vision::camera::{Bearing, Rig, View};

/// Radius of a camera's usable field: cosine of 95 degrees.
pub(crate) const RIM_COS: f32 = -0.087_155_74;
/// A node with a lead below this borders no cell of this camera: between opposite corners of a patch of 4 x 4 degrees the
/// lead changes by at most twice the sine of 5.7 degrees, and the baseline changes it little.
const LEAST_LEAD: f32 = -0.22;

/// One camera of a rig, with its image and the frame of azimuths and elevations.
#[derive(Clone, Copy)]
pub(crate) struct CameraView<'a> {
    /// All cameras in use: a bearing belongs to the camera whose axis is nearest.
    pub(crate) rig: &'a Rig,
    /// Number of the camera.
    pub(crate) camera: usize,
    /// Frame of azimuths and elevations.
    pub(crate) level: LevelFrame,
    /// Its image.
    pub(crate) image: &'a GrayImage<'a>,
    /// Pixels that are left out.
    pub(crate) excluded: ExclusionMask<'a>,
}

/// Projects bearings of the level frame into one camera's image.
pub(crate) struct Projector<'a> {
    view: &'a View,
    rival: Option<&'a View>,
    level: LevelFrame,
}

/// A node of the projection grid: pixel position in 1/256 px, and lead in 2^-14, the cosine of the angle to this camera's
/// axis less that of the other camera. Above 0 the bearing belongs to this camera.
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

    /// The node at an azimuth and an elevation, each as sine and cosine.
    pub(crate) fn node(&self, azimuth: (f32, f32), elevation: (f32, f32)) -> Node {
        let bearing = self.level.bearing_of(azimuth, elevation);
        let seen_from = |view: &View| -> Bearing {
            let b = view.rotation.tr_mul(&(bearing * NOMINAL_RANGE_M - view.position));
            b / libm::sqrtf(b.dot(&b))
        };
        let mine = seen_from(self.view);
        // At the rim of the usable field the lead falls below 0, as where the other camera is nearer.
        let within = (mine.z - RIM_COS) * 8.0;
        let lead = |lead: f32| truncate_to_i32(lead * 16_384.0);
        if mine.z <= RIM_COS - 0.05 {
            return Node { lead: lead(within), ..Node::default() };
        }
        let ahead = self.rival.map_or(1.0, |rival| mine.z - seen_from(rival).z);
        // Projection dominates the cost: skip it where the other camera's lead leaves no cell to this one.
        let pixel = if ahead > LEAST_LEAD { self.view.camera.project(&mine) } else { None };
        let scale = (1 << SUBPIXEL) as f32;
        // Clamped to 2^13 pixels, so that products with weights of 9 bits fit `i32`.
        let fixed = |v: f32| truncate_to_i32(v.clamp(-8_192.0, 8_192.0) * scale);
        Node {
            x: pixel.map_or(0, |p| fixed(p.x)),
            y: pixel.map_or(0, |p| fixed(p.y)),
            lead: lead(if ahead < within { ahead } else { within }),
            usable: pixel.is_some(),
        }
    }
}
