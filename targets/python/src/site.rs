//! Sites: floors with their candidates, as files of the `compass` command.

use crate::error::{wrong, wrong_in};
use crate::plan::Plan;
use compass_host::compass_core::map::site::{MAX_NAME_BYTES, is_name};
use compass_host::interior::Places;
use compass_host::{BuildOptions, SiteFile, floor_bytes, write_file};
use numpy::PyArray2;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// The floors of a building, each with its plan and its candidates.
#[pyclass(frozen, module = "compass_localization")]
#[derive(Debug)]
pub(crate) struct Site {
    pub(crate) file: Arc<SiteFile>,
    pub(crate) name: String,
}

#[pymethods]
impl Site {
    /// Makes a site of one plan: the bytes that `compass map build` writes.
    ///
    /// `spacing` is the distance between candidates, `clearance` their distance from walls, `max_gap` the widest opening of the
    /// outline that still counts as closed, all in metres. `inside` names points (x, y) that are indoors, `region` is a
    /// rectangle (x0, y0, x1, y1) that holds the candidates, for plans whose interior cannot be told. `layers` is 2 for the plan as
    /// drawn and its structure alone, 1 for the plan.
    #[staticmethod]
    #[pyo3(signature = (plan, spacing=0.5, *, name=None, clearance=None, max_gap=None, inside=None, region=None, layers=2))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments")]
    fn build(
        py: Python<'_>,
        plan: &Plan,
        spacing: f64,
        name: Option<String>,
        clearance: Option<f64>,
        max_gap: Option<f64>,
        inside: Option<Vec<[f64; 2]>>,
        region: Option<[f64; 4]>,
        layers: u8,
    ) -> PyResult<Self> {
        if !(1..=2).contains(&layers) {
            return Err(wrong_in("layers", format!("{layers} is not 1 or 2")));
        }
        let name =
            name.unwrap_or_else(|| plan.name[..plan.name.floor_char_boundary(MAX_NAME_BYTES)].to_owned());
        if !is_name(&name) {
            return Err(wrong_in(
                "name",
                format!("{name:?} is not 1 to {MAX_NAME_BYTES} bytes without control characters"),
            ));
        }
        let default = BuildOptions::default();
        let options = BuildOptions {
            spacing_m: spacing,
            clearance_m: clearance.unwrap_or(default.clearance_m),
            max_gap_m: max_gap,
            places: Places { points: inside.unwrap_or_default(), regions: region.into_iter().collect() },
        };
        let structure = plan.structure().filter(|_| layers > 1);
        let bytes = py
            .detach(|| floor_bytes(&name, &plan.raster, &plan.packed, structure, &options))
            .map_err(|error| wrong_in(&plan.name, error))?;
        Ok(Self { file: Arc::new(SiteFile::from_bytes(bytes).map_err(wrong)?), name })
    }

    /// Opens a site file and verifies its checksums.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let file = py.detach(|| SiteFile::read(&path)).map_err(wrong)?;
        Ok(Self { file: Arc::new(file), name: path.display().to_string() })
    }

    /// Writes the site file, whole or not at all.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| write_file(&path, self.file.as_bytes())).map_err(wrong)
    }

    /// The site file's bytes.
    fn to_bytes(&self) -> &[u8] {
        self.file.as_bytes()
    }

    /// Names of the floors.
    #[getter]
    fn floors(&self) -> Vec<String> {
        self.file.floors().iter().map(|floor| floor.name().unwrap_or_default().to_owned()).collect()
    }

    /// Positions of the candidates of a floor, by its number: float64 of shape (n, 2), metres.
    #[pyo3(signature = (floor=0))]
    fn candidates<'py>(&self, py: Python<'py>, floor: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let floors = self.file.floors();
        let map = &floors
            .get(floor)
            .ok_or_else(|| wrong_in("floor", format!("{floor}: there are {}", floors.len())))?
            .map;
        let at: Vec<[f64; 2]> = (0..map.len())
            .filter_map(|number| map.position(number))
            .map(|at| [at.x.to_num(), at.y.to_num()])
            .collect();
        crate::arrays::matrix(py, &at)
    }

    fn __repr__(&self) -> String {
        let floors = self.file.floors();
        let counts: Vec<_> = floors
            .iter()
            .map(|floor| format!("{:?}: {} candidates", floor.name().unwrap_or_default(), floor.map.len()))
            .collect();
        format!("Site({})", counts.join(", "))
    }
}
