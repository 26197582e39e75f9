//! Spherical harmonics.

use super::arrays::{array, vectors};
use super::listening::listening;
use crate::errors::Result;
use fullbody::math::harmonics;
use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;

/// Returns the solid harmonics (P, (L + 1)^2) in Schmidt's semi-normalisation up to a degree L at points (P, 3), by
/// degree and order, with sines at orders below zero.
#[pyfunction]
pub fn solid_harmonics<'py>(
    py: Python<'py>,
    points: PyReadonlyArrayDyn<'py, f64>,
    degree: usize,
) -> Result<Bound<'py, PyArrayDyn<f64>>> {
    let points = vectors("points", &points)?;
    let values = listening(py, |interrupt| {
        let mut values = Vec::with_capacity(points.len() * harmonics::count(degree));
        for point in &points {
            interrupt.charge(1 + harmonics::count(degree) as u64 / 4, 0.0)?;
            values.extend(harmonics::at(point, degree));
        }
        Ok(values)
    })?;
    array(py, values, &[points.len(), harmonics::count(degree)])
}
