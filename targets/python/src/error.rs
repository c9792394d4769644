//! Errors as one exception that names the thing.

use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::fmt::Display;

create_exception!(
    compass_localization,
    CompassError,
    PyValueError,
    "Input that COMPASS cannot use; the message names it and what is wrong with it."
);

/// The exception of an error.
pub(crate) fn wrong(error: impl Display) -> PyErr {
    CompassError::new_err(error.to_string())
}

/// The exception of an error of a thing.
pub(crate) fn wrong_in(name: impl Display, error: impl Display) -> PyErr {
    CompassError::new_err(format!("{name}: {error}"))
}

/// A number that is finite.
pub(crate) fn finite(name: &str, value: f64) -> PyResult<f64> {
    if value.is_finite() { Ok(value) } else { Err(wrong_in(name, format!("{value} is not a finite number"))) }
}
