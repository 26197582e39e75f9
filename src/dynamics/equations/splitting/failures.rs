//! Errors of steps that cannot be taken, with advice.

use super::{DriftKind, Splitting};
use crate::dynamics::rotation::discrete_rotor::variational_rotation;
use crate::dynamics::rotation::free_rotors::{MAX_ROTATION_ANGLE, rotation_angle_bound};
use crate::dynamics::{Dynamics, Rejected};
use crate::error::Error;
use crate::math::Vec3;

impl Splitting {
    /// Returns the error for forces that cannot be evaluated within the step.
    #[cold]
    pub(super) fn refused(&self, dynamics: &Dynamics, rejected: Rejected) -> Error {
        let reason = match rejected {
            Rejected::TooClose { bodies, separation, valid_from } => {
                let [first, second] = bodies.map(|body| {
                    let body = &dynamics.system().bodies()[body];
                    if body.is_composite() { format!("a part of {}", body.name) } else { body.name.clone() }
                });
                format!(
                    "{first} and {second} come to a separation of {separation:.6e} in it, where the \
                     quadrature of their \
                     forces was chosen for {valid_from:.6e} and more"
                )
            }
            Rejected::Failed(error) => return *error,
            other => other.reason().to_owned(),
        };
        self.failed(&format!("{reason}; use a shorter step"))
    }

    #[cold]
    fn failed(&self, detail: &str) -> Error {
        let what = format!("a step of size {:e} at time {}", self.step, self.time);
        Error::NotConverged { what, detail: detail.to_owned() }
    }

    /// Returns the error for a body whose Kepler motion cannot be solved.
    #[cold]
    pub(super) fn unsolved(&self, dynamics: &Dynamics, body: usize) -> Error {
        let name = &dynamics.system().bodies()[body].name;
        self.failed(&format!(
            "the Kepler motion of {name} about the barycentre of the bodies before it is not solved in \
             doubles; use a shorter step, or \
             another order of the bodies"
        ))
    }

    /// Returns the error for a body that rotates too far in this step, with a step in which it would not.
    #[cold]
    pub(super) fn too_far(&self, dynamics: &Dynamics, body: usize, spin: Vec3) -> Error {
        let name = &dynamics.system().bodies()[body].name;
        let (inertia, step) = (self.inertia[body], self.step.abs());
        let (angle, shorter, limit) = match self.drift_kind {
            DriftKind::Kepler => {
                let angle = rotation_angle_bound(inertia, spin, step);
                (
                    angle,
                    0.99 * step * MAX_ROTATION_ANGLE / angle,
                    format!("expected {MAX_ROTATION_ANGLE} rad at most"),
                )
            }
            DriftKind::Free => {
                let follows =
                    |step: &f64| variational_rotation(inertia, [1.0, 0.0, 0.0, 0.0], spin, *step).is_some();
                let shorter =
                    (1..1000).map(|k| 0.99 * step * 0.5_f64.powi(k)).find(follows).unwrap_or_default();
                (spin.norm() * step, shorter, "the discrete rotation has no solution for it".to_owned())
            }
        };
        let remedy = if shorter > f64::MIN_POSITIVE {
            format!("use a step of at most {shorter:.3e}")
        } else {
            "no step is short enough: its spin, or a torque on it, is too large".to_owned()
        };
        self.failed(&format!("{name} rotates by {angle:.3e} rad in it; {limit}; {remedy}"))
    }
}
