//! Plans, and what is seen from a place in them.

use crate::arrays::{from_rgb, matrix};
use crate::error::{finite, wrong, wrong_in};
use compass_host::compass_core::base::scan::Scan;
use compass_host::interior::Places;
use compass_host::plan_import::structure::{DEFAULT_THICKNESS_M, StructureError};
use compass_host::plan_import::{self, Imported, PlanOptions, PlanRaster};
use compass_host::sample::building;
use compass_host::{PackedPlan, PlanDescriptor};
use image::{Rgb, RgbImage};
use numpy::{IntoPyArray as _, PyArray1, PyArray2};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// A floor plan: a raster of walls and glazing.
///
/// Coordinates are metres, x right, y up; headings are degrees counter-clockwise from +x.
#[pyclass(frozen, module = "compass_localization")]
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) name: String,
    pub(crate) raster: Arc<PlanRaster>,
    pub(crate) packed: Arc<PackedPlan>,
    /// The plan without what is thin, where that can be told and is not all of it.
    structure: Option<PackedPlan>,
    /// What a user should know of the file.
    #[pyo3(get)]
    notes: Vec<String>,
}

/// Reads a plan: an image (dark is wall, red is glazing), a ROS map_server .yaml, or a drawing (.svg, .pdf; .dxf and .dwg where
/// built with the feature `cad`).
///
/// `walls` is an image of the same size with the walls alone; `resolution` metres per pixel (default 0.01, or what the .yaml
/// says); `origin` the map position (x, y) of the outer corner of the bottom-left pixel; `min_thickness` removes strokes thinner
/// than that many metres; `scale` is N of a drawing's scale 1:N.
#[pyfunction]
#[pyo3(signature = (path, *, walls=None, resolution=None, origin=None, invert=false, min_thickness=None, scale=None, page=1))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments")]
pub(crate) fn load_plan(
    py: Python<'_>,
    path: PathBuf,
    walls: Option<PathBuf>,
    resolution: Option<f64>,
    origin: Option<[f64; 2]>,
    invert: bool,
    min_thickness: Option<f64>,
    scale: Option<f64>,
    page: usize,
) -> PyResult<Plan> {
    let mut options = PlanOptions::new(&path);
    options.walls = walls;
    options.resolution_m = resolution;
    options.origin = origin;
    options.invert = invert;
    options.min_thickness_m = min_thickness;
    options.drawing.scale = scale;
    options.drawing.page = page;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let file = path.display().to_string();
    py.detach(|| {
        let imported = plan_import::import(&options).map_err(wrong)?;
        Plan::new(name, &imported).map_err(|error| wrong_in(file, error))
    })
}

/// The sample building that the command's demo uses, as a plan of 32 x 22 m.
#[pyfunction]
pub(crate) fn sample_plan(py: Python<'_>) -> PyResult<Plan> {
    py.detach(|| {
        let raster = PlanRaster::from(building());
        let structure = plan_import::structure::keep_structure(&raster, DEFAULT_THICKNESS_M);
        Plan::of("sample-building".to_owned(), raster, structure, Vec::new()).map_err(wrong)
    })
}

impl Plan {
    fn new(name: String, imported: &Imported) -> Result<Self, String> {
        let structure = imported.structure(DEFAULT_THICKNESS_M, &Places::default());
        let notes = imported.notes.iter().map(ToString::to_string).collect();
        Self::of(name, imported.plan.clone(), structure, notes)
    }

    fn of(
        name: String,
        raster: PlanRaster,
        structure: Result<PlanRaster, StructureError>,
        notes: Vec<String>,
    ) -> Result<Self, String> {
        let packed = PackedPlan::new(&raster).map_err(|error| error.to_string())?;
        let second = structure.ok().map(|kept| packed.second_layer(&kept)).transpose();
        let structure = second.map_err(|error| error.to_string())?.flatten();
        Ok(Self { name, raster: Arc::new(raster), packed: Arc::new(packed), structure, notes })
    }

    /// The second layer of a site.
    pub(crate) fn structure(&self) -> Option<&PackedPlan> {
        self.structure.as_ref()
    }

    fn at(&self, x: f64, y: f64, heading: f64) -> PyResult<Scan> {
        let at = [finite("x", x)?, finite("y", y)?];
        self.packed.scan(at, finite("heading", heading)?).map_err(|error| wrong_in(&self.name, error))
    }
}

#[pymethods]
impl Plan {
    /// Name: that of the file without its extension.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Metres along x and along y.
    #[getter]
    fn size(&self) -> (f64, f64) {
        let PlanRaster { width, height, resolution_m, .. } = *self.raster;
        (f64::from(width) * resolution_m, f64::from(height) * resolution_m)
    }

    /// Metres per pixel.
    #[getter]
    fn resolution(&self) -> f64 {
        self.raster.resolution_m
    }

    /// Map position (x, y) of the outer corner of the bottom-left pixel, metres.
    #[getter]
    fn origin(&self) -> [f64; 2] {
        self.raster.origin
    }

    /// The plan as an image, uint8 of shape (height, width, 3), north up: white free, black wall, red glazing.
    #[getter]
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (walls, windows) = (self.raster.walls_mask(), self.raster.windows_mask());
        let (width, height) = (self.raster.width, self.raster.height);
        let pixel = |x: u32, row: u32| {
            let y = height - 1 - row;
            Rgb(if walls.get(x, y) {
                [0, 0, 0]
            } else if windows.get(x, y) {
                [255, 0, 0]
            } else {
                [255; 3]
            })
        };
        let image = py.detach(|| RgbImage::from_fn(width, height, pixel));
        from_rgb(py, image)
    }

    /// Ranges and hit types around a pose: (range_m, hit), float64 and uint8 of shape (360,).
    ///
    /// Bin j looks along heading + j degrees, counter-clockwise. Hit types: 0 open within 30 m, 1 window, 2 wall.
    #[pyo3(signature = (x, y, heading=0.0))]
    #[expect(clippy::type_complexity, reason = "a pair of arrays")]
    fn scan<'py>(
        &self,
        py: Python<'py>,
        x: f64,
        y: f64,
        heading: f64,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<u8>>)> {
        let scan = self.at(x, y, heading)?;
        let range = PlanDescriptor::from(&scan).range_m;
        let hit = scan.hit.map(|hit| hit as u8);
        Ok((range.to_vec().into_pyarray(py), hit.to_vec().into_pyarray(py)))
    }

    /// The descriptor of a pose: float64 of shape (5, 360).
    ///
    /// Rows: range / 30 m; hit type (1 wall, 0.5 window, 0 open); |dr/dtheta| / 5 m, at most 1; 1 / (1 + range); standard
    /// deviation of the range over 11 bins / 10 m.
    #[pyo3(signature = (x, y, heading=0.0))]
    fn describe<'py>(
        &self,
        py: Python<'py>,
        x: f64,
        y: f64,
        heading: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let scan = self.at(x, y, heading)?;
        matrix(py, &PlanDescriptor::from(&scan).channels)
    }

    fn __repr__(&self) -> String {
        let (width, height) = self.size();
        format!("Plan({:?}, {width:.2} x {height:.2} m, {} m per pixel)", self.name, self.raster.resolution_m)
    }
}
