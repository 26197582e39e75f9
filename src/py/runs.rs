//! Simulations and what they record.

use super::arrays::array;
use super::systems::{PyState, PySystem};
use crate::error::Error;
use crate::integrate::Tolerance;
use crate::trajectory::{Integrator, Output, Progress, Simulation, Trajectory};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ops::ControlFlow;

type RuleRow = (usize, usize, usize, usize, (usize, usize));

/// The stepping object.
#[pyclass(name = "Simulation", module = "fullbody._core")]
pub struct PySimulation {
    inner: Simulation,
}

#[pymethods]
impl PySimulation {
    #[new]
    fn new(
        system: &PySystem,
        state: &PyState,
        integrator: &str,
        rtol: f64,
        atol: f64,
    ) -> Result<Self, Error> {
        let tolerance = Tolerance::new(rtol, atol)?;
        let integrator = match integrator {
            "Verner98" => Integrator::Verner98(tolerance),
            other => return Err(Error::invalid("integrator", format!("{other:?}"), "\"Verner98\"")),
        };
        Ok(Self { inner: Simulation::new(&system.inner, &state.inner, integrator)? })
    }

    #[getter]
    fn time(&self) -> f64 {
        self.inner.time()
    }

    #[getter]
    fn state(&self) -> PyState {
        PyState { inner: self.inner.state() }
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

    fn step(&mut self, py: Python<'_>, end: f64) -> Result<(), Error> {
        py.detach(|| self.inner.step(end))
    }

    /// Runs to a time; gives the record and the error that cut it short, if any.
    ///
    /// The GIL is released; about every 50 ms it is taken to look for Ctrl-C and to call `progress(start, time, end)`.
    fn integrate<'py>(
        &mut self,
        py: Python<'py>,
        until: f64,
        spacing: Option<f64>,
        times: Option<Vec<f64>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Bound<'py, PyDict>, Option<PyErr>)> {
        let output = match (spacing, times) {
            (_, Some(times)) => Output::Times(times),
            (Some(spacing), None) => Output::Spacing(spacing),
            (None, None) => Output::Steps,
        };
        let mut record = Trajectory::new(self.inner.state().bodies());
        let mut raised = None;
        let outcome = py.detach(|| {
            let mut hook = |p: Progress| {
                let called = Python::attach(|py| {
                    py.check_signals()?;
                    match &progress {
                        Some(progress) => progress.call1(py, (p.start, p.time, p.end)).map(drop),
                        None => Ok(()),
                    }
                });
                match called {
                    Ok(()) => ControlFlow::Continue(()),
                    Err(error) => {
                        raised = Some(error);
                        ControlFlow::Break(())
                    }
                }
            };
            self.inner.integrate(until, &output, &mut record, &mut hook)
        });
        let error = raised.or(outcome.err().map(PyErr::from));
        Ok((arrays(py, record)?, error))
    }
}

fn arrays(py: Python<'_>, record: Trajectory) -> PyResult<Bound<'_, PyDict>> {
    let (k, n) = (record.len(), record.bodies);
    let dict = PyDict::new(py);
    for (name, values, shape) in [
        ("time", record.time, &[k][..]),
        ("position", record.position, &[k, n, 3]),
        ("velocity", record.velocity, &[k, n, 3]),
        ("attitude", record.attitude, &[k, n, 4]),
        ("spin", record.spin, &[k, n, 3]),
        ("energy", record.energy, &[k, 4]),
        ("angular_momentum", record.angular_momentum, &[k, 3]),
    ] {
        dict.set_item(name, array(py, values, shape)?)?;
    }
    Ok(dict)
}
