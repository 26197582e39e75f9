//! Systems and states.

use super::arrays::{array, from_vectors, rows, vectors};
use super::bodies::PyBody;
use super::listening::listening;
use crate::dynamics::{AttitudeChart, Settings, State, System};
use crate::error::Error;
use crate::math::Vec3;
use crate::math::lanes::VectorPath;
use crate::math::rotation;
use crate::quadrature::Order;
use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// Position, velocity, attitude and spin of every body at a time.
#[pyclass(frozen, name = "State", module = "fullbody._core")]
pub struct PyState {
    pub inner: State,
}

#[pymethods]
impl PyState {
    #[new]
    fn new(
        time: f64,
        position: PyReadonlyArrayDyn<'_, f64>,
        velocity: PyReadonlyArrayDyn<'_, f64>,
        attitude: PyReadonlyArrayDyn<'_, f64>,
        spin: PyReadonlyArrayDyn<'_, f64>,
    ) -> Result<Self, Error> {
        let inner = State::new(
            time,
            vectors("position", &position)?,
            vectors("velocity", &velocity)?,
            rows::<4>("attitude", &attitude)?,
            vectors("spin", &spin)?,
        )?;
        Ok(Self { inner })
    }

    #[staticmethod]
    fn from_tait_bryan(
        time: f64,
        position: PyReadonlyArrayDyn<'_, f64>,
        velocity: PyReadonlyArrayDyn<'_, f64>,
        angles: PyReadonlyArrayDyn<'_, f64>,
        spin: PyReadonlyArrayDyn<'_, f64>,
    ) -> Result<Self, Error> {
        let inner = State::from_tait_bryan(
            time,
            vectors("position", &position)?,
            vectors("velocity", &velocity)?,
            &rows::<3>("angles", &angles)?,
            vectors("spin", &spin)?,
        )?;
        Ok(Self { inner })
    }

    #[getter]
    fn time(&self) -> f64 {
        self.inner.time
    }

    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        from_vectors(py, &self.inner.position)
    }

    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        from_vectors(py, &self.inner.velocity)
    }

    #[getter]
    fn attitude<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        array(py, self.inner.attitude.concat(), &[self.inner.bodies(), 4])
    }

    #[getter]
    fn spin<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        from_vectors(py, &self.inner.spin)
    }

    #[getter]
    fn rotation_matrix<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        // nalgebra stores columns, numpy rows.
        let values = self.inner.attitude.iter();
        let values = values.flat_map(|&q| rotation::matrix(q).transpose().as_slice().to_vec()).collect();
        array(py, values, &[self.inner.bodies(), 3, 3])
    }

    #[getter]
    fn tait_bryan<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let values = self.inner.attitude.iter().flat_map(|&q| rotation::to_tait_bryan(q)).collect();
        array(py, values, &[self.inner.bodies(), 3])
    }
}

/// Bodies under their mutual gravity.
#[pyclass(frozen, name = "System", module = "fullbody._core")]
pub struct PySystem {
    pub inner: System,
}

#[pymethods]
impl PySystem {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        bodies: Vec<PyRef<'_, PyBody>>,
        gravitational_constant: f64,
        gravity: &str,
        gravity_tolerance: f64,
        order: Option<(usize, usize)>,
        attitude_chart: &str,
        vector_path: &str,
    ) -> Result<Self, Error> {
        let settings = Settings {
            gravity: gravity.parse()?,
            gravity_tolerance,
            order: order.map(|(gauss, angles)| Order { gauss, angles }),
            attitude_chart: match attitude_chart {
                "quaternion" => AttitudeChart::Quaternion,
                "tait_bryan" => AttitudeChart::TaitBryan,
                other => {
                    let expected = "\"quaternion\" or \"tait_bryan\"";
                    return Err(Error::invalid("attitude_chart", format!("{other:?}"), expected));
                }
            },
            vector_path: path(vector_path)?,
        };
        let bodies = bodies.iter().map(|body| body.inner.clone()).collect();
        Ok(Self { inner: System::new(bodies, gravitational_constant, settings)? })
    }

    /// Force (N, 3), torque (N, 3), potential energy.
    fn interactions<'py>(&self, py: Python<'py>, state: &PyState) -> PyResult<(Array<'py>, Array<'py>, f64)> {
        let result = listening(py, |patience| self.inner.interactions(&state.inner, patience))?;
        Ok((from_vectors(py, &result.force)?, from_vectors(py, &result.torque)?, result.potential_energy))
    }

    /// Total, translational, rotational, potential.
    fn energy(&self, py: Python<'_>, state: &PyState) -> PyResult<[f64; 4]> {
        let e = listening(py, |patience| self.inner.energy(&state.inner, patience))?;
        Ok([e.total, e.translational, e.rotational, e.potential])
    }

    fn momentum<'py>(&self, py: Python<'py>, state: &PyState) -> PyResult<Array<'py>> {
        vector(py, listening(py, |patience| self.inner.momentum(&state.inner, patience))?)
    }

    fn angular_momentum<'py>(&self, py: Python<'py>, state: &PyState) -> PyResult<Array<'py>> {
        vector(py, listening(py, |patience| self.inner.angular_momentum(&state.inner, patience))?)
    }
}

fn vector<'py>(py: Python<'py>, v: Vec3) -> PyResult<Array<'py>> {
    array(py, v.as_slice().to_vec(), &[3])
}

const PATHS: [(&str, VectorPath); 4] = [
    ("auto", VectorPath::Auto),
    ("portable", VectorPath::Portable),
    ("avx2", VectorPath::Avx2),
    ("avx512", VectorPath::Avx512),
];

fn path(name: &str) -> Result<VectorPath, Error> {
    let known = PATHS.iter().find(|(n, _)| *n == name).map(|(_, path)| *path);
    known.ok_or_else(|| {
        Error::invalid("vector_path", format!("{name:?}"), "\"auto\", \"portable\", \"avx2\" or \"avx512\"")
    })
}

/// Names of the vector paths that this machine can run.
#[pyfunction]
pub fn vector_paths() -> Vec<&'static str> {
    let available = VectorPath::available();
    PATHS.iter().filter(|(_, path)| available.contains(path)).map(|(name, _)| *name).collect()
}
