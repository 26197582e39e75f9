//! The description of a force, as archives and the Python package use it.

use super::{BinaryYarkovsky, Byorp, Function, ThirdBody, Tide, Yorp};
use crate::error::Result;
use serde::{Deserialize, Serialize};

/// The description of one external force: a force on the bodies other than their mutual gravity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", deny_unknown_fields)]
#[non_exhaustive]
pub enum Force {
    /// The gravity of a point mass on a prescribed path.
    ThirdBody(ThirdBody),
    /// A tide of constant time lag.
    Tide(Tide),
    /// The torque of radiation on a body.
    Yorp(Yorp),
    /// The force and torque of radiation on a synchronous secondary.
    Byorp(Byorp),
    /// The force of heat on a secondary that does not rotate synchronously.
    BinaryYarkovsky(BinaryYarkovsky),
    /// A function of the user.
    Function(Function),
}

impl Force {
    /// Returns the name, which no other force of the system has.
    pub fn name(&self) -> &str {
        match self {
            Self::ThirdBody(force) => &force.name,
            Self::Tide(force) => &force.name,
            Self::Yorp(force) => &force.name,
            Self::Byorp(force) => &force.name,
            Self::BinaryYarkovsky(force) => &force.name,
            Self::Function(force) => &force.name,
        }
    }

    /// Checks the numbers of the force, whatever system it acts in.
    ///
    /// # Errors
    /// [`Error::InvalidInput`](crate::error::Error::InvalidInput) for numbers that no force of its kind can
    /// have.
    pub fn check(&self) -> Result<()> {
        match self {
            Self::ThirdBody(force) => force.check(),
            Self::Tide(force) => force.check(),
            Self::Yorp(force) => force.check(),
            Self::Byorp(force) => force.check(),
            Self::BinaryYarkovsky(force) => force.check(),
            Self::Function(_) => Ok(()),
        }
    }

    /// Returns whether the force depends on velocities or spins.
    pub fn depends_on_velocity(&self) -> bool {
        match self {
            Self::ThirdBody(_) => false,
            Self::Tide(_) | Self::Yorp(_) | Self::Byorp(_) | Self::BinaryYarkovsky(_) => true,
            Self::Function(force) => force.depends_on_velocity,
        }
    }
}
