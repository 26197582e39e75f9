//! Polyhedra.

use super::arrays::{array, from_vectors, vectors};
use super::listening::listening;
use crate::errors::Result;
use fullbody::error::{Error, require_positive};
use fullbody::shape::Polyhedron;
use numpy::{PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArray2, PyReadonlyArrayDyn};
use pyo3::prelude::*;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// A homogeneous polyhedron.
#[pyclass(frozen, name = "Polyhedron", module = "fullbody._core")]
pub struct PyPolyhedron {
    pub inner: Polyhedron,
}

impl From<Polyhedron> for PyPolyhedron {
    fn from(inner: Polyhedron) -> Self {
        Self { inner }
    }
}

#[pymethods]
impl PyPolyhedron {
    #[new]
    fn new(
        py: Python<'_>,
        vertices: PyReadonlyArrayDyn<'_, f64>,
        faces: PyReadonlyArray2<'_, i64>,
    ) -> Result<Self> {
        let vertices = vectors("vertices", &vertices)?;
        let faces = indices(&faces)?;
        let inner = listening(py, |interrupt| Polyhedron::new(&vertices, &faces, interrupt))?;
        Ok(inner.into())
    }

    /// Returns the vertices (V, 3) as they were given, in the working frame.
    #[getter]
    fn input_vertices<'py>(&self, py: Python<'py>) -> Result<Array<'py>> {
        from_vectors(py, &self.inner.input_vertices().collect::<Vec<_>>())
    }

    /// Returns the vertices (V, 3) in the polyhedron's own frame.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> Result<Array<'py>> {
        from_vectors(py, &self.inner.vertices().collect::<Vec<_>>())
    }

    /// Returns the triangles (F, 3) as indices of vertices.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyArray2<i64>>> {
        let faces = self.inner.faces();
        let indices: Vec<i64> = faces.iter().flatten().map(|&v| i64::from(v)).collect();
        Ok(numpy::PyArray1::from_vec(py, indices).reshape([faces.len(), 3])?)
    }

    /// Returns the polyhedron with all lengths multiplied by a factor.
    fn scaled(&self, factor: f64) -> Result<Self> {
        require_positive("factor", factor)?;
        Ok(self.inner.scaled(factor).into())
    }

    #[getter]
    fn volume(&self) -> f64 {
        self.inner.volume()
    }

    /// Returns position and attitude of the working frame in the polyhedron's own frame.
    #[getter]
    fn working_frame(&self) -> ([f64; 3], [f64; 4]) {
        let frame = self.inner.working_frame();
        (frame.position.into(), frame.attitude)
    }

    /// Returns the principal moments of inertia of unit mass (3,).
    #[getter]
    fn inertia_per_mass<'py>(&self, py: Python<'py>) -> Result<Array<'py>> {
        array(py, self.inner.inertia_per_mass().as_slice().to_vec(), &[3])
    }

    #[getter]
    fn circumradius(&self) -> f64 {
        self.inner.circumradius()
    }
}

/// Converts rows of three indices. Indices below zero are refused here; indices that are too large are
/// refused later, with their face.
fn indices(faces: &PyReadonlyArray2<'_, i64>) -> Result<Vec<[u32; 3]>, Error> {
    let view = faces.as_array();
    if view.shape()[1] != 3 {
        return Err(Error::invalid("shape of faces", format!("{:?}", view.shape()), "(F, 3)"));
    }
    view.outer_iter()
        .enumerate()
        .map(|(index, row)| {
            let mut face = [0; 3];
            for (k, vertex) in row.iter().enumerate() {
                face[k] = u32::try_from(*vertex).map_err(|_| {
                    Error::invalid(format!("face {index}, vertex {k},"), vertex, "a vertex's place, from 0")
                })?;
            }
            Ok(face)
        })
        .collect()
}
