//! Bodies: one part, or several parts that are rigid together.

use super::composite::Assembly;
use super::frame::WorkingFrame;
use super::{Facets, InputPart, Part, Shape};
use crate::error::{Error, Result, require_positive};
use crate::math::Vec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A body: one part, or several parts that are rigid together. The body frame has its origin in the centre of
/// mass and its axes along the principal axes of inertia.
///
/// ```
/// use fullbody::math::Vec3;
/// use fullbody::shape::{Body, Shape};
///
/// let body = Body::with_density("Beta", Shape::ellipsoid([3.0, 2.0, 1.0])?, 0.5)?;
/// assert!((body.mass() - 4.0 * std::f64::consts::PI).abs() < 1e-14);
/// // m (b^2 + c^2) / 5 and so on.
/// assert!((body.inertia() / body.mass() - Vec3::new(1.0, 2.0, 2.6)).norm() < 1e-15);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "BodyDescription", into = "BodyDescription")]
pub struct Body {
    /// The name that errors and tables use.
    pub(crate) name: String,
    /// The mass in the system's units.
    pub(crate) mass: f64,
    parts: Vec<Part>,
    inertia: Vec3,
    /// The indices of the parts that are not inside another one.
    outer: Vec<usize>,
    circumradius: f64,
    /// The description of a composite as it was given, with its working frame.
    input: Option<(Vec<InputPart>, WorkingFrame)>,
    /// The facets of a body that is known by its light; its part is a point.
    facets: Option<Facets>,
}

impl Body {
    /// Makes a body of one shape with a given mass.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a mass that is not a finite number above zero.
    pub fn with_mass(name: impl Into<String>, shape: Shape, mass: f64) -> Result<Self> {
        let name = name.into();
        require_positive(&format!("mass of {name}"), mass)?;
        Ok(Self {
            name,
            mass,
            inertia: shape.inertia_per_mass() * mass,
            outer: vec![0],
            circumradius: shape.circumradius(),
            parts: vec![Part { shape, mass, placement: None }],
            input: None,
            facets: None,
        })
    }

    /// Makes a body that is known by the light of its facets, and not by its gravity. Its moments of inertia are
    /// equal, those of the homogeneous sphere with the same surface, so that it spins uniformly about any axis.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a mass that is not a finite number above zero.
    pub fn of_facets(name: impl Into<String>, facets: Facets, mass: f64) -> Result<Self> {
        let point = Self::with_mass(name, Shape::Point, mass)?;
        let circumradius = facets.radius();
        let inertia = Vec3::repeat(0.4 * mass * circumradius * circumradius);
        Ok(Self { inertia, circumradius, facets: Some(facets), ..point })
    }

    /// Makes a body of one shape with a given density; a point has none.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a density that is not a finite number above zero, and for a point.
    pub fn with_density(name: impl Into<String>, shape: Shape, density: f64) -> Result<Self> {
        let name = name.into();
        require_positive(&format!("density of {name}"), density)?;
        match shape.volume() {
            volume if volume > 0.0 => Self::with_mass(name, shape, density * volume),
            _ => {
                Err(Error::invalid(format!("density of {name}"), density, "a mass: its shape has no volume"))
            }
        }
    }

    /// Makes a body of several parts, or of one part that is not at the origin.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] names the part whose mass or place is not finite; the mass and the moments of
    /// inertia of the whole have to be those of a possible body.
    pub fn composite(name: impl Into<String>, input: Vec<InputPart>) -> Result<Self> {
        let name = name.into();
        let Assembly { mass, parts, inertia, outer, frame } = Assembly::new(&name, &input)?;
        let reach = |part: &Part| part.position().norm() + part.shape.circumradius();
        let circumradius = parts.iter().map(reach).fold(0.0, f64::max);
        Ok(Self {
            name,
            mass,
            inertia,
            outer,
            circumradius,
            parts,
            input: Some((input, frame)),
            facets: None,
        })
    }

    /// Returns the name that errors and tables use.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the mass in the system's units.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Returns the parts, in the body frame.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Iterates over the parts that are not inside another one; together they have the extent of the body. A
    /// void counts like any other part, so that a void that opens to the surface is closed to other bodies.
    pub fn outer_parts(&self) -> impl Iterator<Item = &Part> + Clone {
        self.outer.iter().map(|&part| &self.parts[part])
    }

    /// Returns the principal moments of inertia (I11, I22, I33); zero for a point.
    pub fn inertia(&self) -> Vec3 {
        self.inertia
    }

    /// Returns an upper bound of the distance of the body's points from its centre: the largest semi-axis of
    /// an ordinary body, the largest sum of a part's offset and its circumradius for a composite, and zero
    /// for a point.
    pub fn circumradius(&self) -> f64 {
        self.circumradius
    }

