//! Shapes, bodies and the gravity of one body.

use super::arrays::{array, from_vectors, vectors};
use crate::error::Error;
use crate::gravity::ExteriorField;
use crate::shape::{Body, Shape};
use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// A shape with a mass. A point has no semi-axes: `None`.
#[pyclass(frozen, name = "Body", module = "fullbody._core")]
pub struct PyBody {
    pub inner: Body,
}

#[pymethods]
impl PyBody {
    #[new]
    #[pyo3(signature = (name, semi_axes, mass=None, density=None))]
    fn new(
        name: String,
        semi_axes: Option<[f64; 3]>,
        mass: Option<f64>,
        density: Option<f64>,
    ) -> Result<Self, Error> {
        let shape = Shape::try_from(semi_axes)?;
        let inner = match (mass, density) {
            (Some(mass), None) => Body::with_mass(name, shape, mass),
            (None, Some(density)) => Body::with_density(name, shape, density),
            (Some(_), Some(_)) => {
                Err(Error::invalid(name, "given both a mass and a density", "one of the two"))
            }
            (None, None) => Err(Error::invalid(name, "given neither mass nor density", "one of the two")),
        }?;
        Ok(Self { inner })
    }

    #[getter]
    fn mass(&self) -> f64 {
        self.inner.mass
    }

    #[getter]
    fn volume(&self) -> f64 {
        self.inner.volume().unwrap_or(f64::NAN)
    }

    #[getter]
    fn inertia<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        array(py, self.inner.inertia().as_slice().to_vec(), &[3])
    }
}

/// Exterior potential (K,) and field (K, 3) of a body at points (K, 3) of its frame.
#[pyfunction]
#[pyo3(name = "exterior_gravity")]
pub fn exterior_gravity<'py>(
    py: Python<'py>,
    body: &PyBody,
    gravitational_constant: f64,
    points: PyReadonlyArrayDyn<'py, f64>,
) -> PyResult<(Array<'py>, Array<'py>)> {
    let field = ExteriorField::new(&body.inner, gravitational_constant);
    let points = vectors("points", &points)?;
    let potential = points.iter().map(|p| field.potential(p)).collect::<Result<Vec<_>, _>>()?;
    let g = points.iter().map(|p| field.field(p)).collect::<Result<Vec<_>, _>>()?;
    let count = potential.len();
    Ok((array(py, potential, &[count])?, from_vectors(py, &g)?))
}
