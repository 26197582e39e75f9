//! Many simulations over cores.

use super::descriptions::from_python;
use super::events::{Watched, events};
use super::listening::Listener;
use super::runs::{Followed, Sampling, arrays};
use super::systems::{PyState, PySystem};
use crate::ensemble::{Answer, Caller, Member, Progress, run};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator};
use rayon::ThreadBuilder;
use std::cell::Cell;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::sync::Arc;

/// What a member is known by, system, state, integrator, end, samples, events, whether the continuous solution is kept,
/// what is followed.
type Given<'py> = (
    Py<PyAny>,
    Bound<'py, PySystem>,
    Bound<'py, PyState>,
    Bound<'py, PyDict>,
    f64,
    Sampling<'py>,
    Vec<Watched<'py>>,
    bool,
    Followed,
);

/// Runs members from an iterator over threads.
///
/// Each one's answer goes to `take(tag, record, counts, time, error)`: with an error alone where the member could not begin,
/// and with nothing where it had not begun at an interrupt. `report(done, under_way)` is called about every 25 ms. Both and
/// the iterator are called in the caller's thread, which looks for Ctrl-C; what they raise stops all runs and is raised at
/// the end. The GIL is released but for these calls, functions of events and forces that are functions of Python.
#[pyfunction]
pub fn integrate_many(
    py: Python<'_>,
    members: Bound<'_, PyIterator>,
    take: Py<PyAny>,
    report: Option<Py<PyAny>>,
    threads: Option<NonZeroUsize>,
) -> PyResult<()> {
    let (listener, stopped) = (Listener::default(), Cell::new(false));
    let mut asking = Asking { members: members.unbind(), take, report, listener, stopped };
    let outcome = py.detach(|| run(&mut asking, threads));
    match asking.listener.raised() {
        Some(error) => Err(error),
        None => Ok(outcome?),
    }
}

/// What the caller knows a member by, and what the functions of its events raise.
type Tag = (Py<PyAny>, Arc<Listener>);

struct Asking {
    members: Py<PyIterator>,
    take: Py<PyAny>,
    report: Option<Py<PyAny>>,
    listener: Listener,
    stopped: Cell<bool>,
}

impl Asking {
    /// Does something in Python; what it raises stops all.
    fn ask<T>(&self, what: impl FnOnce(Python<'_>) -> PyResult<T>) -> Option<T> {
        let stop = |error| {
            self.stopped.set(true);
            self.listener.keep(error);
        };
        Python::attach(what).map_err(stop).ok()
    }
}

impl Caller for Asking {
    type Tag = Tag;

    fn next(&mut self) -> Option<(Tag, Member)> {
        // Those that cannot be members have their answers at once.
        while !self.stopped.get() {
            let found = self.ask(|py| {
                let Some(given) = self.members.bind(py).clone().next().transpose()? else { return Ok(None) };
                let found = member(py, &given);
                if let Err(error) = &found {
                    let none = py.None();
                    self.take.call1(py, (given.get_item(0)?, &none, &none, &none, error.value(py)))?;
                }
                Ok(Some(found.ok()))
            });
            match found.flatten() {
                Some(None) => {}
                found => return found.flatten(),
            }
        }
        None
    }

    fn take(&mut self, (tag, listener): Tag, answer: Answer) {
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
            self.take.call1(py, (tag, record, counts, time, error)).map(drop)
        });
    }

    fn proceed(&mut self, progress: Progress) -> ControlFlow<()> {
        self.ask(|py| {
            py.check_signals()?;
            let report = self.report.as_ref();
            report.map_or(Ok(()), |report| report.call1(py, (progress.done, progress.under_way)).map(drop))
        });
        if self.stopped.get() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Known to Python as one thread, which otherwise would be a new one in each function that it calls.
    fn thread(life: ThreadBuilder) {
        Python::attach(|py| py.detach(|| life.run()));
    }
}

fn member(py: Python<'_>, given: &Bound<'_, PyAny>) -> PyResult<(Tag, Member)> {
    let (tag, system, state, integrator, until, output, watched, dense, following): Given<'_> =
        given.extract()?;
    let listener = Arc::new(Listener::default());
    let member = Member {
        system: system.get().inner.clone(),
        state: state.get().inner.clone(),
        integrator: from_python(&integrator)?,
        until,
        output: output.into(),
        events: events(py, &watched, &listener),
        dense,
        following: following.checked(&system.get().inner)?,
    };
    Ok(((tag, listener), member))
}
