//! Long calls: other threads work meanwhile, and Ctrl-C is heard.

use crate::error::Error;
use crate::patience::Patience;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::Mutex;

/// Keeps the first exception of a call that has released the GIL.
#[derive(Default)]
pub struct Listener {
    raised: Mutex<Option<PyErr>>,
}

impl Listener {
    /// Looks for signals and then does something else that may raise; breaks at an exception.
    pub fn ask(&self, and: impl FnOnce(Python<'_>) -> PyResult<()>) -> ControlFlow<()> {
        match Python::attach(|py| py.check_signals().and_then(|()| and(py))) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.keep(error);
                ControlFlow::Break(())
            }
        }
    }

    /// Keeps an exception, unless there is one.
    pub fn keep(&self, error: PyErr) {
        if let Ok(mut slot) = self.raised.lock() {
            slot.get_or_insert(error);
        }
    }

    /// The exception of a call that failed: the one that was kept, or that of the error.
    pub fn explain(&self, error: Error) -> PyErr {
        self.raised().unwrap_or_else(|| error.into())
    }

    /// The exception that was kept.
    pub fn raised(&self) -> Option<PyErr> {
        self.raised.lock().ok().and_then(|mut slot| slot.take())
    }
}

/// Does work without the GIL, and looks for signals about every 50 ms.
pub fn listening<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&mut Patience) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let listener = Listener::default();
    let outcome = py.detach(|| work(&mut Patience::new(&mut || listener.ask(|_| Ok(())))));
    outcome.map_err(|error| listener.explain(error))
}
