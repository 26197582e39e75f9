//! Systems and states.

use super::arrays::{array, from_vectors, rows, vectors};
use super::bodies::PyBody;
use super::descriptions::{from_python, to_python};
use super::forces::{Function, forces};
use super::listening::listening;
use super::rotations::matrices;
use crate::errors::Result;
use fullbody::dynamics::{FAR, FAST, Parameter, State, System, TANGENT_SIZE};
use fullbody::forces::Load;
use fullbody::gravity::BodyAttraction;
use fullbody::math::Vec3;
use fullbody::math::lanes::VectorPath;
use fullbody::math::rotation;
use fullbody::names::Named;
use numpy::{PyArrayDyn, PyReadonlyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;
type Fast = (usize, f64, f64, f64);
type Far = ((usize, usize), f64, usize, f64, f64, f64, f64);

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
    ) -> Result<Self> {
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
    ) -> Result<Self> {
        let inner = State::from_tait_bryan(
            time,
            vectors("position", &position)?,
            vectors("velocity", &velocity)?,
            &rows::<3>("angles", &angles)?,
            vectors("spin", &spin)?,
        )?;
        Ok(Self { inner })
    }

    /// Makes a state from positions and attitudes alone; velocities and spins are NaN.
    #[staticmethod]
    fn from_poses(
        time: f64,
        position: PyReadonlyArrayDyn<'_, f64>,
        attitude: PyReadonlyArrayDyn<'_, f64>,
    ) -> Result<Self> {
        let inner =
            State::from_poses(time, vectors("position", &position)?, rows::<4>("attitude", &attitude)?)?;
        Ok(Self { inner })
    }

    #[getter]
    fn time(&self) -> f64 {
        self.inner.time()
    }

    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Result<Array<'py>> {
        from_vectors(py, self.inner.position())
    }

    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> Result<Array<'py>> {
        from_vectors(py, self.inner.velocity())
    }

    #[getter]
    fn attitude<'py>(&self, py: Python<'py>) -> Result<Array<'py>> {
        array(py, self.inner.attitude().concat(), &[self.inner.bodies(), 4])
    }

    #[getter]
    fn spin<'py>(&self, py: Python<'py>) -> Result<Array<'py>> {
        from_vectors(py, self.inner.spin())
    }

    #[getter]
    fn rotation_matrix<'py>(&self, py: Python<'py>) -> Result<Array<'py>> {
        matrices(py, self.inner.attitude())
    }

    #[getter]
    fn tait_bryan<'py>(&self, py: Python<'py>) -> Result<Array<'py>> {
        let values = self.inner.attitude().iter().flat_map(|&q| rotation::to_tait_bryan(q)).collect();
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
    fn new(
        py: Python<'_>,
        bodies: Vec<PyRef<'_, PyBody>>,
        gravitational_constant: f64,
        settings: &Bound<'_, PyDict>,
        described: Vec<Bound<'_, PyDict>>,
        functions: BTreeMap<String, Function>,
    ) -> Result<Self> {
        let bodies: Vec<_> = bodies.iter().map(|body| body.inner.clone()).collect();
        if !described.is_empty() {
            listening(py, |interrupt| {
                bodies.iter().try_for_each(|body| BodyAttraction::moments(body, interrupt))
            })?;
        }
        let inner = System::new(bodies, gravitational_constant, from_python(settings)?)?;
        Ok(Self { inner: inner.with_forces(forces(&described, &functions)?)? })
    }

    /// Returns the descriptions of the bodies.
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>> {
        to_python(py, &self.inner.bodies())
    }

    /// Returns the descriptions of the external forces.
    #[getter]
    fn forces<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>> {
        to_python(py, &self.inner.forces())
    }

    /// Returns forces (F, N, 3) and torques (F, N, 3) of each external force.
    fn external_loads<'py>(&self, py: Python<'py>, state: &PyState) -> Result<(Array<'py>, Array<'py>)> {
        let loads = listening(py, |interrupt| self.inner.external_loads_with(&state.inner, interrupt))?;
        let shape = [self.inner.forces().len(), self.inner.bodies().len(), 3];
        let all = |of: fn(&Load) -> Vec3| {
            let mut values = vec![0.0; shape.iter().product()];
            for load in &loads {
                let at = 3 * (load.of * shape[1] + load.on);
                values[at..at + 3].copy_from_slice(of(load).as_slice());
            }
            array(py, values, &shape)
        };
        Ok((all(|load| load.force)?, all(|load| load.torque)?))
    }

    /// Returns positions and velocities (K, 3) of a third body at times (K,), relative to the nominal
    /// barycentre.
    fn third_body<'py>(
        &self,
        py: Python<'py>,
        force: usize,
        times: PyReadonlyArray1<'py, f64>,
    ) -> Result<(Array<'py>, Array<'py>)> {
        let force_model = self.inner.force_model();
        let times = times.as_array();
        let rows = times.iter().map(|&time| force_model.third_body(force, time));
        let (position, velocity): (Vec<_>, Vec<_>) = rows.collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
        Ok((from_vectors(py, &position)?, from_vectors(py, &velocity)?))
    }

    /// Returns the masses (N,).
    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> Result<Array<'py>> {
        array(py, self.inner.masses(), &[self.inner.bodies().len()])
    }

    /// Returns the description of the settings.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>> {
        to_python(py, self.inner.settings())
    }

    /// Returns forces (N, 3), torques (N, 3), the potential energy, and the truncation error of a series.
    fn interactions<'py>(
        &self,
        py: Python<'py>,
        state: &PyState,
    ) -> Result<(Array<'py>, Array<'py>, f64, f64)> {
        let result = listening(py, |interrupt| self.inner.interactions_with(&state.inner, interrupt))?;
        let (force, torque) = (from_vectors(py, &result.force)?, from_vectors(py, &result.torque)?);
        Ok((force, torque, result.potential_energy, result.truncation_error))
    }

    /// Returns the derivatives of loads (6N, 6N), of rates (12N, 12N) and of the rates with respect to
    /// parameters (P, 12N), and the rates (12N,) themselves.
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        state: &PyState,
        parameters: Vec<String>,
    ) -> Result<(Array<'py>, Array<'py>, Array<'py>, Array<'py>)> {
        let named = parameters.iter().map(|name| Parameter::named(name, &self.inner));
        let named: Vec<_> = named.collect::<Result<_, _>>()?;
        let jacobian = listening(py, |interrupt| self.inner.jacobian(&state.inner, &named, interrupt))?;
        let n = self.inner.bodies().len();
        Ok((
            array(py, jacobian.loads, &[6 * n, 6 * n])?,
            array(py, jacobian.rates, &[TANGENT_SIZE * n, TANGENT_SIZE * n])?,
            array(py, jacobian.by_parameters, &[named.len(), TANGENT_SIZE * n])?,
            array(py, jacobian.flow, &[TANGENT_SIZE * n])?,
        ))
    }

    /// Returns the names of the parameters by which runs can be differentiated.
    #[getter]
    fn parameters(&self) -> Vec<String> {
        Parameter::all_of(&self.inner).into_iter().map(|(name, _)| name).collect()
    }

    /// Returns the values of the parameters by their names.
    #[getter]
    fn parameter_values(&self) -> BTreeMap<String, f64> {
        self.inner.parameter_values().into_iter().collect()
    }

    /// Returns the changes of the parameters that lead to another system, by their names, and the first place
    /// of its description that they do not explain.
    fn parameter_changes(
        &self,
        py: Python<'_>,
        other: &Self,
    ) -> Result<(BTreeMap<String, f64>, Option<String>)> {
        let difference = py.detach(|| self.inner.parameter_changes(&other.inner))?;
        Ok((difference.changes.into_iter().collect(), difference.unexplained))
    }

    /// Returns the descriptions of bodies and forces, and G, of the system with a parameter changed, and a
    /// natural size of its changes.
    fn changed<'py>(
        &self,
        py: Python<'py>,
        parameter: &str,
        by: f64,
    ) -> Result<(Bound<'py, PyAny>, Bound<'py, PyAny>, f64, f64)> {
        let named = Parameter::named(parameter, &self.inner)?;
        let changed = named.changed(&self.inner, by)?;
        let (bodies, forces) = (to_python(py, &changed.bodies())?, to_python(py, &changed.forces())?);
        Ok((bodies, forces, changed.gravitational_constant(), named.size(&self.inner)))
    }

    /// Returns the numbers for warnings about a start. The first tuple holds a body, its speed, its speed of
    /// escape and the limit in speeds of escape. The second one holds a pair, its distance, a heavy body, the
    /// distance of that body, the rounding of the pair's coordinates, the tolerance that can be met and the
    /// limit in distances.
    fn start_warnings(&self, state: &PyState, tolerance: Option<f64>) -> (Option<Fast>, Option<Far>) {
        let fast = self.inner.unbound(&state.inner).map(|u| (u.body, u.speed, u.escape, FAST));
        let far = self.inner.far_from_barycentre(&state.inner, tolerance);
        let far =
            far.map(|f| (f.pair.into(), f.separation, f.heavy, f.distance, f.rounding, f.tolerance, FAR));
        (fast, far)
    }

    /// Returns the total, translational, rotational and potential energy.
    fn energy(&self, py: Python<'_>, state: &PyState) -> Result<[f64; 4]> {
        let e = listening(py, |interrupt| self.inner.energy_with(&state.inner, interrupt))?;
        Ok([e.total, e.translational, e.rotational, e.potential])
    }

    fn momentum<'py>(&self, py: Python<'py>, state: &PyState) -> Result<Array<'py>> {
        vector(py, listening(py, |interrupt| self.inner.momentum_with(&state.inner, interrupt))?)
    }

    fn angular_momentum<'py>(&self, py: Python<'py>, state: &PyState) -> Result<Array<'py>> {
        vector(py, listening(py, |interrupt| self.inner.angular_momentum_with(&state.inner, interrupt))?)
    }
}

fn vector<'py>(py: Python<'py>, v: Vec3) -> Result<Array<'py>> {
    array(py, v.as_slice().to_vec(), &[3])
}

/// Returns the names of the vector paths that this machine can run.
#[pyfunction]
pub fn vector_paths() -> Vec<&'static str> {
    VectorPath::available().into_iter().map(VectorPath::name).collect()
}
