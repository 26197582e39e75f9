//! Gauss's rule on a triangle.

use gauss_quad::GaussLegendre;
use std::num::NonZeroUsize;

/// A point of a triangle and its weight; the weights of a rule add up to one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleNode {
    /// The weights of the three vertices in the point, which add up to one.
    pub shares: [f64; 3],
    /// The weight.
    pub weight: f64,
}

/// Returns the conical product rule of n^2 points (Stroud 1971, section 2.8), made of Gauss-Legendre rules in
/// both directions. It is exact for polynomials of degree 2 n - 2: towards one vertex the width 1 - u uses up
/// one degree of the 2 n - 1.
pub fn rule(n: usize) -> Vec<TriangleNode> {
    let gauss = GaussLegendre::new(NonZeroUsize::new(n.max(1)).unwrap_or(NonZeroUsize::MIN));
    let points = || gauss.nodes().zip(gauss.weights()).map(|(&u, &weight)| (0.5 * (1.0 + u), 0.5 * weight));
    let cone = |(u, weight): (f64, f64)| {
        points().map(move |(v, other)| {
            let rest = 1.0 - u;
            TriangleNode { shares: [u, rest * v, rest * (1.0 - v)], weight: 2.0 * rest * weight * other }
        })
    };
    points().flat_map(cone).collect()
}
