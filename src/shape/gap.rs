//! The gap between two shapes of which one is a polyhedron: a bound that never exceeds the distance of their
//! surfaces, and is negative exactly where the shapes share points.
//!
//! For two polyhedra it is the distance of their nearest faces, found by trees of bounding boxes. For an
//! ellipsoid beside a polyhedron, space is stretched so that the ellipsoid becomes the unit ball. If the
//! nearest face is then at distance q from its centre, the distance of the surfaces is at least (q - 1) c,
//! with c the shortest semi-axis. Both bounds have the exact sign, and for a sphere or a point the exact
//! value.

use super::distance::point_to_triangle;
use super::tree::BoundingBox;
use super::{Polyhedron, Shape};
use crate::math::{Mat3, Vec3};

/// Returns the gap between two shapes, negative where they overlap; `None` where neither is a polyhedron.
///
/// `separation` runs from the first centre to the second; the matrices rotate the shapes' frames into its
/// frame.
pub fn gap_between(shapes: [&Shape; 2], separation: &Vec3, rotations: [&Mat3; 2]) -> Option<f64> {
    let [first, second] = rotations;
    // The gap between the circumscribed spheres is a lower bound too.
    let spheres = separation.norm() - shapes[0].circumradius() - shapes[1].circumradius();
    let gap = match shapes {
        [Shape::Polyhedron(a), Shape::Polyhedron(b)] => {
            between_polyhedra([a, b], &first.tr_mul(separation), &first.tr_mul(second))
        }
        [Shape::Polyhedron(a), other] => beside(a, other, &first.tr_mul(separation), &first.tr_mul(second)),
        [other, Shape::Polyhedron(b)] => beside(b, other, &-second.tr_mul(separation), &second.tr_mul(first)),
        _ => return None,
    };
    Some(gap.max(spheres))
}

/// Returns the gap of an ellipsoid or a point beside a polyhedron; its centre and rotation are given in the
/// polyhedron's frame.
fn beside(polyhedron: &Polyhedron, other: &Shape, centre: &Vec3, rotation: &Mat3) -> f64 {
    let within = polyhedron.contains(centre);
    let Shape::Ellipsoid(ellipsoid) = other else {
        let distance = polyhedron.distance(centre);
        return if within { -distance } else { distance };
    };
    let axes = Vec3::from(ellipsoid.semi_axes());
    let shortest = axes.min();
    let stretch = Mat3::from_diagonal(&axes.map(|a| 1.0 / a)) * rotation.transpose();
    // In the stretched space a box of the polyhedron is no nearer than its bounding sphere is in true space,
    // divided by the longest axis.
    let longest = axes.max();
    let bound = |block: &BoundingBox| block.distance(centre) / longest;
    let q = polyhedron.nearest(bound, |corners| {
        let triangle = corners.map(|corner| stretch * (corner - centre));
        point_to_triangle(&Vec3::zeros(), &triangle)
    });
    if within { -(1.0 + q) * shortest } else { (q - 1.0) * shortest }
}

/// Returns the gap of two polyhedra; the position and rotation of the second one are given in the frame of
/// the first.
fn between_polyhedra([a, b]: [&Polyhedron; 2], position: &Vec3, rotation: &Mat3) -> f64 {
    let depth = |inner: &Polyhedron, outer: &Polyhedron, into: &dyn Fn(&Vec3) -> Vec3| {
        let points = inner.vertices().map(|v| into(&v)).filter(|v| outer.contains(v));
        points.map(|v| outer.distance(&v)).fold(0.0, f64::max)
    };
    let least = a.nearest_to(b, position, rotation);
    let apart = least > 0.0 && {
        // Surfaces that do not meet belong to polyhedra that are apart, or of which one lies within the
        // other.
        let corner_of_second = b.vertices().next().map(|v| position + rotation * v);
        let corner_of_first = a.vertices().next().map(|v| rotation.tr_mul(&(v - position)));
        !corner_of_second.is_some_and(|v| a.contains(&v)) && !corner_of_first.is_some_and(|v| b.contains(&v))
    };
    if apart {
        return least;
    }
    let into_a = |v: &Vec3| position + rotation * v;
    let into_b = |v: &Vec3| rotation.tr_mul(&(v - position));
    // Edges that cross without a vertex inside the other polyhedron count as overlap too.
    let least_depth = 1e-12 * (a.circumradius() + b.circumradius());
    -depth(b, a, &into_a).max(depth(a, b, &into_b)).max(least_depth)
}
