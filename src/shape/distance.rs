//! Distances between points, segments and triangles.

use crate::math::Vec3;
use std::f64::consts::PI;

/// Returns the distance of a point from a triangle.
pub fn point_to_triangle(point: &Vec3, triangle: &[Vec3; 3]) -> f64 {
    (closest_point(point, triangle) - point).norm()
}

/// Returns the point of a triangle that is nearest to a point, by the region of the triangle's plane over
/// which the point lies (Ericson 2005, section 5.1.5).
pub fn closest_point(point: &Vec3, [a, b, c]: &[Vec3; 3]) -> Vec3 {
    let (ab, ac) = (b - a, c - a);
    let from = |corner: &Vec3| {
        let d = point - corner;
        [ab.dot(&d), ac.dot(&d)]
    };
    let [d1, d2] = from(a);
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    let [d3, d4] = from(b);
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    let beside_c = d1 * d4 - d3 * d2;
    if beside_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let [d5, d6] = from(c);
    if d6 >= 0.0 && d5 <= d6 {
        return *c;
    }
    let beside_b = d5 * d2 - d1 * d6;
    if beside_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let beside_a = d3 * d6 - d5 * d4;
    if beside_a <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = beside_a + beside_b + beside_c;
    a + ab * (beside_b / sum) + ac * (beside_c / sum)
}

/// Returns the angle of a triangle at one of its points: the angle of a corner within this distance, and pi
/// elsewhere.
pub fn angle_at(point: &Vec3, [a, b, c]: &[Vec3; 3], within: f64) -> f64 {
    let corners = [(a, b, c), (b, c, a), (c, a, b)];
    let corner = corners.into_iter().find(|(corner, ..)| (point - *corner).norm() <= within);
    corner.map_or(PI, |(corner, next, last)| (next - corner).angle(&(last - corner)))
}

/// Returns the least distance from the origin on a straight path that starts at `from`.
#[inline]
pub fn least_distance(from: &Vec3, path: &Vec3) -> f64 {
    let square = path.norm_squared();
    let part = if square > 0.0 { (-from.dot(path) / square).clamp(0.0, 1.0) } else { 0.0 };
    (from + path * part).norm()
}

/// Returns the distance of two segments (Ericson 2005, section 5.1.9).
fn between_segments([p, q]: [&Vec3; 2], [u, v]: [&Vec3; 2]) -> f64 {
    let (d, e, r) = (q - p, v - u, p - u);
    let (a, b, c, f, g) = (d.norm_squared(), d.dot(&e), d.dot(&r), e.dot(&r), e.norm_squared());
    let den = a * g - b * b;
    let s = if den > 0.0 { ((b * f - c * g) / den).clamp(0.0, 1.0) } else { 0.0 };
    let t = (b * s + f) / g;
    let (s, t) = if t < 0.0 {
        ((-c / a).clamp(0.0, 1.0), 0.0)
    } else if t > 1.0 {
        (((b - c) / a).clamp(0.0, 1.0), 1.0)
    } else {
        (s, t)
    };
    (p + d * s - u - e * t).norm()
}

/// Returns the distance of two triangles; zero where they meet.
pub fn between_triangles(a: &[Vec3; 3], b: &[Vec3; 3]) -> f64 {
    let side = |t: &[Vec3; 3], k: usize| [t[k], t[(k + 1) % 3]];
    if (0..3).any(|k| pierces(side(a, k), b) || pierces(side(b, k), a)) {
        return 0.0;
    }
    let mut least = f64::INFINITY;
    for i in 0..3 {
        least = least.min(point_to_triangle(&a[i], b)).min(point_to_triangle(&b[i], a));
        for j in 0..3 {
            let ([p, q], [u, v]) = (side(a, i), side(b, j));
            least = least.min(between_segments([&p, &q], [&u, &v]));
        }
    }
    least
}

/// Returns whether a segment goes through a triangle from one side of it to the other.
fn pierces([p, q]: [Vec3; 2], [a, b, c]: &[Vec3; 3]) -> bool {
    let n = (b - a).cross(&(c - a));
    let (s, t) = (n.dot(&(p - a)), n.dot(&(q - a)));
    if s * t > 0.0 || s == t {
        return false;
    }
    let x = p + (q - p) * (s / (s - t));
    [(a, b), (b, c), (c, a)].iter().all(|(u, v)| (*v - *u).cross(&(x - *u)).dot(&n) >= 0.0)
}
