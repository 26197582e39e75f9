//! What a force is, for archives and the Python package.

use super::{Byorp, Function, ThirdBody, Tide, Yorp};
use serde::{Deserialize, Serialize};

/// One force from outside, or one that the bodies have from each other beside gravity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", deny_unknown_fields)]
pub enum Force {
    /// The gravity of a point mass on a prescribed path.
    ThirdBody(ThirdBody),
    /// A tide of constant time lag.
    Tide(Tide),
    /// The torque of radiation on a body.
    Yorp(Yorp),
    /// The force of radiation on a synchronous secondary.
    Byorp(Byorp),
    /// A caller's function.
    Function(Function),
}

impl Force {
    /// The name, which is its own among the forces of a system.
    pub fn name(&self) -> &str {
        match self {
            Self::ThirdBody(force) => &force.name,
            Self::Tide(force) => &force.name,
            Self::Yorp(force) => &force.name,
            Self::Byorp(force) => &force.name,
            Self::Function(force) => &force.name,
        }
    }

    /// Whether it depends on velocities or spins.
    pub fn depends_on_velocity(&self) -> bool {
        match self {
            Self::ThirdBody(_) => false,
            Self::Tide(_) | Self::Yorp(_) | Self::Byorp(_) => true,
            Self::Function(force) => force.depends_on_velocity,
        }
    }
}
