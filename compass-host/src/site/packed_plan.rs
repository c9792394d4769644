//! A plan raster in the core's packed form.

use super::place::{point, turn};
use crate::plan_import::PlanRaster;
use compass_core::base::scan::Scan;
use compass_core::map::plan::{MarchError, Plan, PlanError, PlanGrid, pack, packed_len};
use thiserror::Error;

/// Why a raster cannot be packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PackError {
    /// The origin is out of the range of coordinates, or not finite.
    #[error("origin is too far out")]
    Origin,
    /// The core does not support the size or the resolution.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// A position from which no rays can be cast.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("at {},{}: {source}", at[0], at[1])]
pub struct ScanError {
    /// The position in metres.
    pub at: [f64; 2],
    /// What is wrong with it.
    pub source: MarchError,
}

/// A plan in the core's packed form.
#[derive(Debug, Clone)]
pub struct PackedPlan {
    bytes: Vec<u8>,
}

impl PackedPlan {
    /// Packs a raster.
    ///
    /// # Errors
    /// When the resolution, origin or size is out of the core's range.
    pub fn new(raster: &PlanRaster) -> Result<Self, PackError> {
        let (walls, windows) = (raster.walls_mask(), raster.windows_mask());
        let [x, y] = raster.origin;
        let origin = point(x, y).ok_or(PackError::Origin)?;
        let grid = PlanGrid { resolution_nm: raster.resolution_nm(), origin };
        let mut bytes = vec![0; packed_len(&walls, &windows)?];
        pack(&walls, &windows, grid, &mut bytes)?;
        Ok(Self { bytes })
    }

    /// Packs the structure of a plan as the second layer of a site: `None` if it is all of this plan, since a second layer that is
    /// the first one says nothing.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn second_layer(&self, structure: &PlanRaster) -> Result<Option<Self>, PackError> {
        let packed = Self::new(structure)?;
        Ok((packed.bytes != self.bytes).then_some(packed))
    }

    /// The plan.
    ///
    /// # Panics
    /// Never: the bytes were packed by [`PackedPlan::new`].
    #[must_use]
    pub fn view(&self) -> Plan<'_> {
        Plan::new(&self.bytes).expect("packed by this type")
    }

    /// The packed bytes.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Casts 360 rays from a position in metres.
    ///
    /// # Errors
    /// Names the position when it is outside the plan or occupied.
    pub fn scan(&self, at: [f64; 2], heading_deg: f64) -> Result<Scan, ScanError> {
        let [x, y] = at;
        let mut scan = Scan::OPEN;
        let position = point(x, y).ok_or(MarchError::Outside);
        position
            .and_then(|p| self.view().scan(p, turn(heading_deg), &mut scan))
            .map_err(|source| ScanError { at, source })?;
        Ok(scan)
    }
}
