//! The order that a rule needs to reach a tolerance, from the geometry.
//!
//! A rule that is exact for polynomials of degree L errs by at most twice the distance of the integrand from
//! those polynomials, which falls like rate^-L. The integrand is the other body's potential. It is analytic
//! away from that body's focal ellipse, which stays outside a sphere of radius D' = D - p' about the centre
//! of the body that is integrated over (D is the separation, p' the other's largest focal semi-axis).
//!
//! Surface rule: the potential is harmonic within that sphere, and its solid harmonics are polynomials, so
//! that rate = D'/a.
//!
//! Focal rule, for the focal ellipse as a disc of radius p: by the theorem of Bernstein, Walsh and Siciak the
//! rate is e^V, where V is the smallest value that the disc's extremal function takes where the potential of
//! a mass point is singular. Lundin's function is cosh 2V = |y|^2 + |y.y - 1|. For a point at distance h from
//! the disc's axis and v from its plane (in units of p) its minimum over the complex cone (y_1 - h)^2 +
//! y_2^2 + v^2 = 0 lies at y_1 = h - q, y_2 = i sqrt(q^2 + v^2), with
//!
//!   sinh^2 V = v^2 + q^2,    q = max(0, h^2 - v^2 - 1) / (2 h):
//!
//! so that rate = h in the disc's plane and v + sqrt(1 + v^2) on its axis. The mean over the disc of the
//! first power that a rule of degree L misses is smaller by about L^2, and the field is larger than the
//! potential by about L.
//!
//! This degree is for the angles. The radii have to be exact only for the mean of the integrand over the
//! angle, an even function of t = sqrt(1 - rho^2) in [-1, 1]. A ray from the centre meets the singularity
//! where rho e - y is isotropic, at rho = |y| e^(+-i theta)/|e| with theta its angle to y, so that no
//! singularity is nearer than rho = h + i v. The rate of the interval is |t + i rho| at rho = h + i v, the
//! sum of the semi-axes of the ellipse with foci +-1 through that point: h + sqrt(h^2 - 1) in the disc's
//! plane, about twice the rate of the angles.
//!
//! A ring of radius rho within the disc is the edge of a smaller disc, from which the other body is further
//! away in units of its radius: sinh V grows by 1/rho or more, and the ring needs fewer angles. The outermost
//! ring has the angles of its own disc; the numbers of angles of the inner rings follow from that number and
//! from the weights ([`angles_of_ring`]).
//!
//! See Lundin (1985), Michigan Math. J. 32, 197, and Siciak (1962), Trans. AMS 105, 322. Where the bodies are
//! too close for these spheres, the order is found by comparing rules, starting from the rate of the confocal
//! family.

use crate::math::lanes::Lanes;
use crate::math::{Mat3, Vec3};
use crate::shape::Ellipsoid;
use pulp::Scalar;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// The order of a product rule: Gauss points in one direction, equally spaced angles in the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(from = "[usize; 2]", into = "[usize; 2]")]
pub struct Order {
    /// The number of latitudes of the surface rule, or of radii of the focal rule.
    pub gauss: usize,
    /// The number of angles.
    pub angles: usize,
}

impl From<[usize; 2]> for Order {
    fn from([gauss, angles]: [usize; 2]) -> Self {
        Self { gauss, angles }
    }
}

impl From<Order> for [usize; 2] {
    fn from(order: Order) -> Self {
        [order.gauss, order.angles]
    }
}

impl Order {
    /// Returns the order of the surface rule that is exact to a polynomial degree.
    pub fn surface(degree: usize) -> Self {
        Self { gauss: degree / 2 + 1, angles: degree + 1 }
    }

    /// Returns the order of the focal rule that is exact to a polynomial degree, and to the degree `radial`
    /// for functions of the radius alone.
    pub fn focal([degree, radial]: [usize; 2]) -> Self {
        Self { gauss: radial / 4 + 1, angles: degree + 1 }
    }
}

/// The rate below which the bounds require more nodes than a comparison of rules does.
const SLOWEST_RATE: f64 = 2.0;

/// The degrees that the rules of one body need in the field of another one, for a tolerance.
///
/// Degrees fall as the rates grow. The range of rates for which the last answer holds is remembered, so that
/// logarithms are taken only outside of it; the answers do not depend on this memory.
#[derive(Debug, Clone)]
pub struct Degrees {
    tolerance: f64,
    surface: DegreeRange,
    radial: DegreeRange,
    angular: DegreeRange,
    /// A number of radii with the result of [`outermost_ring`] for it.
    ring: (usize, f64),
}

