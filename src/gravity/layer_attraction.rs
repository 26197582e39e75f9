//! The difference between the attraction of a distant point by a polyhedron and by a point mass.

use super::{Facets, Layer};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::harmonics;
use crate::math::matrix::cross_times;
use crate::math::{Mat3, Vec3};
use crate::shape::Polyhedron;
use pulp::Arch;

/// The degrees of the layers.
const DEGREES: [usize; 3] = [24, 12, 6];

/// The truncation error of a layer, relative to the quadrupole.
const TOLERANCE: f64 = 1e-15;

/// The excess of the polyhedron's field over that of its mass at its centre, and its moment about the centre,
/// from the points of its layers. Each point contributes its field without that of its mass at the centre and
/// without that of its dipole there, as in [`super::BodyAttraction`]; the dipoles of all points cancel.
#[derive(Debug, Clone)]
pub struct LayerAttraction {
    polyhedron: Polyhedron,
    facets: Facets,
    /// The layers, each with the largest 1/|x|^2 at which it is used, from the nearest.
    layers: Vec<(f64, Layer)>,
}

impl LayerAttraction {
    /// Computes the moments that [`Self::new`] needs, which are cached with the shape.
    pub fn moments(polyhedron: &Polyhedron, interrupt: &mut InterruptCheck) -> Result<()> {
        polyhedron.harmonic_moments(DEGREES[0], Arch::Scalar, interrupt).map(drop)
    }

    /// Prepares a polyhedron. The results are the same on every machine.
    pub fn new(polyhedron: &Polyhedron) -> Self {
        let arch = Arch::Scalar;
        let moments = polyhedron.harmonic_moments(DEGREES[0], arch, &mut InterruptCheck::never());
        let radius = polyhedron.circumradius();
        let layer = |degree: usize| {
            let from = radius * TOLERANCE.powf(-1.0 / (degree - 1) as f64);
            let moments = moments.as_ref().ok().filter(|m| m.len() >= harmonics::count(degree))?;
            Some((from.powi(-2), Layer::from_moments(moments, radius, degree, arch)))
        };
        let layers = DEGREES.iter().filter_map(|&degree| layer(degree)).collect();
        Self { polyhedron: polyhedron.clone(), facets: Facets::new(polyhedron, 1.0), layers }
    }

    /// Returns the excess and the moment as [`super::ExtendedAttraction::at`].
    pub fn at(&self, x: &Vec3, inverse_square: f64, inverse_cube: f64) -> Option<(Vec3, Vec3)> {
        let Some((_, layer)) = self.layers.iter().rev().find(|(from, _)| inverse_square <= *from) else {
            if self.polyhedron.contains(x) {
                return None;
            }
            let field = self.facets.field(Arch::Scalar, x).field;
            return Some((field + x * inverse_cube, x.cross(&field)));
        };
        let (mut perturbation, mut moment) = (Vec3::zeros(), Vec3::zeros());
        for k in 0..layer.count {
            let p = Vec3::new(layer.points[0][k], layer.points[1][k], layer.points[2][k]);
            let square = p.norm_squared() * inverse_square;
            let q = p.dot(&(p - 2.0 * x)) * inverse_square;
            let s = (1.0 + q).sqrt();
            let s3 = (1.0 + q) * s;
            let e = q / (1.0 + s);
            let h = -e * (1.0 + s + s * s) / s3;
            let beyond = e * e * (1.5 * s3 + 3.0 * s * s + 2.0 * s + 1.0) / s3;
            let weight = layer.weights[k];
            perturbation += (p * h - x * (beyond - 1.5 * square)) * weight;
            moment += p * (h * weight);
        }
        Some((perturbation * inverse_cube, x.cross(&moment) * inverse_cube))
    }

    /// Returns the derivatives as [`super::ExtendedAttraction::jacobian`] does. The dipole of a layer's
    /// points p with weights w vanishes. With P = sum of w p h/|x|^3 over the points, -x cross g is -x cross
    /// P. With s = |x - p|/|x| and h5 = s^-5 - 1 the derivative of P is the sum of w p (3 p (1 + h5) - 3 x
    /// h5)^T/|x|^5.
    pub fn jacobian(&self, x: &Vec3) -> (Mat3, Mat3) {
        let square = x.norm_squared();
        let inverse_square = 1.0 / square;
        let Some((_, layer)) = self.layers.iter().rev().find(|(from, _)| inverse_square <= *from) else {
            let at = self.facets.at(Arch::Scalar, x);
            return (at.gradient, at.field.cross_matrix() - cross_times(x, &at.gradient));
        };
        let (mut moment, mut by_position) = (Vec3::zeros(), Mat3::zeros());
        for k in 0..layer.count {
            let p = Vec3::new(layer.points[0][k], layer.points[1][k], layer.points[2][k]);
            let q = p.dot(&(p - 2.0 * x)) * inverse_square;
            let s = (1.0 + q).sqrt();
            let (s2, s3) = (1.0 + q, (1.0 + q) * s);
            let e = q / (1.0 + s);
            let h = -e * (1.0 + s + s2) / s3;
            let h5 = -e * (1.0 + s + s2 + s3 + s2 * s2) / (s2 * s3);
            let weighted = p * layer.weights[k];
            moment += weighted * h;
            by_position += weighted * (p * (1.0 + h5) - x * h5).transpose() * (3.0 * inverse_square);
        }
        let inverse_cube = inverse_square / square.sqrt();
        let torque_gradient = (moment.cross_matrix() - cross_times(x, &by_position)) * inverse_cube;
        (layer.at(Arch::Scalar, x).2, torque_gradient)
    }
}
