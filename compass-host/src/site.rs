//! From a plan raster to what the core works on: the packed plan and the site map.

use crate::interior::{self, InteriorOptions};
use crate::plan_import::PlanRaster;
use anyhow::{Context as _, Result, anyhow, bail};
use compass_core::base::num::{Metres, Point, Turn};
use compass_core::base::scan::Scan;
use compass_core::descriptor::layer_of;
use compass_core::map::plan::{Frame, MarchError, Plan, pack, packed_len};
use compass_core::map::site_map::{Header, Layer, Sink, Writer};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

/// A plan in the core's packed form.
#[derive(Debug, Clone)]
pub struct PackedPlan {
    bytes: Vec<u8>,
}

impl PackedPlan {
    /// Packs a raster.
    ///
    /// # Errors
    /// When the resolution, origin or size lie outside what the core can hold.
    pub fn new(raster: &PlanRaster) -> Result<Self> {
        let (walls, windows) = (raster.walls_mask(), raster.windows_mask());
        let [x, y] = raster.origin;
        let origin = point(x, y).context("origin is too far out")?;
        let frame = Frame { resolution_nm: raster.resolution_nm(), origin };
        let mut bytes = vec![0; packed_len(&walls, &windows)?];
        pack(&walls, &windows, frame, &mut bytes)?;
        Ok(Self { bytes })
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
    pub fn scan(&self, at: [f64; 2], heading_deg: f64) -> Result<Scan> {
        let [x, y] = at;
        let mut scan = Scan::OPEN;
        let position = point(x, y).ok_or(MarchError::Outside);
        position
            .and_then(|p| self.view().scan(p, turn(heading_deg), &mut scan))
            .map_err(|e| anyhow!("at {x},{y}: {e}"))?;
        Ok(scan)
    }
}

/// A point of the map from metres; `None` when it is no number or out of reach.
#[must_use]
pub fn point(x: f64, y: f64) -> Option<Point> {
    let metres = |v: f64| if v.is_finite() { Metres::checked_from_num(v) } else { None };
    Some(Point::new(metres(x)?, metres(y)?))
}

/// A heading from degrees.
#[must_use]
pub fn turn(degrees: f64) -> Turn {
    let share = degrees.rem_euclid(360.0) / 360.0;
    // 2^32 itself is the whole turn, that is 0.
    Turn::from_bits((share * 4_294_967_296.0).round() as u64 as u32)
}

/// An angle in degrees, of any size, as one from -180 up to 180.
#[must_use]
pub fn wrapped(degrees: f64) -> f64 {
    (degrees + 180.0).rem_euclid(360.0) - 180.0
}

/// Options of [`build`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BuildOptions {
    /// Distance between candidates in metres.
    pub spacing_m: f64,
    /// Distance of candidates from anything occupied in metres.
    pub clearance_m: f64,
    /// Openings of the outline to bridge, in metres; automatic when absent.
    pub max_gap_m: Option<f64>,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { spacing_m: 0.5, clearance_m: interior::CLEARANCE_M, max_gap_m: None }
    }
}

/// Builds the site map of a plan: candidates on a grid over the interior, each with its scan, and with the scan of
/// the `structure` as a second layer when that is given.
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
) -> Result<Vec<u8>> {
    let BuildOptions { spacing_m, clearance_m, max_gap_m } = *options;
    let (walls, windows) = (raster.walls_mask(), raster.windows_mask());
    let choice = max_gap_m.map_or_else(InteriorOptions::default, InteriorOptions::with_max_gap_m);
    let found = interior::find(&walls, &windows, raster.resolution_m, &choice)?;
    let cells = found.candidates(&walls, &windows, spacing_m, clearance_m)?;
    if cells.is_empty() {
        bail!("no candidate: spacing {spacing_m} m and clearance {clearance_m} m leave no position inside");
    }
    let plans: Vec<Plan<'_>> = std::iter::once(plan).chain(structure).map(PackedPlan::view).collect();
    let layers = cast(&plans, &cells);
    let header = Header {
        candidates: u32::try_from(cells.len()).context("too many candidates")?,
        layers: plans.len() as u8,
        frame: plan.view().frame(),
        spacing_mm: (spacing_m * 1000.0).round() as u32,
        plan_size: [raster.width, raster.height],
        plan_checksum: plan.view().checksum(),
    };
    let mut writer = Writer::new(Bytes::default(), &header)?;
    for (cell, layers) in cells.iter().zip(layers.chunks_exact(plans.len())) {
        writer.candidate(*cell, layers)?;
    }
    Ok(writer.finish()?.0)
}

/// The layers of the first candidate, one of each plan, then those of the next.
fn cast(plans: &[Plan<'_>], cells: &[[u16; 2]]) -> Vec<Layer> {
    let progress = progress(cells.len() * plans.len(), "casting candidates");
    let layer = |plan: &Plan<'_>, [column, row]: [u16; 2]| {
        let mut scan = Scan::OPEN;
        // Candidates are free in the plan by construction, and in its structure, which only lacks walls; were one
        // not, its scan would be open all around.
        let _ = plan.scan(plan.cell_centre(column, row), Turn::ZERO, &mut scan);
        progress.inc(1);
        layer_of(&scan)
    };
    let layers =
        cells.par_iter().flat_map_iter(|&cell| plans.iter().map(move |plan| layer(plan, cell))).collect();
    progress.finish_and_clear();
    layers
}

/// A progress bar on standard error; silent when that is no terminal.
#[must_use]
pub fn progress(len: usize, what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} [{bar:40}] {pos}/{len} {eta}");
    let bar = ProgressBar::new(len as u64).with_message(what);
    style.map_or_else(|_| bar.clone(), |style| bar.clone().with_style(style))
}

/// Bytes in memory, as the core writes them.
#[derive(Debug, Default)]
pub struct Bytes(pub Vec<u8>);

impl Sink for Bytes {
    type Error = std::convert::Infallible;
    fn append(&mut self, bytes: &[u8]) -> Result<(), Self::Error> {
        self.0.extend_from_slice(bytes);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_become_turns() {
        for degrees in [-720.0, -90.0, 0.0, 12.345, 359.999_999_999_9, 1e6] {
            let back = f64::from(turn(degrees).to_bits()) / 4_294_967_296.0 * 360.0;
            let error = wrapped(back - f64::rem_euclid(degrees, 360.0));
            assert!(error.abs() < 1e-7, "{degrees} became {back}");
        }
        assert!(point(f64::NAN, 0.0).is_none());
        assert!(point(1e12, 0.0).is_none());
    }
}
