//! The positions of two parts in their bodies, and the loads of the bodies from those of the parts.

use super::{Interaction, Pose};
use crate::math::Vec3;
use crate::math::rotation::{rotate, rotate_back};
use crate::shape::Placement;

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

    /// Returns the pose of the two parts.
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
}
