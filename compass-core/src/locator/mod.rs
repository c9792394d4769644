//! From the frames of a rig to a pose: the one pipeline, in memory that its stages share.
//!
//! Host, firmware and C library all run the frames through a [`Locator`]; equal frames, site and [`Settings`] give equal
//! bits everywhere.
//!
//! ```text
//! frames -> Segmented -> Levelled -> Seen -> Fix
//!           segments     up vector   windows, boundaries of floor and ceiling   pose, probability, heights
//! ```
//!
//! [`Locator::locate`] runs them all. Who needs what lies between takes them one by one: each stage is a type that only
//! the stage before it makes, and borrows the locator, so that no stage can be left out or see the frames of another
//! moment. A [`Trace`] sees the result of each.
//!
//! # Cost
//! The memory is one block of `u32` words, of which [`Settings::memory_words`] says at compile time how many it takes.
//! No stage needs all of it for long: the panorama of the windows lies where the detector of segments had its pixels, then
//! the raster of the boundaries, then the search. The presets of [`Settings`] say what they cost.

mod error;
#[cfg(any(test, feature = "introspect"))]
mod introspect;
mod memory;
mod settings;
mod stages;
mod trace;

pub use error::{Error, Field};
pub use settings::{Settings, Smoothing};
pub use stages::{Levelled, Seen, Segmented};
pub use trace::{Picture, Stage, Trace};

use crate::base::raster::GrayImage;
use crate::map::plan::Plan;
use crate::map::site::{Floor, MAX_FLOORS, Site};
use crate::map::site_map::SiteMap;
use crate::pose::heights::HeightPrior;
use crate::pose::{Fix, FloorLayer, PosePrior};
use crate::vision::attitude::UpHint;
use crate::vision::camera::{CAMERAS, PerCamera, Rig, View};
use crate::vision::panorama::Resolution;
use crate::vision::sample::ExclusionMask;
use crate::vision::windows::WindowEvidence;
use heapless::Vec;

/// Most layers of a site: two for each floor.
pub const LAYERS_OF_A_SITE: usize = 2 * MAX_FLOORS;

/// The image of one camera.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// Gray levels, of the size that the rig says.
    pub gray: GrayImage<'a>,
    /// Pixels that say nothing of the building: the robot's own parts.
    pub excluded: ExclusionMask<'a>,
}

impl<'a> From<GrayImage<'a>> for Frame<'a> {
    fn from(gray: GrayImage<'a>) -> Self {
        Self { gray, excluded: ExclusionMask::Unknown }
    }
}

/// The images of all cameras at one moment, `None` for a camera that the rig does not have.
pub type Frames<'a> = PerCamera<Option<Frame<'a>>>;

/// What is known before anything is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// Where up is, roughly, in the axes of camera 0.
    pub up: UpHint,
    /// Heights of the camera and of the ceiling.
    pub heights: HeightPrior,
    /// Where the pose is.
    pub pose: PosePrior,
}

impl Prior {
    /// Up and the heights; of the pose nothing is known.
    #[must_use]
    pub const fn new(up: UpHint, heights: HeightPrior) -> Self {
        Self { up, heights, pose: PosePrior::UNKNOWN }
    }
}

/// Finds the poses of a rig on a site.
///
/// `M` is the memory: a slice lent, or whatever owns one. `T` sees what the stages find. At most `LAYERS` layers of floors
/// are searched: a site has one or two for each floor.
#[derive(Debug)]
pub struct Locator<'a, M = &'a mut [u32], T = (), const LAYERS: usize = 16> {
    layers: Vec<FloorLayer<'a>, LAYERS>,
    rig: Rig,
    settings: Settings,
    resolution: Resolution,
    trace: T,
    found: Found,
    memory: M,
}

/// What the stages hand on, beside what lies in the memory.
#[derive(Debug)]
struct Found {
    segments: [usize; CAMERAS],
    arcs: usize,
    windows: WindowEvidence,
}

