//! Simulations and what they record.

use super::arrays::array;
use super::listening::{Listener, listening};
use super::systems::{PyState, PySystem};
use crate::dynamics::State;
use crate::error::Error;
use crate::integrate::Tolerance;
use crate::math::Vec3;
use crate::trajectory::{
    Condition, Dense, Event, Integrator, Output, Progress, Run, Simulation, StopReason, Trajectory,
};
use numpy::{PyArrayDyn, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::sync::Arc;
use std::time::{Duration, Instant};

type RuleRow = (usize, usize, usize, usize, (usize, usize));
type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// The stepping object.
#[pyclass(name = "Simulation", module = "fullbody._core")]
pub struct PySimulation {
    inner: Simulation,
}

/// What to watch for, as the package describes it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct EventData {
    kind: String,
    first: usize,
    second: Option<usize>,
    value: f64,
    normal: [f64; 3],
    function: Option<Py<PyAny>>,
    direction: i8,
    terminal: bool,
}

#[pymethods]
impl PySimulation {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        system: &PySystem,
        state: &PyState,
        integrator: &str,
        rtol: f64,
        atol: f64,
        step: f64,
        scheme: &str,
    ) -> PyResult<Self> {
        let integrator = Integrator::named(integrator, (rtol, atol), step, scheme)?;
        let (system, state) = (&system.inner, &state.inner);
        let inner = listening(py, |patience| Simulation::begin(system, state, integrator, patience))?;
        Ok(Self { inner })
    }

    /// The simulation that `to_bytes` wrote.
    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        Ok(Self { inner: Simulation::from_bytes(bytes)? })
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyBytes>, Error> {
        Ok(PyBytes::new(py, &self.inner.to_bytes()?))
    }

    #[getter]
    fn time(&self) -> f64 {
        self.inner.time()
    }

    #[getter]
    fn state(&self) -> PyState {
        PyState { inner: self.inner.state() }
    }

    fn set_state(&mut self, py: Python<'_>, state: &PyState) -> PyResult<()> {
        listening(py, |patience| self.inner.set_state(&state.inner, patience))
    }

    /// Accepted steps, rejected attempts, evaluations.
    #[getter]
    fn statistics(&self) -> (u64, u64, u64) {
        let s = self.inner.statistics();
        (s.steps, s.rejected, s.evaluations)
    }

    /// The quadrature in force for each pair: (i, j, integrated body, points, (n, m)).
    #[getter]
    fn rules(&self) -> Vec<RuleRow> {
        let rule = |(i, j, pair): (usize, usize, &crate::mutual::Pair)| {
            let rule = pair.rule()?;
            let integrated = if rule.integrated == 0 { i } else { j };
            Some((i, j, integrated, rule.nodes(), (rule.order.gauss, rule.order.angles)))
        };
        self.inner.dynamics().pairs().filter_map(rule).collect()
    }

    /// Shortest time of an evaluation of the rates of change at the present state, seconds.
    fn time_evaluation(&mut self, py: Python<'_>, number: usize, repeats: usize) -> Result<f64, Error> {
        py.detach(|| self.inner.time_evaluation(number, repeats))
    }

    /// Shortest time of an interaction of the first pair at the present state, seconds.
    fn time_interaction(&self, py: Python<'_>, number: usize, repeats: usize) -> f64 {
        py.detach(|| self.inner.time_interaction(number, repeats))
    }

    fn step(&mut self, py: Python<'_>, end: f64) -> PyResult<()> {
        listening(py, |patience| self.inner.step(end, patience))
    }

    /// Runs to a time; gives the record and the error that cut it short, if any.
    ///
    /// The GIL is released; about every 50 ms it is taken to look for Ctrl-C and, between steps, to call
    /// `progress(start, time, end)` and, every `autosave[0]` seconds, `autosave[1](bytes)`. Event functions take it while they run.
    #[allow(clippy::too_many_arguments)]
    fn integrate<'py>(
        &mut self,
        py: Python<'py>,
        until: f64,
        spacing: Option<f64>,
        times: Option<PyReadonlyArray1<'py, f64>>,
        events: Vec<EventData>,
        dense: bool,
        progress: Option<Py<PyAny>>,
        autosave: Option<(f64, Py<PyAny>)>,
    ) -> PyResult<(Bound<'py, PyDict>, Option<PyErr>)> {
        let output = match (spacing, times) {
            (_, Some(times)) => Output::Times(times.as_array().to_vec()),
            (Some(spacing), None) => Output::Spacing(spacing),
            (None, None) => Output::Steps,
        };
        let listener = Arc::new(Listener::default());
        let mut watched =
            events.into_iter().map(|event| watch(event, &listener)).collect::<Result<Vec<_>, Error>>()?;
        let mut record = Trajectory::new(self.inner.state().bodies());
        let mut saved = Instant::now();
        let outcome = py.detach(|| {
            let mut hook = |simulation: Option<&Simulation>, p: Progress| {
                listener.ask(|py| {
                    let Some(simulation) = simulation else { return Ok(()) };
                    if let Some(progress) = &progress {
                        progress.call1(py, (p.start, p.time, p.end))?;
                    }
                    match &autosave {
                        Some((every, save)) if saved.elapsed() >= Duration::from_secs_f64(*every) => {
                            saved = Instant::now();
                            let bytes = PyBytes::new(py, &simulation.to_bytes()?);
                            save.call1(py, (bytes,)).map(drop)
                        }
                        _ => Ok(()),
                    }
                })
            };
            let run = Run { output: &output, events: &mut watched, dense };
            self.inner.run(until, run, &mut record, &mut hook)
        });
        drop(watched);
        let error = outcome.err().map(|error| listener.explain(error));
        Ok((arrays(py, record)?, error))
    }
}

