//! Exact overlap of two ellipsoids by the contact function of Perram & Wertheim (1985), J. Comput. Phys. 58, 409.
//!
//! For two ellipsoids with centres r apart, F = max over s in [0,1] of
//! s (1-s) r^T [ (1-s) A + s B ]^-1 r, where A = R diag(a^2) R^T. The function of s is concave, and sqrt(F) is the
//! factor by which both bodies would have to grow for their surfaces to touch: F > 1 apart, F = 1 touching,
//! F < 1 overlapping.

use super::{Ellipsoid, Shape};
use crate::math::{Mat3, Vec3};

/// The square of the factor by which two bodies must grow to touch; infinite for two points.
///
/// `separation` runs from the first centre to the second; the matrices turn body frames into its frame.
pub fn contact_function(
    first: &Shape,
    second: &Shape,
    separation: &Vec3,
    rotation_first: &Mat3,
    rotation_second: &Mat3,
) -> f64 {
    let scale = first.circumradius().max(second.circumradius());
    if scale == 0.0 {
        return f64::INFINITY;
    }
    // In units of the larger body nothing over- or underflows.
    let spread = |shape: &Shape, rotation: &Mat3| {
        let axes = Vec3::from(shape.semi_axes()) / scale;
        rotation * Mat3::from_diagonal(&axes.component_mul(&axes)) * rotation.transpose()
    };
    let (a, b) = (spread(first, rotation_first), spread(second, rotation_second));
    let r = separation / scale;
    match (first, second) {
        // Beside a point the maximum sits at the end of the interval: r^T A^-1 r.
        (Shape::Ellipsoid(e), Shape::Point) => return gauge(e, &(rotation_first.transpose() * separation)),
        (Shape::Point, Shape::Ellipsoid(e)) => return gauge(e, &(rotation_second.transpose() * separation)),
        _ => {}
    }
    // Over u = ln(s / (1 - s)), where the maximum of bodies of very different size is not squeezed to an end.
    maximum(|u: f64| {
        let (s, rest) = (1.0 / (1.0 + (-u).exp()), 1.0 / (1.0 + u.exp()));
        let inverse = (rest * a + s * b).cholesky();
        inverse.map_or(0.0, |m| s * rest * r.dot(&m.solve(&r)))
    })
}

/// The factor by which two bodies must grow to touch, infinite where their circumscribed spheres are apart; `None`
/// where their interiors share a point. Touching surfaces do not overlap.
pub fn growth(
    first: &Shape,
    second: &Shape,
    separation: &Vec3,
    rotation_first: &Mat3,
    rotation_second: &Mat3,
) -> Option<f64> {
    // Rounding of the contact function: a gap this small relative to the bodies is contact.
    const TOUCHING: f64 = 1e-13;
    let distance = separation.norm();
    if distance == 0.0 {
        return None;
    }
    if distance >= first.circumradius() + second.circumradius() {
        return Some(f64::INFINITY);
    }
    let square = contact_function(first, second, separation, rotation_first, rotation_second);
    (square >= 1.0 - TOUCHING).then(|| square.sqrt())
}

/// Sum of x_i^2 / a_i^2: below one inside.
fn gauge(ellipsoid: &Ellipsoid, x: &Vec3) -> f64 {
    x.component_div(&Vec3::from(ellipsoid.semi_axes())).norm_squared()
}

/// Maximum of a function with one maximum, by golden sections.
fn maximum(f: impl Fn(f64) -> f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    // Beyond these ends one body is smaller than the round-off of the other.
    let (mut low, mut high) = (-40.0, 40.0);
    let (mut s, mut t) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut fs, mut ft) = (f(s), f(t));
    // The value is flat at its maximum, so that half the digits in u give all of them in F.
    while high - low > 1e-8 {
        if fs < ft {
            (low, s, fs) = (s, t, ft);
            t = low + GOLDEN * (high - low);
            ft = f(t);
        } else {
            (high, t, ft) = (t, s, fs);
            s = high - GOLDEN * (high - low);
            fs = f(s);
        }
    }
    fs.max(ft)
}
