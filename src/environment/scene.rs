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
    /// Centres from the nominal barycentre, inertial axes.
    pub position: Vec<Vec3>,
    /// Their velocities relative to it.
    pub velocity: Vec<Vec3>,
    /// Attitudes; kept up only where [`super::Environment::wants_attitudes`].
    pub attitude: Vec<[f64; 4]>,
    /// Rotation matrices from body frames to inertial axes.
    pub rotation: Vec<Mat3>,
    /// Spins, body frames.
    pub spin: Vec<Vec3>,
    /// The nominal barycentre in the coordinates of the states.
    pub origin: Vec3,
    /// Its velocity.
    pub origin_velocity: Vec3,
}

impl Scene {
    /// Of so many bodies.
    pub fn new(bodies: usize) -> Self {
        let zeros = vec![Vec3::zeros(); bodies];
        Self {
            position: zeros.clone(),
            velocity: zeros.clone(),
            attitude: vec![[1.0, 0.0, 0.0, 0.0]; bodies],
            rotation: vec![Mat3::identity(); bodies],
            spin: zeros,
            ..Self::default()
        }
    }

    /// Position and velocity of a body relative to another.
    #[inline(always)]
    pub(super) fn relative(&self, body: usize, about: usize) -> (Vec3, Vec3) {
        (self.position[body] - self.position[about], self.velocity[body] - self.velocity[about])
    }

    /// Angular velocity of a body, inertial axes.
    #[inline(always)]
    pub(super) fn inertial_spin(&self, body: usize) -> Vec3 {
        turned(&self.rotation[body], &self.spin[body])
    }
}

/// What one force does to the bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Loads {
    /// Forces, inertial.
    pub force: Vec<Vec3>,
    /// Torques about the bodies' centres, body frames.
    pub torque: Vec<Vec3>,
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
