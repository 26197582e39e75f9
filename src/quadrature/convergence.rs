//! How fast a rule converges, from the geometry, and the order that a tolerance takes.
//!
//! The other body's potential is analytic away from its focal ellipse. A rule that is exact for polynomials of degree L
//! then errs like rate^-L, where the rate is that of the family of confocal ellipsoids around the integration set: with
//! kappa the smallest confocal coordinate of a point of the other's focal ellipse,
//!
//!   surface of (a, b, c):          rate = (sqrt(a^2 + kappa) + sqrt(c^2 + kappa)) / (a + c),
//!   its focal ellipse:             rate = (sqrt(a^2 + kappa) + sqrt(c^2 + kappa)) / sqrt(a^2 - c^2).
//!
//! In two dimensions this is the ratio of the conformal radii of the two confocal ellipses, hence exact (Bernstein's
//! ellipse for the flat one); for a sphere it is distance over radius, also exact. In between it is a measured
//! rule, with the margin of [`degree_for`] found from errors against rules of much higher order.

use crate::math::lanes::Lanes;
use crate::math::{Mat3, Vec3};
use crate::shape::Ellipsoid;
use pulp::Scalar;
use std::f64::consts::TAU;

/// Order of a product rule: Gauss points in one direction, equal angles in the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Order {
    /// Latitudes of the surface rule, radii of the focal rule.
    pub gauss: usize,
    /// Angles.
    pub angles: usize,
}

impl Order {
    /// The surface rule that is exact to a polynomial degree.
    pub fn surface(degree: usize) -> Self {
        Self { gauss: degree / 2 + 1, angles: degree + 1 }
    }

    /// The focal rule that is exact to a polynomial degree.
    pub fn focal(degree: usize) -> Self {
        Self { gauss: degree / 4 + 1, angles: degree + 1 }
    }
}

/// Convergence rate of the surface rule on an ellipsoid; see the head of this file.
pub fn rate_surface(ellipsoid: &Ellipsoid, kappa: f64) -> f64 {
    let [a, _, c] = ellipsoid.sorted();
    ((a * a + kappa).sqrt() + (c * c + kappa).sqrt()) / (a + c)
}

/// Convergence rate of the focal rule on an ellipsoid; see the head of this file.
pub fn rate_focal(ellipsoid: &Ellipsoid, kappa: f64) -> f64 {
    let [a, _, c] = ellipsoid.sorted();
    ((a * a + kappa).sqrt() + (c * c + kappa).sqrt()) / ellipsoid.focal_axes()[0]
}

/// Degree to which a rule has to be exact for a tolerance relative to the force, with two degrees more for the torque,
/// which is smaller than its lever times the force by two powers of the rate.
pub fn degree_for(rate: f64, tolerance: f64) -> usize {
    let degree = -tolerance.ln() / rate.ln();
    if degree.is_finite() { degree.ceil() as usize + 2 } else { 2 }
}

/// Smallest confocal coordinate kappa, with respect to `ellipsoid`, of the points of another body's focal ellipse.
///
/// `centre` is the other body's centre and `p`, `q` its focal semi-axes as vectors, all in the canonical frame of
/// `ellipsoid`. A far body is bounded from below by spheres; a near one is searched: rim and interior on a grid, then
/// the rim by golden sections.
pub fn closest_confocal(ellipsoid: &Ellipsoid, centre: &Vec3, p: &Vec3, q: &Vec3) -> f64 {
    let a = ellipsoid.sorted()[0];
    let clearance = centre.norm() - p.norm();
    if clearance > 1.5 * a || p.norm() == 0.0 {
        return confocal(ellipsoid, centre).min((clearance * clearance - a * a).max(0.0));
    }
    const RIM: usize = 24;
    let at = |radius: f64, angle: f64| {
        confocal(ellipsoid, &(centre + radius * (p * angle.cos() + q * angle.sin())))
    };
    let angle = |k: usize| TAU * k as f64 / RIM as f64;
    let inside = (0..RIM).flat_map(|k| [at(0.35, angle(k)), at(0.7, angle(k))]).fold(at(0.0, 0.0), f64::min);
    let nearest = (0..RIM).map(angle).min_by(|x, y| at(1.0, *x).total_cmp(&at(1.0, *y))).unwrap_or(0.0);
    let (mut low, mut high) = (nearest - angle(1), nearest + angle(1));
    for _ in 0..24 {
        let (s, t) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
        if at(1.0, s) < at(1.0, t) { high = t } else { low = s }
    }
    inside.min(at(1.0, 0.5 * (low + high)))
}

fn confocal(ellipsoid: &Ellipsoid, x: &Vec3) -> f64 {
    let square = |v: f64| Lanes::new(Scalar, v * v);
    crate::gravity::kappa([square(x.x), square(x.y), square(x.z)], ellipsoid.sorted().map(|a| a * a)).raw
}

/// The focal semi-axes of an ellipsoid as vectors, turned by the matrix from its canonical frame.
pub fn focal_vectors(ellipsoid: &Ellipsoid, from_canonical: &Mat3) -> [Vec3; 2] {
    let [p, q] = ellipsoid.focal_axes();
    [from_canonical.column(0) * p, from_canonical.column(1) * q]
}
