//! The acceleration by third bodies of a point that moves among the bodies of a system.

use super::third_body::{BattinFactors, ThirdBodyAttraction};
use crate::error::Result;
use crate::math::Vec3;
use crate::orbit::OrbitPosition;
use pulp::Scalar;

/// The acceleration of points by a third body: its direct attraction minus that of the nominal barycentre,
/// with which the coordinates fall.
#[derive(Debug, Clone)]
pub struct PointAttraction {
    name: String,
    attraction: ThirdBodyAttraction,
}

impl PointAttraction {
    pub(super) fn new(name: &str, attraction: &ThirdBodyAttraction) -> Self {
        Self { name: name.to_owned(), attraction: attraction.clone() }
    }

    /// Returns the third body's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns an error for times at which the path is not given.
    pub fn covers(&self, from: f64, to: f64) -> Result<()> {
        self.attraction.covers(&self.name, from, to)
    }

    /// Returns the position of the third body relative to the nominal barycentre.
    #[inline]
    pub fn position(&mut self, time: f64) -> Result<OrbitPosition> {
        self.attraction.position(Scalar, time)
    }

    /// Returns the acceleration of a point at a position relative to the nominal barycentre.
    #[inline]
    pub fn acceleration(&self, third_body: &OrbitPosition, r: &Vec3) -> Vec3 {
        let p = third_body.position;
        let powers = BattinFactors::of(-r.dot(&(p - r + p)) * third_body.inverse_square);
        (r + powers.f * p) * (-self.attraction.mu * third_body.inverse_cube * powers.cube)
    }
}
