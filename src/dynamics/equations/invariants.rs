//! The conserved quantities: the paper's sections "Total energy" and "Angular momentum".

use super::layout::{BarycentricFrame, vector};
use super::state::State;
use crate::math::compensated::sum;
use crate::math::{Vec3, rotation};
use crate::shape::Body;

/// Energy in its parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Energy {
    /// The sum of the three parts.
    pub total: f64,
    /// The kinetic energy of the centres.
    pub translational: f64,
    /// The kinetic energy of the spins.
    pub rotational: f64,
    /// The potential energy, negative.
    pub potential: f64,
}

impl Energy {
    /// Adds up the energy from its parts.
    pub fn new(translational: f64, rotational: f64, potential: f64) -> Self {
        Self { total: sum([translational, rotational, potential]), translational, rotational, potential }
    }
}

/// The conserved quantities at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Invariants {
    /// The time.
    pub time: f64,
    /// The energy in its parts.
    pub energy: Energy,
    /// The total angular momentum about the origin.
    pub angular_momentum: Vec3,
}

impl Invariants {
    /// Returns time, energies (total, translational, rotational, potential) and angular momentum in a row.
    pub fn numbers(&self) -> [f64; 8] {
        let (e, j) = (&self.energy, &self.angular_momentum);
        [self.time, e.total, e.translational, e.rotational, e.potential, j.x, j.y, j.z]
    }

    /// Restores what [`Self::numbers`] returned.
    pub fn from_numbers([time, total, translational, rotational, potential, x, y, z]: [f64; 8]) -> Self {
        let energy = Energy { total, translational, rotational, potential };
        Self { time, energy, angular_momentum: Vec3::new(x, y, z) }
    }
}

pub(super) fn energy(bodies: &[Body], state: &State, potential: f64) -> Energy {
    let translational = bodies.iter().zip(&state.velocity).map(|(b, v)| 0.5 * b.mass * v.norm_squared());
    let rotational = bodies.iter().zip(&state.spin).map(|(b, s)| 0.5 * b.inertia().dot(&s.component_mul(s)));
    Energy::new(sum(translational), sum(rotational), potential)
}

pub(super) fn momentum(bodies: &[Body], state: &State) -> Vec3 {
    Vec3::from([0, 1, 2].map(|c| sum(bodies.iter().zip(&state.velocity).map(|(b, v)| b.mass * v[c]))))
}

/// Returns the total angular momentum about the origin.
pub(super) fn angular_momentum(bodies: &[Body], state: &State) -> Vec3 {
    total(bodies, |i| {
        angular_momentum_of(
            &bodies[i],
            &state.position[i],
            &state.velocity[i],
            state.attitude[i],
            &state.spin[i],
        )
    })
}

/// Returns the total angular momentum for an integrator's vector. It is the sum of the bodies' angular
/// momentum about the barycentre, the constant angular momentum of the nominal barycentre about the origin,
/// and the contribution of the barycentre offset. Computed from the bodies' absolute positions it would lose
/// digits as the system travels.
pub(super) fn angular_momentum_of_vector(
    bodies: &[Body],
    frame: &BarycentricFrame,
    time: f64,
    y: &[f64],
) -> Vec3 {
    let layout = frame.layout;
    let about_barycentre = total(bodies, |i| {
        angular_momentum_of(
            &bodies[i],
            &vector(y, layout.position(i)),
            &vector(y, layout.velocity(i)),
            frame.attitude(i, y),
            &vector(y, layout.spin(i)),
        )
    });
    let mass = sum(bodies.iter().map(|body| body.mass));
    let nominal = Vec3::from(frame.barycentre).cross(&Vec3::from(frame.barycentre_velocity)) * mass;
    if layout.forces == 0 {
        return about_barycentre + nominal;
    }
    let (offset, offset_rate) = frame.barycentre_offset(y);
    let velocity = Vec3::from(frame.barycentre_velocity) + offset_rate;
    let added = frame.nominal_at(time).cross(&offset_rate) + offset.cross(&velocity);
    about_barycentre + nominal + added * mass
}

fn angular_momentum_of(
    body: &Body,
    position: &Vec3,
    velocity: &Vec3,
    attitude: [f64; 4],
    spin: &Vec3,
) -> Vec3 {
    position.cross(velocity) * body.mass + rotation::matrix(attitude) * body.inertia().component_mul(spin)
}

fn total(bodies: &[Body], of_body: impl Fn(usize) -> Vec3) -> Vec3 {
    Vec3::from([0, 1, 2].map(|c| sum((0..bodies.len()).map(|i| of_body(i)[c]))))
}
