//! The crate's errors as the exception classes of `fullbody.errors`.

use crate::error::Error;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

pyo3::import_exception!(fullbody.errors, BodiesOverlap);
pyo3::import_exception!(fullbody.errors, ChartSingularity);
pyo3::import_exception!(fullbody.errors, ForceFailed);
pyo3::import_exception!(fullbody.errors, InvalidInput);
pyo3::import_exception!(fullbody.errors, NotConverged);
pyo3::import_exception!(fullbody.errors, StepSizeTooSmall);

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        let text = error.to_string();
        match error {
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
            Error::Interrupted { .. } => PyKeyboardInterrupt::new_err(text),
        }
    }
}
