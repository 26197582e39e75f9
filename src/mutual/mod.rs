//! Force, torques and energy of a pair of bodies.
//!
//! Takes the relative pose of two bodies and gives an [`Interaction`] per unit G m_first m_second. Methods: the paper's
//! surface integrals (its Eqs. 2-4), the focal rule, the series to a degree, and points. One quadrature serves a pair: the
//! force on the second body is minus that on the first, and both torques come from the same nodes, so that
//! M_first + M_second + r x F_second = 0 holds to round-off.
//!
//! Bodies of several parts interact by their parts: a [`Link`] is the [`Pair`] of a part of one and a part of the other, with
//! their places in the bodies. Each has its own rule.

mod attractor;
mod axes;
mod choice;
mod derivatives;
mod expansion;
mod faceted;
mod faces;
mod gradient;
mod jacobian;
mod link;
mod means;
mod method;
mod multipole;
mod pair;
mod rule;
mod sampled;
mod series_slopes;
mod store;
mod surface;

pub use attractor::BodyGravity;
pub use axes::AxisSlopes;
pub use jacobian::Jacobian;
pub use link::{Foreseen, Link, TooNear};
pub use method::Method;
pub use multipole::Multipole;
pub use pair::Pair;
pub use rule::{Rule, RuleMemory};
pub use store::Store;

use crate::math::{Mat3, Vec3};

/// Where two bodies are and how they are turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// The vector from the first centre to the second, inertial.
    pub separation: Vec3,
    /// Rotation matrix of the first body: body frame to inertial.
    pub rotation_first: Mat3,
    /// Rotation matrix of the second body.
    pub rotation_second: Mat3,
}

/// Force and torques of a pair, per unit G m_first m_second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interaction {
    /// Force on the first body, inertial; the second feels the opposite.
    pub force_on_first: Vec3,
    /// Torque on the first body about its centre, in its body frame.
    pub torque_first: Vec3,
    /// Torque on the second body about its centre, in its body frame.
    pub torque_second: Vec3,
}

/// One body as the integrand's field and the other as the integration set, in the field body's canonical frame.
#[derive(Debug, Clone, Copy)]
struct Roles {
    /// The vector from the field body's centre to the other's.
    origin: Vec3,
    /// Turns the other's canonical frame into the field body's.
    turn: Mat3,
}

/// The results of a quadrature, in the field body's canonical frame, per unit G m m.
#[derive(Debug, Clone, Copy)]
struct Balance {
    /// Force on the body that is integrated over.
    force: Vec3,
    /// Torque on it about its own centre.
    torque: Vec3,
    /// Torque on the field body about its own centre.
    torque_field: Vec3,
}
