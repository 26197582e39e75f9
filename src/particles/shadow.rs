//! The part of a source's disc that the bodies hide.
//!
//! Let p be the position of a particle relative to the centre of an ellipsoid and A = diag(1/a_i^2) in the
//! ellipsoid's frame. The ray p + l d meets the ellipsoid where Q(d) = (d.Ap)^2 - (p.Ap - 1) d.Ad >= 0 and
//! d.Ap < 0: a convex cone of directions. The directions to the source's disc are d = s + tau (u e_1 + w
//! e_2), with s the direction to its centre, e_1 and e_2 perpendicular to s, u^2 + w^2 <= 1, and tau the
//! tangent of its angular radius. The hidden part is the area of the cone's section with that unit circle,
//! divided by pi.
//!
//! Along each line of constant u the hidden part is an interval whose ends contain two square roots. It is
//! integrated over u by the Gauss-Chebyshev rule between the values of u where an end of the interval changes
//! its kind: where the cone's section begins and ends, and where it crosses the circle.

use crate::integrate::polynomial_roots;
use crate::math::rotation::{rotate, rotate_back};
use crate::math::{Mat3, Vec3, perpendicular};
use crate::shape::{Body, Shape};
use gauss_quad::GaussLegendre;
use std::f64::consts::PI;
use std::num::NonZeroUsize;

/// A part of a body that casts a shadow.
#[derive(Debug, Clone)]
struct Occulter {
    /// The index of the body in the system.
    body: usize,
    position: Vec3,
    /// Rotation from the part's frame into the body's.
    rotation: Mat3,
    semi_axes: Vec3,
    radius: f64,
    /// The radius of the inscribed sphere.
    inner: f64,
}

/// The cone of directions that an ellipsoid hides, in the coordinates (1, u, w) of the disc.
#[derive(Debug, Clone)]
struct Cone {
    /// The form Q as a symmetric matrix.
    q: Mat3,
    /// The linear form d.Ap.
    towards: Vec3,
}

/// Which directions to the disc an ellipsoid hides.
enum Hidden {
    Nothing,
    Everything,
    Within(Cone),
}

impl Occulter {
    /// Returns the occulters of a body: its outer parts, where any shape but an ellipsoid is replaced by the
    /// ellipsoid with the same moments of inertia.
    fn of_body(index: usize, body: &Body) -> Vec<Self> {
        let part = |part: &crate::shape::Part| {
            let semi_axes = match &part.shape {
                Shape::Point => return None,
                Shape::Ellipsoid(ellipsoid) => Vec3::from(ellipsoid.semi_axes()),
                other => {
                    let inertia = other.inertia_per_mass();
                    inertia.map(|moment| (2.5 * (inertia.sum() - 2.0 * moment)).max(0.0).sqrt())
                }
            };
            let (position, rotation) = (part.position(), part.rotation());
            let (radius, inner) = (semi_axes.max(), semi_axes.min());
            Some(Self { body: index, position, rotation, semi_axes, radius, inner })
        };
        body.outer_parts().filter_map(part).collect()
    }

    /// Returns which directions the occulter hides. `r` is the particle's position relative to the body's
    /// centre, `s` the direction to the source's centre, inertial.
    fn hidden_directions(&self, rotation: &Mat3, r: &Vec3, s: &Vec3, across: [&Vec3; 2], tau: f64) -> Hidden {
        let p = r - rotate(rotation, &self.position);
        let along = -p.dot(s);
        if along < -self.radius {
            return Hidden::Nothing;
        }
        let lateral_squared = (p + s * along).norm_squared();
        let shadow_radius = self.radius + tau * (along + self.radius);
        if lateral_squared > shadow_radius * shadow_radius * (1.0 + tau * tau) {
            return Hidden::Nothing;
        }
        // No ray to the disc passes the centre at a distance larger than this one.
        if along > 0.0 && lateral_squared.sqrt() + tau * along < self.inner {
            return Hidden::Everything;
        }
        let in_canonical =
            |v: &Vec3| rotate_back(&self.rotation, &rotate_back(rotation, v)).component_div(&self.semi_axes);
        // From here on, vectors are in the frame in which the ellipsoid is the unit sphere.
        let p = in_canonical(&p);
        let directions = Mat3::from_columns(&[
            in_canonical(s),
            in_canonical(across[0]) * tau,
            in_canonical(across[1]) * tau,
        ]);
        let height = (p.norm_squared() - 1.0).max(f64::EPSILON);
        let towards = directions.tr_mul(&p);
        let q = towards * towards.transpose() - directions.tr_mul(&directions) * height;
        Hidden::Within(Cone { q, towards })
    }
}

impl Cone {
    fn q(&self, u: f64, w: f64) -> f64 {
        let d = Vec3::new(1.0, u, w);
        d.dot(&(self.q * d))
    }

