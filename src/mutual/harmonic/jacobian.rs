//! The derivatives of force and torques by the harmonic series.
//!
//! The sums contain the derivatives with respect to the separation's length and to rotations of either body
//! about the axes of the line's frame. A displacement across the line is a rotation of both bodies in the
//! opposite sense, followed by a rotation of everything.

use super::{Harmonic, Line, Request, Series, SeriesSums, Truncation};
use crate::math::{Mat3, Vec3};
use crate::mutual::{Jacobian, Pose};

impl Harmonic {
    /// Returns the derivatives of force and torques with respect to the pose.
    pub fn jacobian(&self, truncation: &Truncation, pose: &Pose) -> Jacobian {
        self.series(truncation).jacobian(pose)
    }
}

impl Series<'_> {
    /// Returns the derivatives of force and torques with respect to the pose.
    pub fn jacobian(&self, pose: &Pose) -> Jacobian {
        let line = Line::new(pose);
        line.jacobian(&self.sums(Request::Derivatives, &line))
    }
}

impl Line {
    fn jacobian(&self, sums: &SeriesSums) -> Jacobian {
        let (r, e) = (self.distance, &self.inertial);
        let [first_by_first, crossed, second_by_second] = sums.by_rotation;
        // Row and column: the torque on a body by the rotation of a body.
        let torque_by_rotation = [[first_by_first, crossed], [crossed.transpose(), second_by_second]];
        let (torque, radial) =
            (sums.torques[0] + sums.torques[1], sums.torques_radial[0] + sums.torques_radial[1]);
        let force = self.force(sums);
        let force_by_rotation = [0, 1].map(|body| {
            let total = torque_by_rotation[0][body] + torque_by_rotation[1][body];
            Mat3::from_rows(&[
                -total.row(1),
                total.row(0).into_owned(),
                -sums.torques_radial[body].transpose(),
            ])
        });
        let force_by_distance = Vec3::new(radial.y + torque.y, -radial.x - torque.x, sums.second_radial);
        let force_by_separation = across(&force, &force_by_rotation, force_by_distance);
        let torque_by_separation = [0, 1].map(|body| {
            let along = -sums.torques_radial[body];
            let by_separation = across(&sums.torques[body], &torque_by_rotation[body], along);
            self.bodies[body] * by_separation * e.transpose() / (r * r)
        });
        let loads = self.interaction(sums);
        let torques = [loads.torque_first, loads.torque_second];
        let [first, second] = &self.bodies;
        Jacobian {
            loads,
            force_by_separation: e * force_by_separation * e.transpose() / (-r * r * r),
            torque_by_separation,
            torque_by_rotation: [0, 1].map(|body| {
                let frame = &self.bodies[body];
                frame * torque_by_rotation[body][body] * frame.transpose() / r + torques[body].cross_matrix()
            }),
            torque_first_by_second: first * crossed * second.transpose() / r,
        }
    }
}

/// Returns the derivatives of a vector with respect to the separation, from those with respect to rotations
/// of both bodies and to the distance, in units of the separation.
fn across(vector: &Vec3, by_rotation: &[Mat3; 2], by_distance: Vec3) -> Mat3 {
    let total = by_rotation[0] + by_rotation[1];
    Mat3::from_columns(&[
        Vec3::y().cross(vector) - total.column(1),
        total.column(0) - Vec3::x().cross(vector),
        by_distance,
    ])
}
