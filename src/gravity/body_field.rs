//! The gravity of a body at points anywhere: the sum over its parts.

use super::ellipsoidal::{rotate, rotate_back};
use super::{Ellipsoidal, HarmonicField, PolyhedralField, PolyhedronGravity};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::lanes::{Lanes, minus};
use crate::math::{Mat3, Vec3};
use crate::shape::{Body, Part, Polyhedron, Shape};
use pulp::{Arch, Simd};

/// The gravity of a body in its own frame.
#[derive(Debug, Clone)]
pub struct BodyField {
    /// The name of the body.
    pub name: String,
    /// G times the body's mass.
    pub gm: f64,
    pub(super) parts: Vec<PartField>,
}

/// The gravity of one part.
#[derive(Debug, Clone)]
pub(super) struct PartField {
    pub position: Vec3,
    /// Whether the part is at the body's centre.
    centred: bool,
    /// The rotation from the body frame into the frame in which the part's axes are sorted.
    pub rotation: Mat3,
    pub kind: PartFieldKind,
}

#[derive(Debug, Clone)]
pub(super) enum PartFieldKind {
    /// An ellipsoid, a sphere or a point.
    Ellipsoidal(Box<Ellipsoidal>),
    /// A field that is evaluated point by point.
    Pointwise(Box<Pointwise>),
}

/// The gravity of a body at its position and attitude.
#[derive(Debug, Clone, Copy)]
pub struct Attractor<'a> {
    /// The gravity of the body in its own frame.
    pub field: &'a BodyField,
    /// The position of the body's centre in the frame of the points.
    pub position: Vec3,
    /// The rotation from the body frame into the frame of the points.
    pub rotation: Mat3,
}

/// The gravity of a polyhedron or of Stokes coefficients, with its mass.
#[derive(Debug, Clone)]
pub(super) struct Pointwise {
    gm: f64,
    source: Source,
}

#[derive(Debug, Clone)]
enum Source {
    Polyhedron(Polyhedron, PolyhedronGravity),
    Harmonics(HarmonicField),
}

impl BodyField {
    /// Prepares the gravity of a body.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::error::Error::Interrupted), while a polyhedron is prepared, and
    /// [`Error::InvalidInput`](crate::error::Error::InvalidInput) for a body of which only the facets are known.
    pub fn new(
        body: &Body,
        gravitational_constant: f64,
        arch: Arch,
        interrupt: &mut InterruptCheck,
    ) -> Result<Self> {
        body.require_vertices()?;
        let mut parts = Vec::with_capacity(body.parts().len());
        for part in body.parts() {
            parts.push(PartField::new(part, gravitational_constant * part.mass, arch, interrupt)?);
        }
        Ok(Self { name: body.name.clone(), gm: gravitational_constant * body.mass, parts })
    }

    /// Returns whether the field outside the body is that of its mass at its centre, whatever its attitude.
    pub fn is_central(&self) -> bool {
        self.parts.iter().all(|part| {
            part.centred && matches!(&part.kind, PartFieldKind::Ellipsoidal(kind) if kind.is_central())
        })
    }

    /// Returns g at points of the body frame outside the body, without the contributions that are evaluated
    /// point by point, which [`Self::pointwise_outside`] returns.
    #[inline(always)]
    pub fn field_outside<S: Simd>(&self, y: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
        let mut sum = [y[0].constant(0.0); 3];
        for part in &self.parts {
            let PartFieldKind::Ellipsoidal(kind) = &part.kind else { continue };
            let part_gravity = part.field_outside(kind, y);
            for k in 0..3 {
                sum[k] = sum[k] + part_gravity[k];
            }
        }
        sum
    }

    /// Returns the contribution of the body's polyhedra and Stokes coefficients to g at a point of the body
    /// frame outside the body.
    pub fn pointwise_outside(&self, y: &Vec3) -> Vec3 {
        let mut sum = Vec3::zeros();
        for part in &self.parts {
            if let PartFieldKind::Pointwise(kind) = &part.kind {
                sum += part.rotation.tr_mul(&kind.outside(&(part.rotation * (y - part.position))).field);
            }
        }
        sum
    }

    /// Returns whether parts of the body are evaluated point by point.
    pub fn is_pointwise(&self) -> bool {
        self.parts.iter().any(|part| matches!(part.kind, PartFieldKind::Pointwise(_)))
    }
}

