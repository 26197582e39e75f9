//! The sum of all external forces on the bodies of a system.

use super::{Load, LoadSink};
use crate::math::Vec3;
use crate::math::compensated::sum;
use crate::shape::Body;

/// The accelerations and torques of all external forces, on each body and in total.
#[derive(Debug, Clone)]
pub struct LoadSum {
    bodies: Vec<Action>,
    /// The force on all bodies together.
    force: Vec3,
    /// One over the mass of all bodies.
    inverse_mass: f64,
}

#[derive(Debug, Clone)]
struct Action {
    acceleration: Vec3,
    torque: Vec3,
    inverse_mass: f64,
}

impl LoadSum {
    /// Makes the sum for these bodies, without any force.
    pub fn none(bodies: &[Body]) -> Self {
        let zero = Vec3::zeros();
        let none = |body: &Body| Action { acceleration: zero, torque: zero, inverse_mass: 1.0 / body.mass };
        Self {
            bodies: bodies.iter().map(none).collect(),
            force: zero,
            inverse_mass: 1.0 / sum(bodies.iter().map(|body| body.mass)),
        }
    }

    /// Sets all accelerations and torques to zero.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.force = Vec3::zeros();
        for body in &mut self.bodies {
            (body.acceleration, body.torque) = (Vec3::zeros(), Vec3::zeros());
        }
    }

    /// Adds the forces to accelerations relative to the barycentre and to torques. Returns the acceleration
    /// of the barycentre.
    #[inline(always)]
    pub fn add_to(&self, acceleration: &mut [Vec3], torque: &mut [Vec3]) -> Vec3 {
        let common = self.force * self.inverse_mass;
        for (body, (acceleration, torque)) in self.bodies.iter().zip(acceleration.iter_mut().zip(torque)) {
            *acceleration += body.acceleration - common;
            *torque += body.torque;
        }
        common
    }
}

impl LoadSink for LoadSum {
    #[inline(always)]
    fn take(&mut self, loads: &[Load]) {
        for load in loads {
            let body = &mut self.bodies[load.on];
            self.force += load.force;
            body.acceleration += load.force * body.inverse_mass;
            if load.can_rotate {
                body.torque += load.torque;
            }
        }
    }
}
