//! The exterior field of a body as a finite series of solid harmonics.
//!
//! Let a_lm be the mean of the solid harmonic S_lm(x/R) over the mass of the body, and y = R x/|x|^2. The
//! potential per unit GM is sum_lm a_lm S_lm(y)/|x|. A displacement of the mass changes a_lm by the means of
//! the derivatives of S_lm, which are harmonics of degree l - 1. Each derivative of the potential with respect
//! to position is therefore a series of the same kind, one degree higher.

use super::PolyhedralField;
use crate::math::exchange::displacement_derivatives;
use crate::math::harmonics::{HarmonicSeries, count};
use crate::math::lanes::BLOCK;
use crate::math::{Mat3, Vec3};
use pulp::Arch;

/// The series of potential, field and gradient per unit GM, valid outside a sphere.
#[derive(Debug, Clone)]
pub struct HarmonicField {
    /// The radius R.
    radius: f64,
    /// The degree of the series of the gradient.
    degree: usize,
    /// The coefficients of the potential, of its derivatives by x, y, z, and by xx, xy, xz, yy, yz, zz.
    series: [Vec<f64>; 10],
}

impl HarmonicField {
    /// Prepares the series from the harmonic moments a_lm of a body for the radius R.
    pub fn new(moments: &[f64], radius: f64) -> Self {
        // Moments up to degree L are (L + 1)^2 numbers; the gradient has degree L + 2.
        let degree = moments.len().isqrt() + 1;
        let first = [0, 1, 2].map(|axis| displacement_derivatives(moments, axis));
        let [x, y, z] = &first;
        let second = [(x, 0), (x, 1), (x, 2), (y, 1), (y, 2), (z, 2)];
        let second = second.map(|(first, axis)| displacement_derivatives(first, axis));
        let [xx, xy, xz, yy, yz, zz] = second;
        let [x, y, z] = first;
        let series = [moments.to_vec(), x, y, z, xx, xy, xz, yy, yz, zz];
        Self { radius, degree, series }
    }

    /// Returns the radius of the sphere outside which the series is the field of the body.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns the cost of one point, in units of that of one face of a polyhedron: four harmonics count as
    /// one face.
    pub fn work(&self) -> usize {
        count(self.degree) / 4
    }

    /// Returns g and its moment x cross g at a point; `None` within the sphere.
    pub fn field_and_moment(&self, x: &Vec3) -> Option<(Vec3, Vec3)> {
        let field = self.at(x).field;
        (x.norm() >= self.radius).then(|| (field, x.cross(&field)))
    }

    /// Returns potential, field and gradient at a point. Within the sphere the series still has a value, but
    /// not that of the body.
    pub fn at(&self, x: &Vec3) -> PolyhedralField {
        let distance = x.norm();
        let y = x * (self.radius / distance / distance);
        let points = [0, 1, 2].map(|axis| [y[axis]; BLOCK]);
        let points: [&[f64]; 3] = points.each_ref().map(|list| list.as_slice());
        let series = &self.series.each_ref().map(|coefficients| coefficients.as_slice());
        let mut out = [0.0; 10 * BLOCK];
        Arch::Scalar.dispatch(HarmonicSeries { points, series, degree: self.degree, out: &mut out });
        let [potential, gx, gy, gz, xx, xy, xz, yy, yz, zz] =
            std::array::from_fn(|k| out[k * BLOCK] / distance);
        let inverse = 1.0 / self.radius;
        let inverse_square = inverse / self.radius;
        PolyhedralField {
            potential,
            // Moving the point by d is the same as displacing the mass by -d.
            field: Vec3::new(gx, gy, gz) * -inverse,
            gradient: Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * inverse_square,
            solid_angle: 0.0,
        }
    }
}
