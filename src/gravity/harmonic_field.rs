//! The exterior field of a body by its harmonic moments.
//!
//! With the means a_lm of S_lm in units of R, and y = R x/|x|^2, the potential is sum of a_lm S_lm(y)/|x|.
//! Where the mass is displaced, a_lm changes by the derivatives of S_lm, which are harmonics of degree l - 1:
//! the derivatives of the potential by position are series of the same kind, one degree higher each.

use super::PolyhedralField;
use crate::math::exchange::displaced;
use crate::math::harmonics::{HarmonicSeries, count};
use crate::math::lanes::BLOCK;
use crate::math::{Mat3, Vec3};
use pulp::Arch;

/// The field of unit GM outside a sphere, as a finite series.
#[derive(Debug, Clone)]
pub struct HarmonicField {
    radius: f64,
    degree: usize,
    /// The series of the potential, the three of the field, and the gradient's xx, xy, xz, yy, yz and zz.
    series: [Vec<f64>; 10],
}

impl HarmonicField {
    /// Prepares the field of moments in units of a radius.
    pub fn new(moments: &[f64], radius: f64) -> Self {
        let degree = moments.len().isqrt() + 1;
        let first = [0, 1, 2].map(|axis| displaced(moments, axis));
        let [x, y, z] = &first;
        let second = [(x, 0), (x, 1), (x, 2), (y, 1), (y, 2), (z, 2)].map(|(by, axis)| displaced(by, axis));
        let [xx, xy, xz, yy, yz, zz] = second;
        let [x, y, z] = first;
        let series = [moments.to_vec(), x, y, z, xx, xy, xz, yy, yz, zz];
        Self { radius, degree, series }
    }

    /// Returns the radius of the sphere within which the field is not known.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns the work at a point, in facets of a polyhedron.
    pub fn work(&self) -> usize {
        count(self.degree) / 4
    }

    /// Returns g and x cross g at a point; `None` within the sphere.
    pub fn with_moment(&self, x: &Vec3) -> Option<(Vec3, Vec3)> {
        let field = self.at(x).field;
        (x.norm() >= self.radius).then(|| (field, x.cross(&field)))
    }

    /// Returns the field at a point. The finite series continues it into the sphere, where it is not that of the
    /// body.
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
        let (once, twice) = (1.0 / self.radius, 1.0 / self.radius / self.radius);
        PolyhedralField {
            potential,
            // The field at x + d is that of the mass displaced by -d.
            field: Vec3::new(gx, gy, gz) * -once,
            gradient: Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * twice,
            solid_angle: 0.0,
        }
    }
}
