//! Outlines of bodies seen from a point: the distance of two outlines, and whether one is inside the other.
//!
//! The observer is at the distance D along a unit vector u. A position x is seen in the same direction as the
//! position x / (1 - x.u / D) would be seen from infinity along u. This map takes lines to lines, and an
//! ellipsoid with the centre c and the matrix Q to another one. With g = 1 - c.u / D and
//! s = g^2 - u.Q u / D^2, the outline of the latter across u has the centre (g c + Q u / D) / s, and its matrix
//! follows from the tangent planes through the observer, (n.c - w)^2 = n.Q n.
//!
//! An outline reaches h(n) from its centre along a unit vector n across the line of sight. That of an
//! ellipsoid is an ellipse with h(n)^2 = n.A n, and that of a polyhedron the convex hull of its vertices.
//! With r from one centre to the other, two outlines are apart by the maximum over n of
//!
//!   n.r - h_A(n) - h_B(-n),
//!
//! which is below zero where they overlap; and the outline of A, at r from that of B, is inside it, all
//! around, where the maximum over n of
//!
//!   n.r + h_A(n) - h_B(n)
//!
//! is below zero. Each function is evaluated at one n: a lower bound of the maximum, which has its sign.
//! Where two ellipses touch, n is their common normal (Perram & Wertheim 1985, J. Comput. Phys. 58, 409);
//! where an ellipse touches another one from inside, it is the normal at the point of A that is farthest from
//! the centre when B is stretched to a circle. For polygons the normals of the sides and of the nearest or
//! farthest corner suffice.
//!
//! Where two outlines overlap, the body in front is the one on the point's side of a plane that separates the
//! bodies.

use crate::math::{Mat3, Vec3, perpendicular};
use crate::shape::{Body, Part, Shape, across_separating_plane, tip};

type Vec2 = nalgebra::Vector2<f64>;

/// Two bodies and the point from which they are seen, farther from the origin than either body reaches toward
/// it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sighting<'a> {
    /// The body that may be hidden, and that which may hide it.
    pub bodies: [&'a Body; 2],
    /// The centres.
    pub centres: [&'a Vec3; 2],
    /// The rotations from the bodies' frames into that of the centres.
    pub rotations: [&'a Mat3; 2],
    /// The unit vector toward the point.
    pub direction: &'a Vec3,
    /// One over the point's distance from the origin; zero at infinity.
    pub nearness: f64,
}

impl Sighting<'_> {
    /// Returns the units of work of [`Self::gap`] and [`Self::overhang`] for two bodies.
    pub fn work(bodies: [&Body; 2]) -> u64 {
        let vertices = |part: &Part| match &part.shape {
            Shape::Polyhedron(polyhedron) => polyhedron.vertices().count() as u64,
            _ => 1,
        };
        let [behind, front] = bodies.map(|body| body.outer_parts().count() as u64);
        let vertices = bodies.map(|body| body.outer_parts().map(vertices).sum::<u64>());
        8 * (front * vertices[0] + behind * vertices[1])
    }

    /// Returns the distance of the outlines: negative where they overlap and the second body is in front. For
    /// bodies of several parts it is the least one of two parts.
    pub fn gap(&self) -> f64 {
        let [behind, front] = self.outlines();
        let pairs = behind.iter().flat_map(|a| front.iter().map(|b| gap(a, b).max(self.depth(a, b))));
        pairs.fold(f64::INFINITY, f64::min)
    }

    /// Returns how far the outline of the first body extends beyond that of the second: negative where it is
    /// inside and the second body is in front. For bodies of several parts each part of the first body has to
    /// be inside one part of the second: a region that only several parts cover together counts as visible.
    pub fn overhang(&self) -> f64 {
        let [behind, front] = self.outlines();
        let least = |a: &PartOutline| {
            front.iter().map(|b| overhang(a, b).max(self.depth(a, b))).fold(f64::INFINITY, f64::min)
        };
        behind.iter().map(least).fold(f64::NEG_INFINITY, f64::max)
    }

    fn outlines(&self) -> [Vec<PartOutline<'_>>; 2] {
        let x = perpendicular(self.direction);
        let frame = [x, self.direction.cross(&x), *self.direction];
        [0, 1].map(|k| {
            let outline =
                |part| PartOutline::new(part, self.centres[k], self.rotations[k], &frame, self.nearness);
            self.bodies[k].outer_parts().map(outline).collect()
        })
    }

    /// Returns a length that is negative where the second of two parts whose outlines overlap is in front.
    fn depth(&self, a: &PartOutline, b: &PartOutline) -> f64 {
        let r = b.centre - a.centre;
        let n = across_separating_plane([a.shape, b.shape], [&a.rotation, &b.rotation], &r);
        let ends = [a.centre + tip(a.shape, &a.rotation, &n), b.centre + tip(b.shape, &b.rotation, &-n)];
        n.dot(&((ends[0] + ends[1]) * (0.5 * self.nearness) - self.direction))
    }
}

/// The outline of a part in the plane across the direction to the point, and the part itself.
struct PartOutline<'a> {
    shape: &'a Shape,
    centre: Vec3,
    rotation: Mat3,
    /// The centre of the outline.
    centre_in_plane: Vec2,
    form: OutlineForm,
}

