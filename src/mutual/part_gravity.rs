//! The state-independent part of a body part's gravity.

use super::Store;
use crate::error::{Error, Result};
use crate::gravity::{Facets, FarSeries, Layer};
use crate::interrupt::InterruptCheck;
use crate::math::rotation::rotate_back;
use crate::math::{Mat3, Vec3};
use crate::quadrature::focal_distance;
use crate::shape::{Ellipsoid, Polyhedron, Shape};
use pulp::Arch;
use std::sync::Arc;

/// The state-independent part of a body part's gravity: shape, canonical frame, series and facets.
#[derive(Debug, Clone)]
pub struct PartGravity {
    pub(super) name: String,
    pub(super) shape: Shape,
    /// Rotation from the body frame into the canonical frame, in which the axes are sorted.
    pub(super) canonical: Mat3,
    /// Whether the axes are sorted in the body frame already.
    sorted: bool,
    /// Semi-axes of the focal ellipse; zeros for a shape without one.
    focal_axes: [f64; 2],
    pub(super) series: Arc<FarSeries>,
    /// The facets of a polyhedron that is part of a pair.
    pub(super) facets: Option<Arc<Facets>>,
    pub(super) store: Arc<Store>,
}

impl PartGravity {
    /// Computes what the store does not have yet for a shape; the name is used in error messages.
    pub fn new(name: &str, shape: &Shape, store: &Arc<Store>) -> Self {
        let (canonical, focal_axes) = match shape {
            Shape::Ellipsoid(e) => (e.canonical(), e.focal_axes()),
            _ => (Mat3::identity(), [0.0; 2]),
        };
        let sorted = canonical == Mat3::identity();
        let (series, store) = (store.series(shape), store.clone());
        let (name, shape) = (name.to_owned(), shape.clone());
        Self { name, shape, canonical, sorted, focal_axes, series, facets: None, store }
    }

    /// Returns the part in units of `unit`, with a polyhedron's facets.
    pub(super) fn in_unit(&self, unit: f64) -> Self {
        let mut scaled = Self::new(&self.name, &self.shape.scaled(1.0 / unit), &self.store);
        scaled.facets = scaled.polyhedron().map(|polyhedron| self.store.facets(polyhedron));
        scaled
    }

    /// Rotates a vector from the canonical frame into the body frame.
    #[inline(always)]
    pub(super) fn in_body(&self, v: Vec3) -> Vec3 {
        if self.sorted { v } else { rotate_back(&self.canonical, &v) }
    }

    /// Converts a rotation into the body frame to a rotation into the canonical frame.
    #[inline(always)]
    pub(super) fn rotation_to_canonical(&self, rotation: Mat3) -> Mat3 {
        if self.sorted { rotation } else { self.canonical * rotation }
    }

    /// Converts a rotation that starts in the body frame to one that starts in the canonical frame.
    #[inline(always)]
    pub(super) fn rotation_from_canonical(&self, rotation: Mat3) -> Mat3 {
        if self.sorted { rotation } else { rotation * self.canonical.transpose() }
    }

    pub(super) fn polyhedron(&self) -> Option<&Polyhedron> {
        match &self.shape {
            Shape::Polyhedron(polyhedron) => Some(polyhedron),
            _ => None,
        }
    }

    /// Returns a polyhedron's layer of a degree.
    pub(super) fn layer(
        &self,
        degree: usize,
        arch: Arch,
        interrupt: &mut InterruptCheck,
    ) -> Result<Arc<Layer>> {
        let Some(polyhedron) = self.polyhedron() else {
            return Err(Error::invalid(&self.name, "without faces", "a polyhedron"));
        };
        self.store.layer(polyhedron, degree, arch, interrupt)
    }

    pub(super) fn ellipsoid(&self) -> Option<&Ellipsoid> {
        match &self.shape {
            Shape::Ellipsoid(e) => Some(e),
            _ => None,
        }
    }

    /// Returns a lower bound of the distance of a point of the canonical frame from the singular set of the
    /// exterior potential.
    pub(super) fn singular_distance(&self, arch: Arch, x: &Vec3) -> f64 {
        /// Beyond this many radii the sphere around the body is a good enough bound.
        const FAR: f64 = 3.0;
        let (distance, radius) = (x.norm(), self.shape.focal_reach());
        match (&self.facets, self.ellipsoid()) {
            _ if distance > FAR * radius => distance - radius,
            (Some(facets), _) => facets.edge_distance(arch, x),
            (None, Some(ellipsoid)) => focal_distance(ellipsoid, x),
            (None, None) => distance,
        }
    }

    /// Returns the semi-axes in the canonical frame; zeros for a point.
    pub(super) fn semi_axes(&self) -> [f64; 3] {
        self.ellipsoid().map_or([0.0; 3], Ellipsoid::sorted)
    }

    /// Returns, for each axis of the body's frame, its index among the canonical axes.
    pub(super) fn rows_of_axes(&self) -> [usize; 3] {
        [0, 1, 2].map(|axis| (0..3).find(|&row| self.canonical[(row, axis)] != 0.0).unwrap_or(axis))
    }

    /// Returns the semi-axes of the focal ellipse; zeros for a sphere or a point.
    pub(super) fn focal_axes(&self) -> [f64; 2] {
        self.focal_axes
    }
}
