//! The proximity of two bodies to contact, by their parts.

use super::{Body, growth};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3};

/// The proximity of two bodies to contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proximity {
    /// The least factor by which a part of one body and a part of the other must grow, each about its own
    /// centre, to touch; one where the bodies touch. For parts far apart it is the factor of the spheres
    /// around them, a lower bound.
    pub factor: f64,
    /// Whether the interiors of the bodies share a point.
    pub overlap: bool,
}

impl Proximity {
    /// Computes the proximity of two bodies.
    ///
    /// `separation` runs from the first centre to the second; the matrices rotate the body frames into its
    /// frame. An interruption names `time`.
    pub fn compute(
        bodies: [&Body; 2],
        separation: &Vec3,
        rotations: [&Mat3; 2],
        time: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<Self> {
        /// The factor above which the spheres around two parts are used instead of the parts.
        const FAR: f64 = 2.0;
        /// Units of work of two parts that are near each other.
        const NEAR: u64 = 30;
        let [first, second] = bodies;
        let mut nearest = Self { factor: f64::INFINITY, overlap: false };
        for a in first.outer_parts() {
            for b in second.outer_parts() {
                interrupt.charge(1, time)?;
                let (mut r, mut rotation_a, mut rotation_b) = (*separation, *rotations[0], *rotations[1]);
                if let Some(placement) = &a.placement {
                    r -= rotation_a * placement.position;
                    rotation_a *= placement.rotation;
                }
                if let Some(placement) = &b.placement {
                    r += rotation_b * placement.position;
                    rotation_b *= placement.rotation;
                }
                let circumradii = a.shape.circumradius() + b.shape.circumradius();
                let spheres = r.norm() / circumradii;
                if spheres >= nearest.factor {
                    continue;
                }
                if spheres > FAR {
                    nearest.factor = spheres;
                    continue;
                }
                interrupt.charge(NEAR, time)?;
                let shapes = [&a.shape, &b.shape];
                let growth = growth(shapes, &r, [&rotation_a, &rotation_b], time, interrupt)?.with_levers(
                    r.norm(),
                    circumradii,
                    [a.placement, b.placement],
                );
                nearest.overlap |= growth.overlap(&first.name, &second.name)?;
                nearest.factor = nearest.factor.min(growth.factor);
            }
        }
        Ok(nearest)
    }
}
