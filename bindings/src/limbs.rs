//! Limbs of polyhedra.

use super::arrays::{array, from_vectors, vectors};
use super::listening::listening;
use super::polyhedra::PyPolyhedron;
use crate::errors::Result;
use fullbody::error::Error;
use fullbody::math::Vec3;
use fullbody::photometry::Limb;
use numpy::{PyArray1, PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// The limb of a polyhedron, in its own frame.
#[pyclass(frozen, name = "Limb", module = "fullbody._core")]
pub struct PyLimb {
    inner: Limb,
}

/// Returns arrays (M, 3) of equal length as vectors.
fn rays<const N: usize>(arrays: [(&str, &PyReadonlyArrayDyn<'_, f64>); N]) -> Result<[Vec<Vec3>; N], Error> {
    let mut all = [const { Vec::new() }; N];
    for (rows, (what, array)) in all.iter_mut().zip(arrays) {
        *rows = vectors(what, array)?;
    }
    match all.iter().find(|rows| rows.len() != all[0].len()) {
        Some(rows) => Err(Error::invalid("number of rays", rows.len(), all[0].len().to_string())),
        None => Ok(all),
    }
}

#[pymethods]
impl PyLimb {
    #[new]
    fn new(polyhedron: &PyPolyhedron) -> Self {
        Self { inner: Limb::new(polyhedron.inner.clone()) }
    }

    /// Returns the distances (M,) of rays from the limb, negative inside it, and their derivatives (M, 3) with
    /// respect to the points and to the directions of the rays.
    fn distances<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArrayDyn<'py, f64>,
        directions: PyReadonlyArrayDyn<'py, f64>,
    ) -> Result<(Array<'py>, Array<'py>, Array<'py>)> {
        let [points, directions] = rays([("points", &points), ("directions", &directions)])?;
        let all = listening(py, |interrupt| self.inner.distances(&points, &directions, interrupt))?;
        let by_point: Vec<_> = all.iter().map(|ray| ray.by_point).collect();
        let by_direction: Vec<_> = all.iter().map(|ray| ray.by_direction).collect();
        let distance = array(py, all.iter().map(|ray| ray.distance).collect(), &[all.len()])?;
        Ok((distance, from_vectors(py, &by_point)?, from_vectors(py, &by_direction)?))
    }

    /// Returns the indices of rays and the fractions of their displacements at which they cross the limb.
    fn crossings<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArrayDyn<'py, f64>,
        directions: PyReadonlyArrayDyn<'py, f64>,
        displacements: PyReadonlyArrayDyn<'py, f64>,
    ) -> Result<(Bound<'py, PyArray1<i64>>, Array<'py>)> {
        let [points, directions, displacements] =
            rays([("points", &points), ("directions", &directions), ("displacements", &displacements)])?;
        let (rays, fractions) =
            listening(py, |interrupt| self.inner.crossings(&points, &directions, &displacements, interrupt))?;
        let rays = rays.into_iter().map(|ray| ray as i64).collect();
        let count = fractions.len();
        Ok((PyArray1::from_vec(py, rays), array(py, fractions, &[count])?))
    }

    /// Returns the ends (E, 2, 3) of the edges of the limb that is seen along a direction.
    fn edges<'py>(&self, py: Python<'py>, direction: [f64; 3]) -> Result<Array<'py>> {
        let edges = self.inner.edges(&direction.into());
        array(py, edges.iter().flatten().flat_map(|v| [v.x, v.y, v.z]).collect(), &[edges.len(), 2, 3])
    }
}