enum OutlineForm {
    /// The vectors whose sum, weighted with the components of n, has the length h(n); zero for a point.
    Ellipse([Vec3; 2]),
    /// The corners of a convex polygon, relative to the centre, counterclockwise.
    Polygon(Vec<Vec2>),
}

impl<'a> PartOutline<'a> {
    fn new(part: &'a Part, centre: &Vec3, rotation: &Mat3, frame: &[Vec3; 3], nearness: f64) -> Self {
        let centre = centre + rotation * part.position();
        let rotation = rotation * part.rotation();
        let local_axes = frame.map(|axis| rotation.tr_mul(&axis));
        let [x, y, toward] = frame.map(|axis| axis.dot(&centre));
        let growth = 1.0 - nearness * toward;
        let (centre_in_plane, form) = match &part.shape {
            Shape::Point | Shape::Stokes(_) => {
                (Vec2::new(x, y) / growth, OutlineForm::Ellipse([Vec3::zeros(); 2]))
            }
            Shape::Ellipsoid(ellipsoid) => {
                let [first, second, depth] =
                    local_axes.map(|axis| axis.component_mul(&Vec3::from(ellipsoid.semi_axes())));
                let square = growth * growth - nearness * nearness * depth.norm_squared();
                let root = square.sqrt();
                let curvature = nearness * nearness / (growth + root);
                let seen = |along: Vec3, c: f64| {
                    along / root + depth * ((nearness * c + curvature * along.dot(&depth)) / square)
                };
                let centre = |along: Vec3, c: f64| (growth * c + nearness * along.dot(&depth)) / square;
                let centre_in_plane = Vec2::new(centre(first, x), centre(second, y));
                (centre_in_plane, OutlineForm::Ellipse([seen(first, x), seen(second, y)]))
            }
            Shape::Polyhedron(polyhedron) => {
                let centre_in_plane = Vec2::new(x, y) / growth;
                let corner = |v: Vec3| {
                    let [along, aside, above] = local_axes.map(|axis| axis.dot(&v));
                    // The difference of the corner's place and the centre's.
                    (Vec2::new(along, aside) + centre_in_plane * (nearness * above))
                        / (growth - nearness * above)
                };
                (centre_in_plane, OutlineForm::Polygon(hull(polyhedron.vertices().map(corner).collect())))
            }
        };
        Self { shape: &part.shape, centre, rotation, centre_in_plane, form }
    }

