//! Why the equations cannot be evaluated at a trial state.

use crate::error::{Error, Refusal};

/// A trial state at which the equations cannot be evaluated; a shorter step may avoid it.
#[derive(Debug, Clone, PartialEq)]
pub enum Rejected {
    /// Two bodies, or a part of one and a part of the other, are nearer to each other than the rule in force holds.
    TooClose {
        /// Places of the two in the system.
        bodies: [usize; 2],
        /// Separation of the centres of what is too near.
        separation: f64,
        /// The least at which the rule holds.
        valid_from: f64,
    },
    /// An attitude is at the pole of the Tait-Bryan angles.
    Pole,
    /// A rate of change is infinite or no number.
    NotFinite,
    /// A force from outside fails, with steps of any size.
    Failed(Box<Error>),
}

impl Rejected {
    /// The reason without names and numbers.
    pub fn reason(&self) -> &'static str {
        match self {
            Self::TooClose { .. } => "two bodies come too close within a step",
            Self::Pole => "an attitude reaches the pole of the Tait-Bryan angles",
            Self::NotFinite => "a rate of change is not finite",
            Self::Failed(_) => "a force from outside fails",
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
