//! A polyhedron's gravity at single points, near or far, inside or outside.
//!
//! Takes points relative to the centre of mass and gives Phi, g and dg/dx per unit GM: from the facets near
//! by, and from a layer of the degree that the distance needs where the sums over facets would lose digits.

use super::{Facets, Layer, PolyhedralField};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3};
use crate::shape::Polyhedron;
use pulp::Arch;

/// The degrees of the layers.
const DEGREES: [usize; 3] = [24, 12, 6];

/// The truncation error of a layer, relative to the field.
const TOLERANCE: f64 = 1e-16;

/// The distance, in sizes of the body, beyond which the squares of doubles may be out of range.
const POINT_FROM: f64 = 1e100;

/// A polyhedron prepared for evaluation.
#[derive(Debug, Clone)]
pub struct PolyhedronGravity {
    /// The unit of length of facets and layers, a power of two.
    unit: f64,
    facets: Facets,
    /// The layers from the nearest on, each with the least distance at which it is used.
    layers: Vec<(f64, Layer)>,
    arch: Arch,
}

impl PolyhedronGravity {
    /// Prepares the facets and layers of a polyhedron.
    pub fn new(polyhedron: &Polyhedron, arch: Arch, interrupt: &mut InterruptCheck) -> Result<Self> {
        polyhedron.check(interrupt)?;
        let radius = polyhedron.circumradius();
        let unit = radius.log2().floor().exp2();
        let moments = polyhedron.harmonic_moments(DEGREES[0], arch, interrupt)?;
        let layer = |degree: usize| {
            let from = radius / unit * TOLERANCE.powf(-1.0 / (degree + 1) as f64);
            (from, Layer::from_moments(&moments, radius / unit, degree, arch))
        };
        Ok(Self { unit, facets: Facets::new(polyhedron, unit), layers: DEGREES.map(layer).into(), arch })
    }

    /// Returns potential, field and gradient at a point.
    pub fn at(&self, x: &Vec3) -> PolyhedralField {
        let x = x / self.unit;
        let largest = x.amax();
        if largest > POINT_FROM {
            let u = x / largest;
            let r = u.norm();
            let (potential, u) = (1.0 / r / largest, u / r);
            let gradient = (3.0 * u * u.transpose() - Mat3::identity()) * potential.powi(3);
            let field = -u * (potential * potential);
            return self.in_units(PolyhedralField { potential, field, gradient, solid_angle: 0.0 });
        }
        let distance = x.norm();
        let field = match self.layers.iter().rev().find(|(from, _)| distance >= *from) {
            Some((_, layer)) => {
                let (potential, field, gradient) = layer.at(self.arch, &x);
                PolyhedralField { potential, field, gradient, solid_angle: 0.0 }
            }
            None => self.facets.at(self.arch, &x),
        };
        self.in_units(field)
    }

    fn in_units(&self, f: PolyhedralField) -> PolyhedralField {
        let unit = self.unit;
        PolyhedralField {
            potential: f.potential / unit,
            field: f.field / unit / unit,
            gradient: f.gradient / unit / unit / unit,
            ..f
        }
    }
}