/// The continuous solution of a run.
#[pyclass(frozen, name = "Dense", module = "fullbody._core")]
pub struct PyDense {
    inner: Dense,
}

#[pymethods]
impl PyDense {
    /// First and last time, in the direction of the run.
    #[getter]
    fn range(&self) -> (f64, f64) {
        self.inner.range()
    }

    /// Memory of the polynomials in bytes.
    #[getter]
    fn bytes(&self) -> usize {
        self.inner.bytes()
    }

    fn state(&self, time: f64) -> Result<PyState, Error> {
        Ok(PyState { inner: self.inner.state(time)? })
    }

    /// Positions, velocities, attitudes and spins at times (K,).
    fn states<'py>(
        &self,
        py: Python<'py>,
        times: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let times = times.as_array().to_vec();
        let states = listening(py, |patience| self.inner.states(&times, patience))?;
        let (k, n) = (states.len(), states.first().map_or(0, State::bodies));
        let vectors = |f: fn(&State) -> &Vec<Vec3>| {
            states.iter().flat_map(|s| f(s).iter().flat_map(|v| [v.x, v.y, v.z])).collect::<Vec<f64>>()
        };
        let attitude: Vec<f64> = states.iter().flat_map(|s| s.attitude.concat()).collect();
        let dict = PyDict::new(py);
        dict.set_item("position", array(py, vectors(|s| &s.position), &[k, n, 3])?)?;
        dict.set_item("velocity", array(py, vectors(|s| &s.velocity), &[k, n, 3])?)?;
        dict.set_item("attitude", array(py, attitude, &[k, n, 4])?)?;
        dict.set_item("spin", array(py, vectors(|s| &s.spin), &[k, n, 3])?)?;
        Ok(dict)
    }
}

/// Smallest sum of the tolerances that the adaptive integrators work with.
#[pyfunction]
pub fn tolerance_floor() -> f64 {
    Tolerance::FLOOR
}

fn watch(event: EventData, listener: &Arc<Listener>) -> Result<Event<'static>, Error> {
    let EventData { kind, first, second, value, normal, function, direction, terminal } = event;
    let other = second.unwrap_or(first);
    let condition = match (kind.as_str(), function) {
        ("Separation", _) => Condition::Separation { first, second: other, value },
        ("Contact", _) => Condition::Contact { first, second: other },
        ("Periapsis", _) => Condition::Periapsis { first, second: other },
        ("Apoapsis", _) => Condition::Apoapsis { first, second: other },
        ("PlaneCrossing", _) => {
            Condition::PlaneCrossing { body: first, reference: second, normal: Vec3::from(normal) }
        }
        ("Escape", _) => Condition::Escape { first, second: other, distance: value },
        ("Alignment", _) => Condition::Alignment { body: first, other },
        ("Function", Some(function)) => {
            let listener = listener.clone();
            Condition::Function(Box::new(move |state: &State| {
                let value = Python::attach(|py| {
                    function.call1(py, (PyState { inner: state.clone() },))?.extract::<f64>(py)
                });
                value.map_err(|error| {
                    listener.keep(error);
                    Error::invalid("value of an event's function", "an exception", "a number")
                })
            }))
        }
        (other, _) => return Err(Error::invalid("event", format!("{other:?}"), "one of fullbody.events")),
    };
    Ok(Event { condition, direction, terminal })
}

fn arrays(py: Python<'_>, record: Trajectory) -> PyResult<Bound<'_, PyDict>> {
    let (k, n) = (record.len(), record.bodies);
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
    let events: Vec<(usize, f64, PyState)> =
        record.events.into_iter().map(|e| (e.event, e.time, PyState { inner: e.state })).collect();
    dict.set_item("events", events)?;
    dict.set_item("dense", record.dense.map(|inner| PyDense { inner }))?;
    let (reason, event) = match record.stop_reason {
        StopReason::Unfinished => ("unfinished", None),
        StopReason::End => ("end", None),
        StopReason::Event(index) => ("event", Some(index)),
        StopReason::Interrupted => ("interrupted", None),
    };
    dict.set_item("stop_reason", (reason, event))?;
    Ok(dict)
}
