//! Polyhedra and their gravity.

use super::arrays::{array, from_vectors, vectors};
use super::listening::listening;
use crate::error::{Error, require_finite, require_positive};
use crate::gravity::{Anywhere, PolyhedralField};
use crate::math::Vec3;
use crate::math::lanes::VectorPath;
use crate::patience::Patience;
use crate::shape::Polyhedron;
use numpy::{PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArray2, PyReadonlyArrayDyn};
use pulp::Arch;
use pyo3::prelude::*;
use rayon::prelude::*;
use std::sync::OnceLock;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// A homogeneous polyhedron.
#[pyclass(frozen, name = "Polyhedron", module = "fullbody._core")]
pub struct PyPolyhedron {
    pub inner: Polyhedron,
    /// Its gravity, made at the first use.
    gravity: OnceLock<Anywhere>,
}

impl From<Polyhedron> for PyPolyhedron {
    fn from(inner: Polyhedron) -> Self {
        Self { inner, gravity: OnceLock::new() }
    }
}

#[pymethods]
impl PyPolyhedron {
    #[new]
    fn new(
        py: Python<'_>,
        vertices: PyReadonlyArrayDyn<'_, f64>,
        faces: PyReadonlyArray2<'_, i64>,
    ) -> PyResult<Self> {
        let vertices = vectors("vertices", &vertices)?;
        let faces = indices(&faces)?;
        let inner = listening(py, |patience| Polyhedron::new(&vertices, &faces, patience))?;
        Ok(inner.into())
    }

    /// Vertices (V, 3) as they were given, in the working frame.
    #[getter]
    fn given<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        from_vectors(py, &self.inner.given().collect::<Vec<_>>())
    }

    /// Vertices (V, 3) in the polyhedron's own frame.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        from_vectors(py, &self.inner.vertices().collect::<Vec<_>>())
    }

    /// Triangles of vertices (F, 3).
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let faces = self.inner.faces();
        let indices: Vec<i64> = faces.iter().flatten().map(|&v| i64::from(v)).collect();
        numpy::PyArray1::from_vec(py, indices).reshape([faces.len(), 3])
    }

    /// The same with all lengths times a factor.
    fn scaled(&self, factor: f64) -> Result<Self, Error> {
        require_positive("factor", factor)?;
        Ok(self.inner.scaled(factor).into())
    }

    #[getter]
    fn volume(&self) -> f64 {
        self.inner.volume()
    }

    /// Position and attitude of the working frame in the polyhedron's own frame.
    #[getter]
    fn working_frame(&self) -> ([f64; 3], [f64; 4]) {
        let frame = self.inner.working_frame();
        (frame.position.into(), frame.attitude)
    }

    /// Principal moments of inertia of unit mass (3,).
    #[getter]
    fn inertia_per_mass<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        array(py, self.inner.inertia_per_mass().as_slice().to_vec(), &[3])
    }

    #[getter]
    fn circumradius(&self) -> f64 {
        self.inner.circumradius()
    }

    /// Potential (K,), field (K, 3) and gradient (K, 3, 3) per unit GM at points (K, 3) of its own frame; `surface` allows
    /// points on the surface, where the gradient means nothing.
    fn gravity<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArrayDyn<'py, f64>,
        surface: bool,
    ) -> PyResult<(Array<'py>, Array<'py>, Array<'py>)> {
        let points = vectors("points", &points)?;
        let fields = listening(py, |patience| {
            let anywhere = self.anywhere(patience)?;
            self.fields(anywhere, &points, surface, patience)
        })?;
        let count = fields.len();
        let potential = fields.iter().map(|f| f.potential).collect();
        let field: Vec<Vec3> = fields.iter().map(|f| f.field).collect();
        let gradient = fields.iter().flat_map(|f| f.gradient.iter().copied()).collect();
        Ok((array(py, potential, &[count])?, from_vectors(py, &field)?, array(py, gradient, &[count, 3, 3])?))
    }
}

impl PyPolyhedron {
    fn anywhere(&self, patience: &mut Patience) -> Result<&Anywhere, Error> {
        if let Some(made) = self.gravity.get() {
            return Ok(made);
        }
        let arch = VectorPath::Auto.arch().unwrap_or(Arch::Scalar);
        let made = Anywhere::new(&self.inner, arch, patience)?;
        Ok(self.gravity.get_or_init(|| made))
    }

    fn fields(
        &self,
        anywhere: &Anywhere,
        points: &[Vec3],
        surface: bool,
        patience: &mut Patience,
    ) -> Result<Vec<PolyhedralField>, Error> {
        /// Points whose distance from the surface is below this share of the size lie on it.
        const ON: f64 = 1e-14;
        over_cores(points, self.inner.faces().len(), patience, |index, x| {
            require_finite(&format!("point {index}"), x.as_slice())?;
            if !surface && self.inner.distance(x) <= ON * self.inner.circumradius() {
                let value = format!("[{}, {}, {}]", x.x, x.y, x.z);
                let expected = "one off the surface, where the gradient jumps and is infinite on edges";
                return Err(Error::invalid(format!("point {index}"), value, expected));
            }
            Ok(anywhere.at(x))
        })
    }
}

/// Something at many points over the cores, looking for Ctrl-C between groups of points; `work` is that at a point, in facets.
pub fn over_cores<T: Send>(
    points: &[Vec3],
    work: usize,
    patience: &mut Patience,
    at: impl Fn(usize, &Vec3) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    /// Facets of all points of a group: a few milliseconds.
    const GROUP: usize = 200_000;
    let group = (GROUP / work.max(1)).max(1);
    let mut all = Vec::with_capacity(points.len());
    for (start, points) in (0..).step_by(group).zip(points.chunks(group)) {
        patience.spend(crate::patience::UNITS / 2, 0.0)?;
        let one = |(k, x): (usize, &Vec3)| at(start + k, x);
        // A group of little work is not worth the threads.
        if points.len() * work < 2000 {
            all.extend(points.iter().enumerate().map(one).collect::<Result<Vec<_>, _>>()?);
        } else {
            all.extend(points.par_iter().enumerate().map(one).collect::<Result<Vec<_>, _>>()?);
        }
    }
    Ok(all)
}

/// Rows of three vertices; those below zero are refused here, those too large with their face.
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
