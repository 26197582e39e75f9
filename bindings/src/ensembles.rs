//! Many simulations in parallel.

use super::descriptions::from_python;
use super::events::{EventSpec, events};
use super::listening::Listener;
use super::runs::{Sampling, TangentRequest, arrays};
use super::systems::{PyState, PySystem};
use crate::errors::{Raised, Result};
use fullbody::ensemble::{Member, MemberOutcome, run_within};
use fullbody::workers::{JobProgress, JobSource, WorkerThread};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator};
use std::cell::Cell;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::sync::Arc;

/// A member from Python: its tag, system, state, integrator, end, samples, events, whether the continuous
/// solution is kept, and which derivatives are integrated.
type MemberTuple<'py> = (
    Py<PyAny>,
    Bound<'py, PySystem>,
    Bound<'py, PyState>,
    Bound<'py, PyDict>,
    f64,
    Sampling<'py>,
    Vec<EventSpec<'py>>,
    bool,
    TangentRequest,
);

/// Runs members from an iterator over threads.
///
/// The outcome of each goes to `take(tag, record, counts, time, error)`: with the error alone if the member
/// could not begin, and with the tag alone if it had not begun at an interrupt. `report(done, under_way)` is
/// called about every 25 ms. Both and the iterator are called in the caller's thread, which checks for
/// Ctrl-C; an exception in them stops all runs and is raised at the end. The GIL is released except for these
/// calls, for event functions and for forces that are Python functions.
#[pyfunction]
pub fn integrate_many(
    py: Python<'_>,
    members: Bound<'_, PyIterator>,
    take: Py<PyAny>,
    report: Option<Py<PyAny>>,
    threads: Option<NonZeroUsize>,
) -> Result<()> {
    let (listener, stopped) = (Listener::default(), Cell::new(false));
    let mut source = PyJobSource { members: members.unbind(), take, report, listener, stopped };
    // Each thread is known to Python as one thread; otherwise it would be a new one in each function that it
    // calls.
    let life = |life: WorkerThread| Python::attach(|py| py.detach(|| life.run()));
    let outcome = py.detach(|| run_within(&mut source, threads, life));
    match source.listener.raised() {
        Some(error) => Err(error.into()),
        None => Ok(outcome?),
    }
}

/// The object by which the caller identifies a member, and the exceptions of its event functions.
type Tag = (Py<PyAny>, Arc<Listener>);

struct PyJobSource {
    members: Py<PyIterator>,
    take: Py<PyAny>,
    report: Option<Py<PyAny>>,
    listener: Listener,
    stopped: Cell<bool>,
}

impl PyJobSource {
    /// Calls Python code, whose exception stops all runs.
    fn ask<T>(&self, what: impl FnOnce(Python<'_>) -> Result<T>) -> Option<T> {
        let stop = |error: Raised| {
            self.stopped.set(true);
            self.listener.keep(error);
        };
        Python::attach(what).map_err(stop).ok()
    }

    fn flow(&self) -> ControlFlow<()> {
        if self.stopped.get() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl JobSource for PyJobSource {
    type Job = (Tag, Member);
    type Answer = (Tag, MemberOutcome);

    fn next(&mut self) -> Option<(Tag, Member)> {
        // An object that cannot be a member gets its error at once.
        while !self.stopped.get() {
            let member_or_error = self.ask(|py| {
                let Some(arguments) = self.members.bind(py).clone().next().transpose()? else {
                    return Ok(None);
                };
                let member_or_error = member(py, &arguments).map_err(PyErr::from);
                if let Err(error) = &member_or_error {
                    let none = py.None();
                    self.take.call1(py, (arguments.get_item(0)?, &none, &none, &none, error.value(py)))?;
                }
                Ok(Some(member_or_error.ok()))
            });
            match member_or_error.flatten() {
                Some(None) => {}
                next => return next.flatten(),
            }
        }
        None
    }

    fn take(&mut self, ((tag, listener), answer): (Tag, MemberOutcome)) -> ControlFlow<()> {
        self.ask(|py| {
            let (record, counts, time, error) = match answer {
                None => (None, None, None, None),
                Some(Err(error)) => (None, None, None, Some(listener.explain(error))),
                Some(Ok(ran)) => {
                    let counts = (ran.statistics.steps, ran.statistics.rejected, ran.statistics.evaluations);
                    let error = ran.error.map(|error| listener.explain(error));
                    (Some(arrays(py, ran.record)?), Some(counts), Some(ran.time), error)
                }
            };
            self.take.call1(py, (tag, record, counts, time, error))?;
            Ok(())
        });
        self.flow()
    }

    fn proceed(&mut self, progress: JobProgress) -> ControlFlow<()> {
        self.ask(|py| {
            py.check_signals()?;
            if let Some(report) = &self.report {
                report.call1(py, (progress.done, progress.under_way))?;
            }
            Ok(())
        });
        self.flow()
    }
}

fn member(py: Python<'_>, arguments: &Bound<'_, PyAny>) -> Result<(Tag, Member)> {
    let (tag, system, state, integrator, until, output, watched, dense, tangent_options): MemberTuple<'_> =
        arguments.extract()?;
    let listener = Arc::new(Listener::default());
    let member = Member {
        system: system.get().inner.clone(),
        state: state.get().inner.clone(),
        integrator: from_python(&integrator)?,
        until,
        output: output.into(),
        events: events(py, &watched, &listener),
        dense,
        tangent_options: tangent_options.checked(&system.get().inner)?,
    };
    Ok(((tag, listener), member))
}
