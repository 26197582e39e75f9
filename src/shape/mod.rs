//! Bodies: one part or several, each a shape with a mass. Shapes are ellipsoids of any axes (spheres, oblate,
//! prolate and triaxial ones), polyhedra, points, and whatever is known by its Stokes coefficients.
//!
//! Takes the shapes of the parts, their masses or densities, positions and rotations; gives volume, inertia,
//! principal axes, the focal ellipse and the overlap test. The inertia is that of the paper's section
//! "Surface integration".

mod body;
mod composite;
mod contact;
mod crossing;
mod distance;
mod ellipsoid;
mod facets;
mod frame;
mod gap;
mod horizon;
mod moment_cache;
mod mesh;
mod proximity;
mod part;
mod part_derivative;
mod plane;
mod polyhedron;
mod stokes;
mod tree;

pub use body::Body;
#[doc(hidden)]
pub use contact::{Growth, growth};
pub(crate) use distance::least_distance;
pub use ellipsoid::Ellipsoid;
pub use facets::Facets;
pub use frame::WorkingFrame;
#[doc(hidden)]
pub use gap::gap_between;
#[doc(hidden)]
pub use horizon::Horizons;
#[doc(hidden)]
pub use mesh::{Edge, solid_angle};
#[doc(hidden)]
pub use part::Placement;
pub use part::{InputPart, Part};
#[doc(hidden)]
pub use part_derivative::{PartDerivative, PartNumber};
#[doc(hidden)]
pub use plane::{across_separating_plane, normal, support, tip};
pub use polyhedron::Polyhedron;
pub(crate) use polyhedron::solid_moments;
#[doc(hidden)]
pub use proximity::Proximity;
pub use stokes::{InputCoefficients, StokesCoefficients, StokesNumber};
#[doc(hidden)]
pub use tree::{BoundingBox, Tree};

use crate::error::{Error, Result, require_positive};
use crate::math::{Mat3, Vec3};
use serde::{Deserialize, Serialize};

/// The shape of a part. Its description consists of the semi-axes, of vertices and faces, of Stokes
/// coefficients, or of nothing for a point.
///
/// ```
/// use fullbody::shape::Shape;
///
/// assert!(matches!(Shape::ellipsoid([1.0, 2.0, 1.5])?, Shape::Ellipsoid(_)));
/// let refused = Shape::ellipsoid([1.0, -2.0, 1.5]).unwrap_err();
/// assert!(refused.to_string().contains("-2"));
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "ShapeDescription", into = "ShapeDescription")]
#[non_exhaustive]
pub enum Shape {
    /// A homogeneous ellipsoid.
    Ellipsoid(Ellipsoid),
    /// A homogeneous polyhedron.
    Polyhedron(Polyhedron),
    /// A shape that is known by its gravity, without a surface.
    Stokes(StokesCoefficients),
    /// A point without extent. A body that is a point has no rotational dynamics.
    Point,
}

impl TryFrom<Option<[f64; 3]>> for Shape {
    type Error = Error;

    fn try_from(semi_axes: Option<[f64; 3]>) -> Result<Self> {
        semi_axes.map_or(Ok(Self::Point), Self::ellipsoid)
    }
}

/// The description of a shape in archives and for the Python package.
#[derive(Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
enum ShapeDescription {
    Axes(Option<[f64; 3]>),
    Mesh { vertices: Vec<[f64; 3]>, faces: Vec<[u32; 3]> },
    Stokes(InputCoefficients),
}

impl TryFrom<ShapeDescription> for Shape {
    type Error = Error;

    fn try_from(description: ShapeDescription) -> Result<Self> {
        match description {
            ShapeDescription::Axes(semi_axes) => Self::try_from(semi_axes),
            ShapeDescription::Mesh { vertices, faces } => {
                let vertices: Vec<Vec3> = vertices.into_iter().map(Vec3::from).collect();
                Ok(Self::Polyhedron(Polyhedron::unchecked(&vertices, &faces)?))
            }
            ShapeDescription::Stokes(given) => Ok(Self::Stokes(StokesCoefficients::new(given)?)),
        }
    }
}