impl PartField {
    fn new(part: &Part, gm: f64, arch: Arch, interrupt: &mut InterruptCheck) -> Result<Self> {
        let canonical = match &part.shape {
            Shape::Ellipsoid(ellipsoid) => ellipsoid.canonical(),
            _ => Mat3::identity(),
        };
        let source = match &part.shape {
            Shape::Polyhedron(polyhedron) => Some(Source::Polyhedron(
                polyhedron.clone(),
                PolyhedronGravity::new(polyhedron, arch, interrupt)?,
            )),
            Shape::Stokes(stokes) => {
                Some(Source::Harmonics(HarmonicField::new(stokes.moments(), stokes.radius())))
            }
            Shape::Ellipsoid(_) | Shape::Point => None,
        };
        let kind = match source {
            Some(source) => PartFieldKind::Pointwise(Box::new(Pointwise { gm, source })),
            None => PartFieldKind::Ellipsoidal(Box::new(Ellipsoidal::new(&part.shape, gm))),
        };
        let (position, rotation) = (part.position(), canonical * part.rotation().transpose());
        Ok(Self { position, centred: position == Vec3::zeros(), rotation, kind })
    }

    /// Returns g of an ellipsoidal part at points of the body frame outside the body.
    #[inline(always)]
    fn field_outside<S: Simd>(&self, kind: &Ellipsoidal, y: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
        let (c, p) = (|value| y[0].constant(value), &self.position);
        let y = if self.centred { y } else { minus(y, [c(p.x), c(p.y), c(p.z)]) };
        if kind.is_central() {
            return kind.central_field(y);
        }
        rotate_back(kind.at(rotate(y, &self.rotation)).field, &self.rotation)
    }

    /// Returns the part's centre in the frame of the points, and the rotation from that frame into the part's
    /// frame.
    pub fn pose_in_points_frame(&self, attractor: &Attractor<'_>) -> (Vec3, Mat3) {
        (
            attractor.position + attractor.rotation * self.position,
            self.rotation * attractor.rotation.transpose(),
        )
    }
}

/// The distance from a polyhedron's surface, relative to the polyhedron's size, below which a point counts as
/// lying on the surface.
const ON_SURFACE: f64 = 1e-14;

impl Pointwise {
    /// Returns whether a point of the part's frame is on the surface of a polyhedron, where the gradient jumps
    /// and is infinite on edges.
    pub fn is_surface(&self, x: &Vec3) -> bool {
        match &self.source {
            Source::Polyhedron(polyhedron, _) => {
                polyhedron.distance(x) <= ON_SURFACE * polyhedron.circumradius()
            }
            Source::Harmonics(_) => false,
        }
    }

    /// Returns the least distance from the centre at which the field is known.
    pub fn least_distance(&self) -> f64 {
        match &self.source {
            Source::Polyhedron(..) => 0.0,
            Source::Harmonics(field) => field.radius(),
        }
    }

    /// Returns the work at a point, in facets of a polyhedron.
    pub fn work(&self) -> usize {
        match &self.source {
            Source::Polyhedron(polyhedron, _) => polyhedron.faces().len(),
            Source::Harmonics(field) => field.work(),
        }
    }

    /// Returns the field at a point of the part's frame; NaN where it is not known.
    pub fn at(&self, x: &Vec3) -> PolyhedralField {
        if x.norm() < self.least_distance() {
            let (field, gradient) = (Vec3::repeat(f64::NAN), Mat3::repeat(f64::NAN));
            return PolyhedralField { potential: f64::NAN, field, gradient, solid_angle: f64::NAN };
        }
        self.outside(x)
    }

    /// Returns the field at a point of the part's frame outside the body, and a continuation of it into the
    /// sphere that contains Stokes coefficients.
    fn outside(&self, x: &Vec3) -> PolyhedralField {
        let f = match &self.source {
            Source::Polyhedron(_, gravity) => gravity.at(x),
            Source::Harmonics(field) => field.at(x),
        };
        PolyhedralField {
            potential: self.gm * f.potential,
            field: self.gm * f.field,
            gradient: self.gm * f.gradient,
            ..f
        }
    }
}

/// Returns Phi, g and the six numbers of dg/dx, in the order of [`super::Gravity`].
pub(super) fn columns(f: &PolyhedralField) -> [f64; 10] {
    let (g, m) = (&f.field, &f.gradient);
    let [xx, xy, xz, yy, yz, zz] = [m[(0, 0)], m[(0, 1)], m[(0, 2)], m[(1, 1)], m[(1, 2)], m[(2, 2)]];
    [f.potential, g.x, g.y, g.z, xx, xy, xz, yy, yz, zz]
}
