//! The pair of a part of one body and a part of another, with the parts' positions in their bodies.

use super::part_offsets::PartOffsets;
use super::{Interaction, Jacobian, Method, Pair, PartGravity, Pose, ShapeDerivatives, Store};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::Mat3;
use crate::math::rotation::{rotate, rotate_back};
use crate::quadrature::Order;
use crate::shape::{Body, Part, PartDerivative, Shape};
use pulp::Arch;
use std::ops::Range;
use std::sync::Arc;

/// The least tolerance of a force: focal and surface rules reach round-off there, so that a smaller one gains
/// nothing.
pub const LEAST_TOLERANCE: f64 = 1e-16;

/// The pair of two parts of two bodies. Its methods take and return quantities of the bodies: the bodies'
/// pose, and the loads about their centres per unit of their masses.
#[derive(Debug, Clone)]
pub struct Link {
    /// The pair of the shapes.
    pub pair: Pair,
    /// The parts' positions in their bodies; `None` for two ordinary bodies.
    offsets: Option<Box<PartOffsets>>,
    /// One over the masses of the bodies.
    inverse_masses: [f64; 2],
}

/// The predicted motion of two bodies in the time for which a rule is chosen.
#[derive(Debug, Clone, Copy)]
pub struct PredictedMotion {
    /// The least separation of their centres.
    pub reach: f64,
    /// The angle by which each body rotates, in rad.
    pub rotation_angles: [f64; 2],
    /// The factor by which the bodies would have to grow to touch; infinite where it is not known.
    pub growth: f64,
}

/// The error that two parts are nearer to each other than the least separation for which the rule in use is
/// valid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TooNear {
    /// The separation of the parts' centres.
    pub separation: f64,
    /// The least separation for which the rule is valid.
    pub valid_from: f64,
}

impl Link {
    /// Returns the numbers of parts of two bodies that form links: one each where the bodies count as points.
    pub fn parts_of(bodies: [&Body; 2], method: Method) -> [usize; 2] {
        if method == Method::Point { [1; 2] } else { bodies.map(|body| body.parts().len()) }
    }

    /// Makes the link of two parts, given by their indices in the bodies. `tolerance` is relative to the
    /// force between the bodies.
    pub fn new(
        bodies: [&Body; 2],
        parts: [usize; 2],
        method: Method,
        tolerance: f64,
        fixed: Option<Order>,
        arch: Arch,
        store: &Arc<Store>,
    ) -> Self {
        let pair = |[first, second]: [PartGravity; 2], tolerance| {
            Pair::new(first, second, method, tolerance, fixed, arch)
        };
        let inverse_masses = bodies.map(|body| 1.0 / body.mass);
        if method == Method::Point {
            let points = bodies.map(|body| PartGravity::new(&body.name, &Shape::Point, store));
            return Self { pair: pair(points, tolerance), offsets: None, inverse_masses };
        }
        let [first, second] = [0, 1].map(|k| &bodies[k].parts()[parts[k]]);
        let gravity =
            [gravity(bodies[0], parts[0], first, store), gravity(bodies[1], parts[1], second, store)];
        if first.placement.is_none() && second.placement.is_none() {
            return Self { pair: pair(gravity, tolerance), offsets: None, inverse_masses };
        }
        // The forces of voids and of the matter around them cancel, but their errors do not.
        let terms = bodies.map(|body| body.mass_without_signs() / body.mass);
        let tolerance = (tolerance / (terms[0] * terms[1])).max(tolerance.min(LEAST_TOLERANCE));
        let share = (first.mass / bodies[0].mass) * (second.mass / bodies[1].mass);
        let offsets = Box::new(PartOffsets { parts, share, placements: [first.placement, second.placement] });
        Self { pair: pair(gravity, tolerance), offsets: Some(offsets), inverse_masses }
    }

    /// Chooses the rule for a pose, and for the predicted motion from there. It may allocate and is called
    /// between steps only.
    pub fn prepare(
        &mut self,
        pose: &Pose,
        predicted: Option<&PredictedMotion>,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let part_pose = self.pose(pose);
        let closing = match predicted {
            Some(predicted) => self.closing(pose, &part_pose, predicted, interrupt)?,
            None => 0.0,
        };
        self.pair.prepare(&part_pose, closing, interrupt)
    }