    /// Returns how far the outline reaches from its centre along a unit vector.
    fn support(&self, n: Vec2) -> f64 {
        match &self.form {
            OutlineForm::Ellipse(axes) => ellipse_support(axes, n),
            OutlineForm::Polygon(corners) => {
                corners.iter().map(|c| c.dot(&n)).fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }
}

/// Returns the distance of two outlines; negative where they overlap.
fn gap(a: &PartOutline, b: &PartOutline) -> f64 {
    let r = b.centre_in_plane - a.centre_in_plane;
    let along = |n: Vec2| n.dot(&r) - a.support(n) - b.support(-n);
    match (&a.form, &b.form) {
        (OutlineForm::Ellipse(p), OutlineForm::Ellipse(q)) => along(unit(common_normal(p, q, r), r)),
        (OutlineForm::Ellipse(_), OutlineForm::Polygon(_)) => gap(b, a),
        (OutlineForm::Polygon(p), OutlineForm::Ellipse(q)) => {
            let nearest = p.iter().map(|corner| r - corner).min_by(|v, w| {
                let [v, w] = [v, w].map(|v| v.dot(&conjugate(q, v)));
                v.total_cmp(&w)
            });
            let corner_normal = nearest.map(|offset| unit(conjugate(q, &offset), r));
            sides(p).chain(corner_normal).map(along).fold(f64::NEG_INFINITY, f64::max)
        }
        (OutlineForm::Polygon(p), OutlineForm::Polygon(q)) => {
            sides(p).chain(sides(q).map(|n| -n)).map(along).fold(f64::NEG_INFINITY, f64::max)
        }
    }
}

/// Returns how far the outline `a` extends beyond the outline `b`; negative where it is inside.
fn overhang(a: &PartOutline, b: &PartOutline) -> f64 {
    let r = a.centre_in_plane - b.centre_in_plane;
    let along = |n: Vec2| n.dot(&r) + a.support(n) - b.support(n);
    match (&a.form, &b.form) {
        (OutlineForm::Ellipse(p), OutlineForm::Ellipse(q)) => along(unit(farthest(p, q, r), r)),
        (OutlineForm::Polygon(p), OutlineForm::Ellipse(q)) => {
            let normals = p.iter().map(|corner| unit(conjugate(q, &(r + corner)), r));
            normals.map(along).fold(f64::NEG_INFINITY, f64::max)
        }
        (_, OutlineForm::Polygon(q)) => sides(q).map(along).fold(f64::NEG_INFINITY, f64::max),
    }
}

/// Returns how far an ellipse reaches from its centre along a unit vector.
fn ellipse_support([x, y]: &[Vec3; 2], n: Vec2) -> f64 {
    (x * n.x + y * n.y).norm()
}

/// Returns the unit vector along `n`; that along `or`, or any one, where `n` is zero.
fn unit(n: Vec2, or: Vec2) -> Vec2 {
    n.try_normalize(0.0).or_else(|| or.try_normalize(0.0)).unwrap_or_else(Vec2::x)
}

/// Returns A^-1 v times the determinant of A, for an ellipse with the matrix A.
fn conjugate([x, y]: &[Vec3; 2], v: &Vec2) -> Vec2 {
    let xy = x.dot(y);
    Vec2::new(y.norm_squared() * v.x - xy * v.y, x.norm_squared() * v.y - xy * v.x)
}

/// Returns the normals of the sides of a convex polygon, outward.
fn sides(corners: &[Vec2]) -> impl Iterator<Item = Vec2> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| unit(Vec2::new(b.y - a.y, a.x - b.x), *a))
}

/// Returns the convex hull of points, counterclockwise (Andrew 1979, Inf. Process. Lett. 9, 216).
fn hull(mut points: Vec<Vec2>) -> Vec<Vec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut corners: Vec<Vec2> = Vec::new();
    let half = |corners: &mut Vec<Vec2>, points: &mut dyn Iterator<Item = &Vec2>| {
        let start = corners.len();
        for point in points {
            while let [.., a, b] = &corners[start..]
                && (b - a).perp(&(point - b)) <= 0.0
            {
                corners.pop();
            }
            corners.push(*point);
        }
        // The last point is the first one of the other half.
        corners.pop();
    };
    half(&mut corners, &mut points.iter());
    half(&mut corners, &mut points.iter().rev());
    corners
}

