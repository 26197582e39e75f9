//! Conversion of attitudes, many at a time.

use super::arrays::{array, rows};
use crate::errors::Result;
use fullbody::math::rotation;
use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// Returns rotation matrices (K, 3, 3) of quaternions.
pub fn matrices<'py>(py: Python<'py>, quaternions: &[[f64; 4]]) -> Result<Array<'py>> {
    // nalgebra stores columns, numpy rows.
    let rows = quaternions.iter().flat_map(|&q| <[[f64; 3]; 3]>::from(rotation::matrix(q).transpose()));
    array(py, rows.flatten().collect(), &[quaternions.len(), 3, 3])
}

/// Returns rotation matrices (K, 3, 3) of quaternions (K, 4) of any non-zero length.
#[pyfunction]
pub fn rotation_matrices<'py>(
    py: Python<'py>,
    quaternions: PyReadonlyArrayDyn<'py, f64>,
) -> Result<Array<'py>> {
    matrices(py, &rows::<4>("quaternions", &quaternions)?)
}

/// Returns the quaternion (4,) of the rotation `second` followed by the rotation `first`.
#[pyfunction]
pub fn quaternion_product<'py>(py: Python<'py>, first: [f64; 4], second: [f64; 4]) -> Result<Array<'py>> {
    array(py, rotation::product(first, second).to_vec(), &[4])
}

/// Returns the quaternion (4,) of the Tait-Bryan angles (phi, theta, psi).
#[pyfunction]
pub fn quaternion_of_tait_bryan<'py>(py: Python<'py>, angles: [f64; 3]) -> Result<Array<'py>> {
    array(py, rotation::from_tait_bryan(angles).to_vec(), &[4])
}
