//! Separating planes of two bodies.
//!
//! A plane with unit normal n separates two bodies whose centres are r apart where n.r > h_A(n) + h_B(n),
//! with h the support functions: every n gives a lower bound of the gap. The normal for which n.r / (h_A +
//! h_B) is largest is the normal of the plane that both bodies touch when they have grown to touch, and the
//! ratio is the factor of that growth. This is the dual of the contact function, and its parameter s is
//! related to it by s / (1 - s) = h_A / h_B.
//!
//! Of two bodies, the one in front is that on the observer's side of a plane that separates them. Its centre
//! may be farther from the observer than that of the other body.

use super::Shape;
use crate::math::{Mat3, Vec3};
use nalgebra::Matrix6x3;

/// Returns the support function: how far a body extends from its centre along a unit vector.
pub fn support(shape: &Shape, rotation: &Mat3, normal: &Vec3) -> f64 {
    rotation.tr_mul(normal).component_mul(&Vec3::from(shape.semi_axes())).norm()
}

/// Returns the unit normal, from the first body to the second, of the plane that both touch when they have
/// grown to touch; `None` where doubles cannot represent it.
///
/// `balance` is ln(h_A / h_B): the search starts from its value at a pose nearby, and leaves the value found.
/// A normal that is off by a small angle bounds the gap almost as well.
pub fn normal(
    shapes: [&Shape; 2],
    rotations: [&Mat3; 2],
    separation: &Vec3,
    balance: &mut f64,
) -> Option<Vec3> {
    /// The ends of the search for the balance, beyond which one body is smaller than the round-off of the
    /// other.
    const END: f64 = 40.0;
    let unit = |n: Vec3| (n.norm() > 0.0 && n.norm().is_finite()).then(|| n.normalize());
    let scale = shapes[0].circumradius().max(shapes[1].circumradius());
    let axes = shapes.map(|shape| Vec3::from(shape.semi_axes()) / scale);
    let r = separation / separation.norm();
    let body = |k: usize| Mat3::from_diagonal(&axes[k]) * rotations[k].transpose();
    let [a, b] = [body(0), body(1)];
    // n = [(1 - s) A + s B]^-1 r is computed from the factors of A and B, which keeps the digits of thin
    // bodies.
    let at = |u: f64| {
        let (s, complement) = (1.0 / (1.0 + (-u).exp()), 1.0 / (1.0 + u.exp()));
        let mut rows = Matrix6x3::zeros();
        rows.fixed_rows_mut::<3>(0).copy_from(&(a * complement.sqrt()));
        rows.fixed_rows_mut::<3>(3).copy_from(&(b * s.sqrt()));
        let triangle = rows.qr().unpack_r();
        triangle.solve_upper_triangular(&triangle.tr_solve_upper_triangular(&r)?)
    };
    match (shapes[0], shapes[1]) {
        (Shape::Point, Shape::Point) => return unit(r),
        (_, Shape::Point) => return unit(at(-END)?),
        (Shape::Point, _) => return unit(at(END)?),
        _ => {}
    }
    // ln(h_A / h_B) - u falls through zero.
    let (mut low, mut high) = (-END, END);
    let mut u = balance.clamp(low, high);
    let mut last: Option<(f64, f64)> = None;
    let mut n = at(u)?;
    for _ in 0..60 {
        let residual = ((a * n).norm() / (b * n).norm()).ln() - u;
        if residual > 0.0 {
            low = u
        } else {
            high = u
        }
        let secant = last.map_or(u + residual, |(v, other)| u - residual * (u - v) / (residual - other));
        let next = if secant > low && secant < high { secant } else { 0.5 * (low + high) };
        last = Some((u, residual));
        let moved = (next - u).abs();
        u = next;
        n = at(u)?;
        // The gap is flat in n at its maximum.
        if moved < 1e-7 {
            break;
        }
    }
    *balance = u;
    unit(n)
}

/// Returns a vector across a plane that separates two shapes, from the first to the second, with a length of
/// the size of their distance. Along a line of sight d toward the observer the second shape can hide the
/// first one only if the vector's component along d is above zero.
///
/// Polyhedra count as their convex hulls. Where no such plane is found, since the hulls overlap or are as
/// near as rounding, it is the vector between the centres.
pub fn across_separating_plane(shapes: [&Shape; 2], rotations: [&Mat3; 2], separation: &Vec3) -> Vec3 {
    let distance = separation.norm();
    let normal_vector = if distance > shapes[0].circumradius() + shapes[1].circumradius() {
        None
    } else if shapes.iter().any(|shape| matches!(shape, Shape::Polyhedron(_))) {
        between_hulls(shapes, rotations, separation)
    } else {
        normal(shapes, rotations, separation, &mut 0.0).map(|n| n * distance)
    };
    normal_vector.unwrap_or(*separation)
}

/// Approaches the point of the difference of two convex hulls that is nearest to the origin on straight lines
/// to its tips (Gilbert 1966, SIAM J. Control 4, 61), until a plane across the way there is between them.
fn between_hulls(shapes: [&Shape; 2], rotations: [&Mat3; 2], separation: &Vec3) -> Option<Vec3> {
    const STEPS: usize = 100;
    let mut way = *separation;
    for _ in 0..STEPS {
        let [first, second] = [way, -way];
        let tip = separation + tip(shapes[1], rotations[1], &second) - tip(shapes[0], rotations[0], &first);
        if tip.dot(&way) > 0.0 {
            return Some(way);
        }
        let line = tip - way;
        way += line * (-way.dot(&line) / line.norm_squared()).clamp(0.0, 1.0);
    }
    None
}

/// Returns the point of a shape, relative to its centre, that is farthest along a vector.
pub fn tip(shape: &Shape, rotation: &Mat3, n: &Vec3) -> Vec3 {
    let local = rotation.tr_mul(n);
    let tip = match shape {
        Shape::Point => Vec3::zeros(),
        Shape::Stokes(stokes) => local.normalize() * stokes.radius(),
        Shape::Ellipsoid(ellipsoid) => {
            let axes = Vec3::from(ellipsoid.semi_axes());
            axes.component_mul(&axes.component_mul(&local).normalize())
        }
        Shape::Polyhedron(polyhedron) => {
            let farther = |a: Vec3, b: Vec3| if b.dot(&local) > a.dot(&local) { b } else { a };
            polyhedron.vertices().reduce(farther).unwrap_or_default()
        }
    };
    rotation * tip
}
