//! Bodies: a shape with a mass. Ellipsoids of any axes (sphere, oblate, prolate, triaxial) and point masses.
//!
//! Takes semi-axes along the body frame's x, y, z and a mass or density; gives volume, inertia, the focal
//! ellipse and the overlap test. Inertia: the paper's section "Surface integration".

mod contact;
mod crossing;
mod distance;
mod ellipsoid;
mod mesh;
mod plane;
mod polyhedron;
mod tree;

pub use contact::{Growth, contact_function, growth};
pub use ellipsoid::Ellipsoid;
pub use mesh::{Edge, solid_angle};
pub use plane::{normal, support};
pub use polyhedron::Polyhedron;
pub use tree::{Block, Tree};

use crate::error::{Error, Result, require_positive};
use crate::math::Vec3;
use serde::{Deserialize, Serialize};

/// The shape of a body. Described by its semi-axes; none for a point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Option<[f64; 3]>", into = "Option<[f64; 3]>")]
pub enum Shape {
    /// A homogeneous ellipsoid.
    Ellipsoid(Ellipsoid),
    /// A body without extent; it has no spin dynamics.
    Point,
}

/// A shape with a mass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// The name that errors and tables use.
    pub name: String,
    /// The shape.
    #[serde(rename = "semi_axes")]
    pub shape: Shape,
    /// Mass in the system's units.
    pub mass: f64,
}

impl Body {
    /// A body of given mass.
    pub fn with_mass(name: impl Into<String>, shape: Shape, mass: f64) -> Result<Self> {
        let name = name.into();
        require_positive(&format!("mass of {name}"), mass)?;
        Ok(Self { name, shape, mass })
    }

    /// A body of given density; a point has none.
    pub fn with_density(name: impl Into<String>, shape: Shape, density: f64) -> Result<Self> {
        let name = name.into();
        require_positive(&format!("density of {name}"), density)?;
        match shape {
            Shape::Ellipsoid(e) => Self::with_mass(name, shape, density * e.volume()),
            Shape::Point => {
                Err(Error::invalid(format!("density of {name}"), density, "a mass: a point has no volume"))
            }
        }
    }

    /// Principal moments of inertia (I11, I22, I33); zero for a point.
    pub fn inertia(&self) -> Vec3 {
        match self.shape {
            Shape::Ellipsoid(e) => e.inertia_per_mass() * self.mass,
            Shape::Point => Vec3::zeros(),
        }
    }
}

impl TryFrom<Option<[f64; 3]>> for Shape {
    type Error = Error;

    fn try_from(semi_axes: Option<[f64; 3]>) -> Result<Self> {
        semi_axes.map_or(Ok(Self::Point), Self::ellipsoid)
    }
}

impl From<Shape> for Option<[f64; 3]> {
    fn from(shape: Shape) -> Self {
        match shape {
            Shape::Ellipsoid(e) => Some(e.semi_axes()),
            Shape::Point => None,
        }
    }
}

impl Shape {
    /// An ellipsoid; semi-axes along x, y, z in any order, equal ones welcome.
    pub fn ellipsoid(semi_axes: [f64; 3]) -> Result<Self> {
        Ok(Self::Ellipsoid(Ellipsoid::new(semi_axes)?))
    }

    /// A sphere.
    pub fn sphere(radius: f64) -> Result<Self> {
        require_positive("radius", radius)?;
        Self::ellipsoid([radius; 3])
    }

    /// The same shape with all lengths times a factor above zero.
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::Ellipsoid(e) => Self::Ellipsoid(e.scaled(factor)),
            Self::Point => Self::Point,
        }
    }

    /// The power of two next below the largest semi-axis, an exact unit of length in which squares and cubes neither
    /// overflow nor underflow; one for a point.
    pub fn natural_unit(&self) -> f64 {
        match self {
            Self::Ellipsoid(_) => self.circumradius().log2().floor().exp2(),
            Self::Point => 1.0,
        }
    }

    /// Largest distance of a surface point from the centre; zero for a point.
    pub fn circumradius(&self) -> f64 {
        match self {
            Self::Ellipsoid(e) => e.sorted()[0],
            Self::Point => 0.0,
        }
    }

    /// Semi-axes along the body frame; zeros for a point.
    pub fn semi_axes(&self) -> [f64; 3] {
        match self {
            Self::Ellipsoid(e) => e.semi_axes(),
            Self::Point => [0.0; 3],
        }
    }
}
