//! What the forces are told of the bodies, and what they answer.

use crate::error::{Error, Result};
use crate::math::rotation::turned;
use crate::math::{Mat3, Vec3};
use crate::shape::Body;
use serde::{Deserialize, Serialize};

/// The bodies at a time, as forces see them.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// Time.
    pub time: f64,
    /// Centres from the barycentre, inertial axes.
    pub position: &'a [[f64; 3]],
    /// Velocities relative to it.
    pub velocity: &'a [[f64; 3]],
    /// Spins, body frames.
    pub spin: &'a [[f64; 3]],
    /// Rotation matrices from the body frames to inertial axes.
    pub rotation: &'a [Mat3],
    /// Attitudes; none unless [`super::Environment::wants_attitudes`].
    pub attitude: &'a [[f64; 4]],
    /// Position and velocity of the barycentre from the nominal one.
    pub departure: [Vec3; 2],
    /// Those of the nominal one in the coordinates of the states.
    pub nominal: [Vec3; 2],
}

impl Scene<'_> {
    /// Where a body's centre is from the nominal barycentre.
    #[inline(always)]
    pub(super) fn place(&self, body: usize) -> Vec3 {
        self.departure[0] + Vec3::from(self.position[body])
    }

    /// Position and velocity of a body relative to another one.
    #[inline(always)]
    pub(super) fn relative(&self, body: usize, about: usize) -> (Vec3, Vec3) {
        let between = |of: &[[f64; 3]]| Vec3::from(of[body]) - Vec3::from(of[about]);
        (between(self.position), between(self.velocity))
    }

    /// Angular velocity of a body, inertial axes.
    #[inline(always)]
    pub(super) fn inertial_spin(&self, body: usize) -> Vec3 {
        turned(&self.rotation[body], &Vec3::from(self.spin[body]))
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

impl Load {
    /// Of a force in the list of forces on a body, which does nothing yet.
    pub(super) fn none(of: usize, on: usize, turns: bool) -> Self {
        Self { of, on, force: Vec3::zeros(), torque: Vec3::zeros(), turns }
    }
}

/// What is done with the loads of each force as soon as they are there.
pub trait TakeLoads {
    /// Takes those of a force.
    fn take(&mut self, loads: &[Load]);
}

impl TakeLoads for () {
    fn take(&mut self, _: &[Load]) {}
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
