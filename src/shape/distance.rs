//! Distances between points, segments and triangles.

use crate::math::Vec3;

/// Distance of a point from a triangle.
pub fn point_to_triangle(point: &Vec3, triangle: &[Vec3; 3]) -> f64 {
    (closest_point(point, triangle) - point).norm()
}

/// The point of a triangle that is nearest to a point, by the region of its plane that the point lies over (Ericson 2005,
/// section 5.1.5).
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
