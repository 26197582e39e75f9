//! The mean force and torque of sunlight on a synchronous secondary (BYORP).
//!
//! They are means over the secondary's orbit and over the orbit round the Sun. A secondary that keeps one side
//! towards the other body also keeps its faces in the same places of its orbit, and what remains of the force
//! and the torque is constant in its body frame: M. Cuk & J. A. Burns (2005), Icarus 176, 418, and J. McMahon &
//! D. Scheeres (2010), Icarus 209, 494.
//!
//! The components refer to the principal axes, whose signs follow from the side that faces the other body: the
//! long axis points away from it, the short axis to the side of the orbit's normal, and the middle axis, which
//! completes them, along the motion. While the secondary is locked these signs do not change.

use super::evaluator::Evaluator;
use super::lock::Lock;
use super::snapshot::{Load, MotionSnapshot, Switch, two_indices};
use super::{BodyBlock, ForceParameter, LoadJacobian};
use crate::error::{Result, require_finite};
use crate::math::matrix::times_cross;
use crate::math::rotation::rotate;
use crate::math::{Mat3, Vec3};
use crate::shape::Body;
use serde::{Deserialize, Deserializer, Serialize};

/// The mean force and torque of radiation on a synchronous secondary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Byorp {
    /// The name of the force.
    pub name: String,
    /// The name of the secondary.
    pub on: String,
    /// The name of the body about which it moves.
    pub about: String,
    /// The force along the secondary's long axis, away from the other body, along its middle axis, in the
    /// direction of its motion, and along its short axis, to the side of the orbit's normal. A description may
    /// give the second one alone.
    #[serde(deserialize_with = "components")]
    pub force: [f64; 3],
    /// The torque about the secondary's centre along the same axes.
    #[serde(default)]
    pub torque: [f64; 3],
}

fn components<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<[f64; 3], D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum ForceInput {
        Along(f64),
        All([f64; 3]),
    }
    Ok(match ForceInput::deserialize(deserializer)? {
        ForceInput::Along(force) => [0.0, force, 0.0],
        ForceInput::All(force) => force,
    })
}

impl Byorp {
    /// Returns an error for numbers that no such force has, whatever system it acts in.
    pub(super) fn check(&self) -> Result<()> {
        require_finite(&format!("force of {}", self.name), &self.force)?;
        require_finite(&format!("torque of {}", self.name), &self.torque)
    }

    pub(super) fn prepared(
        &self,
        of: usize,
        bodies: &[Body],
        gravitational_constant: f64,
    ) -> Result<ByorpForce> {
        let name = &self.name;
        let (on, about) = two_indices(name, ["on", "about"], [&self.on, &self.about], bodies)?;
        self.check()?;
        Ok(ByorpForce {
            lock: Lock::new(name, [on, about], bodies, gravitational_constant)?,
            force: self.force.into(),
            torque: self.torque.into(),
            state: None,
            lowest: f64::INFINITY,
            loads: [Load::none(of, on, self.torque != [0.0; 3])],
        })
    }
}

/// The evaluator of a force and torque of radiation.
#[derive(Debug, Clone)]
pub(super) struct ByorpForce {
    pub lock: Lock,
    force: Vec3,
    torque: Vec3,
    /// The switch of the force; `None` before the first state has decided whether the force acts.
    pub state: Option<Switch>,
    /// The smallest margin before a switch at all evaluations of the present step.
    lowest: f64,
    loads: [Load; 1],
}

/// The least margin of a step's evaluations with which the step contains no switch: evaluations are more
/// closely spaced than the samples by which switches are searched.
const FAR: f64 = 0.05;

impl ByorpForce {
    /// Returns whether the force acts.
    #[inline(always)]
    fn acts(&self) -> bool {
        self.state.is_none_or(|switch| switch.on)
    }

    /// Returns whether an evaluation of the present step came near a switch.
    pub fn nears_switch(&self) -> bool {
        let far = self.lowest > FAR;
        !far
    }

    /// Returns how far a state is from the next switch: below zero where it is beyond the switch by more than
    /// rounding.
    #[inline(always)]
    pub fn margin(&self, snapshot: MotionSnapshot) -> f64 {
        let margin = self.lock.margin(snapshot);
        if self.acts() { margin + self.lock.rounding() } else { self.lock.rounding() - margin }
    }

    /// Switches the force.
    pub fn switch(&mut self) {
        if let Some(switch) = &mut self.state {
            switch.times += u64::from(switch.on);
            switch.on = !switch.on;
        }
    }

    /// Returns what the next switch adds to the force, inertial, and to the torque, body frame.
    pub fn jump(&self, snapshot: MotionSnapshot) -> [Vec3; 2] {
        let sign = if self.acts() { -1.0 } else { 1.0 };
        let axes = self.axes(snapshot) * sign;
        [rotate(&snapshot.rotation[self.lock.on], &(axes * self.force)), axes * self.torque]
    }

    /// Returns the axes to which the components refer, body frame, in columns.
    #[inline(always)]
    fn axes(&self, snapshot: MotionSnapshot) -> Mat3 {
        let (r, v) = snapshot.relative(self.lock.on, self.lock.about);
        let rotation = &snapshot.rotation[self.lock.on];
        let towards = |axis: usize, direction: &Vec3| {
            let mut unit = Vec3::zeros();
            unit[axis] = 1.0_f64.copysign(rotation.column(axis).dot(direction));
            unit
        };
        let [long, _, short] = self.lock.axes;
        let (outwards, up) = (towards(long, &r), towards(short, &r.cross(&v)));
        Mat3::from_columns(&[outwards, up.cross(&outwards), up])
    }
}

impl Evaluator for ByorpForce {
    #[inline(always)]
    fn loads(&self) -> &[Load] {
        &self.loads
    }

    /// Decides at the first state whether the force acts; later its switches decide.
    fn begin_step(&mut self, _: &str, snapshot: MotionSnapshot, _: f64) -> Result<()> {
        self.lowest = f64::INFINITY;
        self.state.get_or_insert(Switch { on: self.lock.margin(snapshot) > 0.0, times: 0 });
        Ok(())
    }

    #[inline(always)]
    fn compute(&mut self, snapshot: MotionSnapshot) {
        self.lowest = self.lowest.min(self.margin(snapshot));
        let axes = if self.acts() { self.axes(snapshot) } else { Mat3::zeros() };
        let load = &mut self.loads[0];
        load.force = rotate(&snapshot.rotation[self.lock.on], &(axes * self.force));
        load.torque = axes * self.torque;
    }

    /// Takes the force along the motion for the parameter.
    fn unit(&self, _: ForceParameter) -> Option<Self> {
        Some(Self { force: Vec3::y(), torque: Vec3::zeros(), ..self.clone() })
    }

    /// Adds the derivatives of the force R f, with f constant in the body frame: dR = R [theta]x.
    fn add_jacobian(&mut self, _: &str, snapshot: MotionSnapshot, jacobian: &mut LoadJacobian) -> Result<()> {
        if self.acts() {
            let on = self.lock.on;
            let force = self.axes(snapshot) * self.force;
            let by_rotation = times_cross(&snapshot.rotation[on], &force);
            jacobian.add(BodyBlock::translation(on), BodyBlock::rotation(on), &by_rotation, -1.0);
        }
        Ok(())
    }
}