    /// Returns the hidden interval of w on a line of constant u.
    fn interval(&self, u: f64) -> Option<[f64; 2]> {
        let row = Vec3::new(1.0, u, 0.0);
        let a = self.q[(2, 2)];
        let b = self.q.row(2).dot(&row.transpose());
        let c = row.dot(&(self.q * row));
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            return None;
        }
        let far = -(b + discriminant.sqrt().copysign(b));
        let (first, second) = (far / a, if far == 0.0 { 0.0 } else { c / far });
        let (low, high) = (first.min(second), first.max(second));
        let [t0, t1] = [self.towards.dot(&row), self.towards[2]];
        if a < 0.0 {
            // The line crosses one of the two cones from side to side.
            (t0 + t1 * 0.5 * (low + high) < 0.0).then_some([low, high])
        } else if t1 < 0.0 {
            Some([high, f64::INFINITY])
        } else {
            Some([f64::NEG_INFINITY, low])
        }
    }

    /// Appends the values of u at which an end of the interval changes its kind.
    fn breaks(&self, out: &mut Vec<f64>) {
        let q = &self.q;
        // The discriminant of the interval is a quadratic in u.
        let minor = |i: usize, j: usize| q[(2, i)] * q[(2, j)] - q[(2, 2)] * q[(i, j)];
        let (c, b, a) = (minor(0, 0), minor(0, 1), minor(1, 1));
        let square = b * b - a * c;
        if square >= 0.0 {
            let far = -(b + square.sqrt().copysign(b));
            out.extend([far / a, c / far]);
        }
        // On the circle, u = (1 - t^2)/(1 + t^2) and w = 2 t/(1 + t^2): a quartic in t, from -1 to 1 on
        // either half.
        for side in [1.0, -1.0] {
            let (q01, q11) = (q[(0, 1)] * side, q[(1, 1)]);
            let (q02, q12) = (q[(0, 2)], q[(1, 2)] * side);
            let quartic = [
                q[(0, 0)] + 2.0 * q01 + q11,
                4.0 * (q02 + q12),
                2.0 * q[(0, 0)] - 2.0 * q11 + 4.0 * q[(2, 2)],
                4.0 * (q02 - q12),
                q[(0, 0)] - 2.0 * q01 + q11,
            ];
            polynomial_roots(&quartic, &mut |t| out.push(side * (1.0 - t * t) / (1.0 + t * t)));
        }
    }
}

/// The number of nodes of the rule between two breaks.
const NODES: NonZeroUsize = NonZeroUsize::new(20).unwrap();

/// Returns weights and abscissae of the rule from -1 to 1: Gauss-Legendre in t, with the cosine of t as the
/// abscissa. Square roots at either end are smooth in t.
fn rule() -> Vec<[f64; 2]> {
    let gauss = GaussLegendre::new(NODES);
    let node = |(x, weight): (&f64, &f64)| {
        let t = 0.5 * PI * (1.0 + x);
        [0.5 * PI * weight * t.sin(), t.cos()]
    };
    gauss.nodes().zip(gauss.weights()).map(node).collect()
}

/// The source's disc as particles see it, with buffers.
#[derive(Debug, Clone)]
pub struct Disc {
    occulters: Vec<Occulter>,
    /// The radius of the source.
    radius: f64,
    rule: Vec<[f64; 2]>,
    cones: Vec<Cone>,
    breaks: Vec<f64>,
    intervals: Vec<[f64; 2]>,
}

impl Disc {
    /// Takes the radius of a source, and the bodies that may hide it.
    pub fn new(radius: f64, bodies: &[Body]) -> Self {
        let occulters =
            bodies.iter().enumerate().flat_map(|(index, body)| Occulter::of_body(index, body)).collect();
        let (cones, breaks, intervals) = Default::default();
        Self { occulters, radius, rule: rule(), cones, breaks, intervals }
    }

    /// Returns the visible part of the disc, where the source lies in the direction `towards`, inertial;
    /// `pose_from` returns a body's rotation and the position relative to its centre.
    pub fn visible(&mut self, towards: &Vec3, mut pose_from: impl FnMut(usize) -> (Mat3, Vec3)) -> f64 {
        let square = towards.norm_squared();
        let s = towards / square.sqrt();
        let tau = self.radius / (square - self.radius * self.radius).max(f64::MIN_POSITIVE).sqrt();
        let first = perpendicular(&s);
        let second = s.cross(&first);
        self.cones.clear();
        for occulter in &self.occulters {
            let (rotation, r) = pose_from(occulter.body);
            match occulter.hidden_directions(&rotation, &r, &s, [&first, &second], tau) {
                Hidden::Nothing => {}
                Hidden::Everything => return 0.0,
                Hidden::Within(cone) => self.cones.push(cone),
            }
        }
        if self.cones.is_empty() {
            return 1.0;
        }
        let Self { rule, cones, breaks, intervals, .. } = self;
        breaks.clear();
        breaks.extend([-1.0, 1.0]);
        if tau > 0.0 {
            cones.iter().for_each(|cone| cone.breaks(breaks));
            breaks.retain(|u| (-1.0..=1.0).contains(u));
            breaks.sort_unstable_by(f64::total_cmp);
            breaks.dedup();
        }
        if breaks.len() == 2 {
            // In a disc that no cone crosses, each cone hides all or nothing.
            let hidden = cones.iter().any(|cone| cone.towards[0] < 0.0 && cone.q(0.0, 0.0) >= 0.0);
            return if hidden { 0.0 } else { 1.0 };
        }
        let mut hidden = 0.0;
        for pair in breaks.windows(2) {
            let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
            for [weight, abscissa] in &*rule {
                hidden += half * weight * covered(cones, middle + half * abscissa, intervals);
            }
        }
        (1.0 - hidden / PI).clamp(0.0, 1.0)
    }
}

/// Returns the length of the circle's chord at u that the cones hide.
fn covered(cones: &[Cone], u: f64, intervals: &mut Vec<[f64; 2]>) -> f64 {
    let chord = (1.0 - u * u).max(0.0).sqrt();
    intervals.clear();
    intervals.extend(cones.iter().filter_map(|cone| {
        let [low, high] = cone.interval(u)?;
        let (low, high) = (low.max(-chord), high.min(chord));
        (low < high).then_some([low, high])
    }));
    intervals.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut length, mut covered_to) = (0.0, f64::NEG_INFINITY);
    for &[low, high] in &*intervals {
        length += (high - low.max(covered_to)).max(0.0);
        covered_to = covered_to.max(high);
    }
    length
}