    /// Returns the share of the parts' separation that may close without overlap.
    fn closing(
        &self,
        pose: &Pose,
        part_pose: &Pose,
        predicted: &PredictedMotion,
        interrupt: &mut InterruptCheck,
    ) -> Result<f64> {
        let distance = part_pose.separation.norm();
        let (mut reach, mut growth) = (predicted.reach, predicted.growth);
        if let Some(offsets) = &self.offsets {
            // A chord is at most as long as its arc, and at most two radii long.
            let swing = |body: usize| {
                predicted.rotation_angles[body].min(2.0)
                    * offsets.placements[body].map_or(0.0, |placement| placement.position.norm())
            };
            reach = distance - (pose.separation.norm() - predicted.reach) - swing(0) - swing(1);
            growth = f64::INFINITY;
        }
        let touching = if reach > self.pair.contact_distance() {
            0.0
        } else if growth.is_finite() {
            1.0 / growth
        } else {
            1.0 / self.pair.growth(part_pose, interrupt)?
        };
        Ok((1.0 - (reach / distance).max(touching)).clamp(0.0, 0.5))
    }

    /// Returns whether the parts are nearer to each other than the rule in use is valid for.
    #[inline(always)]
    pub fn too_near(&self, pose: &Pose) -> Option<TooNear> {
        let separation = match &self.offsets {
            None => pose.separation.norm(),
            Some(offsets) => offsets.separation(pose).norm(),
        };
        if self.pair.covers(separation) {
            return None;
        }
        Some(TooNear { separation, valid_from: self.pair.valid_from() })
    }

    /// Returns the contribution of this link to the force on the bodies' centres and the torques about them,
    /// with the rule in use.
    pub fn interaction(&self, pose: &Pose) -> Interaction {
        self.interaction_of(pose, Pair::ALL)
    }

    /// Returns the contribution of one of the [`Pair::pieces`].
    pub fn interaction_of(&self, pose: &Pose, nodes: Range<usize>) -> Interaction {
        match &self.offsets {
            None => self.pair.interaction_of(pose, nodes),
            Some(offsets) => {
                offsets.about_centres(pose, self.pair.interaction_of(&offsets.pose(pose), nodes))
            }
        }
    }

    /// Chooses the nodes for [`Self::jacobian`]; see [`Pair::prepare_jacobian`].
    pub fn prepare_jacobian(
        &mut self,
        pose: &Pose,
        lengths: bool,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        self.pair.prepare_jacobian(&self.pose(pose), lengths, interrupt)
    }

    /// Returns the derivatives of force and torques of the parts, about their own centres.
    #[inline]
    pub fn jacobian_of_parts(&self, pose: &Pose, interrupt: &mut InterruptCheck) -> Result<Jacobian> {
        match &self.offsets {
            None => self.pair.jacobian(pose, interrupt),
            Some(offsets) => self.pair.jacobian(&offsets.pose(pose), interrupt),
        }
    }

    /// Returns the contribution of this link to the derivatives of force and torques of the bodies, from the
    /// derivatives of the parts.
    #[inline]
    pub fn about_centres(&self, pose: &Pose, parts: &Jacobian) -> Jacobian {
        self.offsets.as_ref().map_or(*parts, |offsets| offsets.jacobian_about_centres(pose, parts))
    }

    /// Returns the contribution of this link to the derivatives of the bodies' loads with respect to a number
    /// of a part of the first (0) or the second (1) body, from the derivatives of the parts with respect to
    /// the pose; per unit G m_first m_second at fixed masses.
    pub fn by_part(&self, pose: &Pose, parts: &Jacobian, which: usize, by: &PartDerivative) -> Interaction {
        match &self.offsets {
            None => parts.loads.times(by.mass * self.inverse_masses[which]),
            Some(offsets) => offsets.by_part(pose, parts, which, by),
        }
    }

