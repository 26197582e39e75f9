//! How the pull of a polyhedron on a distant point differs from that of a point mass.

use super::{Facets, Layer};
use crate::error::Result;
use crate::math::Vec3;
use crate::math::harmonics;
use crate::patience::Patience;
use crate::shape::Polyhedron;
use pulp::Arch;

/// Degrees of the layers.
const DEGREES: [usize; 3] = [24, 12, 6];

/// What a layer leaves out, relative to the quadrupole.
const TOLERANCE: f64 = 1e-15;

/// The polyhedron's field less that of its mass at its centre, and its moment about the centre, by the points of its layers: each
/// point's field less that of its mass at the centre and less the dipole there, as in [`super::BodyPull`]. The dipoles of all
/// points cancel.
#[derive(Debug, Clone)]
pub struct LayerPull {
    polyhedron: Polyhedron,
    facets: Facets,
    /// Layers and the largest 1/|x|^2 at which they are used, from the nearest.
    layers: Vec<(f64, Layer)>,
}

impl LayerPull {
    /// Computes the moments that [`Self::new`] takes, which are kept with the shape.
    pub fn moments(polyhedron: &Polyhedron, patience: &mut Patience) -> Result<()> {
        polyhedron.harmonic_moments(DEGREES[0], Arch::Scalar, patience).map(drop)
    }

    /// Of a polyhedron. The results are the same on every machine.
    pub fn new(polyhedron: &Polyhedron) -> Self {
        let arch = Arch::Scalar;
        let moments = polyhedron.harmonic_moments(DEGREES[0], arch, &mut Patience::endless());
        let radius = polyhedron.circumradius();
        let layer = |degree: usize| {
            let from = radius * TOLERANCE.powf(-1.0 / (degree - 1) as f64);
            let moments = moments.as_ref().ok().filter(|m| m.len() >= harmonics::count(degree))?;
            Some((from.powi(-2), Layer::from_moments(moments, radius, degree, arch)))
        };
        let layers = DEGREES.iter().filter_map(|&degree| layer(degree)).collect();
        Self { polyhedron: polyhedron.clone(), facets: Facets::new(polyhedron, 1.0), layers }
    }

    /// As [`super::ExtendedPull::at`].
    pub fn at(&self, x: &Vec3, inverse_square: f64, inverse_cube: f64) -> Option<(Vec3, Vec3)> {
        let Some((_, layer)) = self.layers.iter().rev().find(|(from, _)| inverse_square <= *from) else {
            if self.polyhedron.contains(x) {
                return None;
            }
            let field = self.facets.field(Arch::Scalar, x).field;
            return Some((field + x * inverse_cube, x.cross(&field)));
        };
        let (mut excess, mut moment) = (Vec3::zeros(), Vec3::zeros());
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
            excess += (p * h - x * (beyond - 1.5 * square)) * weight;
            moment += p * (h * weight);
        }
        Some((excess * inverse_cube, x.cross(&moment) * inverse_cube))
    }
}