/// A degree and the range of rates for which it is known to be needed.
#[derive(Debug, Clone, Copy)]
struct DegreeRange {
    degree: usize,
    slowest: f64,
    fastest: f64,
}

impl Degrees {
    /// Starts without remembered ranges.
    pub fn new(tolerance: f64) -> Self {
        let unknown_range = DegreeRange { degree: 0, slowest: f64::INFINITY, fastest: 0.0 };
        let [surface, radial, angular] = [unknown_range; 3];
        Self { tolerance, surface, radial, angular, ring: (0, 0.0) }
    }

    /// Returns the degree to which the surface rule must be exact, or `None` for bodies too close for the
    /// bound.
    ///
    /// `centre` is the other body's centre in the canonical frame, `other_focal` its largest focal semi-axis.
    pub fn surface(&mut self, ellipsoid: &Ellipsoid, centre: &Vec3, other_focal: f64) -> Option<usize> {
        let rate = (centre.norm() - other_focal) / ellipsoid.sorted()[0];
        self.surface.degree_for(rate, self.tolerance, 0.0, 2)
    }

    /// Returns the degree to which the focal rule must be exact and the degree for the integrand's mean over
    /// the angle, or `None` for bodies too close for the bound; see [`Self::surface`].
    pub fn focal(&mut self, ellipsoid: &Ellipsoid, centre: &Vec3, other_focal: f64) -> Option<[usize; 2]> {
        let p = ellipsoid.focal_axes()[0];
        // The first power that n radii miss is 4 n, one above the degree; that is the margin of the torque.
        // The semi-axis changes by no more than the point moves.
        let (h, v) = (centre.xy().norm() / p, centre.z / p);
        let semi_major = (0.5 * (length(h + 1.0, v) + length(h - 1.0, v)) - other_focal / p).max(1.0);
        let rate = semi_major + (semi_major * semi_major - 1.0).sqrt();
        let radial = self.radial.degree_for(rate, self.tolerance, 0.0, 0)?;
        // A rule that stays in use may have one radius more.
        let gauss = Order::focal([radial; 2]).gauss + 1;
        if self.ring.0 != gauss {
            self.ring = (gauss, outermost_ring(gauss));
        }
        let outermost = p * self.ring.1;
        let h = (centre.xy().norm() - other_focal).max(0.0) / outermost;
        let v = (centre.z.abs() - other_focal).max(0.0) / outermost;
        let beyond = h * h - v * v - 1.0;
        let sinh = if beyond > 0.0 { length(v, beyond / (2.0 * h)) } else { v };
        let degree = self.angular.degree_for(sinh + length(1.0, sinh), self.tolerance, 1.0, 1)?;
        Some([degree, radial])
    }
}

impl DegreeRange {
    /// Returns [`degree_for`] a rate, from the remembered range if that contains the rate.
    fn degree_for(&mut self, rate: f64, tolerance: f64, power: f64, margin: usize) -> Option<usize> {
        if !(self.slowest..=self.fastest).contains(&rate) {
            let degree = degree_for(rate, tolerance, power, margin)?;
            let (slowest, fastest) =
                if degree == self.degree { (self.slowest, self.fastest) } else { (rate, rate) };
            *self = Self { degree, slowest: slowest.min(rate), fastest: fastest.max(rate) };
        }
        Some(self.degree)
    }
}

/// Returns a lower bound of the radius of a focal rule's outermost ring. Its t = sqrt(1 - rho^2) is the least
/// positive root of P_{2n+1}, near sin(pi / (2n + 3/2)) and above 0.99 of that.
fn outermost_ring(gauss: usize) -> f64 {
    let t = 0.99 * (PI / (2.0 * gauss as f64 + 1.5)).sin();
    ((1.0 - t) * (1.0 + t)).sqrt()
}

/// Returns the number of angles of a ring that meets the tolerance. The ring's radius is that of the outermost
/// ring divided by `radius_ratio`, its weight is `weight_ratio` times as large, and the angles of the outermost ring
/// meet the tolerance. It returns the outermost ring's number if the tolerance is zero, or so loose that no
/// rate needs as many. The ring's error may be twice that of the outermost one.
pub fn angles_of_ring(outermost: usize, radius_ratio: f64, weight_ratio: f64, tolerance: f64) -> usize {
    let degree = outermost as f64 - 2.0;
    if degree < 1.0 || tolerance <= 0.0 {
        return outermost;
    }
    // The number `log_rate` bounds from above the logarithm of the slowest rate at which this number of angles is
    // sufficient: it is the fixed point of a contraction by about the degree.
    let digits = -tolerance.ln();
    let next = |log_rate: f64| ((digits - (digits / log_rate).ln_1p()) / degree).max(0.0);
    let log_rate = (0..100).fold(digits / degree, |log_rate, _| next(log_rate));
    if log_rate > 0.0 {
        let ring_log_rate = (radius_ratio * log_rate.sinh()).asinh();
        (degree_of(ring_log_rate, tolerance / (0.5 * weight_ratio).max(1.0), 1.0, 1) + 1).min(outermost)
    } else {
        outermost
    }
}

