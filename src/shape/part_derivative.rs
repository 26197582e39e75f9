//! The derivatives of a composite with respect to the mass or the position of one of its parts.
//!
//! The frame of a composite moves and rotates with such a change. The centre of mass c moves by dc = dm (g -
//! c)/M + m dg/M, with g the part's centre. The principal axes rotate by the vector phi that keeps the
//! inertia tensor T diagonal, phi_i = dT_kj / (I_k - I_j) for i, j, k in cyclic order; there is no rotation
//! where two moments are equal and dT_kj vanishes.

use super::frame::ROUNDING;
use super::{Body, Part, Placement, Shape};
use crate::error::{Error, Result};
use crate::math::rotation;
use crate::math::{Mat3, Vec3};

/// A parameter of a part of a composite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartNumber {
    /// The mass of the part.
    Mass,
    /// A coordinate of the part's position in the working frame.
    Position(usize),
}

/// The derivatives of a composite's parts and moments, in its body frame, with respect to a parameter of one
/// of its parts.
#[derive(Debug, Clone, PartialEq)]
pub struct PartDerivative {
    /// The index of the part.
    pub part: usize,
    /// The derivative of the part's mass, divided by that mass.
    pub relative_mass: f64,
    /// The derivative of the body's mass.
    pub mass: f64,
    /// The derivatives of the positions of all parts.
    pub positions: Vec<Vec3>,
    /// The derivative of the rotation of all parts, as a rotation vector.
    pub rotation_change: Vec3,
    /// The derivatives of the moments of inertia.
    pub inertia: Vec3,
    /// A change of the parameter that is small for the body.
    pub size: f64,
}

impl PartDerivative {
    /// Returns the placement of a part and its mass relative to that of the body, after a change of the
    /// parameter.
    pub fn changed(
        &self,
        index: usize,
        placement: &Placement,
        share: f64,
        mass: f64,
        by: f64,
    ) -> (Placement, f64) {
        let relative_change = if index == self.part { self.relative_mass } else { 0.0 };
        let rotation =
            rotation::matrix(rotation::exponential(&(self.rotation_change * by))) * placement.rotation;
        let position = placement.position + self.positions[index] * by;
        (
            Placement { position, rotation },
            share * (1.0 + relative_change * by) / (1.0 + self.mass * by / mass),
        )
    }
}

impl Body {
    /// Returns the derivatives with respect to a parameter of a part, or an error where two moments are
    /// equal, so that the principal axes jump.
    #[doc(hidden)]
    pub fn by_part(&self, index: usize, number: PartNumber) -> Result<PartDerivative> {
        let parts = self.parts();
        let part = &parts[index];
        let axes = self.working_frame().map_or_else(Mat3::identity, |frame| rotation::matrix(frame.attitude));
        let arm = part.position();
        let square = |arm: &Vec3, by: &Vec3| {
            Mat3::from_diagonal_element(arm.dot(by)) - 0.5 * (arm * by.transpose() + by * arm.transpose())
        };
        let (relative_mass, mass, shift, centre, tensor, size) = match number {
            PartNumber::Mass => {
                let rotation = part.rotation();
                let tensor = rotation * part.shape.inertia_tensor_per_mass() * rotation.transpose()
                    + square(&arm, &arm);
                (1.0 / part.mass, 1.0, Vec3::zeros(), arm / self.mass, tensor, part.mass.abs())
            }
            PartNumber::Position(axis) => {
                let shift = axes.column(axis).into_owned();
                let tensor = 2.0 * part.mass * square(&arm, &shift);
                (0.0, 0.0, shift, shift * (part.mass / self.mass), tensor, self.circumradius())
            }
        };
        let inertia = self.inertia();
        let all = inertia.sum();
        let mut rotation_change = Vec3::zeros();
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let (product, difference) = (tensor[(k, j)], inertia[k] - inertia[j]);
            if difference.abs() > ROUNDING * all {
                rotation_change[i] = product / difference;
            } else if (product * size).abs() > ROUNDING * all {
                let number = match number {
                    PartNumber::Mass => "mass".to_owned(),
                    PartNumber::Position(axis) => format!("position {}", ["x", "y", "z"][axis]),
                };
                return Err(Error::invalid(
                    format!("derivative by the {number} of part {index} of {}", self.name),
                    format!("none: two of its moments of inertia are {}", inertia[j]),
                    "moments that differ, so that its principal axes do not jump",
                ));
            }
        }
        let moved = |(k, part): (usize, &Part)| {
            let shift = if k == index { shift } else { Vec3::zeros() };
            rotation_change.cross(&part.position()) + shift - centre
        };
        let positions = parts.iter().enumerate().map(moved).collect();
        let part = index;
        Ok(PartDerivative {
            part,
            relative_mass,
            mass,
            positions,
            rotation_change,
            inertia: tensor.diagonal(),
            size,
        })
    }

    /// Returns the body with a parameter of a part changed.
    #[doc(hidden)]
    pub fn with_part(&self, index: usize, number: PartNumber, by: f64) -> Result<Self> {
        let mut parts = self.input_parts().to_vec();
        match number {
            PartNumber::Mass => parts[index].mass += by,
            PartNumber::Position(axis) => parts[index].position[axis] += by,
        }
        Self::composite(self.name.clone(), parts)
    }

    /// Returns the body with another mass: the masses of all parts change in proportion.
    ///
    /// # Errors
    /// Returns the errors of [`Self::with_mass`] or [`Self::composite`].
    pub fn with_total_mass(&self, mass: f64) -> Result<Self> {
        if let Some(facets) = self.facets() {
            return Self::of_facets(self.name.clone(), facets.clone(), mass);
        }
        if !self.is_composite() {
            return Self::with_mass(self.name.clone(), self.parts()[0].shape.clone(), mass);
        }
        let mut parts = self.input_parts().to_vec();
        parts.iter_mut().for_each(|part| part.mass *= mass / self.mass);
        Self::composite(self.name.clone(), parts)
    }

    /// Returns the body, which must have one part, with another shape.
    ///
    /// # Errors
    /// Returns the errors of [`Self::with_mass`].
    pub fn with_shape(&self, shape: Shape) -> Result<Self> {
        Self::with_mass(self.name.clone(), shape, self.mass)
    }
}
