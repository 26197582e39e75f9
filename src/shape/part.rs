//! Parts of bodies: a shape with a mass at a position.

use super::Shape;
use crate::error::{Error, Result, require_finite, require_positive};
use crate::math::{Mat3, Vec3, rotation};
use serde::{Deserialize, Serialize};

/// Position and rotation of one frame in another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The origin of the frame.
    pub position: Vec3,
    /// The rotation matrix that maps vectors of the frame to the other one.
    pub rotation: Mat3,
}

/// A part of a body, in the body's own frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// The shape, centred at the part's own centre.
    pub shape: Shape,
    /// The mass; negative for a void.
    pub mass: f64,
    /// The position and rotation in the body's frame; `None` for the one part of an ordinary body, which is
    /// at the origin and not rotated.
    pub placement: Option<Placement>,
}

impl Part {
    /// Returns the part's centre in the body's frame.
    pub fn position(&self) -> Vec3 {
        self.placement.map_or_else(Vec3::zeros, |placement| placement.position)
    }

    /// Returns the rotation from the part's frame into the body's frame.
    pub fn rotation(&self) -> Mat3 {
        self.placement.map_or_else(Mat3::identity, |placement| placement.rotation)
    }
}

/// A part of a composite as it was given, in the working frame that the caller chose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputPart {
    /// The shape.
    #[serde(rename = "semi_axes")]
    pub shape: Shape,
    /// The mass: positive for matter, negative for a void.
    pub mass: f64,
    /// The part's centre; for a polyhedron the origin of its vertices' frame.
    pub position: [f64; 3],
    /// The quaternion that rotates vectors of the part into the working frame.
    pub attitude: [f64; 4],
}

impl InputPart {
    /// Returns the mass of a part from its density, of either sign; `what` names the part in errors.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a point, which has no volume.
    pub fn mass_of(what: &str, shape: &Shape, density: f64) -> Result<f64> {
        let volume = shape.volume();
        if volume > 0.0 {
            Ok(density * volume)
        } else {
            Err(Error::invalid(format!("density of {what}"), density, "a mass: its shape has no volume"))
        }
    }

    /// Returns an error for numbers that no part can have.
    pub(super) fn check(&self, what: &str) -> Result<()> {
        if !(self.mass.is_finite() && self.mass != 0.0) {
            let expected = "a finite number that is not zero: above for matter, below for a void";
            return Err(Error::invalid(format!("mass of {what}"), self.mass, expected));
        }
        if let Shape::Stokes(_) = self.shape {
            return Err(Error::invalid(
                what,
                "given by its Stokes coefficients",
                "a shape with a surface, or a point",
            ));
        }
        require_finite(&format!("position of {what}"), &self.position)?;
        require_finite(&format!("attitude of {what}"), &self.attitude)?;
        let length = self.attitude.iter().fold(0.0, |length: f64, q| length.hypot(*q));
        require_positive(&format!("length of the attitude of {what}"), length)
    }

    pub(super) fn placement(&self) -> Placement {
        let rotation = rotation::matrix(rotation::normalised(self.attitude));
        let position = Vec3::from(self.position);
        let Shape::Polyhedron(polyhedron) = &self.shape else { return Placement { position, rotation } };
        // The position and attitude refer to the frame in which the vertices were given, not to the principal
        // frame.
        let frame = polyhedron.working_frame();
        let rotation = rotation * rotation::matrix(frame.attitude).transpose();
        Placement { position: position - rotation * frame.position, rotation }
    }
}
