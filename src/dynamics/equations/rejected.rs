//! The reasons why the equations cannot be evaluated at a trial state.

use crate::error::{Error, Refusal};

/// A trial state at which the equations cannot be evaluated; a shorter step may avoid it.
#[derive(Debug, Clone, PartialEq)]
pub enum Rejected {
    /// Two bodies, or two parts of them, are nearer to each other than the rule in use is valid for.
    TooClose {
        /// The indices of the two bodies in the system.
        bodies: [usize; 2],
        /// The separation of the centres of these bodies or parts.
        separation: f64,
        /// The least separation for which the rule is valid.
        valid_from: f64,
    },
    /// An attitude is at the pole of the Tait-Bryan angles.
    Pole,
    /// A rate of change is infinite or not a number.
    NotFinite,
    /// An external force fails, for steps of any size.
    Failed(Box<Error>),
}

impl Rejected {
    /// Returns the reason without names and numbers.
    pub fn reason(&self) -> &'static str {
        match self {
            Self::TooClose { .. } => "two bodies come too close within a step",
            Self::Pole => "an attitude reaches the pole of the Tait-Bryan angles",
            Self::NotFinite => "a rate of change is not finite",
            Self::Failed(_) => "an external force fails",
        }
    }
}

impl From<Rejected> for Refusal {
    fn from(rejected: Rejected) -> Self {
        match rejected {
            Rejected::Failed(error) => Self::Failed(error),
            other => Self::Shorter(other.reason()),
        }
    }
}
