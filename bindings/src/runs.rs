//! Simulations and their records.

use super::arrays::array;
use super::descriptions::{from_python, to_python};
use super::events::{EventSpec, PyCondition, events};
use super::forces::{Function, call};
use super::listening::{Listener, listening};
use super::systems::{PyState, PySystem};
use crate::errors::{Raised, Result};
use fullbody::dynamics::{Parameter, Quadrature, State, System, TANGENT_SIZE};
use fullbody::error::Error;
use fullbody::forces::WORK_AND_IMPULSE;
use fullbody::integrate::Tolerance;
use fullbody::math::Vec3;
use fullbody::trajectory::{
    Dense, INDICATORS, Occurrence, Output, Progress, Run, Simulation, StopReason, TangentOptions, Trajectory,
};
use numpy::{PyArrayDyn, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

type RuleRow = ([usize; 2], Option<[usize; 2]>, String, Option<(usize, usize, (usize, usize))>);
type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// The times at which samples are recorded: `None` for every step, `"ends"`, a spacing, or times (K,).
#[derive(FromPyObject)]
pub enum Sampling<'py> {
    // This variant comes first, since an array of one number also converts to a number.
    Times(PyReadonlyArray1<'py, f64>),
    Spacing(f64),
    Named(Option<String>),
}

impl From<Sampling<'_>> for Output {
    fn from(output: Sampling<'_>) -> Self {
        match output {
            Sampling::Spacing(spacing) => Self::Spacing(spacing),
            Sampling::Times(times) => Self::Times(times.as_array().to_vec()),
            Sampling::Named(None) => Self::Steps,
            Sampling::Named(Some(_)) => Self::Ends,
        }
    }
}

/// The tangent vectors that are integrated beside a run: the parameters of the derivatives, or `None`, and
/// whether indicators of chaos are computed.
#[derive(FromPyObject)]
pub struct TangentRequest(Option<Vec<String>>, bool);

impl TangentRequest {
    pub fn checked(self, system: &System) -> Result<TangentOptions, Error> {
        let parameter = |name: &String| Parameter::named(name, system);
        let names = self.0.as_ref().map(|names| names.iter().map(parameter).collect());
        Ok(TangentOptions { derivatives: names.transpose()?, chaos: self.1 })
    }
}

/// A simulation.
#[pyclass(name = "Simulation", module = "fullbody._core")]
pub struct PySimulation {
    inner: Simulation,
}

