//! The gravity of a body: the sum over its parts, at points anywhere.

use super::{Anywhere, Ellipsoidal, PolyhedralField};
use crate::error::Result;
use crate::math::{Mat3, Vec3};
use crate::patience::Patience;
use crate::shape::{Body, Part, Polyhedron, Shape};
use pulp::Arch;

/// A body's gravity in its own frame.
#[derive(Debug, Clone)]
pub struct BodyField {
    /// The body's name.
    pub name: String,
    pub(super) parts: Vec<PartField>,
}

/// The gravity of one part.
#[derive(Debug, Clone)]
pub(super) struct PartField {
    pub position: Vec3,
    /// Turns the body's vectors into those of the frame in which the part's axes are sorted.
    pub turn: Mat3,
    pub kind: Kind,
}

#[derive(Debug, Clone)]
pub(super) enum Kind {
    /// A point too.
    Ellipsoidal(Box<Ellipsoidal>),
    Polyhedral(Box<Polyhedral>),
}

/// A body's gravity where the body is.
#[derive(Debug, Clone, Copy)]
pub struct Attractor<'a> {
    /// The gravity in the body's frame.
    pub field: &'a BodyField,
    /// The body's centre in the frame of the points.
    pub position: Vec3,
    /// Turns the body's vectors into that frame.
    pub rotation: Mat3,
}

/// A polyhedron's gravity with its mass.
#[derive(Debug, Clone)]
pub(super) struct Polyhedral {
    gm: f64,
    pub polyhedron: Polyhedron,
    anywhere: Anywhere,
}

impl BodyField {
    /// Of a body, with a gravitational constant.
    pub fn new(
        body: &Body,
        gravitational_constant: f64,
        arch: Arch,
        patience: &mut Patience,
    ) -> Result<Self> {
        let mut parts = Vec::with_capacity(body.parts().len());
        for part in body.parts() {
            parts.push(PartField::new(part, gravitational_constant * part.mass, arch, patience)?);
        }
        Ok(Self { name: body.name.clone(), parts })
    }
}

impl PartField {
    fn new(part: &Part, gm: f64, arch: Arch, patience: &mut Patience) -> Result<Self> {
        let canonical = match &part.shape {
            Shape::Ellipsoid(ellipsoid) => ellipsoid.canonical(),
            Shape::Polyhedron(_) | Shape::Point => Mat3::identity(),
        };
        let kind = if let Shape::Polyhedron(polyhedron) = &part.shape {
            let anywhere = Anywhere::new(polyhedron, arch, patience)?;
            Kind::Polyhedral(Box::new(Polyhedral { gm, polyhedron: polyhedron.clone(), anywhere }))
        } else {
            Kind::Ellipsoidal(Box::new(Ellipsoidal::new(&part.shape, gm)))
        };
        Ok(Self { position: part.position(), turn: canonical * part.rotation().transpose(), kind })
    }

    /// The part's centre in the frame of the points, and what turns that frame's vectors into its own.
    pub fn placed(&self, attractor: &Attractor<'_>) -> (Vec3, Mat3) {
        (attractor.position + attractor.rotation * self.position, self.turn * attractor.rotation.transpose())
    }
}

/// Points whose distance from a polyhedron's surface is below this share of its size lie on it.
const ON_SURFACE: f64 = 1e-14;

impl Polyhedral {
    /// Whether a point of the polyhedron's frame is on its surface, where the gradient jumps and is infinite on edges.
    pub fn is_surface(&self, x: &Vec3) -> bool {
        self.polyhedron.distance(x) <= ON_SURFACE * self.polyhedron.circumradius()
    }

    /// At one point of the polyhedron's frame.
    pub fn at(&self, x: &Vec3) -> PolyhedralField {
        let f = self.anywhere.at(x);
        PolyhedralField {
            potential: self.gm * f.potential,
            field: self.gm * f.field,
            gradient: self.gm * f.gradient,
            ..f
        }
    }
}

/// Phi, g and the six of dg/dx, in the order of [`super::Gravity`].
pub(super) fn columns(f: &PolyhedralField) -> [f64; 10] {
    let (g, m) = (&f.field, &f.gradient);
    let [xx, xy, xz, yy, yz, zz] = [m[(0, 0)], m[(0, 1)], m[(0, 2)], m[(1, 1)], m[(1, 2)], m[(2, 2)]];
    [f.potential, g.x, g.y, g.z, xx, xy, xz, yy, yz, zz]
}
