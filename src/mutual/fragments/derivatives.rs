//! The derivatives of force and torques, summed over pairs of fragments, with respect to the pose and to the
//! scales of both polyhedra.

use super::bound::MOST_DEGREES;
use super::{Accuracy, Fragment, Fragments, Step};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::harmonics::{count, scale_degrees};
use crate::math::rotation::{rotate, rotate_back};
use crate::mutual::harmonic::Series;
use crate::mutual::part_offsets::PartOffsets;
use crate::mutual::{Interaction, Jacobian, Pose, ShapeDerivatives};
use std::ops::ControlFlow;

impl Fragments {
    /// Returns the derivatives with respect to the pose; `None` where the tolerance is not kept.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`].
    pub fn jacobian(&self, pose: &Pose, interrupt: &mut InterruptCheck) -> Result<Option<Jacobian>> {
        let mut sum = Jacobian::of_loads(Interaction::ZERO);
        let complete = self.evaluate_interruptibly(pose, interrupt, |series, offsets, part_pose, _| {
            sum.add(&offsets.jacobian_about_centres(pose, &series.jacobian(part_pose)));
        })?;
        Ok(complete.then_some(sum))
    }

    /// Returns the derivatives with respect to factors of all lengths of either polyhedron; `None` where the
    /// tolerance is not kept.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`].
    pub fn shape_derivatives(
        &self,
        pose: &Pose,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<ShapeDerivatives>> {
        let mut out = ShapeDerivatives::ZERO;
        let complete =
            self.evaluate_interruptibly(pose, interrupt, |series, offsets, part_pose, fragments| {
                let parts = series.jacobian(part_pose);
                for (body, sum) in out.scale.iter_mut().enumerate() {
                    sum.add(&by_scale(series, offsets, [pose, part_pose], &parts, body, fragments[body]));
                }
            })?;
        Ok(complete.then_some(out))
    }

    /// Calls a function with the series of each pair of fragments, with interrupt checks. Returns false where the
    /// tolerance is not kept.
    fn evaluate_interruptibly<'a>(
        &'a self,
        pose: &Pose,
        interrupt: &mut InterruptCheck,
        mut add: impl FnMut(&Series<'_>, &PartOffsets, &Pose, [&'a Fragment; 2]),
    ) -> Result<bool> {
        /// The work of the derivatives of a pair in units of that of its loads.
        const GRADIENT: u64 = 3;
        let (mut checked, mut work_left) = (Ok(()), self.most_work());
        let complete = self.walk(pose, Accuracy::Derivatives, &(0..usize::MAX), self.shares, |step| {
            checked = interrupt.charge(GRADIENT * step.work(), 0.0);
            work_left = work_left.saturating_sub(step.work());
            if checked.is_err() || work_left == 0 {
                return ControlFlow::Break(());
            }
            if let Step::Take(pair) = step {
                self.add_pair(pose, pair, &mut add);
            }
            ControlFlow::Continue(())
        });
        checked.map(|()| complete)
    }
}

/// Returns the derivatives of the loads about the polyhedra's centres with respect to the scale of one
/// polyhedron, with which its fragment moves away from the centre and grows.
fn by_scale(
    series: &Series<'_>,
    offsets: &PartOffsets,
    [pose, part_pose]: [&Pose; 2],
    parts: &Jacobian,
    body: usize,
    fragment: &Fragment,
) -> Interaction {
    let (rotation, sign) =
        if body == 0 { (&pose.rotation_first, 1.0) } else { (&pose.rotation_second, -1.0) };
    let displacement = rotate(rotation, &fragment.centre) * -sign;
    let mut moments = [0.0; count(MOST_DEGREES)];
    let degree = series.degrees[body];
    let moments = &mut moments[..count(degree)];
    moments.copy_from_slice(&series.moments[body][..count(degree)]);
    scale_degrees(moments, |l| l as f64);
    let mut changed_moments = series.moments;
    changed_moments[body] = moments;
    let mut changed = Series { moments: changed_moments, ..*series }.interaction(part_pose);
    let [first, second] = &parts.torque_by_separation;
    changed.add(&Interaction {
        force_on_first: parts.force_by_separation * displacement,
        torque_first: first * displacement,
        torque_second: second * displacement,
    });
    let mut changed = offsets.about_centres(pose, changed);
    let force = rotate_back(rotation, &(parts.loads.force_on_first * (sign * offsets.share)));
    let torque = if body == 0 { &mut changed.torque_first } else { &mut changed.torque_second };
    *torque += fragment.centre.cross(&force);
    changed
}

impl Jacobian {
    fn add(&mut self, other: &Self) {
        self.loads.add(&other.loads);
        self.force_by_separation += other.force_by_separation;
        for body in 0..2 {
            self.torque_by_separation[body] += other.torque_by_separation[body];
            self.torque_by_rotation[body] += other.torque_by_rotation[body];
        }
        self.torque_first_by_second += other.torque_first_by_second;
    }
}
