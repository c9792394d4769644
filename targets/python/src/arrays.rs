//! Images and matrices as numpy arrays.

use crate::error::{wrong, wrong_in};
use compass_host::Frame;
use image::RgbImage;
use numpy::{
    IntoPyArray as _, PyArray2, PyArrayDyn, PyArrayMethods as _, PyReadonlyArrayDyn,
    PyUntypedArrayMethods as _,
};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Reads an image file: PNG, JPEG, WebP, PGM, BMP or TIFF.
///
/// Returns an array of uint8, (height, width) of a gray image and (height, width, 3) of one in colour: what the command sees.
#[pyfunction]
pub(crate) fn read_image<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyAny>> {
    let frame = py.detach(|| Frame::read(&path)).map_err(wrong)?;
    let (height, width) = (frame.height() as usize, frame.width() as usize);
    match frame.rgb() {
        Some(rgb) => Ok(rgb.to_vec().into_pyarray(py).reshape([height, width, 3])?.into_any()),
        None => Ok(frame.gray().pixels().to_vec().into_pyarray(py).reshape([height, width])?.into_any()),
    }
}

/// A frame from an array of uint8 of shape (height, width) or (height, width, 3), in RGB.
///
/// The pixels are copied once, so that the array may change while another thread computes.
pub(crate) fn frame(name: &str, array: &Bound<'_, PyAny>) -> PyResult<Frame> {
    let wanted = "expected an array of uint8 of shape (height, width) or (height, width, 3)";
    let Ok(bytes) = array.cast::<PyArrayDyn<u8>>() else {
        let found = array
            .getattr("dtype")
            .map_or_else(|_| array.get_type().to_string(), |dtype| format!("dtype {dtype}"));
        return Err(wrong_in(name, format!("{wanted}, not {found}")));
    };
    let shape = bytes.shape().to_vec();
    let view: PyReadonlyArrayDyn<'_, u8> = bytes.try_readonly().map_err(|error| wrong_in(name, error))?;
    let samples: Vec<u8> = match view.as_slice() {
        Ok(in_order) if bytes.is_c_contiguous() => in_order.to_vec(),
        // Parts of arrays, and transposed ones.
        _ => view.as_array().iter().copied().collect(),
    };
    let side = |pixels: usize| u32::try_from(pixels).unwrap_or(u32::MAX);
    let frame = match shape[..] {
        [height, width] => Frame::from_gray(side(width), side(height), samples),
        [height, width, 3] => {
            RgbImage::from_raw(side(width), side(height), samples).and_then(Frame::from_rgb)
        }
        _ => return Err(wrong_in(name, format!("{wanted}, not of shape {shape:?}"))),
    };
    frame.ok_or_else(|| wrong_in(name, format!("shape {shape:?}: sides must be 1 to 65535 pixels")))
}

/// An image as an array of shape (height, width, 3).
pub(crate) fn from_rgb(py: Python<'_>, image: RgbImage) -> PyResult<Bound<'_, PyAny>> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    Ok(image.into_raw().into_pyarray(py).reshape([height, width, 3])?.into_any())
}

/// Rows of equal length as an array.
pub(crate) fn matrix<'py, T: numpy::Element + Copy, const N: usize>(
    py: Python<'py>,
    rows: &[[T; N]],
) -> PyResult<Bound<'py, PyArray2<T>>> {
    rows.as_flattened().to_vec().into_pyarray(py).reshape([rows.len(), N])
}
