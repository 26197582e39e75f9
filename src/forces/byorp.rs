//! The mean force and torque of sunlight on a synchronous secondary (BYORP).
//!
//! They are means over the secondary's orbit and over the orbit round the Sun. The attitude of a synchronous
//! secondary is the same at each passage of a point of its orbit. Its mean force and torque are therefore not
//! zero, and constant in its body frame: M. Cuk & J. A. Burns (2005), Icarus 176, 418, and J. McMahon &
//! D. Scheeres (2010), Icarus 209, 494.
//!
//! The components refer to the principal axes, whose signs follow from the side that faces the other body:
//! the long axis points away from it, the short axis to the side of the orbit's normal, and the middle axis,
//! which completes them, along the motion. While the secondary is locked these signs do not change.

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
    /// direction of its motion, and along its short axis, to the side of the orbit's normal. A description
    /// may contain the second one alone.
    #[serde(deserialize_with = "components")]
    pub force: [f64; 3],
    /// The torque about the secondary's centre along the same axes.
    #[serde(default)]
    pub torque: [f64; 3],
}

/// Reads the three components of the force, or the one along the motion alone.
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
    /// Returns an error if a component is not finite; this does not depend on the system.
    pub(super) fn check(&self) -> Result<()> {
        require_finite(&format!("force of {}", self.name), &self.force)?;
        require_finite(&format!("torque of {}", self.name), &self.torque)
    }

    /// Returns the evaluator of the force, which has this index among the external forces.
    pub(super) fn prepared(
        &self,
        index: usize,
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
            loads: [Load::none(index, on, self.torque != [0.0; 3])],
        })
    }
}

/// The evaluator of a force and torque of radiation.
#[derive(Debug, Clone)]
pub(super) struct ByorpForce {
    pub lock: Lock,
    force: Vec3,
    torque: Vec3,
    /// Whether the force acts, and how often it was switched off; `None` before the first state.
    pub state: Option<Switch>,
    /// The smallest margin before a switch of all evaluations in the current step.
    lowest: f64,
    loads: [Load; 1],
}

/// The margin above which, at all evaluations of a step, the step is taken to contain no switch: the
/// evaluations are more closely spaced than the samples with which switches are detected.
const FAR: f64 = 0.05;

impl ByorpForce {
    /// Returns whether the force acts.
    #[inline(always)]
    fn acts(&self) -> bool {
        self.state.is_none_or(|switch| switch.on)
    }

    /// Returns whether an evaluation of the current step came near a switch; NaN counts as near.
    pub fn nears_switch(&self) -> bool {
        let far = self.lowest > FAR;
        !far
    }

    /// Returns the margin of a state before the next switch, which is below zero where the state is beyond
    /// the switch by more than the rounding error.
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

    /// Returns the jumps of the force (inertial frame) and of the torque (body frame) at the next switch.
    pub fn jump(&self, snapshot: MotionSnapshot) -> [Vec3; 2] {
        let sign = if self.acts() { -1.0 } else { 1.0 };
        let axes = self.axes(snapshot) * sign;
        [rotate(&snapshot.rotation[self.lock.on], &(axes * self.force)), axes * self.torque]
    }

    /// Returns the axes to which the components refer, as columns in the body frame.
    #[inline(always)]
    fn axes(&self, snapshot: MotionSnapshot) -> Mat3 {
        let (r, v) = snapshot.relative(self.lock.on, self.lock.about);
        let rotation = &snapshot.rotation[self.lock.on];
        let signed_axis = |axis: usize, direction: &Vec3| {
            let mut unit = Vec3::zeros();
            unit[axis] = 1.0_f64.copysign(rotation.column(axis).dot(direction));
            unit
        };
        let [long, _, short] = self.lock.axes;
        let (outwards, up) = (signed_axis(long, &r), signed_axis(short, &r.cross(&v)));
        Mat3::from_columns(&[outwards, up.cross(&outwards), up])
    }
}

impl Evaluator for ByorpForce {
    #[inline(always)]
    fn loads(&self) -> &[Load] {
        &self.loads
    }

    /// Determines at the first state whether the force acts; later the switches determine it.
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

    /// Returns the force for a parameter of one: the parameter is the component along the motion.
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
