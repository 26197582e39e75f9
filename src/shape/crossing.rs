//! Faces of one mesh that cross or touch where they should not, found by the exact predicates of Shewchuk
//! (1997) in the crate `robust`.

use super::tree::{BoundingBox, Tree};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Units of work of a pair of faces, for [`InterruptCheck`].
const PAIR: u64 = 20;

/// Returns the first two faces that share points other than those of their common vertices and edge.
pub fn first_crossing(
    vertices: &[Vec3],
    faces: &[[u32; 3]],
    tree: &Tree,
    interrupt: &mut InterruptCheck,
) -> Result<Option<[usize; 2]>> {
    let corners = |face: [u32; 3]| face.map(|v| vertices[v as usize]);
    for (i, face) in faces.iter().enumerate() {
        let mut partner = None;
        let mut tested = 1;
        tree.meeting(&BoundingBox::around(&corners(*face)), |j| {
            let j = j as usize;
            if j > i && partner.is_none_or(|k| j < k) {
                tested += 1;
                if cross(vertices, *face, faces[j]) {
                    partner = Some(j);
                }
            }
        });
        interrupt.charge(PAIR * tested, 0.0)?;
        if let Some(j) = partner {
            return Ok(Some([i, j]));
        }
    }
    Ok(None)
}

/// Returns whether two faces share points other than those of their common vertices.
fn cross(vertices: &[Vec3], first: [u32; 3], second: [u32; 3]) -> bool {
    let corners = |face: [u32; 3]| face.map(|v| vertices[v as usize]);
    let shared: Vec<u32> = first.into_iter().filter(|v| second.contains(v)).collect();
    let (a, b) = (corners(first), corners(second));
    let unshared =
        |face: [u32; 3]| face.into_iter().filter(|v| !shared.contains(v)).map(|v| vertices[v as usize]);
    match shared[..] {
        [] => (0..3)
            .any(|k| segment_meets([a[k], a[(k + 1) % 3]], &b) || segment_meets([b[k], b[(k + 1) % 3]], &a)),
        // Both faces extend from the common vertex until one of them ends, at the side opposite to it.
        [_] => {
            let side = |face| -> Vec<Vec3> { unshared(face).collect() };
            let (p, q) = (side(first), side(second));
            segment_meets([p[0], p[1]], &b) || segment_meets([q[0], q[1]], &a)
        }
        // Two faces with a common edge share more than it only where one is folded onto the other.
        [u, v] => {
            let (u, v) = (vertices[u as usize], vertices[v as usize]);
            let [Some(p), Some(q)] = [unshared(first).next(), unshared(second).next()] else { return true };
            side_of(&[u, v, p], &q) == 0.0 && {
                let axis = (v - u).cross(&(p - u)).iamax();
                (flat_side(axis, &u, &v, &p) > 0.0) == (flat_side(axis, &u, &v, &q) > 0.0)
            }
        }
        _ => true,
    }
}

/// Returns on which side of a plane a point lies; zero in the plane, exactly.
fn side_of(plane: &[Vec3; 3], point: &Vec3) -> f64 {
    let coordinates = |v: &Vec3| Coord3D { x: v.x, y: v.y, z: v.z };
    let [a, b, c] = plane;
    orient3d(coordinates(a), coordinates(b), coordinates(c), coordinates(point))
}

/// Returns on which side of the line through two points a third one lies, in the plane that remains without
/// one axis.
fn flat_side(axis: usize, a: &Vec3, b: &Vec3, point: &Vec3) -> f64 {
    let coordinates = |v: &Vec3| Coord { x: v[(axis + 1) % 3], y: v[(axis + 2) % 3] };
    orient2d(coordinates(a), coordinates(b), coordinates(point))
}

fn same_side(s: f64, t: f64) -> bool {
    s > 0.0 && t > 0.0 || s < 0.0 && t < 0.0
}

/// Returns whether a segment and a triangle share a point.
fn segment_meets(segment: [Vec3; 2], triangle: &[Vec3; 3]) -> bool {
    let [p, q] = segment;
    let (above, below) = (side_of(triangle, &p), side_of(triangle, &q));
    if same_side(above, below) {
        return false;
    }
    let [a, b, c] = triangle;
    if above == 0.0 && below == 0.0 {
        return flat_meets([p, q], triangle);
    }
    let sides = [(a, b), (b, c), (c, a)].map(|(u, v)| side_of(&[p, q, *u], v));
    sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0)
}

/// Returns whether a segment and a triangle in one plane share a point.
fn flat_meets([p, q]: [Vec3; 2], triangle: &[Vec3; 3]) -> bool {
    let [a, b, c] = triangle;
    let axis = (b - a).cross(&(c - a)).iamax();
    let side = |u: &Vec3, v: &Vec3, w: &Vec3| flat_side(axis, u, v, w);
    let inside = |w: &Vec3| {
        let sides = [side(a, b, w), side(b, c, w), side(c, a, w)];
        sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0)
    };
    let sides_meet = |u: &Vec3, v: &Vec3| {
        let [s, t, x, y] = [side(&p, &q, u), side(&p, &q, v), side(u, v, &p), side(u, v, &q)];
        // A segment on the line of a side is decided by its ends, which lie within the triangle's other sides
        // or beyond them.
        !(same_side(s, t) || same_side(x, y) || s == 0.0 && t == 0.0)
    };
    inside(&p) || inside(&q) || sides_meet(a, b) || sides_meet(b, c) || sides_meet(c, a)
}
