//! Potential and field of one body at single points, with every input and result checked.

use super::{Anywhere, Ellipsoidal};
use crate::error::{Error, Result, require_finite};
use crate::math::Vec3;
use crate::math::lanes::{Lanes, VectorPath};
use crate::patience::Patience;
use crate::shape::{Body, Ellipsoid, Part, Place, Shape};
use pulp::{Arch, Scalar};

/// A body's exterior gravity in its own frame.
#[derive(Debug, Clone)]
pub struct ExteriorField {
    name: String,
    parts: Vec<PartField>,
    /// Whether points inside are welcome.
    inside: bool,
}

/// The gravity of one part.
#[derive(Debug, Clone)]
struct PartField {
    gm: f64,
    /// Unit of length; the shape is in this unit.
    unit: f64,
    shape: Shape,
    place: Option<Place>,
    ellipsoidal: Ellipsoidal,
    /// Of a polyhedron, in the system's unit.
    polyhedron: Option<Anywhere>,
}

/// Distance in units of the body beyond which all but the monopole is below round-off.
const MONOPOLE_FROM: f64 = 1e9;

/// Depth below a polyhedron's surface, in sizes of it, that counts as on the surface.
const SURFACE: f64 = 1e-12;

impl ExteriorField {
    /// Computes the moments of polyhedra that [`Self::new`] takes, which are kept with the shapes.
    pub fn moments(body: &Body, patience: &mut Patience) -> Result<()> {
        let arch = VectorPath::Auto.arch().unwrap_or(Arch::Scalar);
        let mut parts = body.parts().iter();
        parts.try_for_each(|part| match &part.shape {
            Shape::Polyhedron(polyhedron) => Anywhere::new(polyhedron, arch, patience).map(drop),
            _ => Ok(()),
        })
    }

    /// The gravity of a body, with a gravitational constant.
    pub fn new(body: &Body, gravitational_constant: f64) -> Self {
        let field = |part: &Part| {
            let unit = part.shape.natural_unit();
            let shape = part.shape.scaled(1.0 / unit);
            let arch = VectorPath::Auto.arch().unwrap_or(Arch::Scalar);
            let polyhedron = match &part.shape {
                // Endless patience has no end that would be an error.
                Shape::Polyhedron(p) => Anywhere::new(p, arch, &mut Patience::endless()).ok(),
                _ => None,
            };
            PartField {
                gm: gravitational_constant * part.mass,
                unit,
                ellipsoidal: Ellipsoidal::new(&part.shape, gravitational_constant * part.mass),
                shape,
                place: part.place,
                polyhedron,
            }
        };
        Self { name: body.name.clone(), parts: body.parts().iter().map(field).collect(), inside: false }
    }

    /// The same that takes points inside too: the gravity of homogeneous matter there, and none within a homothetic shell.
    pub fn with_inside(self) -> Self {
        Self { inside: true, ..self }
    }

    /// Phi (positive) at a point of the body frame, outside or on the surface.
    pub fn potential(&self, point: &Vec3) -> Result<f64> {
        Ok(self.checked(self.evaluate(point)?)?.0)
    }

    /// g = grad Phi at a point of the body frame, outside or on the surface.
    pub fn field(&self, point: &Vec3) -> Result<Vec3> {
        Ok(self.checked(self.evaluate(point)?)?.1)
    }

    fn evaluate(&self, point: &Vec3) -> Result<(f64, Vec3)> {
        require_finite(&format!("point in the field of {}", self.name), point.as_slice())?;
        // Minus zero: the sum with it leaves any number as it is.
        let (mut potential, mut field) = (-0.0, Vec3::repeat(-0.0));
        for part in &self.parts {
            let (phi, g) = match &part.place {
                None => part.evaluate(point, self.inside),
                Some(place) => part
                    .evaluate(&place.rotation.tr_mul(&(point - place.position)), self.inside)
                    .map(|(phi, g)| (phi, place.rotation * g)),
            }
            .map_err(|expected| self.inside(point, expected))?;
            potential += phi;
            field += g;
        }
        Ok((potential, field))
    }

    fn checked(&self, (potential, field): (f64, Vec3)) -> Result<(f64, Vec3)> {
        let what = format!("field of {}", self.name);
        match [potential, field.x, field.y, field.z].iter().find(|v| !v.is_finite()) {
            None => Ok((potential, field)),
            Some(v) => {
                Err(Error::invalid(what, v, "a finite number; choose units that keep the numbers in range"))
            }
        }
    }

    fn inside(&self, point: &Vec3, expected: &str) -> Error {
        let value = format!("[{}, {}, {}]", point.x, point.y, point.z);
        Error::invalid(format!("point in the field of {}", self.name), value, expected)
    }
}

impl PartField {
    /// Phi and g at a point of the part's frame; what was expected where the point is inside.
    fn evaluate(&self, point: &Vec3, inside: bool) -> std::result::Result<(f64, Vec3), &'static str> {
        if let (Some(polyhedron), Shape::Polyhedron(solid)) = (&self.polyhedron, &self.shape) {
            let f = polyhedron.at(point);
            // Of a point on the surface the angle may be anything.
            if !inside
                && f.solid_angle > 1.0
                && solid.distance(&(point / self.unit)) > SURFACE * solid.circumradius()
            {
                return Err("a point outside or on the surface");
            }
            return Ok((self.gm * f.potential, self.gm * f.field));
        }
        let x = point / self.unit;
        // The largest component is tried first: its square may overflow.
        let distance = x.amax() * (x / x.amax()).norm();
        let Shape::Ellipsoid(ellipsoid) = &self.shape else {
            return match distance {
                d if d > 0.0 => Ok(self.in_units(1.0 / d, -x / d / d / d)),
                _ => Err("a point away from the centre of a point mass"),
            };
        };
        if distance > MONOPOLE_FROM {
            return Ok(self.in_units(1.0 / distance, -x / distance / distance / distance));
        }
        // Points meant to lie on the surface may round to just inside it.
        if x.component_div(&Vec3::from(ellipsoid.semi_axes())).norm_squared() < 1.0 - 1e-12 {
            if !inside {
                return Err("a point outside or on the surface");
            }
        }
        Ok(self.lanes(ellipsoid, point))
    }

    fn lanes(&self, ellipsoid: &Ellipsoid, point: &Vec3) -> (f64, Vec3) {
        let x = ellipsoid.canonical() * point;
        let gravity = self.ellipsoidal.at([x.x, x.y, x.z].map(|x| Lanes::splat(Scalar, x)));
        (
            gravity.potential.first(),
            ellipsoid.canonical().transpose() * Vec3::from(gravity.field.map(Lanes::first)),
        )
    }

    fn in_units(&self, potential: f64, field: Vec3) -> (f64, Vec3) {
        let gm = self.gm / self.unit;
        (gm * potential, gm / self.unit * field)
    }
}