    /// Returns the contribution of this link to the derivatives of the bodies' loads with respect to the
    /// lengths of its parts.
    pub fn shape_derivatives(&self, pose: &Pose, interrupt: &mut InterruptCheck) -> Result<ShapeDerivatives> {
        match &self.offsets {
            None => self.pair.shape_derivatives(pose, interrupt),
            Some(offsets) => {
                let parts = self.pair.shape_derivatives(&offsets.pose(pose), interrupt)?;
                Ok(parts.map(|loads| offsets.about_centres(pose, loads)))
            }
        }
    }

    /// Returns the contribution of this link to the derivatives of the bodies' loads as [`Pair::by_moment`].
    pub fn by_moment(&self, pose: &Pose, body: usize, index: usize) -> Interaction {
        match &self.offsets {
            None => self.pair.by_moment(pose, body, index),
            Some(offsets) => {
                offsets.about_centres(pose, self.pair.by_moment(&offsets.pose(pose), body, index))
            }
        }
    }

    /// Returns the indices of the parts in their bodies; `None` for two ordinary bodies.
    pub fn parts(&self) -> Option<[usize; 2]> {
        self.offsets.as_ref().map(|offsets| offsets.parts)
    }

    /// Returns the number of points as [`Pair::points`].
    pub fn points(&self, pose: &Pose) -> Option<usize> {
        self.pair.points(&self.pose(pose))
    }

    /// Returns the pair of two ordinary bodies, whose interaction is that of this link.
    #[inline]
    pub fn ordinary(&self) -> Option<&Pair> {
        self.offsets.is_none().then_some(&self.pair)
    }

    /// Returns the truncation error as [`Pair::truncation_error`], for this link's contribution to the force
    /// between the bodies.
    pub fn truncation_error(&self, pose: &Pose) -> Option<f64> {
        match &self.offsets {
            None => self.pair.truncation_error(pose),
            Some(offsets) => Some(offsets.share.abs() * self.pair.truncation_error(&offsets.pose(pose))?),
        }
    }

    /// Returns the contribution of this link to the potential energy per unit G m m.
    pub fn potential_energy(&self, pose: &Pose) -> f64 {
        let (pose, share) = self.part_pose_and_share(pose);
        share * self.pair.potential_energy_of(&pose, Pair::ALL)
    }

    /// Adds the contribution of this link to the potential energy, times a strength, piece by piece.
    pub fn add_energy(
        &self,
        pose: &Pose,
        strength: f64,
        sum: &mut f64,
        time: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let (pose, share) = self.part_pose_and_share(pose);
        let pieces = self.pair.energy_pieces(&pose, interrupt)?;
        let work = self.pair.work() / pieces.len() as u64;
        for nodes in pieces {
            interrupt.charge(work, time)?;
            *sum += strength * (share * self.pair.potential_energy_of(&pose, nodes));
        }
        Ok(())
    }

    /// Returns the pose of the two parts, and their share of the interaction.
    fn part_pose_and_share(&self, pose: &Pose) -> (Pose, f64) {
        self.offsets.as_ref().map_or((*pose, 1.0), |offsets| (offsets.pose(pose), offsets.share))
    }

    fn pose(&self, pose: &Pose) -> Pose {
        self.offsets.as_ref().map_or(*pose, |offsets| offsets.pose(pose))
    }
}