impl Found {
    const NOTHING: Self = Self { segments: [0; CAMERAS], arcs: 0, windows: WindowEvidence::NOTHING };
}

impl<'a, M: AsRef<[u32]> + AsMut<[u32]>, const LAYERS: usize> Locator<'a, M, (), LAYERS> {
    /// For the cameras of a rig on all floors of a site. What the memory holds does not matter.
    ///
    /// # Errors
    /// As of [`traced`](Self::traced); [`Error::Layers`] if the site has more than `LAYERS`.
    pub fn new(site: &Site<'a>, rig: Rig, settings: Settings, memory: M) -> Result<Self, Error> {
        let mut locator = Self::without_site(rig, settings, memory)?;
        locator.add_site(site)?;
        Ok(locator)
    }

    /// For cameras that are named later, with [`set_rig`](Self::set_rig); layers may be added.
    ///
    /// # Errors
    /// As of [`traced`](Self::traced).
    pub fn without_rig(settings: Settings, memory: M) -> Result<Self, Error> {
        Self::without_site(Rig::NONE, settings, memory)
    }

    /// For the cameras of a rig, to look around with; layers may be added.
    ///
    /// # Errors
    /// As of [`traced`](Self::traced).
    pub fn without_site(rig: Rig, settings: Settings, memory: M) -> Result<Self, Error> {
        Self::traced(rig, settings, memory, ())
    }
}

impl<'a, M: AsRef<[u32]> + AsMut<[u32]>, T: Trace, const LAYERS: usize> Locator<'a, M, T, LAYERS> {
    /// For the cameras of a rig, with a sink of what the stages find; layers may be added.
    ///
    /// # Errors
    /// [`Error::Setting`] for a setting out of its range, [`Error::Side`] for images that are too large;
    /// [`Error::Memory`] says how much is missing.
    pub fn traced(rig: Rig, settings: Settings, memory: M, trace: T) -> Result<Self, Error> {
        settings.check(&rig, memory.as_ref().len())?;
        let resolution = settings.resolution(&rig);
        Ok(Self { layers: Vec::new(), rig, settings, resolution, trace, found: Found::NOTHING, memory })
    }
}

impl<'a, M, T, const LAYERS: usize> Locator<'a, M, T, LAYERS> {
    /// Adds all layers of all floors of a site, behind those that are there: all or none.
    ///
    /// # Errors
    /// [`Error::Layers`].
    pub fn add_site(&mut self, site: &Site<'a>) -> Result<(), Error> {
        let before = self.layers.len();
        let added = site.floors().try_for_each(|floor| self.add_layers(&floor));
        if added.is_err() {
            self.layers.truncate(before);
        }
        added
    }

    /// Adds the layers of a floor behind those that are there: all or none.
    ///
    /// # Errors
    /// [`Error::Layers`].
    pub fn add_layers(&mut self, floor: &Floor<'a>) -> Result<(), Error> {
        let (before, number) = (self.layers.len(), self.floors());
        for (layer, index) in (0..).zip(0..floor.layers()) {
            let Some(plan) = floor.plan(index) else { continue };
            let (map, name) = (*floor.map(), floor.name());
            let layer = FloorLayer { map, number: layer, plan, floor: number, name };
            if self.layers.push(layer).is_err() {
                self.layers.truncate(before);
                return Err(Error::Layers { most: LAYERS });
            }
        }
        Ok(())
    }

    /// Adds a floor of one layer: its candidates, and the plan that they were cast from.
    ///
    /// # Errors
    /// [`Error::Layers`].
    pub fn add_floor(&mut self, name: &'a str, map: SiteMap<'a>, plan: Plan<'a>) -> Result<(), Error> {
        let layer = FloorLayer { map, number: 0, plan, floor: self.floors(), name };
        self.layers.push(layer).map_err(|_| Error::Layers { most: LAYERS })
    }

    fn floors(&self) -> u8 {
        self.layers.last().map_or(0, |layer| layer.floor.saturating_add(1))
    }

