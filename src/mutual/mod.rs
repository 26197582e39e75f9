//! Force, torques and energy of a pair of bodies.
//!
//! Takes the relative pose of two bodies and gives an [`Interaction`] per unit G m_first m_second. The
//! methods are the paper's surface integrals (its Eqs. 2-4), the focal rule, the mutual expansion to a
//! degree, and point masses. One quadrature serves a pair: the force on the second body is minus that on the
//! first, and both torques come from the same nodes, so that M_first + M_second + r x F_second = 0 holds to
//! round-off.
//!
//! Bodies of several parts interact by their parts: a `Link` is the `Pair` of a part of one body and a
//! part of the other, with the positions of the parts in their bodies. Each link has its own rule.

mod part_gravity;
mod axes;
mod choice;
mod derivatives;
mod face_gradient;
mod faceted;
mod faceted_gradient;
mod faces;
mod fragments;
mod gradient;
mod harmonic;
mod jacobian;
mod link;
mod means;
mod method;
mod multipole;
mod pair;
mod part_offsets;
mod rule;
mod sampled;
mod series_jacobian;
mod store;
mod surface;

#[doc(hidden)]
pub use axes::ShapeDerivatives;
pub use harmonic::harmonics;
#[doc(hidden)]
pub use jacobian::Jacobian;
#[doc(hidden)]
pub use link::{LEAST_TOLERANCE, Link, PredictedMotion, TooNear};
pub use method::Method;
#[doc(hidden)]
pub use multipole::Multipole;
#[doc(hidden)]
pub use pair::Pair;
#[doc(hidden)]
pub use part_gravity::PartGravity;
#[doc(hidden)]
pub use rule::{Rule, RuleMemory};
#[doc(hidden)]
pub use store::Store;

use crate::math::{Mat3, Vec3};

/// The relative position and the rotations of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// The vector from the first centre to the second, inertial.
    pub separation: Vec3,
    /// The rotation matrix of the first body: body frame to inertial.
    pub rotation_first: Mat3,
    /// The rotation matrix of the second body: body frame to inertial.
    pub rotation_second: Mat3,
}

/// Force and torques of a pair, per unit G m_first m_second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interaction {
    /// The force on the first body, inertial; the force on the second one is the opposite.
    pub force_on_first: Vec3,
    /// The torque on the first body about its centre, in its body frame.
    pub torque_first: Vec3,
    /// The torque on the second body about its centre, in its body frame.
    pub torque_second: Vec3,
}

impl Interaction {
    /// The interaction of zero force and torques.
    pub(crate) const ZERO: Self = {
        let zero = Vec3::new(0.0, 0.0, 0.0);
        Self { force_on_first: zero, torque_first: zero, torque_second: zero }
    };

    /// Adds another interaction.
    pub(crate) fn add(&mut self, other: &Self) {
        self.force_on_first += other.force_on_first;
        self.torque_first += other.torque_first;
        self.torque_second += other.torque_second;
    }

    /// Returns the interaction multiplied by a factor.
    pub(crate) fn times(&self, factor: f64) -> Self {
        Self {
            force_on_first: self.force_on_first * factor,
            torque_first: self.torque_first * factor,
            torque_second: self.torque_second * factor,
        }
    }
}

/// The relative pose of a pair for a quadrature: one body provides the field, and the other is integrated
/// over. Vectors are in the field body's canonical frame.
#[derive(Debug, Clone, Copy)]
struct Roles {
    /// The vector from the field body's centre to the other's.
    origin: Vec3,
    /// The rotation from the other body's canonical frame into that of the field body.
    rotation: Mat3,
}

/// The results of a quadrature, in the field body's canonical frame, per unit G m m.
#[derive(Debug, Clone, Copy, Default)]
struct Balance {
    /// The force on the body that is integrated over.
    force: Vec3,
    /// The torque on the body that is integrated over, about its own centre.
    torque: Vec3,
    /// The torque on the field body about its own centre.
    torque_field: Vec3,
}