#[pymethods]
impl PySimulation {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        system: &PySystem,
        state: &PyState,
        integrator: &Bound<'_, PyDict>,
        notes: String,
    ) -> Result<Self> {
        let integrator = from_python(integrator)?;
        let (system, state) = (&system.inner, &state.inner);
        let mut inner = listening(py, |interrupt| Simulation::begin(system, state, integrator, interrupt))?;
        inner.notes = notes;
        Ok(Self { inner })
    }

    /// Reads the simulation that `to_bytes` wrote, with the functions of its forces by their names.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: &[u8], functions: BTreeMap<String, Function>) -> Result<Self> {
        let calls: BTreeMap<_, _> = functions.iter().map(|(name, function)| (name, call(function))).collect();
        let function_of = |name: &str| calls.get(&name.to_owned()).cloned().flatten();
        let inner = listening(py, |interrupt| Simulation::from_bytes_with(bytes, function_of, interrupt))?;
        Ok(Self { inner })
    }

    /// Returns the description of the simulation in such bytes, and the text that is kept with it.
    #[staticmethod]
    fn described<'py>(py: Python<'py>, bytes: &[u8]) -> Result<(Bound<'py, PyAny>, String)> {
        let (description, notes) = Simulation::described(bytes)?;
        Ok((to_python(py, &description)?, notes))
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.inner.to_bytes()?))
    }

    /// Returns the text that is kept with the simulation.
    #[getter]
    fn notes(&self) -> &str {
        &self.inner.notes
    }

    #[getter]
    fn time(&self) -> f64 {
        self.inner.time()
    }

    #[getter]
    fn state(&self) -> PyState {
        PyState { inner: self.inner.state() }
    }

    /// Returns the conserved quantities at the start: time, four energies, angular momentum.
    #[getter]
    fn start(&self) -> [f64; 8] {
        self.inner.start().numbers()
    }

    /// Returns the conserved quantities at the present state: time, four energies, angular momentum.
    #[getter]
    fn invariants(&mut self, py: Python<'_>) -> Result<[f64; 8]> {
        listening(py, |interrupt| Ok(self.inner.invariants(interrupt)?.numbers()))
    }

    /// Returns work, impulse and angular impulse (F, 7) of each external force since the start, one force
    /// after the other.
    #[getter]
    fn work_and_impulse(&self) -> Vec<f64> {
        self.inner.work_and_impulse().to_vec()
    }

    fn set_state(&mut self, py: Python<'_>, state: &PyState) -> Result<()> {
        listening(py, |interrupt| self.inner.set_state(&state.inner, interrupt))
    }

    /// Returns the numbers of accepted steps, rejected attempts and evaluations.
    #[getter]
    fn statistics(&self) -> (u64, u64, u64) {
        let s = self.inner.statistics();
        (s.steps, s.rejected, s.evaluations)
    }

    /// Returns the quadrature in use for each pair: bodies, indices of the parts of composites, method, and
    /// the rule, if it has one, as integrated body, points and (n, m).
    #[getter]
    fn rules(&self) -> Vec<RuleRow> {
        let row = |row: Quadrature| {
            let rule = row.rule.map(|r| (r.integrated, r.points, (r.order.gauss, r.order.angles)));
            (row.bodies, row.parts, row.method.to_string(), rule)
        };
        self.inner.dynamics().quadratures_at(&self.inner.state()).into_iter().map(row).collect()
    }

    fn step(&mut self, py: Python<'_>, end: f64) -> Result<()> {
        listening(py, |interrupt| self.inner.step_with(end, interrupt))
    }

    /// Runs to a time. Returns the record, and the error that ended the run early, if any.
    ///
    /// The GIL is released; about every 50 ms it is taken to check for Ctrl-C and, between steps, to call
    /// `progress(start, time, end)` and, every `autosave[0]` seconds, `autosave[1](bytes)`. Event functions
    /// take it while they run.
    #[allow(clippy::too_many_arguments)]
    fn integrate<'py>(
        &mut self,
        py: Python<'py>,
        until: f64,
        output: Sampling<'py>,
        watched: Vec<EventSpec<'py>>,
        dense: bool,
        progress: Option<Py<PyAny>>,
        autosave: Option<(f64, Py<PyAny>)>,
        tangent_options: TangentRequest,
    ) -> Result<(Bound<'py, PyDict>, Option<PyErr>)> {
        let output = output.into();
        let tangent_options = tangent_options.checked(self.inner.system())?;
        let listener = Arc::new(Listener::default());
        let mut events = events(py, &watched, &listener);
        let mut record = Trajectory::new(self.inner.system().bodies().len());
        let mut saved = Instant::now();
        let outcome = py.detach(|| {
            let mut hook = |simulation: Option<&Simulation>, p: Progress| {
                listener.ask(|py| {
                    let Some(simulation) = simulation else { return Ok(()) };
                    if let Some(progress) = &progress {
                        progress.call1(py, (p.start, p.time, p.end))?;
                    }
                    match &autosave {
                        Some((every, save))
                            if p.time != p.start && saved.elapsed() >= Duration::from_secs_f64(*every) =>
                        {
                            saved = Instant::now();
                            let bytes = PyBytes::new(py, &simulation.to_bytes()?);
                            save.call1(py, (bytes,))?;
                        }
                        _ => {}
                    }
                    Ok(())
                })
            };
            let run = Run { output: &output, events: &mut events, dense, tangent_options: &tangent_options };
            self.inner.run(until, run, &mut record, &mut hook)
        });
        let error = outcome.err().map(|error| listener.explain(error));
        Ok((arrays(py, record)?, error))
    }
}

/// The continuous solution of a run.
#[pyclass(frozen, name = "Dense", module = "fullbody._core")]
pub struct PyDense {
    pub inner: Dense,
}

#[pymethods]
impl PyDense {
    /// Returns the first and the last time, in the direction of the run.
    #[getter]
    fn range(&self) -> (f64, f64) {
        self.inner.range()
    }

    /// Returns the memory of the polynomials in bytes.
    #[getter]
    fn bytes(&self) -> usize {
        self.inner.bytes()
    }

    fn state(&self, time: f64) -> Result<PyState> {
        Ok(PyState { inner: self.inner.state(time)? })
    }

    /// Returns positions, velocities, attitudes and spins at times (K,).
    fn states<'py>(&self, py: Python<'py>, times: PyReadonlyArray1<'py, f64>) -> Result<Bound<'py, PyDict>> {
        let times = times.as_array().to_vec();
        let states = listening(py, |interrupt| self.inner.states(&times, interrupt))?;
        let (k, n) = (states.len(), states.first().map_or(0, State::bodies));
        let vectors = |f: fn(&State) -> &[Vec3]| {
            states.iter().flat_map(|s| f(s).iter().flat_map(|v| [v.x, v.y, v.z])).collect::<Vec<f64>>()
        };
        let attitude: Vec<f64> = states.iter().flat_map(|s| s.attitude().concat()).collect();
        let dict = PyDict::new(py);
        dict.set_item("position", array(py, vectors(State::position), &[k, n, 3])?)?;
        dict.set_item("velocity", array(py, vectors(State::velocity), &[k, n, 3])?)?;
        dict.set_item("attitude", array(py, attitude, &[k, n, 4])?)?;
        dict.set_item("spin", array(py, vectors(State::spin), &[k, n, 3])?)?;
        Ok(dict)
    }

