//! One floor: a name, a site map and the plans of its layers.

use crate::map::plan::{Plan, PlanError};
use crate::map::site_map::{SiteMap, SiteMapError};
use core::fmt;

/// Most bytes of a floor's name.
pub const MAX_NAME_BYTES: usize = 23;

/// Whether a floor can have this name: 1 to [`MAX_NAME_BYTES`] bytes without control characters.
#[must_use]
pub fn is_name(name: &str) -> bool {
    (1..=MAX_NAME_BYTES).contains(&name.len()) && !name.chars().any(char::is_control)
}

/// Why parts do not make a floor. Layers count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FloorError {
    /// The name is empty, too long, not UTF-8, or has control characters.
    Name,
    /// A part does not lie where the parts before it end.
    Offset,
    /// The site map cannot be read.
    Map(SiteMapError),
    /// The packed plan of this layer cannot be read.
    Plan(u8, PlanError),
    /// The map has not as many layers as there are plans.
    Layers,
    /// Resolution or origin of this layer's plan are not those of the map.
    Frame(u8),
    /// Width or height of this layer's plan are not those that the map says.
    PlanSize(u8),
    /// The map says that it was made from another plan than that of layer 0.
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
            Self::Frame(layer) => {
                write!(f, "plan resolution or origin of layer {layer} are not those of its map")
            }
            Self::PlanSize(layer) => write!(f, "plan size of layer {layer} is not that of its map"),
            Self::PlanChecksum => f.write_str("its map was made from another plan than its own"),
        }
    }
}

impl core::error::Error for FloorError {}

/// A floor of a site: where one can be on it, and what surrounds one there.
#[derive(Debug, Clone, Copy)]
pub struct Floor<'a> {
    name: &'a str,
    map: SiteMap<'a>,
    plan: Plan<'a>,
    structure: Option<Plan<'a>>,
}

impl<'a> Floor<'a> {
    /// Puts a floor together from its map, the plan that was made from, and of a map of two layers the plan of the
    /// structure alone.
    ///
    /// # Errors
    /// [`FloorError`] names what does not fit.
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
            if plan.frame() != header.frame {
                return Err(FloorError::Frame(layer));
            }
            if [plan.width(), plan.height()] != header.plan_size {
                return Err(FloorError::PlanSize(layer));
            }
        }
        if plan.checksum() == header.plan_checksum { Ok(floor) } else { Err(FloorError::PlanChecksum) }
    }

    /// Its name, unique in its site.
    #[must_use]
    pub const fn name(&self) -> &'a str {
        self.name
    }

    /// The map of positions.
    #[must_use]
    pub const fn map(&self) -> &SiteMap<'a> {
        &self.map
    }

    /// Layers of map and plans, 1 or 2.
    #[must_use]
    pub const fn layers(&self) -> usize {
        if self.structure.is_some() { 2 } else { 1 }
    }

    /// The plan from which a layer of the map was cast: 0 the plan as drawn, 1 its structure.
    #[must_use]
    pub fn plan(&self, layer: usize) -> Option<Plan<'a>> {
        self.plans().nth(layer)
    }

    fn plans(&self) -> impl Iterator<Item = Plan<'a>> + use<'a> {
        core::iter::once(self.plan).chain(self.structure)
    }

    /// The bytes of its parts in the order of the file.
    pub(super) fn parts(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        core::iter::once(self.map.as_bytes()).chain(self.plans().map(|plan| plan.as_bytes()))
    }

    pub(super) fn verify(&self) -> Result<(), FloorError> {
        self.map.verify().map_err(FloorError::Map)?;
        let mut plans = (0..).zip(self.plans());
        plans.try_for_each(|(layer, plan)| plan.verify().map_err(|error| FloorError::Plan(layer, error)))
    }
}
