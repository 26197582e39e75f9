//! The bodies at one time in the form that external forces take, and the loads that the forces exert.

use crate::error::{Error, Result};
use crate::math::rotation::rotate;
use crate::math::{Mat3, Vec3};
use crate::shape::Body;
use serde::{Deserialize, Serialize};

/// The bodies at a time in the form that external forces take.
#[derive(Debug, Clone, Copy)]
pub struct MotionSnapshot<'a> {
    /// The time.
    pub time: f64,
    /// Centres relative to the barycentre, inertial axes.
    pub position: &'a [[f64; 3]],
    /// Velocities relative to the barycentre.
    pub velocity: &'a [[f64; 3]],
    /// Spins, body frames.
    pub spin: &'a [[f64; 3]],
    /// Rotation matrices from the body frames to inertial axes.
    pub rotation: &'a [Mat3],
    /// Attitudes; empty unless `needs_attitudes`.
    pub attitude: &'a [[f64; 4]],
    /// Position and velocity of the barycentre relative to the nominal one.
    pub barycentre_offset: [Vec3; 2],
    /// Position and velocity of the nominal barycentre in the coordinates of the states.
    pub nominal: [Vec3; 2],
}

impl MotionSnapshot<'_> {
    /// Returns the position of a body's centre relative to the nominal barycentre.
    #[inline(always)]
    pub(super) fn position_from_barycentre(&self, body: usize) -> Vec3 {
        self.barycentre_offset[0] + Vec3::from(self.position[body])
    }

    /// Returns position and velocity of a body relative to another one.
    #[inline(always)]
    pub(super) fn relative(&self, body: usize, about: usize) -> (Vec3, Vec3) {
        let between = |of: &[[f64; 3]]| Vec3::from(of[body]) - Vec3::from(of[about]);
        (between(self.position), between(self.velocity))
    }

    /// Returns the angular velocity of a body, inertial axes.
    #[inline(always)]
    pub(super) fn inertial_spin(&self, body: usize) -> Vec3 {
        rotate(&self.rotation[body], &Vec3::from(self.spin[body]))
    }
}

/// The load of one force on one of the bodies on which it acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// The index of the force in the list of forces.
    pub of: usize,
    /// The index of the body.
    pub on: usize,
    /// The force, inertial.
    pub force: Vec3,
    /// The torque about the body's centre, body frame.
    pub torque: Vec3,
    /// Whether the force can exert a torque on the body.
    pub can_rotate: bool,
}

impl Load {
    /// Returns a load of zero, of this force on this body.
    pub(super) fn none(of: usize, on: usize, can_rotate: bool) -> Self {
        Self { of, on, force: Vec3::zeros(), torque: Vec3::zeros(), can_rotate }
    }
}

/// A receiver of the loads of each force, as soon as they have been computed.
pub trait LoadSink {
    /// Receives the loads of one force.
    fn take(&mut self, loads: &[Load]);
}

impl LoadSink for () {
    fn take(&mut self, _: &[Load]) {}
}

/// The switch of a force, with a count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Switch {
    /// Whether the force acts.
    pub on: bool,
    /// How often the force was switched off.
    pub times: u64,
}

/// Returns the index of a body that a force names.
pub(super) fn body_index(force: &str, role: &str, name: &str, bodies: &[Body]) -> Result<usize> {
    bodies.iter().position(|body| body.name == name).ok_or_else(|| {
        let names: Vec<_> = bodies.iter().map(|body| body.name.as_str()).collect();
        Error::invalid(format!("{role} of {force}"), format!("{name:?}"), format!("one of {names:?}"))
    })
}

/// Returns the index of a body on which a force exerts a torque.
pub(super) fn index_of_extended(force: &str, role: &str, name: &str, bodies: &[Body]) -> Result<usize> {
    let index = body_index(force, role, name, bodies)?;
    if bodies[index].inertia() == Vec3::zeros() {
        let expected = "a body with extent, which a torque can turn";
        return Err(Error::invalid(format!("{role} of {force}"), format!("the point {name}"), expected));
    }
    Ok(index)
}

/// Returns the indices of two bodies that a force names.
pub(super) fn two_indices(
    force: &str,
    [first_role, second_role]: [&str; 2],
    [first, second]: [&str; 2],
    bodies: &[Body],
) -> Result<(usize, usize)> {
    let (i, j) =
        (body_index(force, first_role, first, bodies)?, body_index(force, second_role, second, bodies)?);
    if i == j {
        let what = format!("{first_role} and {second_role} of {force}");
        return Err(Error::invalid(what, format!("{first:?} twice"), "two bodies"));
    }
    Ok((i, j))
}
