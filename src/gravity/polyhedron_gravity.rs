//! A polyhedron's gravity at single points, near or far, inside or outside.
//!
//! Takes points relative to the centre of mass and gives Phi, g and dg/dx per unit GM. Near the body these are
//! the sums over its faces and edges ([`Facets`]), which lose digits with distance. Farther away they come from
//! a [`Layer`], the farther the lower its degree, and very far away from a point mass.

use super::{Facets, Layer, PolyhedralField};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3};
use crate::shape::Polyhedron;
use pulp::Arch;

/// The degrees of the layers. With [`TOLERANCE`] they are used from 4.4, 17 and 193 circumradii on.
const DEGREES: [usize; 3] = [24, 12, 6];

/// The allowed truncation error of a layer relative to the field, (R/r)^(degree + 1) with R the circumradius.
const TOLERANCE: f64 = 1e-16;

/// The coordinate, in working units of length, beyond which the body is a point mass: the squares of larger
/// coordinates may overflow.
const POINT_FROM: f64 = 1e100;

/// A polyhedron prepared for the evaluation of its gravity.
#[derive(Debug, Clone)]
pub struct PolyhedronGravity {
    /// The working unit of length, that of facets and layers: the largest power of two up to the circumradius.
    unit: f64,
    facets: Facets,
    /// The layers in the order of increasing least distance, which precedes each.
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
            return self.in_callers_unit(PolyhedralField { potential, field, gradient, solid_angle: 0.0 });
        }
        let distance = x.norm();
        let field = match self.layers.iter().rev().find(|(from, _)| distance >= *from) {
            Some((_, layer)) => {
                let (potential, field, gradient) = layer.at(self.arch, &x);
                PolyhedralField { potential, field, gradient, solid_angle: 0.0 }
            }
            None => self.facets.at(self.arch, &x),
        };
        self.in_callers_unit(field)
    }

    /// Converts a field from the working unit to the caller's unit of length.
    fn in_callers_unit(&self, f: PolyhedralField) -> PolyhedralField {
        let unit = self.unit;
        PolyhedralField {
            potential: f.potential / unit,
            field: f.field / unit / unit,
            gradient: f.gradient / unit / unit / unit,
            ..f
        }
    }
}