    /// Returns for each condition, in the pieces that contain a part of a span of time, its function at the
    /// start of the first piece and the times of its zeros.
    fn crossings(
        &self,
        py: Python<'_>,
        system: &PySystem,
        conditions: Vec<Bound<'_, PyCondition>>,
        span: [f64; 2],
    ) -> Result<Vec<(f64, Vec<f64>)>> {
        let raised = Arc::new(Listener::default());
        let conditions = conditions.iter().map(|condition| condition.get().condition(py, &raised)).collect();
        let crossings =
            listening(py, |interrupt| self.inner.crossings(&system.inner, conditions, span, interrupt));
        let crossings = crossings.map_err(|error| raised.raised().map_or(error, Raised::from))?;
        Ok(crossings.into_iter().map(|crossing| (crossing.at_start, crossing.times)).collect())
    }
}

/// Returns the tolerances (rtol, atol) with which the integrators work: rtol is raised where their sum is
/// below the accuracy of doubles.
#[pyfunction]
pub fn tolerance(rtol: f64, atol: f64) -> Result<(f64, f64)> {
    let tolerance = Tolerance::new(rtol, atol)?;
    Ok((tolerance.relative(), tolerance.absolute()))
}

/// Returns the record as arrays by their names.
pub fn arrays(py: Python<'_>, record: Trajectory) -> Result<Bound<'_, PyDict>> {
    let (k, n, f) = (record.len(), record.bodies, record.switched_off.len());
    let dict = PyDict::new(py);
    let shaped: [(&str, Vec<f64>, &[usize]); 7] = [
        ("time", record.time, &[k]),
        ("position", record.position, &[k, n, 3]),
        ("velocity", record.velocity, &[k, n, 3]),
        ("attitude", record.attitude, &[k, n, 4]),
        ("spin", record.spin, &[k, n, 3]),
        ("energy", record.energy, &[k, 4]),
        ("angular_momentum", record.angular_momentum, &[k, 3]),
    ];
    for (name, values, shape) in shaped {
        let values: Array<'_> = array(py, values, shape)?;
        dict.set_item(name, values)?;
    }
    if f > 0 {
        let columns = |from: usize, to: usize| -> Vec<f64> {
            record
                .work_and_impulse
                .chunks_exact(WORK_AND_IMPULSE)
                .flat_map(|entry| entry[from..to].to_vec())
                .collect()
        };
        dict.set_item("work", array(py, columns(0, 1), &[k, f])?)?;
        dict.set_item("impulse", array(py, columns(1, 4), &[k, f, 3])?)?;
        dict.set_item("angular_impulse", array(py, columns(4, 7), &[k, f, 3])?)?;
    }
    if !record.transition.is_empty() {
        let size = TANGENT_SIZE * n;
        dict.set_item("transition", array(py, record.transition, &[k, size, size])?)?;
        let parameters = record.sensitivity.len() / (k * size);
        if parameters > 0 {
            dict.set_item("sensitivity", array(py, record.sensitivity, &[k, parameters, size])?)?;
        }
    }
    if !record.chaos.is_empty() {
        dict.set_item("chaos", array(py, record.chaos, &[k, INDICATORS])?)?;
    }
    dict.set_item("switched_off", record.switched_off)?;
    dict.set_item("start", record.start.map(|start| start.numbers()))?;
    let event = |e: Occurrence| {
        let size = TANGENT_SIZE * n;
        let derivatives = e.derivatives.map(|derivatives| {
            let parameters = derivatives.sensitivity.len() / size;
            let sensitivity = array(py, derivatives.sensitivity, &[parameters, size])?;
            let (transition, flow) =
                (array(py, derivatives.transition, &[size, size])?, array(py, derivatives.flow, &[size])?);
            Ok::<_, Raised>((transition, sensitivity, flow))
        });
        Ok::<_, Raised>((e.event, e.time, PyState { inner: e.state }, derivatives.transpose()?))
    };
    let events = record.events.into_iter().map(event).collect::<Result<Vec<_>>>()?;
    dict.set_item("events", events)?;
    dict.set_item("dense", record.dense.map(|inner| PyDense { inner }))?;
    let (reason, event) = match record.stop_reason {
        StopReason::Unfinished => ("unfinished", None),
        StopReason::End => ("end", None),
        StopReason::Event(index) => ("event", Some(index)),
        StopReason::Interrupted => ("interrupted", None),
        other => {
            return Err(Error::invalid("stop reason", format!("{other:?}"), "one that Python has").into());
        }
    };
    dict.set_item("stop_reason", (reason, event))?;
    Ok(dict)
}