    /// Returns the sum of the magnitudes of the parts' masses.
    pub fn mass_without_signs(&self) -> f64 {
        if self.input.is_none() { self.mass } else { self.parts.iter().map(|part| part.mass.abs()).sum() }
    }

    /// Returns the volume of an ordinary body, zero for a point. For a composite, whose parts may overlap, it
    /// is that of the ellipsoid with its [`Self::semi_axes`].
    pub fn volume(&self) -> f64 {
        if self.input.is_none() {
            return self.parts[0].shape.volume();
        }
        let [a, b, c] = self.semi_axes();
        4.0 * PI / 3.0 * a * b * c
    }

    /// Returns the semi-axes along the body frame: those of an ellipsoid, zeros for a point, and for a
    /// composite, a polyhedron or Stokes coefficients those of the homogeneous ellipsoid with the same mass
    /// and moments of inertia.
    pub fn semi_axes(&self) -> [f64; 3] {
        let by_inertia = matches!(self.parts[0].shape, Shape::Polyhedron(_) | Shape::Stokes(_));
        if self.input.is_none() && self.facets.is_none() && !by_inertia {
            return self.parts[0].shape.semi_axes();
        }
        let all = self.inertia.sum();
        [0, 1, 2].map(|k| (2.5 * (all - 2.0 * self.inertia[k]) / self.mass).max(0.0).sqrt())
    }

    /// Returns an error for a body whose surface is not known, where one is asked for.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a body that is given by Stokes coefficients.
    pub fn require_surface(&self) -> Result<()> {
        if let Shape::Stokes(_) = self.parts[0].shape {
            let expected =
                "a body with a surface, which contact, occultations, light, projectiles and launches need";
            return Err(Error::invalid(&self.name, "given by its Stokes coefficients", expected));
        }
        self.require_vertices()
    }

    /// Returns an error for a body of which only the facets are known, where its vertices are needed.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a body that is given by areas and normals of its facets.
    pub fn require_vertices(&self) -> Result<()> {
        if self.facets.is_some() {
            let expected =
                "its polyhedron, which gravity, contact and occultations need: ConvexShape.polyhedron()";
            return Err(Error::invalid(&self.name, "given by areas and normals of facets", expected));
        }
        Ok(())
    }

    /// Returns the facets of a body that is known by its light.
    pub fn facets(&self) -> Option<&Facets> {
        self.facets.as_ref()
    }

    /// Returns the parts of a composite as they were given, in its working frame; none for an ordinary body.
    pub fn input_parts(&self) -> &[InputPart] {
        self.input.as_ref().map_or(&[], |(parts, _)| parts)
    }

    /// Returns where the working frame of a composite, a polyhedron or Stokes coefficients lies in the body
    /// frame; `None` for other bodies.
    pub fn working_frame(&self) -> Option<WorkingFrame> {
        match (&self.input, &self.parts[0].shape) {
            (Some((_, frame)), _) => Some(*frame),
            (None, Shape::Polyhedron(polyhedron)) => Some(polyhedron.working_frame()),
            (None, Shape::Stokes(stokes)) => Some(stokes.working_frame()),
            _ => None,
        }
    }

    /// Returns whether the body has several parts, or one that is not at the origin.
    pub fn is_composite(&self) -> bool {
        self.input.is_some()
    }
}

/// The description of a body in archives and for the Python package.
#[derive(Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
enum BodyDescription {
    Ordinary {
        name: String,
        // Without this attribute an absent shape would be read as that of a point.
        #[serde(rename = "semi_axes", deserialize_with = "Shape::deserialize")]
        shape: Shape,
        mass: f64,
    },
    Composite {
        name: String,
        parts: Vec<InputPart>,
    },
    Facets {
        name: String,
        facets: Facets,
        mass: f64,
    },
}

impl TryFrom<BodyDescription> for Body {
    type Error = Error;

    fn try_from(description: BodyDescription) -> Result<Self> {
        match description {
            BodyDescription::Ordinary { name, shape, mass } => Self::with_mass(name, shape, mass),
            BodyDescription::Composite { name, parts } => Self::composite(name, parts),
            BodyDescription::Facets { name, facets, mass } => Self::of_facets(name, facets, mass),
        }
    }
}

impl From<Body> for BodyDescription {
    fn from(body: Body) -> Self {
        match body {
            Body { name, input: Some((parts, _)), .. } => Self::Composite { name, parts },
            Body { name, facets: Some(facets), mass, .. } => Self::Facets { name, facets, mass },
            Body { name, mass, mut parts, .. } => {
                Self::Ordinary { name, shape: parts.swap_remove(0).shape, mass }
            }
        }
    }
}
