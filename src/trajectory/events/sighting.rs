//! The outlines of two bodies seen along a direction: how far they are apart, and whether one is inside the
//! other.
//!
//! A body extends by h(n) from its centre along a unit vector n. For n perpendicular to the line of sight
//! this is the extent of its outline. The outline of an ellipsoid is an ellipse with h(n)^2 = n.R diag(a^2)
//! R^T n, and that of a polyhedron is the convex hull of its vertices. With r the vector from one centre to
//! the other, the gap of two outlines is the maximum over n of
//!
//!   n.r - h_A(n) - h_B(-n),
//!
//! which is below zero where they overlap. The outline of B is inside that of A by the minimum over n of
//!
//!   h_A(n) - h_B(n) - n.r.
//!
//! Both are functions of the angle of n. They are sampled at all angles and then refined to the last digits
//! near the best samples.

use crate::integrate::extremum;
use crate::math::{Mat3, Vec3};
use crate::shape::{Body, Part, Shape};
use std::convert::Infallible;
use std::f64::consts::TAU;

/// The number of angles of n at which the functions are sampled. For ellipses up to about thirty times as
/// long as wide no maximum is missed.
const SAMPLES: usize = 64;

/// Two bodies and the direction along which they are seen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sighting<'a> {
    /// The bodies.
    pub bodies: [&'a Body; 2],
    /// The vector from the first centre to the second.
    pub separation: &'a Vec3,
    /// The rotations from the bodies' frames into that of the separation.
    pub rotations: [&'a Mat3; 2],
    /// The unit vector along the line of sight.
    pub direction: &'a Vec3,
}

impl Sighting<'_> {
    /// Returns the distance of the outlines; negative where they overlap. For bodies of several parts it is
    /// the distance of the nearest two parts.
    pub fn gap(&self) -> f64 {
        let [first, second] = self.outlines();
        let apart = |a: &Outline, b: &Outline| {
            let r = [b.centre[0] - a.centre[0], b.centre[1] - a.centre[1]];
            maximum(a.size + b.size, |n| n[0] * r[0] + n[1] * r[1] - a.reach(n) - b.reach([-n[0], -n[1]]))
        };
        let pairs = first.iter().flat_map(|a| second.iter().map(move |b| apart(a, b)));
        pairs.fold(f64::INFINITY, f64::min)
    }

    /// Returns how far the outline of the first body extends beyond that of the second; negative where it is
    /// inside. For bodies of several parts each part of the first body has to be inside one part of the
    /// second: a region that only several parts cover together counts as visible.
    pub fn excess(&self) -> f64 {
        let [first, second] = self.outlines();
        let outside = |a: &Outline, b: &Outline| {
            let r = [a.centre[0] - b.centre[0], a.centre[1] - b.centre[1]];
            maximum(a.size + b.size, |n| n[0] * r[0] + n[1] * r[1] + a.reach(n) - b.reach(n))
        };
        let least = |a: &Outline| second.iter().map(|b| outside(a, b)).fold(f64::INFINITY, f64::min);
        first.iter().map(least).fold(f64::NEG_INFINITY, f64::max)
    }

    fn outlines(&self) -> [Vec<Outline>; 2] {
        let mut least = Vec3::zeros();
        least[self.direction.iamin()] = 1.0;
        let x = self.direction.cross(&least).normalize();
        let plane = [x, self.direction.cross(&x)];
        [0, 1].map(|k| {
            let body = self.bodies[k];
            let centre = if k == 0 { Vec3::zeros() } else { *self.separation };
            let outline = |part: &Part| {
                let rotation = self.rotations[k] * part.rotation();
                Outline::new(&part.shape, &(centre + self.rotations[k] * part.position()), &rotation, plane)
            };
            body.outer_parts().map(outline).collect()
        })
    }
}

/// The outline of a part in the plane across the line of sight.
struct Outline {
    centre: [f64; 2],
    /// An upper bound of the outline's extent from its centre.
    size: f64,
    form: Form,
}

enum Form {
    Dot,
    /// The vectors whose components along n give h(n).
    Ellipse([Vec3; 2]),
    /// The points of the hull relative to the centre.
    Hull(Vec<[f64; 2]>),
}

impl Outline {
    fn new(shape: &Shape, centre: &Vec3, rotation: &Mat3, plane: [Vec3; 2]) -> Self {
        let own = plane.map(|axis| rotation.tr_mul(&axis));
        let form = match shape {
            Shape::Point => Form::Dot,
            Shape::Ellipsoid(ellipsoid) => {
                Form::Ellipse(own.map(|axis| axis.component_mul(&Vec3::from(ellipsoid.semi_axes()))))
            }
            Shape::Polyhedron(polyhedron) => {
                Form::Hull(polyhedron.vertices().map(|v| own.map(|axis| axis.dot(&v))).collect())
            }
        };
        Self { centre: plane.map(|axis| axis.dot(centre)), size: shape.circumradius(), form }
    }

    /// Returns how far the outline extends from its centre along a unit vector.
    fn reach(&self, n: [f64; 2]) -> f64 {
        match &self.form {
            Form::Dot => 0.0,
            Form::Ellipse([x, y]) => (x * n[0] + y * n[1]).norm(),
            Form::Hull(points) => {
                points.iter().map(|p| p[0] * n[0] + p[1] * n[1]).fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }
}

/// Returns the maximum over all unit vectors of a function whose variation is of the size of `size`.
fn maximum(size: f64, function: impl Fn([f64; 2]) -> f64) -> f64 {
    let at = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        function([cos, sin])
    };
    let step = TAU / SAMPLES as f64;
    let (sin, cos) = step.sin_cos();
    let mut n = [1.0, 0.0];
    let values: [f64; SAMPLES] = std::array::from_fn(|_| {
        let value = function(n);
        n = [n[0] * cos - n[1] * sin, n[1] * cos + n[0] * sin];
        value
    });
    let best = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // Between two samples a peak rises by less than the square of their distance times the function's second
    // derivative.
    let reach = 4.0 * step * step * (size + best.abs());
    let mut found = best;
    for (k, value) in values.iter().enumerate() {
        let beside = [values[(k + SAMPLES - 1) % SAMPLES], values[(k + 1) % SAMPLES]];
        if *value < best - reach || beside.iter().any(|other| other > value) {
            continue;
        }
        let middle = k as f64 * step;
        // The search ends early where its function falls below zero, which this difference never does.
        let top = best + reach + size;
        let Ok((_, least)) =
            extremum(|angle| Ok::<_, Infallible>(top - at(angle)), middle - step, middle + step);
        found = found.max(top - least);
    }
    found
}