impl PartOffsets {
    /// Converts derivatives about the parts' centres to those about the bodies' centres. The parts'
    /// separation changes with the bodies' rotations by A_i = dr/dv_i = +-R_i [p_i]x.
    pub(super) fn jacobian_about_centres(&self, pose: &Pose, parts: &Jacobian) -> Jacobian {
        let rotations = [&pose.rotation_first, &pose.rotation_second];
        let signs = [1.0, -1.0];
        let part_rotations =
            [0, 1].map(|i| self.placements[i].map_or(Mat3::identity(), |placement| placement.rotation));
        let lever = [0, 1]
            .map(|i| self.placements[i].map_or(Mat3::zeros(), |placement| placement.position.cross_matrix()));
        let k = &parts.force_by_separation;
        let force = parts.loads.force_on_first;
        let separation_by_rotation = [0, 1].map(|i| rotations[i] * lever[i] * signs[i]);
        let force_by_rotation = [0, 1].map(|i| {
            k * separation_by_rotation[i]
                - parts.torque_by_separation[i].transpose() * part_rotations[i].transpose()
        });
        let by_separation = [0, 1].map(|i| {
            part_rotations[i] * parts.torque_by_separation[i]
                + lever[i] * rotations[i].transpose() * k * signs[i]
        });
        let torque_by_rotation = [0, 1].map(|i| {
            let part_torque_by_rotation = parts.torque_by_separation[i] * separation_by_rotation[i]
                + parts.torque_by_rotation[i] * part_rotations[i].transpose();
            let attraction = (rotations[i].transpose() * force).cross_matrix()
                + rotations[i].transpose() * force_by_rotation[i];
            (part_rotations[i] * part_torque_by_rotation + lever[i] * attraction * signs[i]) * self.share
        });
        let other = parts.torque_by_separation[0] * separation_by_rotation[1]
            + parts.torque_first_by_second * part_rotations[1].transpose();
        let first_by_second =
            part_rotations[0] * other + lever[0] * rotations[0].transpose() * force_by_rotation[1];
        Jacobian {
            loads: self.about_centres(pose, parts.loads),
            force_by_separation: k * self.share,
            torque_by_separation: by_separation.map(|block| block * self.share),
            torque_by_rotation,
            torque_first_by_second: first_by_second * self.share,
        }
    }

    /// Returns the derivatives of the bodies' loads with respect to a number of a part.
    ///
    /// With s the separation of the parts, dP the displacement of this part and phi its rotation, ds = -+R dP, and the
    /// rotation is Q^T phi in the part's frame, with Q the rotation from the part's frame to the body's frame.
    pub(super) fn by_part(
        &self,
        pose: &Pose,
        parts: &Jacobian,
        which: usize,
        by: &PartDerivative,
    ) -> Interaction {
        let (torque_by_rotation, rotation, sign) = match which {
            0 => (parts.torque_by_rotation[0], &pose.rotation_first, 1.0),
            _ => (parts.torque_by_rotation[1], &pose.rotation_second, -1.0),
        };
        let crossed = parts.torque_first_by_second;
        let (position, part_rotation) = (
            by.positions[self.parts[which]],
            self.placements[which].map_or(Mat3::identity(), |p| p.rotation),
        );
        let mass = if self.parts[which] == by.part { by.relative_mass } else { 0.0 };
        let displacement = rotate(rotation, &position) * -sign;
        let part_rotation_change = rotate_back(&part_rotation, &by.rotation_change);
        let [first, second] = &parts.torque_by_separation;
        let torque_change = if which == 0 {
            [torque_by_rotation * part_rotation_change, crossed.transpose() * part_rotation_change]
        } else {
            [crossed * part_rotation_change, torque_by_rotation * part_rotation_change]
        };
        let loads = &parts.loads;
        let changed = Interaction {
            force_on_first: parts.force_by_separation * displacement
                - parts.torque_by_separation[which].transpose() * part_rotation_change
                + loads.force_on_first * mass,
            torque_first: first * displacement + torque_change[0] + loads.torque_first * mass,
            torque_second: second * displacement + torque_change[1] + loads.torque_second * mass,
        };
        let mut changed = self.about_centres(pose, changed);
        let force = rotate_back(rotation, &(loads.force_on_first * (sign * self.share)));
        let torque = if which == 0 { &mut changed.torque_first } else { &mut changed.torque_second };
        let part_torque = if which == 0 { &loads.torque_first } else { &loads.torque_second };
        *torque += by.rotation_change.cross(&rotate(&part_rotation, part_torque)) * self.share
            + position.cross(&force);
        changed
    }
}

/// Returns the state-independent part of a part's gravity, with the name for errors.
fn gravity(body: &Body, index: usize, part: &Part, store: &Arc<Store>) -> PartGravity {
    if part.placement.is_none() {
        return PartGravity::new(&body.name, &part.shape, store);
    }
    PartGravity::new(&format!("part {index} of {}", body.name), &part.shape, store)
}
