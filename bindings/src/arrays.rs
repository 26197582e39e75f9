//! Conversion of numpy arrays, in C order.

use crate::errors::Result;
use fullbody::error::Error;
use fullbody::math::Vec3;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::prelude::*;

/// Returns the rows of a (N, W) array.
pub fn rows<const W: usize>(what: &str, array: &PyReadonlyArrayDyn<'_, f64>) -> Result<Vec<[f64; W]>, Error> {
    let view = array.as_array();
    let shape = view.shape();
    if shape.len() != 2 || shape[1] != W {
        return Err(Error::invalid(format!("shape of {what}"), format!("{shape:?}"), format!("(N, {W})")));
    }
    Ok(match view.as_slice() {
        Some(numbers) => numbers.as_chunks::<W>().0.to_vec(),
        None => view.outer_iter().map(|row| std::array::from_fn(|k| row[k])).collect(),
    })
}

/// Returns the rows of a (N, 3) array as vectors.
pub fn vectors(what: &str, array: &PyReadonlyArrayDyn<'_, f64>) -> Result<Vec<Vec3>, Error> {
    Ok(rows::<3>(what, array)?.into_iter().map(Vec3::from).collect())
}

/// Makes an array of any shape from numbers in C order.
pub fn array<'py>(py: Python<'py>, values: Vec<f64>, shape: &[usize]) -> Result<Bound<'py, PyArrayDyn<f64>>> {
    Ok(PyArray1::from_vec(py, values).reshape(shape)?)
}

/// Makes a (N, 3) array.
pub fn from_vectors<'py>(py: Python<'py>, vectors: &[Vec3]) -> Result<Bound<'py, PyArrayDyn<f64>>> {
    array(py, vectors.iter().flat_map(|v| [v.x, v.y, v.z]).collect(), &[vectors.len(), 3])
}
