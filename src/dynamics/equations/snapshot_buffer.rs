//! The snapshots of an integrator's vectors for external forces.

use super::layout::BarycentricFrame;
use crate::forces::MotionSnapshot;
use crate::math::Mat3;

/// The frame of the vectors, with the rotations at the last vector.
#[derive(Debug, Clone)]
pub struct SnapshotBuffer {
    pub frame: BarycentricFrame,
    /// The rotation matrices at the last vector.
    pub rotation: Vec<Mat3>,
    /// The attitudes at the last vector as quaternions, where forces need them.
    attitude: Vec<[f64; 4]>,
}

impl SnapshotBuffer {
    pub fn new(frame: BarycentricFrame, attitudes: bool) -> Self {
        let bodies = frame.layout.bodies;
        Self {
            frame,
            rotation: vec![Mat3::identity(); bodies],
            attitude: vec![[0.0; 4]; if attitudes { bodies } else { 0 }],
        }
    }

    /// Returns a snapshot of a vector whose rotation matrices are known, and stores its attitudes.
    #[inline(always)]
    pub fn take_snapshot<'a>(&'a mut self, time: f64, y: &'a [f64]) -> MotionSnapshot<'a> {
        for (body, attitude) in self.attitude.iter_mut().enumerate() {
            *attitude = self.frame.attitude(body, y);
        }
        self.last_snapshot(time, y)
    }

    /// Returns a snapshot with the attitudes of the last vector, for that vector or one with the same
    /// attitudes.
    #[inline(always)]
    pub fn last_snapshot<'a>(&'a self, time: f64, y: &'a [f64]) -> MotionSnapshot<'a> {
        self.frame.snapshot(time, y, &self.rotation, &self.attitude)
    }
}
