//! The positions of two parts in their bodies, and what becomes of the parts' loads there.

use super::{Interaction, Jacobian, Pose};
use crate::math::rotation::{rotate, rotate_back};
use crate::math::{Mat3, Vec3};
use crate::shape::{PartDerivative, Placement};

/// Two parts of two bodies.
#[derive(Debug, Clone)]
pub(super) struct PartOffsets {
    /// The indices of the parts in their bodies.
    pub parts: [usize; 2],
    /// The product of the parts' shares of the masses of their bodies.
    pub share: f64,
    pub placements: [Option<Placement>; 2],
}

impl PartOffsets {
    /// Returns the vector from the first part's centre to the second's.
    #[inline(never)]
    pub fn separation(&self, pose: &Pose) -> Vec3 {
        let mut separation = pose.separation;
        if let Some(placement) = &self.placements[0] {
            separation -= rotate(&pose.rotation_first, &placement.position);
        }
        if let Some(placement) = &self.placements[1] {
            separation += rotate(&pose.rotation_second, &placement.position);
        }
        separation
    }

    #[inline]
    pub fn pose(&self, pose: &Pose) -> Pose {
        let mut part_pose = Pose { separation: self.separation(pose), ..*pose };
        if let Some(placement) = &self.placements[0] {
            part_pose.rotation_first *= placement.rotation;
        }
        if let Some(placement) = &self.placements[1] {
            part_pose.rotation_second *= placement.rotation;
        }
        part_pose
    }

    /// Converts loads about the parts' centres to those about the bodies' centres, in the bodies' frames.
    #[inline]
    pub fn about_centres(&self, pose: &Pose, parts: Interaction) -> Interaction {
        let force = parts.force_on_first * self.share;
        let about = |placement: &Option<Placement>, rotation, torque: Vec3, force: Vec3| match placement {
            None => torque * self.share,
            Some(placement) => {
                rotate(&placement.rotation, &torque) * self.share
                    + placement.position.cross(&rotate_back(rotation, &force))
            }
        };
        Interaction {
            force_on_first: force,
            torque_first: about(&self.placements[0], &pose.rotation_first, parts.torque_first, force),
            torque_second: about(&self.placements[1], &pose.rotation_second, parts.torque_second, -force),
        }
    }

    /// Converts derivatives about the parts' centres to those about the bodies' centres. The parts'
    /// separation changes with the bodies' rotations by A_i = dr/dv_i = +-R_i [p_i]x.
    pub fn jacobian_about_centres(&self, pose: &Pose, parts: &Jacobian) -> Jacobian {
        let rotations = [&pose.rotation_first, &pose.rotation_second];
        let signs = [1.0, -1.0];
        let part_rotations =
            [0, 1].map(|i| self.placements[i].map_or(Mat3::identity(), |placement| placement.rotation));
        let lever = [0, 1]
            .map(|i| self.placements[i].map_or(Mat3::zeros(), |placement| placement.position.cross_matrix()));
        let k = &parts.force_by_separation;
        let force = parts.loads.force_on_first;
        let moved = [0, 1].map(|i| rotations[i] * lever[i] * signs[i]);
        let force_by_rotation = [0, 1].map(|i| {
            k * moved[i] - parts.torque_by_separation[i].transpose() * part_rotations[i].transpose()
        });
        let by_separation = [0, 1].map(|i| {
            part_rotations[i] * parts.torque_by_separation[i]
                + lever[i] * rotations[i].transpose() * k * signs[i]
        });
        let torque_by_rotation = [0, 1].map(|i| {
            let part_torque_by_rotation = parts.torque_by_separation[i] * moved[i]
                + parts.torque_by_rotation[i] * part_rotations[i].transpose();
            let attraction = (rotations[i].transpose() * force).cross_matrix()
                + rotations[i].transpose() * force_by_rotation[i];
            (part_rotations[i] * part_torque_by_rotation + lever[i] * attraction * signs[i]) * self.share
        });
        let other = parts.torque_by_separation[0] * moved[1]
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

    /// With s the separation of the parts, dP the displacement of this part and phi its rotation, ds = -+R
    /// dP, and the rotation is Q^T phi in the part's own frame, with Q the rotation from there to the body's
    /// frame.
    pub fn by_part(&self, pose: &Pose, parts: &Jacobian, which: usize, by: &PartDerivative) -> Interaction {
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
        let step = rotate(rotation, &position) * -sign;
        let spin = rotate_back(&part_rotation, &by.rotation_change);
        let [first, second] = &parts.torque_by_separation;
        let torque_change = if which == 0 {
            [torque_by_rotation * spin, crossed.transpose() * spin]
        } else {
            [crossed * spin, torque_by_rotation * spin]
        };
        let loads = &parts.loads;
        let changed = Interaction {
            force_on_first: parts.force_by_separation * step
                - parts.torque_by_separation[which].transpose() * spin
                + loads.force_on_first * mass,
            torque_first: first * step + torque_change[0] + loads.torque_first * mass,
            torque_second: second * step + torque_change[1] + loads.torque_second * mass,
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
