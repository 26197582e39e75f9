//! Bodies: one part or several, each a shape with a mass. Ellipsoids of any axes (sphere, oblate, prolate, triaxial) and
//! point masses.
//!
//! Takes semi-axes along the part's x, y, z and a mass or density, and where the parts are; gives volume, inertia, principal
//! axes, the focal ellipse and the overlap test. Inertia: the paper's section "Surface integration".

mod body;
mod composite;
mod contact;
mod crossing;
mod distance;
mod ellipsoid;
mod frame;
mod gap;
mod kept;
mod mesh;
mod meeting;
mod part;
mod plane;
mod polyhedron;
mod tree;

pub use body::Body;
pub use contact::{Growth, contact_function, growth};
pub use ellipsoid::Ellipsoid;
pub use frame::WorkingFrame;
pub use gap::gap_between;
pub use meeting::Meeting;
pub use mesh::{Edge, solid_angle};
pub use part::{GivenPart, Part, Place};
pub use plane::{normal, support};
pub use polyhedron::Polyhedron;
pub use tree::{Block, Tree};

use crate::error::{Error, Result, require_positive};
use crate::math::{Mat3, Vec3};
use serde::{Deserialize, Serialize};

/// The shape of a part. Described by its semi-axes, or vertices and faces; none for a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Description", into = "Description")]
pub enum Shape {
    /// A homogeneous ellipsoid.
    Ellipsoid(Ellipsoid),
    /// A homogeneous polyhedron.
    Polyhedron(Polyhedron),
    /// No extent. A body of such a part alone has no spin dynamics.
    Point,
}

impl TryFrom<Option<[f64; 3]>> for Shape {
    type Error = Error;

    fn try_from(semi_axes: Option<[f64; 3]>) -> Result<Self> {
        semi_axes.map_or(Ok(Self::Point), Self::ellipsoid)
    }
}

/// What a shape is made from, for archives and the Python package.
#[derive(Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
enum Description {
    Axes(Option<[f64; 3]>),
    Mesh { vertices: Vec<[f64; 3]>, faces: Vec<[u32; 3]> },
}

impl TryFrom<Description> for Shape {
    type Error = Error;

    fn try_from(description: Description) -> Result<Self> {
        match description {
            Description::Axes(semi_axes) => Self::try_from(semi_axes),
            Description::Mesh { vertices, faces } => {
                let vertices: Vec<Vec3> = vertices.into_iter().map(Vec3::from).collect();
                Ok(Self::Polyhedron(Polyhedron::unchecked(&vertices, &faces)?))
            }
        }
    }
}

impl From<Shape> for Description {
    fn from(shape: Shape) -> Self {
        match shape {
            Shape::Ellipsoid(e) => Self::Axes(Some(e.semi_axes())),
            Shape::Polyhedron(p) => {
                Self::Mesh { vertices: p.given().map(Into::into).collect(), faces: p.faces().to_vec() }
            }
            Shape::Point => Self::Axes(None),
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
            Self::Polyhedron(p) => Self::Polyhedron(p.scaled(factor)),
            Self::Point => Self::Point,
        }
    }

    /// The power of two next below the circumradius, an exact unit of length in which squares and cubes neither
    /// overflow nor underflow; one for a point.
    pub fn natural_unit(&self) -> f64 {
        match self {
            Self::Ellipsoid(_) | Self::Polyhedron(_) => self.circumradius().log2().floor().exp2(),
            Self::Point => 1.0,
        }
    }

    /// Volume; zero for a point.
    pub fn volume(&self) -> f64 {
        match self {
            Self::Ellipsoid(e) => e.volume(),
            Self::Polyhedron(p) => p.volume(),
            Self::Point => 0.0,
        }
    }

    /// Principal moments of inertia of unit mass about the shape's own axes; zeros for a point.
    pub fn inertia_per_mass(&self) -> Vec3 {
        match self {
            Self::Ellipsoid(e) => e.inertia_per_mass(),
            Self::Polyhedron(p) => p.inertia_per_mass(),
            Self::Point => Vec3::zeros(),
        }
    }

    /// The tensor of inertia of unit mass about the centre.
    pub fn inertia_tensor_per_mass(&self) -> Mat3 {
        Mat3::from_diagonal(&self.inertia_per_mass())
    }

    /// Larger semi-axis of the focal ellipse: how far from the centre the mass reaches that attracts alike; zero for a sphere
    /// and a point, all of a polyhedron.
    pub fn focal_reach(&self) -> f64 {
        match self {
            Self::Ellipsoid(e) => e.focal_axes()[0],
            Self::Polyhedron(p) => p.circumradius(),
            Self::Point => 0.0,
        }
    }

    /// Largest distance of a surface point from the centre; zero for a point.
    pub fn circumradius(&self) -> f64 {
        match self {
            Self::Ellipsoid(e) => e.sorted()[0],
            Self::Polyhedron(p) => p.circumradius(),
            Self::Point => 0.0,
        }
    }

    /// Semi-axes along the part's frame; zeros for a point, and for a polyhedron, which has none.
    pub fn semi_axes(&self) -> [f64; 3] {
        match self {
            Self::Ellipsoid(e) => e.semi_axes(),
            Self::Polyhedron(_) | Self::Point => [0.0; 3],
        }
    }
}