    /// The layers in the order that [`ScoredPose::layer`](crate::pose::ScoredPose::layer) counts them.
    #[must_use]
    pub fn layers(&self) -> &[FloorLayer<'a>] {
        &self.layers
    }

    /// The cameras.
    #[must_use]
    pub const fn rig(&self) -> &Rig {
        &self.rig
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Size of the panorama's cells: what the settings allow and the coarsest lens holds.
    #[must_use]
    pub const fn resolution(&self) -> Resolution {
        self.resolution
    }

    /// Largest angle between a segment and the vertical that it points to, degrees.
    #[must_use]
    pub fn inlier_tolerance_deg(&self) -> f32 {
        self.settings.tolerance_deg(self.resolution)
    }

    /// The sink of what the stages find.
    pub const fn trace_mut(&mut self) -> &mut T {
        &mut self.trace
    }

    /// The same locator with another sink.
    #[must_use]
    pub fn with_trace<U>(self, trace: U) -> Locator<'a, M, U, LAYERS> {
        let Self { layers, rig, settings, resolution, found, memory, .. } = self;
        Locator { layers, rig, settings, resolution, trace, found, memory }
    }
}

impl<'a, M: AsRef<[u32]> + AsMut<[u32]>, T: Trace, const LAYERS: usize> Locator<'a, M, T, LAYERS> {
    /// Takes another rig, as for a recording whose frames change their size.
    ///
    /// # Errors
    /// [`Error::Side`], [`Error::Memory`]; the rig is then the former.
    pub fn set_rig(&mut self, rig: Rig) -> Result<(), Error> {
        self.settings.check(&rig, self.memory.as_ref().len())?;
        self.resolution = self.settings.resolution(&rig);
        self.rig = rig;
        Ok(())
    }

    /// The pose that explains best what the frames show.
    ///
    /// # Errors
    /// [`Error::Camera`], [`Error::Size`] and [`Error::Mask`] name the camera whose frame does not fit the rig;
    /// [`Error::Up`] and [`Error::Axis`] if the frames do not tell which way is up. "Nowhere" is no error: see
    /// [`Fix::probability`]. Frames that show nothing have a pose too, of probability 0.
    pub fn locate(&mut self, frames: &Frames<'_>, prior: &Prior) -> Result<Fix<'a>, Error> {
        Ok(self.segment(frames)?.level_near(prior.up)?.see().locate_within(prior.heights, &prior.pose))
    }

    /// First stage: the line segments of all frames.
    ///
    /// # Errors
    /// [`Error::Camera`], [`Error::Size`], [`Error::Mask`].
    // Inlined down to the loops over all pixels, so that a caller compiled for wider vectors has them wider.
    #[inline(always)]
    pub fn segment<'l, 'f>(&'l mut self, frames: &Frames<'f>) -> Result<Segmented<'l, 'f, Self>, Error> {
        check_frames(&self.rig, frames)?;
        Ok(Segmented::new(self, *frames))
    }

    fn memory_map(&self) -> memory::Layout {
        self.settings.layout(&self.rig)
    }
}

/// Whether there is a frame of each camera of the rig and of no other, each of the size that the rig says.
fn check_frames(rig: &Rig, frames: &Frames<'_>) -> Result<(), Error> {
    for (number, frame) in (0..).zip(frames) {
        match (rig.view(usize::from(number)), frame) {
            (Some(view), Some(frame)) => check_size(number, view, frame)?,
            (None, None) => {}
            (view, _) => return Err(Error::Camera { camera: number, missing: view.is_some() }),
        }
    }
    Ok(())
}

fn check_size(camera: u8, view: &View, frame: &Frame<'_>) -> Result<(), Error> {
    let expected = [view.width, view.height].map(u32::from);
    let found = [frame.gray.width(), frame.gray.height()];
    if found != expected {
        return Err(Error::Size { camera, expected, found });
    }
    match frame.excluded.size() {
        Some(found) if found != expected => Err(Error::Mask { camera, expected, found }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
