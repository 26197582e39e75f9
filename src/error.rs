//! The one error type. Every variant carries what is needed to correct the fault: which body, when, which
//! value and what was expected. The Python package raises exceptions of the same names from these.

use thiserror::Error;

/// An error of `fullbody`.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument is not physically meaningful or has the wrong shape.
    #[error("{what} is {value}; expected {expected}")]
    InvalidInput {
        /// The name of the quantity, with the body to which it belongs.
        what: String,
        /// The rejected value as text.
        value: String,
        /// The values that are accepted.
        expected: String,
    },

    /// Two bodies share interior points, where the exterior potential does not hold. A run ends before that
    /// at a terminal event of [`Condition::Contact`](crate::trajectory::Condition::Contact).
    #[error("{first} and {second} overlap at time {time}; expected interiors apart")]
    BodiesOverlap {
        /// The name of one body.
        first: String,
        /// The name of the other body.
        second: String,
        /// The time in the system's units.
        time: f64,
    },

    /// The error control requires a step so small that it no longer advances the time.
    #[error("step size {step:e} at time {time} is too small to advance the time; {reason}")]
    StepSizeTooSmall {
        /// The time in the system's units.
        time: f64,
        /// The size of the step.
        step: f64,
        /// The reason why the steps became small.
        reason: String,
    },

    /// A quadrature or an iteration reached its limit.
    #[error("{what} did not converge: {detail}")]
    NotConverged {
        /// The name of the computation.
        what: String,
        /// The limit that was reached, and what would help.
        detail: String,
    },

    /// The Tait-Bryan angles came too near their pole, theta = 90 degrees. Quaternions have no pole:
    /// [`Settings::attitude_chart`](crate::dynamics::Settings::attitude_chart).
    #[error(
        "attitude of {body} at time {time} has |cos theta| = {cos_theta:.3e}, too near the pole of the \
         Tait-Bryan angles; expected the attitude chart of quaternions"
    )]
    ChartSingularity {
        /// The name of the body.
        body: String,
        /// The time in the system's units.
        time: f64,
        /// The distance from the pole, |cos theta|.
        cos_theta: f64,
    },

    /// An external force is not available, or its function failed.
    #[error("force {force} at time {time}: {detail}")]
    ForceFailed {
        /// The name of the force.
        force: String,
        /// The time in the system's units.
        time: f64,
        /// The description of the failure.
        detail: String,
        /// The value that the function returned instead of success, if it returned one.
        answer: Option<i32>,
    },

    /// The caller's hook asked to stop (Ctrl-C); the state stays at the last accepted step.
    #[error("interrupted at time {time}")]
    Interrupted {
        /// The time of the last accepted step.
        time: f64,
    },
}

/// The result type of this crate, with [`enum@Error`] as the error.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Makes an [`Error::InvalidInput`] from a quantity, a value and an expectation.
    pub fn invalid(
        what: impl Into<String>,
        value: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> Self {
        Self::InvalidInput { what: what.into(), value: value.to_string(), expected: expected.into() }
    }
}

impl Error {
    /// Prefixes the quantity of an [`Error::InvalidInput`] with the name of its owner.
    #[must_use]
    pub fn of(self, name: &str) -> Self {
        match self {
            Self::InvalidInput { what, value, expected } => {
                Self::InvalidInput { what: format!("{what} of {name}"), value, expected }
            }
            other => other,
        }
    }

    /// Sets the time of the simulated motion where the error has none yet.
    #[must_use]
    pub fn at(self, time: f64) -> Self {
        match self {
            Self::Interrupted { .. } => Self::Interrupted { time },
            other => other,
        }
    }
}

/// The reason why the rates of change cannot be evaluated at a trial state.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Refusal {
    /// A shorter step may avoid the state.
    Shorter(&'static str),
    /// No step avoids the state: the run ends.
    Failed(Box<Error>),
}

/// Returns an error for NaN and infinities, naming the quantity and the component.
///
/// # Errors
/// [`Error::InvalidInput`] names the first number that is not finite.
pub fn require_finite(what: &str, values: &[f64]) -> Result<()> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(k) if values.len() == 1 => Err(Error::invalid(what, values[k], "a finite number")),
        Some(k) => Err(Error::invalid(format!("{what}, component {k},"), values[k], "a finite number")),
    }
}

/// Returns an error for everything but finite numbers above zero.
///
/// # Errors
/// [`Error::InvalidInput`] for a number that is not finite or not above zero.
pub fn require_positive(what: &str, value: f64) -> Result<()> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(Error::invalid(what, value, "a finite number above zero"))
    }
}
