//! The bodies whose brightness is computed: their surfaces, their facets, and the Sun's disc.

use super::law::Law;
use super::mesh::Mesh;
use crate::error::{Error, Result};
use crate::math::{Vec3, perpendicular};
use crate::shape::{Body, Part, Shape};
use gauss_quad::GaussLegendre;
use std::f64::consts::TAU;
use std::num::NonZeroUsize;

/// How a body reflects light.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// The scattering law.
    pub law: Law,
    /// The albedo, by which the brightness is multiplied: one number, or one for each face of a polyhedron.
    pub albedo: Vec<f64>,
}

/// Bodies with the data that do not change from one view to the next.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The bodies.
    pub bodies: Vec<Body>,
    /// Their surfaces.
    pub surfaces: Vec<Surface>,
    /// Whether bodies can hide each other.
    mutual: bool,
    /// Points of the Sun's disc, each as two coordinates in radians from its centre and a weight.
    pub sun: Vec<[f64; 3]>,
    /// The semi-axes of each body that is one ellipsoid about its centre.
    pub semi_axes: Vec<Option<Vec3>>,
    /// The facets of each part of each body; empty where all bodies are ellipsoids.
    pub meshes: Vec<Mesh>,
}

/// Numbers of rings on the Sun's disc and of points on each ring.
const RINGS: NonZeroUsize = NonZeroUsize::new(6).unwrap();
const ANGLES: usize = 12;

impl Scene {
    /// Takes bodies with their surfaces. If `mutual` is false, occultations and eclipses are neglected. The
    /// Sun's radius is an angle in radians, zero for parallel light.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] if the numbers of bodies and surfaces differ, and for an albedo, a law or a
    /// radius of the Sun out of its range, and for a body without a known surface.
    pub fn new(bodies: Vec<Body>, surfaces: Vec<Surface>, mutual: bool, sun_radius: f64) -> Result<Self> {
        if surfaces.len() != bodies.len() {
            return Err(Error::invalid("number of surfaces", surfaces.len(), format!("{}", bodies.len())));
        }
        for (body, surface) in bodies.iter().zip(&surfaces) {
            let areas = body.facets().map(|facets| facets.areas().len());
            if areas.is_none() {
                body.require_surface()?;
            }
            let what = format!("albedo of {}", body.name);
            if let Some(wrong) = surface.albedo.iter().find(|a| !(**a >= 0.0 && a.is_finite())) {
                return Err(Error::invalid(what, wrong, "a finite number, zero or above"));
            }
            let faces = match body.parts() {
                [Part { shape: Shape::Polyhedron(polyhedron), .. }] => polyhedron.faces().len(),
                _ => areas.unwrap_or(1),
            };
            if surface.albedo.len() != 1 && surface.albedo.len() != faces {
                let expected = match faces {
                    1 => "one: only polyhedra and facets have one for each face".to_string(),
                    _ => format!("one, or {faces}, one for each face"),
                };
                return Err(Error::invalid(
                    format!("number of values of {what}"),
                    surface.albedo.len(),
                    expected,
                ));
            }
            surface.law.check().map_err(|error| error.of(&format!("the scattering law of {}", body.name)))?;
        }
        if !(0.0..1.0).contains(&sun_radius) {
            return Err(Error::invalid("sun_radius", sun_radius, "an angle from 0 to below 1 radian"));
        }
        let semi_axes: Vec<_> = bodies.iter().map(ellipsoid).collect();
        let all_exact = semi_axes.iter().all(Option::is_some);
        let parts = bodies.iter().enumerate().filter(|_| !all_exact);
        let parts = parts.flat_map(|(k, body)| body.outer_parts().enumerate().map(move |(i, p)| ([k, i], p)));
        let meshes = parts.filter_map(|(indices, part)| Mesh::new(indices, part)).collect();
        Ok(Self { bodies, surfaces, mutual, sun: disc(sun_radius), semi_axes, meshes })
    }

    /// Returns whether a body can hide another one.
    pub fn hides(&self) -> bool {
        self.mutual && self.bodies.len() > 1
    }

    /// Iterates over the weights of the points of the Sun's disc and the unit vectors to them, for a unit
    /// vector to its centre.
    pub fn suns(&self, to_sun: &Vec3) -> impl Iterator<Item = (f64, Vec3)> {
        let first = perpendicular(to_sun);
        let (second, to_sun) = (to_sun.cross(&first), *to_sun);
        self.sun.iter().map(move |[x, y, weight]| (*weight, (to_sun + first * *x + second * *y).normalize()))
    }
}

/// Returns the semi-axes of a body that is one ellipsoid about its centre; `None` for another body.
fn ellipsoid(body: &Body) -> Option<Vec3> {
    match body.parts() {
        [Part { shape: Shape::Ellipsoid(ellipsoid), placement: None, .. }] => {
            Some(Vec3::from(ellipsoid.semi_axes()))
        }
        _ => None,
    }
}

/// Returns points of the Sun's disc with weights: Gauss's rule in the squared radius, and equal angles that
/// are shifted from ring to ring.
fn disc(radius: f64) -> Vec<[f64; 3]> {
    if radius == 0.0 {
        return vec![[0.0, 0.0, 1.0]];
    }
    let rule = GaussLegendre::new(RINGS);
    let rings = rule.nodes().zip(rule.weights()).enumerate();
    let ring = |(index, (x, weight)): (usize, (&f64, &f64))| {
        let distance = radius.tan() * (0.5 * (1.0 + x)).sqrt();
        let weight = 0.5 * weight / ANGLES as f64;
        (0..ANGLES).map(move |step| {
            let angle = TAU * (step as f64 + 0.5 * (index % 2) as f64) / ANGLES as f64;
            [distance * angle.cos(), distance * angle.sin(), weight]
        })
    };
    rings.flat_map(ring).collect()
}
