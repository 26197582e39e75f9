//! Long calls that release the GIL and check for Ctrl-C.

use crate::errors::{Interrupted, Raised, Result};
use fullbody::error::Error;
use fullbody::interrupt::InterruptCheck;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::Mutex;

/// The first exception of a call that has released the GIL.
#[derive(Default)]
pub struct Listener {
    raised: Mutex<Option<PyErr>>,
}

impl Listener {
    /// Checks for signals and then calls `and`; breaks at an exception.
    pub fn ask(&self, and: impl FnOnce(Python<'_>) -> Result<()>) -> ControlFlow<()> {
        let checked = |py: Python<'_>| {
            py.check_signals()?;
            and(py)
        };
        match Python::attach(checked) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.keep(error);
                ControlFlow::Break(())
            }
        }
    }

    /// Keeps an exception, unless there is one.
    pub fn keep(&self, error: impl Into<PyErr>) {
        if let Ok(mut slot) = self.raised.lock() {
            slot.get_or_insert_with(|| error.into());
        }
    }

    /// Returns the exception of a call that failed: the one that was kept, or the one for the error.
    pub fn explain(&self, error: Error) -> PyErr {
        self.raised().unwrap_or_else(|| Raised::from(error).into())
    }

    /// Takes the exception that was kept; a plain `KeyboardInterrupt` becomes an `Interrupted`.
    pub fn raised(&self) -> Option<PyErr> {
        let raised = self.raised.lock().ok().and_then(|mut slot| slot.take())?;
        Some(Python::attach(|py| {
            if !raised.get_type(py).is(py.get_type::<PyKeyboardInterrupt>()) {
                return raised;
            }
            let interrupted = Interrupted::new_err("interrupted");
            interrupted.set_cause(py, Some(raised));
            interrupted
        }))
    }
}

/// Runs work without the GIL, and checks for signals about every 50 ms.
pub fn listening<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&mut InterruptCheck) -> Result<T, Error> + Send,
) -> Result<T> {
    let listener = Listener::default();
    let outcome = py.detach(|| work(&mut InterruptCheck::new(&mut || listener.ask(|_| Ok(())))));
    Ok(outcome.map_err(|error| listener.explain(error))?)
}
