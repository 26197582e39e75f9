//! Conversion of the crate's errors to the exception classes of `fullbody.errors`.

use fullbody::error::Error;
use numpy::AsSliceError;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

pyo3::import_exception!(fullbody.errors, BodiesOverlap);
pyo3::import_exception!(fullbody.errors, ChartSingularity);
pyo3::import_exception!(fullbody.errors, ForceFailed);
pyo3::import_exception!(fullbody.errors, Interrupted);
pyo3::import_exception!(fullbody.errors, InvalidInput);
pyo3::import_exception!(fullbody.errors, NotConverged);
pyo3::import_exception!(fullbody.errors, StepSizeTooSmall);

/// An exception that is raised in Python. Functions that Python calls return it, so that `?` applies to the
/// crate's errors and to Python's own alike.
#[derive(Debug)]
pub struct Raised(PyErr);

/// The result of a function that Python calls.
pub type Result<T, E = Raised> = std::result::Result<T, E>;

impl From<PyErr> for Raised {
    fn from(error: PyErr) -> Self {
        Self(error)
    }
}

impl From<AsSliceError> for Raised {
    fn from(error: AsSliceError) -> Self {
        Self(error.into())
    }
}

impl From<Raised> for PyErr {
    fn from(raised: Raised) -> Self {
        raised.0
    }
}

impl From<Error> for Raised {
    fn from(error: Error) -> Self {
        let mut text = error.to_string();
        // The arguments of the Python package that avoid the error.
        match error {
            Error::BodiesOverlap { .. } => {
                text.push_str(" (a run can end at the contact: events.Contact, terminal)");
            }
            Error::ChartSingularity { .. } => text.push_str(" (attitude_chart=\"quaternion\")"),
            _ => {}
        }
        Self(match error {
            Error::InvalidInput { .. } => InvalidInput::new_err(text),
            Error::BodiesOverlap { first, second, time } => {
                BodiesOverlap::new_err((text, (first, second), time))
            }
            Error::StepSizeTooSmall { time, step, .. } => StepSizeTooSmall::new_err((text, time, step)),
            Error::NotConverged { .. } => NotConverged::new_err(text),
            Error::ChartSingularity { body, time, .. } => ChartSingularity::new_err((text, body, time)),
            Error::ForceFailed { force, time, answer, .. } => {
                ForceFailed::new_err((text, force, time, answer))
            }
            Error::Interrupted { .. } => Interrupted::new_err(text),
            _ => PyRuntimeError::new_err(text),
        })
    }
}
