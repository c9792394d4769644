//! A floor: name, site map, and the packed plans of its layers.

use crate::map::plan::{Plan, PlanError};
use crate::map::site_map::{SiteMap, SiteMapError};
use core::fmt;

/// Largest length of the name of a floor, bytes of UTF-8.
pub const MAX_NAME_BYTES: usize = 23;

/// Whether a name is valid for a floor: 1 to [`MAX_NAME_BYTES`] bytes of UTF-8 without control characters.
#[must_use]
pub fn is_name(name: &str) -> bool {
    (1..=MAX_NAME_BYTES).contains(&name.len()) && !name.chars().any(char::is_control)
}

/// Errors of [`Floor::new`] and of reading a floor. Layers are numbered 0 plan, 1 structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FloorError {
    /// The name is empty, too long, not UTF-8, or contains control characters.
    Name,
    /// The offset of a part is not the end of the part before it.
    Offset,
    /// The site map is invalid.
    Map(SiteMapError),
    /// The packed plan of this layer is invalid.
    Plan(u8, PlanError),
    /// The number of layers of the map differs from the number of plans.
    Layers,
    /// Resolution or origin of the plan of this layer differ from those of the map.
    Grid(u8),
    /// Width or height of the plan of this layer differ from those of the map.
    PlanSize(u8),
    /// The map was cast from a plan other than that of layer 0.
    PlanChecksum,
}

impl fmt::Display for FloorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name => {
                write!(f, "its name is not 1 to {MAX_NAME_BYTES} bytes of UTF-8 without control characters")
            }
            Self::Offset => f.write_str("a part does not lie where the one before it ends"),
            Self::Map(error) => error.fmt(f),
            Self::Plan(layer, error) => write!(f, "layer {layer}: {error}"),
            Self::Layers => f.write_str("its map has not as many layers as it has plans"),
            Self::Grid(layer) => {
                write!(f, "plan resolution or origin of layer {layer} are not those of its map")
            }
            Self::PlanSize(layer) => write!(f, "plan size of layer {layer} is not that of its map"),
            Self::PlanChecksum => f.write_str("its map was made from another plan than its own"),
        }
    }
}

impl core::error::Error for FloorError {}

/// A floor of a site: its candidates and the packed plans of its layers.
#[derive(Debug, Clone, Copy)]
pub struct Floor<'a> {
    name: &'a str,
    map: SiteMap<'a>,
    plan: Plan<'a>,
    structure: Option<Plan<'a>>,
}

impl<'a> Floor<'a> {
    /// A floor from its parts: the site map, the plan that layer 0 was cast from, and for a map of two layers the plan of
    /// the structure.
    ///
    /// # Errors
    /// [`FloorError`]: invalid name, or map and plans that do not belong together.
    pub fn new(
        name: &'a str,
        map: SiteMap<'a>,
        plan: Plan<'a>,
        structure: Option<Plan<'a>>,
    ) -> Result<Self, FloorError> {
        let floor = Self { name, map, plan, structure };
        let header = map.header();
        if !is_name(name) {
            return Err(FloorError::Name);
        }
        if usize::from(header.layers) != floor.plans().count() {
            return Err(FloorError::Layers);
        }
        for (layer, plan) in (0..).zip(floor.plans()) {
            if plan.grid() != header.grid {
                return Err(FloorError::Grid(layer));
            }
            if [plan.width(), plan.height()] != header.plan_size {
                return Err(FloorError::PlanSize(layer));
            }
        }
        if plan.checksum() == header.plan_checksum { Ok(floor) } else { Err(FloorError::PlanChecksum) }
    }

    /// The name, unique within a site.
    #[must_use]
    pub const fn name(&self) -> &'a str {
        self.name
    }

    /// The site map: candidates and their scans.
    #[must_use]
    pub const fn map(&self) -> &SiteMap<'a> {
        &self.map
    }

    /// Number of layers, 1 or 2.
    #[must_use]
    pub const fn layers(&self) -> usize {
        if self.structure.is_some() { 2 } else { 1 }
    }

    /// The plan that a layer of the map was cast from: 0 plan, 1 structure; `None` for a layer that does not exist.
    #[must_use]
    pub fn plan(&self, layer: usize) -> Option<Plan<'a>> {
        self.plans().nth(layer)
    }

    fn plans(&self) -> impl Iterator<Item = Plan<'a>> + use<'a> {
        core::iter::once(self.plan).chain(self.structure)
    }

    /// The bytes of the parts in the order of the file.
    pub(super) fn parts(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        core::iter::once(self.map.as_bytes()).chain(self.plans().map(|plan| plan.as_bytes()))
    }

    pub(super) fn verify(&self) -> Result<(), FloorError> {
        self.map.verify().map_err(FloorError::Map)?;
        let mut plans = (0..).zip(self.plans());
        plans.try_for_each(|(layer, plan)| plan.verify().map_err(|error| FloorError::Plan(layer, error)))
    }
}
