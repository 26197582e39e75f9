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
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3};

/// Returns the gap between two shapes, negative where they overlap; `None` where neither is a polyhedron.
///
/// `separation` runs from the first centre to the second; the matrices rotate the shapes' frames into its frame. An
/// interruption names `time`.
///
/// # Errors
/// [`Error::Interrupted`](crate::error::Error::Interrupted).
pub fn gap_between(
    shapes: [&Shape; 2],
    separation: &Vec3,
    rotations: [&Mat3; 2],
    time: f64,
    interrupt: &mut InterruptCheck,
) -> Result<Option<f64>> {
    let [first, second] = rotations;
    // The gap between the circumscribed spheres is a lower bound too.
    let spheres = separation.norm() - shapes[0].circumradius() - shapes[1].circumradius();
    let mut charge = |work| interrupt.charge(work, time);
    let in_first = (first.tr_mul(separation), first.tr_mul(second));
    let in_second = (-second.tr_mul(separation), second.tr_mul(first));
    let gap = match shapes {
        [Shape::Polyhedron(a), Shape::Polyhedron(b)] => between_polyhedra([a, b], in_first, &mut charge),
        [Shape::Polyhedron(a), other] => beside(a, other, in_first, &mut charge),
        [other, Shape::Polyhedron(b)] => beside(b, other, in_second, &mut charge),
        _ => return Ok(None),
    };
    Ok(Some(gap?.max(spheres)))
}

/// Returns the gap of an ellipsoid or a point beside a polyhedron; its centre and rotation are given in the
/// polyhedron's frame. `charge` counts work and checks for an interrupt.
fn beside(
    polyhedron: &Polyhedron,
    other: &Shape,
    (centre, rotation): (Vec3, Mat3),
    charge: &mut impl FnMut(u64) -> Result<()>,
) -> Result<f64> {
    charge(polyhedron.work_of_containment())?;
    let within = polyhedron.contains(&centre);
    let Shape::Ellipsoid(ellipsoid) = other else {
        let distance = polyhedron.distance(&centre);
        return Ok(if within { -distance } else { distance });
    };
    let axes = Vec3::from(ellipsoid.semi_axes());
    let shortest = axes.min();
    let stretch = Mat3::from_diagonal(&axes.map(|a| 1.0 / a)) * rotation.transpose();
    // In the stretched space a box of the polyhedron is no nearer than its bounding sphere is in true space,
    // divided by the longest axis.
    let longest = axes.max();
    let bound = |block: &BoundingBox| block.distance(&centre) / longest;
    let q = polyhedron.nearest(bound, |corners| {
        charge(1)?;
        let triangle = corners.map(|corner| stretch * (corner - centre));
        Ok(point_to_triangle(&Vec3::zeros(), &triangle))
    })?;
    Ok(if within { -(1.0 + q) * shortest } else { (q - 1.0) * shortest })
}

/// Returns the gap of two polyhedra; the position and rotation of the second one are given in the frame of
/// the first. `charge` counts work and checks for an interrupt.
fn between_polyhedra(
    [a, b]: [&Polyhedron; 2],
    (position, rotation): (Vec3, Mat3),
    charge: &mut impl FnMut(u64) -> Result<()>,
) -> Result<f64> {
    let least = a.nearest_to(b, &position, &rotation, charge)?;
    charge(a.work_of_containment() + b.work_of_containment())?;
    let apart = least > 0.0 && {
        // Surfaces that do not meet belong to polyhedra that are apart, or of which one lies within the
        // other.
        let corner_of_second = b.vertices().next().map(|v| position + rotation * v);
        let corner_of_first = a.vertices().next().map(|v| rotation.tr_mul(&(v - position)));
        !corner_of_second.is_some_and(|v| a.contains(&v)) && !corner_of_first.is_some_and(|v| b.contains(&v))
    };
    if apart {
        return Ok(least);
    }
    let into_a = |v: &Vec3| position + rotation * v;
    let into_b = |v: &Vec3| rotation.tr_mul(&(v - position));
    // Edges that cross without a vertex inside the other polyhedron count as overlap too.
    let least_depth = 1e-12 * (a.circumradius() + b.circumradius());
    let mut depth = |inner: &Polyhedron, outer: &Polyhedron, into: &dyn Fn(&Vec3) -> Vec3| {
        inner.vertices().map(|v| into(&v)).try_fold(0.0_f64, |depth, v| {
            charge(outer.work_of_containment())?;
            Ok(if outer.contains(&v) { depth.max(outer.distance(&v)) } else { depth })
        })
    };
    Ok(-depth(b, a, &into_a)?.max(depth(a, b, &into_b)?).max(least_depth))
}