/// Returns the length of a vector whose components are near one; `hypot` would take as long as the rest.
fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// Returns the degree of a body's layer in the field of another one, whose potential falls by this rate from
/// degree to degree in the body's circumscribed sphere; `None` for bodies too close for the bound.
pub fn layer_degree(rate: f64, tolerance: f64) -> Option<usize> {
    degree_for(rate, tolerance, 0.0, 2)
}

/// Returns the smallest degree L with L^-power rate^-L below the tolerance, plus `margin`: the torque is
/// smaller than lever times force by about the rate, and its error must be smaller by as much.
fn degree_for(rate: f64, tolerance: f64, power: f64, margin: usize) -> Option<usize> {
    (rate >= SLOWEST_RATE).then(|| degree_of(rate.ln(), tolerance, power, margin))
}

/// Returns [`degree_for`] a rate that is given by its logarithm.
fn degree_of(log_rate: f64, tolerance: f64, power: f64, margin: usize) -> usize {
    let without_power = -tolerance.ln() / log_rate;
    (without_power - power * without_power.ln_1p() / log_rate).ceil().max(0.0) as usize + margin
}

/// Returns a first guess of the degree for close bodies: by the ratio of the conformal radii of two confocal
/// ellipses.
pub fn guess_degree(ellipsoid: &Ellipsoid, flat: bool, kappa: f64, tolerance: f64) -> usize {
    let [a, _, c] = ellipsoid.sorted();
    let size = if flat { ellipsoid.focal_axes()[0] } else { a + c };
    let rate = ((a * a + kappa).sqrt() + (c * c + kappa).sqrt()) / size;
    (-tolerance.ln() / rate.ln().max(1e-3)).ceil() as usize + 2
}

/// Returns the smallest confocal coordinate kappa, with respect to `ellipsoid`, of the points of another
/// body's focal ellipse.
///
/// `centre` is the other body's centre and `p`, `q` its focal semi-axes as vectors, all in the canonical
/// frame of `ellipsoid`. A far body is bounded from below by spheres. A near one is searched: its rim and
/// interior on a grid, then its rim by golden sections.
pub fn closest_confocal(ellipsoid: &Ellipsoid, centre: &Vec3, p: &Vec3, q: &Vec3) -> f64 {
    let a = ellipsoid.sorted()[0];
    let clearance = centre.norm() - p.norm();
    if p.norm() == 0.0 {
        return confocal(ellipsoid, centre);
    }
    if clearance > 1.5 * a {
        return clearance * clearance - a * a;
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
    let square = |v: f64| -> Lanes<Scalar> { Lanes::splat(Scalar, v * v) };
    crate::gravity::kappa([square(x.x), square(x.y), square(x.z)], ellipsoid.sorted().map(|a| a * a)).first()
}

/// Returns a lower bound of the distance of a point from an ellipsoid's focal ellipse, where its exterior
/// potential is singular. Both are in the canonical frame.
///
/// The bound is the distance of two parallel planes, one through the point and the other touching the
/// ellipse, nearly perpendicular to the normal of the confocal ellipsoid through the point. A point within
/// the ellipsoid, where its potential is another function, counts as on the surface.
pub fn focal_distance(ellipsoid: &Ellipsoid, x: &Vec3) -> f64 {
    let [p, q] = ellipsoid.focal_axes();
    let squares = Vec3::from(ellipsoid.sorted().map(|a| a * a));
    let x2 = x.component_mul(x);
    // This is where Newton's iteration for the confocal coordinate begins.
    let kappa = (x2.sum() - x2.dot(&squares) / x2.sum()).max(0.0);
    let normal = x.component_div(&squares.add_scalar(kappa));
    let reach = (p * normal.x).hypot(q * normal.y);
    let surface = normal.component_mul(&normal).dot(&squares).sqrt();
    (x.dot(&normal).max(surface) - reach) / normal.norm()
}

/// Returns the focal semi-axes of an ellipsoid as vectors, rotated by the matrix from its canonical frame.
pub fn focal_vectors(ellipsoid: &Ellipsoid, in_body: &Mat3) -> [Vec3; 2] {
    let [p, q] = ellipsoid.focal_axes();
    [in_body.column(0) * p, in_body.column(1) * q]
}
