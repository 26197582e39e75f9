//! Event conditions of runs.

use super::arrays::array;
use super::listening::{Listener, listening};
use super::systems::{PyState, PySystem};
use crate::errors::{Raised, Result};
use fullbody::dynamics::{Parameter, State};
use fullbody::error::Error;
use fullbody::math::Vec3;
use fullbody::math::spline::Spline;
use fullbody::trajectory::{Condition, ConditionDerivatives, Event, Viewpoint};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use std::sync::Arc;

/// The condition of an event; bodies are given by their index in the system.
#[pyclass(frozen, name = "Condition", module = "fullbody._core")]
pub enum PyCondition {
    Separation { first: usize, second: usize, value: f64 },
    Contact { first: usize, second: usize },
    Periapsis { first: usize, second: usize },
    Apoapsis { first: usize, second: usize },
    PlaneCrossing { body: usize, reference: Option<usize>, normal: [f64; 3] },
    Escape { first: usize, second: usize, distance: f64 },
    Alignment { body: usize, other: usize },
    ClosestApproach { force: usize },
    Occultation { body: usize, by: usize, total: bool, toward: Py<PyViewpoint> },
    Function { f: Py<PyAny> },
}

/// The path of a point that sees the bodies or lights them, as a cubic spline.
#[pyclass(frozen, name = "Viewpoint", module = "fullbody._core")]
pub struct PyViewpoint {
    inner: Viewpoint,
}

#[pymethods]
impl PyViewpoint {
    /// Makes the path through positions (T, 3) from the barycentre at times (T,), of which only the directions
    /// count if it is distant, with the time that light takes per unit length.
    #[new]
    fn new(
        times: Vec<f64>,
        positions: Vec<[f64; 3]>,
        slowness: f64,
        distant: bool,
        bounded: bool,
    ) -> Result<Self> {
        let path = Spline::new("times of Occultation", &times, &positions)?;
        Ok(Self { inner: Viewpoint { path, slowness, distant, bounded } })
    }
}

/// A condition with its direction and whether the run ends there.
pub type EventSpec<'py> = (Bound<'py, PyCondition>, i8, bool);

/// Makes the core's events. The first exception of a function goes to `listener`.
pub fn events(py: Python<'_>, watched: &[EventSpec<'_>], listener: &Arc<Listener>) -> Vec<Event<'static>> {
    let event = |(condition, direction, terminal): &EventSpec<'_>| Event {
        condition: condition.get().condition(py, listener),
        direction: *direction,
        terminal: *terminal,
    };
    watched.iter().map(event).collect()
}

/// The derivatives of a condition's function with respect to a tangent vector, to time, to parameters, and to
/// its own parameters.
type FunctionDerivatives<'py> = (Bound<'py, PyArrayDyn<f64>>, f64, Vec<f64>, Vec<(String, f64)>);

#[pymethods]
impl PyCondition {
    /// Returns the derivatives (12N,) of the function with respect to a tangent vector, its derivative with
    /// respect to time, the derivatives (P,) with respect to parameters, and those by the condition's own
    /// parameters under their names.
    fn derivatives<'py>(
        &self,
        py: Python<'py>,
        system: &PySystem,
        state: &PyState,
        parameters: Vec<String>,
    ) -> Result<FunctionDerivatives<'py>> {
        let raised = Arc::new(Listener::default());
        let mut condition = self.condition(py, &raised);
        let named = parameters.iter().map(|name| Parameter::named(name, &system.inner));
        let named: Vec<_> = named.collect::<Result<_, _>>()?;
        let derivatives =
            listening(py, |interrupt| condition.derivatives(&system.inner, &state.inner, &named, interrupt));
        let ConditionDerivatives { by_state, by_time, by_parameters, by_condition_parameters } =
            derivatives.map_err(|error| raised.raised().map_or(error, Raised::from))?;
        let count = by_state.len();
        Ok((array(py, by_state, &[count])?, by_time, by_parameters, by_condition_parameters))
    }
}

impl PyCondition {
    /// Makes the core's condition. The first exception of a function goes to `listener`.
    pub(super) fn condition(&self, py: Python<'_>, listener: &Arc<Listener>) -> Condition<'static> {
        match *self {
            Self::Separation { first, second, value } => Condition::Separation { first, second, value },
            Self::Contact { first, second } => Condition::Contact { first, second },
            Self::Periapsis { first, second } => Condition::Periapsis { first, second },
            Self::Apoapsis { first, second } => Condition::Apoapsis { first, second },
            Self::PlaneCrossing { body, reference, normal } => {
                Condition::PlaneCrossing { body, reference, normal: Vec3::from(normal) }
            }
            Self::Escape { first, second, distance } => Condition::Escape { first, second, distance },
            Self::Alignment { body, other } => Condition::Alignment { body, other },
            Self::ClosestApproach { force } => Condition::ClosestApproach { force },
            Self::Occultation { body, by, total, ref toward } => {
                Condition::Occultation { body, by, total, viewpoint: Box::new(toward.get().inner.clone()) }
            }
            Self::Function { ref f } => {
                let (f, listener) = (f.clone_ref(py), listener.clone());
                Condition::Function(Box::new(move |state: &State| {
                    let value = Python::attach(|py| {
                        f.call1(py, (PyState { inner: state.clone() },))?.extract::<f64>(py)
                    });
                    value.map_err(|error| {
                        listener.keep(error);
                        Error::invalid("value of an event's function", "an exception", "a number")
                    })
                }))
            }
        }
    }
}
