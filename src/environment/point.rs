//! What third bodies do to a point that moves among the bodies of a system.

use super::third_body::{Powers, Pull};
use crate::error::Result;
use crate::math::Vec3;
use crate::orbit::Place;
use pulp::Scalar;

/// A third body's pull on points: the direct one less that on the nominal barycentre, with which the coordinates fall.
#[derive(Debug, Clone)]
pub struct PointPull {
    name: String,
    pull: Pull,
}

impl PointPull {
    pub(super) fn new(name: &str, pull: &Pull) -> Self {
        Self { name: name.to_owned(), pull: pull.clone() }
    }

    /// The third body's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Refuses times for which its path is not given.
    pub fn covers(&self, from: f64, to: f64) -> Result<()> {
        self.pull.covers(&self.name, from, to)
    }

    /// Where it is, from the nominal barycentre.
    #[inline]
    pub fn place(&mut self, time: f64) -> Result<Place> {
        self.pull.position(Scalar, time)
    }

    /// The acceleration of a point, from the nominal barycentre.
    #[inline]
    pub fn acceleration(&self, place: &Place, r: &Vec3) -> Vec3 {
        let p = place.position;
        let powers = Powers::of(-r.dot(&(p - r + p)) * place.inverse_square);
        (r + powers.f * p) * (-self.pull.mu * place.inverse_cube * powers.cube)
    }
}