/// Returns the direction n at which n.r / (h_A(n) + h_B(n)) is largest: the common normal of two ellipses,
/// r apart, when they have grown to touch.
///
/// It is along (A + t B)^-1 r with t = h_A/h_B, which is sought in its logarithm.
fn common_normal(a: &[Vec3; 2], b: &[Vec3; 2], r: Vec2) -> Vec2 {
    /// Beyond these ends one ellipse is smaller than the round-off of the other.
    const END: f64 = 40.0;
    /// The distance is flat in n at its maximum.
    const ENOUGH: f64 = 1e-9;
    let at = |u: f64| conjugate(a, &r) + conjugate(b, &r) * u.exp();
    // ln(h_A / h_B) - u falls through zero.
    let (mut low, mut high) = (-END, END);
    let mut n = at(0.0);
    let logarithm_error = |n: Vec2, u: f64| (ellipse_support(a, n) / ellipse_support(b, n)).ln() - u;
    let (mut u, mut value) = (0.0, logarithm_error(n, 0.0));
    let mut next = value;
    for _ in 0..60 {
        if !value.is_finite() {
            // One of them is a point or is seen edge on.
            return n;
        }
        if value > 0.0 {
            low = u
        } else {
            high = u
        }
        if !(next > low && next < high) {
            next = 0.5 * (low + high);
        }
        let (last, other) = (u, value);
        u = next;
        n = at(u);
        value = logarithm_error(n, u);
        next = u - value * (u - last) / (value - other);
        if (u - last).abs() < ENOUGH || value == 0.0 {
            break;
        }
    }
    n
}

/// Returns the normal of the ellipse B at the multiple of it that touches an ellipse A around it, at r.
///
/// With B stretched to the unit circle, A has its centre at c and the semi-axes s, along its own axes. The
/// farthest point x of A from the origin satisfies (x - c)_i = s_i^2 c_i / (m - s_i^2), with the multiplier m
/// above both s_i^2.
fn farthest([ax, ay]: &[Vec3; 2], [bx, by]: &[Vec3; 2], r: Vec2) -> Vec2 {
    // B = L L^T, with the lower triangle L.
    let first = bx.norm();
    let aside = bx.dot(by) / first;
    let second = bx.cross(by).norm() / first;
    // An ellipse that is seen edge on has no inside.
    if second.is_nan() || second <= 0.0 {
        return r;
    }
    let into = |x: f64, y: f64| (x / first, (y - aside * (x / first)) / second);
    let (cx, cy) = into(r.x, r.y);
    let (ux, uy) = (ax / first, (ay - ax * (aside / first)) / second);
    let half = 0.5 * (2.0 * ux.dot(&uy)).atan2(ux.norm_squared() - uy.norm_squared());
    let (sin, cos) = half.sin_cos();
    let centre_along_axes = Vec2::new(cx * cos + cy * sin, cy * cos - cx * sin);
    let (s1, s2) = ((ux * cos + uy * sin).norm(), (uy * cos - ux * sin).norm());
    let (c1, c2) = (centre_along_axes.x.abs(), centre_along_axes.y.abs());
    let (p, q, between) = (s1 * c1, s2 * c2, ((s1 - s2) * (s1 + s2)).max(0.0));
    // With d = m - s1^2 the weights are w1 = p / d and w2 = q / (d + between), of square sum one, which
    // falls.
    let (mut low, mut high) = (p.max(q - between).max(0.0), p.hypot(q));
    let mut d = low;
    for _ in 0..60 {
        let (w1, w2) = (p / d, q / (d + between));
        let length = w1.hypot(w2);
        if !length.is_finite() || high <= low {
            break;
        }
        if length > 1.0 {
            low = d
        } else {
            high = d
        }
        // Newton's step for 1 / length - 1, which is nearly linear.
        let slope = (w1 * w1 / d + w2 * w2 / (d + between)) / length;
        let newton = d + (length - 1.0) * length / slope;
        let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        let moved = (next - d).abs();
        d = next;
        if moved <= 1e-9 * high {
            break;
        }
    }
    let w2 = if d + between > 0.0 { (q / (d + between)).min(1.0) } else { 0.0 };
    let w1 = (1.0 - w2 * w2).sqrt();
    let (x1, x2) =
        ((c1 + s1 * w1).copysign(centre_along_axes.x), (c2 + s2 * w2).copysign(centre_along_axes.y));
    let (x, y) = (x1 * cos - x2 * sin, x1 * sin + x2 * cos);
    // The normal is L^-T times the direction of the farthest point.
    let y = y / second;
    Vec2::new((x - aside * y) / first, y)
}
