//! Shapes that are given by Stokes coefficients.

use super::arrays::array;
use crate::errors::Result;
use fullbody::shape::{InputCoefficients, StokesCoefficients};
use numpy::{PyArrayDyn, PyReadonlyArray1};
use pyo3::prelude::*;

/// A shape that is given by its Stokes coefficients.
#[pyclass(frozen, name = "StokesCoefficients", module = "fullbody._core")]
pub struct PyStokesCoefficients {
    pub inner: StokesCoefficients,
}

impl From<StokesCoefficients> for PyStokesCoefficients {
    fn from(inner: StokesCoefficients) -> Self {
        Self { inner }
    }
}

#[pymethods]
impl PyStokesCoefficients {
    /// Makes a shape from coefficients in the 4 pi normalisation, ((L + 1)^2,) by degree and, within a degree,
    /// from S_l,l to S_l,1 and C_l,0 to C_l,l.
    #[new]
    fn new(
        coefficients: PyReadonlyArray1<'_, f64>,
        reference_radius: f64,
        mean_inertia: f64,
        radius: f64,
    ) -> Result<Self> {
        let coefficients = coefficients.as_array().to_vec();
        let input = InputCoefficients { coefficients, reference_radius, mean_inertia, radius };
        Ok(StokesCoefficients::new(input)?.into())
    }

    /// Returns the coefficients as they were given, their reference radius, the mean moment of inertia of unit
    /// mass and the radius of the sphere.
    #[getter]
    fn given<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyArrayDyn<f64>>, f64, f64, f64)> {
        let given = self.inner.input();
        let coefficients = array(py, given.coefficients.clone(), &[given.coefficients.len()])?;
        Ok((coefficients, given.reference_radius, given.mean_inertia, given.radius))
    }

    /// Returns the principal moments of inertia of unit mass (3,).
    #[getter]
    fn inertia_per_mass<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyArrayDyn<f64>>> {
        array(py, self.inner.inertia_per_mass().as_slice().to_vec(), &[3])
    }

    /// Returns position and attitude of the working frame in the body frame.
    #[getter]
    fn working_frame(&self) -> ([f64; 3], [f64; 4]) {
        let frame = self.inner.working_frame();
        (frame.position.into(), frame.attitude)
    }

    /// Returns the radius of the sphere about the centre of mass that contains the body.
    #[getter]
    fn circumradius(&self) -> f64 {
        self.inner.radius()
    }
}