impl From<Shape> for ShapeDescription {
    fn from(shape: Shape) -> Self {
        match shape {
            Shape::Ellipsoid(e) => Self::Axes(Some(e.semi_axes())),
            Shape::Polyhedron(p) => Self::Mesh {
                vertices: p.input_vertices().map(Into::into).collect(),
                faces: p.faces().to_vec(),
            },
            Shape::Stokes(stokes) => Self::Stokes(stokes.input().clone()),
            Shape::Point => Self::Axes(None),
        }
    }
}

impl Shape {
    /// Makes an ellipsoid with semi-axes along x, y, z in any order; equal ones are allowed.
    ///
    /// # Errors
    /// Returns the errors of [`Ellipsoid::new`].
    pub fn ellipsoid(semi_axes: [f64; 3]) -> Result<Self> {
        Ok(Self::Ellipsoid(Ellipsoid::new(semi_axes)?))
    }

    /// Makes a sphere.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a radius that is not a finite number above zero.
    pub fn sphere(radius: f64) -> Result<Self> {
        require_positive("radius", radius)?;
        Self::ellipsoid([radius; 3])
    }

    /// Returns the shape with all lengths multiplied by a factor above zero.
    #[doc(hidden)]
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::Ellipsoid(e) => Self::Ellipsoid(e.scaled(factor)),
            Self::Polyhedron(p) => Self::Polyhedron(p.scaled(factor)),
            Self::Stokes(stokes) => Self::Stokes(stokes.scaled(factor)),
            Self::Point => Self::Point,
        }
    }

    /// Returns the largest power of two below the circumradius: an exact unit of length in which squares and
    /// cubes neither overflow nor underflow. It is one for a point.
    pub fn natural_unit(&self) -> f64 {
        match self {
            Self::Ellipsoid(_) | Self::Polyhedron(_) | Self::Stokes(_) => {
                self.circumradius().log2().floor().exp2()
            }
            Self::Point => 1.0,
        }
    }

    /// Returns the volume; zero for a point and for a shape without a surface.
    pub fn volume(&self) -> f64 {
        match self {
            Self::Ellipsoid(e) => e.volume(),
            Self::Polyhedron(p) => p.volume(),
            Self::Stokes(_) | Self::Point => 0.0,
        }
    }

    /// Returns the principal moments of inertia of unit mass about the shape's own axes; zeros for a point.
    pub fn inertia_per_mass(&self) -> Vec3 {
        match self {
            Self::Ellipsoid(e) => e.inertia_per_mass(),
            Self::Polyhedron(p) => p.inertia_per_mass(),
            Self::Stokes(stokes) => stokes.inertia_per_mass(),
            Self::Point => Vec3::zeros(),
        }
    }

    /// Returns the inertia tensor of unit mass about the centre.
    pub fn inertia_tensor_per_mass(&self) -> Mat3 {
        Mat3::from_diagonal(&self.inertia_per_mass())
    }

    /// Returns how far from the centre an equivalent mass distribution with the same exterior field extends:
    /// the larger semi-axis of the focal ellipse, zero for a sphere or a point, and the circumradius of any
    /// other shape.
    pub fn focal_reach(&self) -> f64 {
        match self {
            Self::Ellipsoid(e) => e.focal_axes()[0],
            Self::Polyhedron(p) => p.circumradius(),
            Self::Stokes(stokes) => stokes.radius(),
            Self::Point => 0.0,
        }
    }

    /// Returns the largest distance of a surface point from the centre, or an upper bound of it; zero for a
    /// point.
    pub fn circumradius(&self) -> f64 {
        match self {
            Self::Ellipsoid(e) => e.sorted()[0],
            Self::Polyhedron(p) => p.circumradius(),
            Self::Stokes(stokes) => stokes.radius(),
            Self::Point => 0.0,
        }
    }

    /// Returns the semi-axes along the part's frame; zeros for a shape that has none.
    pub fn semi_axes(&self) -> [f64; 3] {
        match self {
            Self::Ellipsoid(e) => e.semi_axes(),
            Self::Polyhedron(_) | Self::Stokes(_) | Self::Point => [0.0; 3],
        }
    }
}
