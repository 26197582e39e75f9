//! The one error type. Every variant carries what a person needs to act: which body, when, which value
//! and what was expected. The Python classes of the same names are raised from these.

use thiserror::Error;

/// An error of `fullbody`.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument that describes nothing physical, or has the wrong shape.
    #[error("{what} is {value}; expected {expected}")]
    InvalidInput {
        /// The quantity, with the body it belongs to.
        what: String,
        /// The offending value, printed.
        value: String,
        /// What would have been accepted.
        expected: String,
    },

    /// Two bodies share interior points: the exterior potential does not hold there.
    #[error(
        "{first} and {second} overlap at time {time}; expected interiors apart (a run can end at the contact: events.Contact, terminal)"
    )]
    BodiesOverlap {
        /// Name of one body.
        first: String,
        /// Name of the other.
        second: String,
        /// Time in the system's units.
        time: f64,
    },

    /// The error control asks for a step that no longer advances the time.
    #[error("step size {step:e} at time {time} is too small to advance the time; {reason}")]
    StepSizeTooSmall {
        /// Time in the system's units.
        time: f64,
        /// The step asked for.
        step: f64,
        /// What made the steps shrink.
        reason: String,
    },

    /// A quadrature or iteration that reached its stated limit.
    #[error("{what} did not converge: {detail}")]
    NotConverged {
        /// The computation.
        what: String,
        /// The limit reached, and what would help.
        detail: String,
    },

    /// The Tait-Bryan chart came too near its pole (theta = 90 degrees).
    #[error(
        "attitude of {body} at time {time} has |cos theta| = {cos_theta:.3e}, too near the pole of the \
         Tait-Bryan angles; use attitude_chart=\"quaternion\""
    )]
    ChartSingularity {
        /// Name of the body.
        body: String,
        /// Time in the system's units.
        time: f64,
        /// Distance from the pole.
        cos_theta: f64,
    },

    /// An external force cannot be had, or its function failed.
    #[error("force {force} at time {time}: {detail}")]
    ForceFailed {
        /// Name of the force.
        force: String,
        /// Time in the system's units.
        time: f64,
        /// What went wrong.
        detail: String,
        /// The value that the function returned instead of success, where that is what went wrong.
        answer: Option<i32>,
    },

    /// The caller's hook asked to stop (Ctrl-C); the state stays at the last accepted step.
    #[error("interrupted at time {time}")]
    Interrupted {
        /// Time of the last accepted step.
        time: f64,
    },
}

/// Result with this crate's [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Returns an [`Error::InvalidInput`] from anything printable.
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
    pub fn of(self, name: &str) -> Self {
        match self {
            Self::InvalidInput { what, value, expected } => {
                Self::InvalidInput { what: format!("{what} of {name}"), value, expected }
            }
            other => other,
        }
    }

    /// Sets the time of the simulated motion where the error has none yet.
    pub fn at(self, time: f64) -> Self {
        match self {
            Self::Interrupted { .. } => Self::Interrupted { time },
            other => other,
        }
    }
}

/// Why the rates of change cannot be evaluated at a trial state.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Refusal {
    /// A shorter step may avoid the state.
    Shorter(&'static str),
    /// No step avoids the state: the run ends.
    Failed(Box<Error>),
}

/// Returns an error for NaN and infinities, naming the quantity and the component.
pub fn require_finite(what: &str, values: &[f64]) -> Result<()> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(k) if values.len() == 1 => Err(Error::invalid(what, values[k], "a finite number")),
        Some(k) => Err(Error::invalid(format!("{what}, component {k},"), values[k], "a finite number")),
    }
}

/// Returns an error for everything but finite numbers above zero.
pub fn require_positive(what: &str, value: f64) -> Result<()> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(Error::invalid(what, value, "a finite number above zero"))
    }
}
