//! COMPASS for Python: the module `compass_localization._native`, which the package re-exports.
//!
//! Nothing is computed here. Arrays and options become what `compass-host` takes, its results become arrays and plain objects,
//! so that an answer has the bits of the `compass` command.

mod arrays;
mod error;
mod evaluation;
mod fix;
mod locator;
mod picture;
mod plan;
mod rig;
mod seen;
mod simulation;
mod site;
mod track;

use pyo3::prelude::*;

/// The native part of `compass_localization`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("CompassError", module.py().get_type::<error::CompassError>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<plan::Plan>()?;
    module.add_class::<site::Site>()?;
    module.add_class::<rig::Rig>()?;
    module.add_class::<locator::Locator>()?;
    module.add_class::<fix::Fix>()?;
    module.add_class::<fix::Pose>()?;
    module.add_class::<track::Track>()?;
    module.add_class::<track::Estimate>()?;
    module.add_function(wrap_pyfunction!(evaluation::evaluate, module)?)?;
    module.add_function(wrap_pyfunction!(plan::load_plan, module)?)?;
    module.add_function(wrap_pyfunction!(plan::sample_plan, module)?)?;
    module.add_function(wrap_pyfunction!(arrays::read_image, module)?)?;
    module.add_function(wrap_pyfunction!(simulation::simulate, module)?)?;
    Ok(())
}
