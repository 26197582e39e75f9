//! The bodies of a vector as forces from outside see them.

use super::BarycentricFrame;
use crate::environment::Scene;
use crate::math::Mat3;

/// Where the barycentre nominally is, and how the bodies are turned.
#[derive(Debug, Clone)]
pub(super) struct View {
    pub frame: BarycentricFrame,
    /// Rotation matrices of the last vector.
    pub rotation: Vec<Mat3>,
    /// Its attitudes as quaternions, where forces want them.
    attitude: Vec<[f64; 4]>,
}

impl View {
    pub fn new(frame: BarycentricFrame, attitudes: bool) -> Self {
        let bodies = frame.layout.bodies;
        Self {
            frame,
            rotation: vec![Mat3::identity(); bodies],
            attitude: vec![[0.0; 4]; if attitudes { bodies } else { 0 }],
        }
    }

    /// The bodies of a vector whose rotation matrices are known. Its attitudes are taken over.
    #[inline(always)]
    pub fn show<'a>(&'a mut self, time: f64, y: &'a [f64]) -> Scene<'a> {
        for (body, attitude) in self.attitude.iter_mut().enumerate() {
            *attitude = self.frame.attitude(body, y);
        }
        self.shown(time, y)
    }

    /// Those of the vector that was shown last, or of one with the same attitudes.
    #[inline(always)]
    pub fn shown<'a>(&'a self, time: f64, y: &'a [f64]) -> Scene<'a> {
        self.frame.scene(time, y, &self.rotation, &self.attitude)
    }
}
