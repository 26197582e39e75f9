//! A part as the one that attracts: what of its gravity does not depend on the state.

use super::Store;
use crate::error::{Error, Result};
use crate::gravity::{Facets, FarSeries, Layer};
use crate::math::rotation::turned_back;
use crate::math::{Mat3, Vec3};
use crate::patience::Patience;
use crate::quadrature::focal_distance;
use crate::shape::{Ellipsoid, Polyhedron, Shape};
use pulp::Arch;
use std::sync::Arc;

/// What of a part's gravity does not depend on the state.
#[derive(Debug, Clone)]
pub struct BodyGravity {
    pub(super) name: String,
    pub(super) shape: Shape,
    /// From the body frame into the one in which its axes are sorted.
    pub(super) canonical: Mat3,
    /// Whether they are in the body frame.
    sorted: bool,
    /// Semi-axes of the focal ellipse; zeros for what has none.
    focal_axes: [f64; 2],
    pub(super) series: Arc<FarSeries>,
    /// Of a polyhedron in a pair.
    pub(super) facets: Option<Arc<Facets>>,
    pub(super) store: Arc<Store>,
}

impl BodyGravity {
    /// Precomputes for a shape what the store does not have yet; the name is for errors.
    pub fn new(name: &str, shape: &Shape, store: &Arc<Store>) -> Self {
        let (canonical, focal_axes) = match shape {
            Shape::Ellipsoid(e) => (e.canonical(), e.focal_axes()),
            Shape::Polyhedron(_) | Shape::Point => (Mat3::identity(), [0.0; 2]),
        };
        let sorted = canonical == Mat3::identity();
        let (series, store) = (store.series(shape), store.clone());
        let (name, shape) = (name.to_owned(), shape.clone());
        Self { name, shape, canonical, sorted, focal_axes, series, facets: None, store }
    }

    /// The same in units of `unit`, with a polyhedron's facets.
    pub(super) fn in_unit(&self, unit: f64) -> Self {
        let mut scaled = Self::new(&self.name, &self.shape.scaled(1.0 / unit), &self.store);
        scaled.facets = scaled.polyhedron().map(|polyhedron| self.store.facets(polyhedron));
        scaled
    }

    /// A vector of the canonical frame, in the body frame.
    #[inline(always)]
    pub(super) fn in_body(&self, v: Vec3) -> Vec3 {
        if self.sorted { v } else { turned_back(&self.canonical, &v) }
    }

    /// What turns another frame into the body's, as what turns it into the canonical one.
    #[inline(always)]
    pub(super) fn to_canonical(&self, turn: Mat3) -> Mat3 {
        if self.sorted { turn } else { self.canonical * turn }
    }

    /// What turns the body frame into another, as what turns the canonical one into it.
    #[inline(always)]
    pub(super) fn out_of_canonical(&self, turn: Mat3) -> Mat3 {
        if self.sorted { turn } else { turn * self.canonical.transpose() }
    }

    pub(super) fn polyhedron(&self) -> Option<&Polyhedron> {
        match &self.shape {
            Shape::Polyhedron(polyhedron) => Some(polyhedron),
            _ => None,
        }
    }

    /// A polyhedron's layer of a degree.
    pub(super) fn layer(&self, degree: usize, arch: Arch, patience: &mut Patience) -> Result<Arc<Layer>> {
        let Some(polyhedron) = self.polyhedron() else {
            return Err(Error::invalid(&self.name, "without faces", "a polyhedron"));
        };
        self.store.layer(polyhedron, degree, arch, patience)
    }

    pub(super) fn ellipsoid(&self) -> Option<&Ellipsoid> {
        match &self.shape {
            Shape::Ellipsoid(e) => Some(e),
            Shape::Polyhedron(_) | Shape::Point => None,
        }
    }

    /// A bound from below of the distance of a point of the canonical frame from where the exterior potential is singular.
    pub(super) fn singular_distance(&self, arch: Arch, x: &Vec3) -> f64 {
        /// Beyond so many radii the sphere around the body is near enough.
        const FAR: f64 = 3.0;
        let (distance, radius) = (x.norm(), self.shape.focal_reach());
        match (&self.facets, self.ellipsoid()) {
            _ if distance > FAR * radius => distance - radius,
            (Some(facets), _) => facets.edge_distance(arch, x),
            (None, Some(ellipsoid)) => focal_distance(ellipsoid, x),
            (None, None) => distance,
        }
    }

    /// Semi-axes in the canonical frame; zeros for a point.
    pub(super) fn semi_axes(&self) -> [f64; 3] {
        self.ellipsoid().map_or([0.0; 3], Ellipsoid::sorted)
    }

    /// Semi-axes of the focal ellipse; zeros for a sphere or a point.
    pub(super) fn focal_axes(&self) -> [f64; 2] {
        self.focal_axes
    }
}
