//! What the motion conserves: the paper's sections "Total energy" and "Angular momentum".

use super::{State, System};
use crate::math::compensated::sum;
use crate::math::{Vec3, rotation};

/// Energy in its parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Energy {
    /// Sum of the three parts.
    pub total: f64,
    /// Kinetic energy of the centres.
    pub translational: f64,
    /// Kinetic energy of the spins.
    pub rotational: f64,
    /// Potential energy, negative.
    pub potential: f64,
}

impl Energy {
    /// From the parts.
    pub fn new(translational: f64, rotational: f64, potential: f64) -> Self {
        Self { total: sum([translational, rotational, potential]), translational, rotational, potential }
    }
}

pub(super) fn energy(system: &System, state: &State, potential: f64) -> Energy {
    let bodies = system.bodies();
    let translational = bodies.iter().zip(&state.velocity).map(|(b, v)| 0.5 * b.mass * v.norm_squared());
    let rotational = bodies.iter().zip(&state.spin).map(|(b, s)| 0.5 * b.inertia().dot(&s.component_mul(s)));
    Energy::new(sum(translational), sum(rotational), potential)
}

pub(super) fn momentum(system: &System, state: &State) -> Vec3 {
    Vec3::from(
        [0, 1, 2].map(|c| sum(system.bodies().iter().zip(&state.velocity).map(|(b, v)| b.mass * v[c]))),
    )
}

pub(super) fn angular_momentum(system: &System, state: &State) -> Vec3 {
    let of_body = |i: usize| {
        let body = &system.bodies()[i];
        let orbital = state.position[i].cross(&state.velocity[i]) * body.mass;
        orbital + rotation::matrix(state.attitude[i]) * body.inertia().component_mul(&state.spin[i])
    };
    Vec3::from([0, 1, 2].map(|c| sum((0..state.bodies()).map(|i| of_body(i)[c]))))
}
