//! What the forces are told of the bodies, and what they answer.

use crate::error::{Error, Result};
use crate::math::rotation::turned;
use crate::math::{Mat3, Vec3};
use crate::shape::Body;
use serde::{Deserialize, Serialize};

/// The bodies at a time, as forces see them.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Time.
    pub time: f64,
    /// The bodies.
    pub bodies: Vec<Actor>,
    /// The nominal barycentre in the coordinates of the states.
    pub origin: Vec3,
    /// Its velocity.
    pub origin_velocity: Vec3,
}

/// A body at that time.
#[derive(Debug, Clone, Copy)]
pub struct Actor {
    /// Centre from the nominal barycentre, inertial axes.
    pub position: Vec3,
    /// Velocity relative to it.
    pub velocity: Vec3,
    /// Spin, body frame.
    pub spin: Vec3,
    /// Rotation matrix from the body frame to inertial axes.
    pub rotation: Mat3,
    /// Attitude; kept up only where [`super::Environment::wants_attitudes`].
    pub attitude: [f64; 4],
}

impl Scene {
    /// Of so many bodies.
    pub fn new(bodies: usize) -> Self {
        let zero = Vec3::zeros();
        let (rotation, attitude) = (Mat3::identity(), [1.0, 0.0, 0.0, 0.0]);
        let at_rest = Actor { position: zero, velocity: zero, spin: zero, rotation, attitude };
        Self { bodies: vec![at_rest; bodies], ..Self::default() }
    }
}

impl Actor {
    /// Position and velocity relative to another body.
    #[inline(always)]
    pub(super) fn relative(&self, about: &Self) -> (Vec3, Vec3) {
        (self.position - about.position, self.velocity - about.velocity)
    }

    /// Angular velocity, inertial axes.
    #[inline(always)]
    pub(super) fn inertial_spin(&self) -> Vec3 {
        turned(&self.rotation, &self.spin)
    }
}

/// What one force does to one of the bodies that it acts on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Place of the force in the list of forces.
    pub of: usize,
    /// Place of the body.
    pub on: usize,
    /// The force, inertial.
    pub force: Vec3,
    /// The torque about the body's centre, body frame.
    pub torque: Vec3,
    /// Whether it ever turns the body.
    pub turns: bool,
}

/// Whether a force acts, and how often it has been switched off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Switch {
    /// Whether it acts.
    pub on: bool,
    /// How often it was switched off.
    pub times: u64,
}

/// The place of a body that a force names.
pub(super) fn place(force: &str, role: &str, name: &str, bodies: &[Body]) -> Result<usize> {
    bodies.iter().position(|body| body.name == name).ok_or_else(|| {
        let names: Vec<_> = bodies.iter().map(|body| body.name.as_str()).collect();
        Error::invalid(format!("{role} of {force}"), format!("{name:?}"), format!("one of {names:?}"))
    })
}

/// The place of a body that a force turns.
pub(super) fn place_to_turn(force: &str, role: &str, name: &str, bodies: &[Body]) -> Result<usize> {
    let at = place(force, role, name, bodies)?;
    if bodies[at].inertia() == Vec3::zeros() {
        let expected = "a body with extent, which a torque can turn";
        return Err(Error::invalid(format!("{role} of {force}"), format!("the point {name}"), expected));
    }
    Ok(at)
}

/// Two places of bodies that a force names.
pub(super) fn two_places(
    force: &str,
    [first_role, second_role]: [&str; 2],
    [first, second]: [&str; 2],
    bodies: &[Body],
) -> Result<(usize, usize)> {
    let (i, j) = (place(force, first_role, first, bodies)?, place(force, second_role, second, bodies)?);
    if i == j {
        let what = format!("{first_role} and {second_role} of {force}");
        return Err(Error::invalid(what, format!("{first:?} twice"), "two bodies"));
    }
    Ok((i, j))
}
