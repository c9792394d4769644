//! The site map of a plan: candidates on a grid over the interior, each with its scans.

use super::packed_plan::PackedPlan;
use crate::interior::{self, InteriorError, InteriorOptions, Places};
use crate::output::Bytes;
use crate::plan_import::PlanRaster;
use crate::progress::{Progress, Silent};
use compass_core::base::num::Turn;
use compass_core::base::scan::Scan;
use compass_core::descriptor::layer_of;
use compass_core::map::plan::Plan;
use compass_core::map::site_map::{Header, Layer, Writer};
use rayon::prelude::*;
use std::convert::Infallible;
use thiserror::Error;

/// Why a site map could not be built.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The plan has no interior, or an option is out of range.
    #[error(transparent)]
    Interior(#[from] InteriorError),
    /// No candidate position is inside and clear of everything occupied.
    #[error("no candidate: spacing {spacing_m} m and clearance {clearance_m} m leave no position inside")]
    NoCandidate {
        /// Distance between candidates, metres.
        spacing_m: f64,
        /// Distance of candidates from anything occupied, metres.
        clearance_m: f64,
    },
    /// There are 2^32 candidates or more.
    #[error("too many candidates")]
    TooManyCandidates,
}

/// Options of [`build`].
#[derive(Debug, Clone, PartialEq)]
pub struct BuildOptions {
    /// Distance between candidates in metres.
    pub spacing_m: f64,
    /// Distance of candidates from anything occupied in metres.
    pub clearance_m: f64,
    /// Openings of the outline to bridge, in metres; automatic when absent.
    pub max_gap_m: Option<f64>,
    /// What is inside, in map metres; if nothing is named, what the plan encloses.
    pub places: Places,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            spacing_m: 0.5,
            clearance_m: interior::CLEARANCE_M,
            max_gap_m: None,
            places: Places::default(),
        }
    }
}

/// Builds the site map of a plan: candidates on a grid over the interior, each with its scan and, if `structure` is
/// given, the scan of the structure as a second layer.
///
/// Uses all cores; the bytes are the same for any number of them.
///
/// # Errors
/// A plan without interior, options out of range, or no candidate left.
pub fn build(
    raster: &PlanRaster,
    plan: &PackedPlan,
    structure: Option<&PackedPlan>,
    options: &BuildOptions,
) -> Result<Vec<u8>, BuildError> {
    build_with_progress(raster, plan, structure, options, &Silent)
}

/// [`build`] with progress reports.
///
/// # Errors
/// As [`build`].
pub fn build_with_progress(
    raster: &PlanRaster,
    plan: &PackedPlan,
    structure: Option<&PackedPlan>,
    options: &BuildOptions,
    progress: &dyn Progress,
) -> Result<Vec<u8>, BuildError> {
    let BuildOptions { spacing_m, clearance_m, max_gap_m, places } = options.clone();
    let (walls, windows) = (raster.walls_mask(), raster.windows_mask());
    let choice = InteriorOptions { max_gap_m, places, origin: raster.origin };
    let found = interior::find(&walls, &windows, raster.resolution_m, &choice)?;
    let cells = found.candidates(&walls, &windows, spacing_m, clearance_m)?;
    if cells.is_empty() {
        return Err(BuildError::NoCandidate { spacing_m, clearance_m });
    }
    let plans: Vec<Plan<'_>> = std::iter::once(plan).chain(structure).map(PackedPlan::view).collect();
    let layers = cast(&plans, &cells, progress);
    let header = Header {
        candidates: u32::try_from(cells.len()).map_err(|_| BuildError::TooManyCandidates)?,
        layers: plans.len() as u8,
        grid: plan.view().grid(),
        spacing_mm: (spacing_m * 1000.0).round() as u32,
        plan_size: [raster.width, raster.height],
        plan_checksum: plan.view().checksum(),
    };
    let Ok(Bytes(bytes)) = write(&header, &cells, &layers);
    Ok(bytes)
}

/// The layers of the first candidate, one per plan, then those of the next.
fn cast(plans: &[Plan<'_>], cells: &[[u16; 2]], progress: &dyn Progress) -> Vec<Layer> {
    let progress = progress.begin(cells.len() * plans.len(), "casting candidates");
    let layer = |plan: &Plan<'_>, [column, row]: [u16; 2]| {
        let mut scan = Scan::OPEN;
        // Candidates are free in the plan by construction, and in its structure, which only lacks walls. An occupied
        // one would get an open scan.
        let _ = plan.scan(plan.cell_centre(column, row), Turn::ZERO, &mut scan);
        progress.step();
        layer_of(&scan)
    };
    let layer = &layer;
    cells.par_iter().flat_map_iter(|&cell| plans.iter().map(move |plan| layer(plan, cell))).collect()
}

/// Writes the map; writing into memory cannot fail.
fn write(header: &Header, cells: &[[u16; 2]], layers: &[Layer]) -> Result<Bytes, Infallible> {
    let mut writer = Writer::new(Bytes::default(), header)?;
    for (cell, layers) in cells.iter().zip(layers.chunks_exact(usize::from(header.layers))) {
        writer.candidate(*cell, layers)?;
    }
    writer.finish()
}
