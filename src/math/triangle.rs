//! Gauss's rule on a triangle.

use gauss_quad::GaussLegendre;
use std::f64::consts::PI;
use std::num::NonZeroUsize;

/// A point of a triangle and its weight; the weights of a rule add up to one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleNode {
    /// Shares of the three vertices, which add up to one.
    pub shares: [f64; 3],
    /// The weight.
    pub weight: f64,
}

/// The conical product rule of n^2 points, exact for polynomials of degree 2 n - 1 (Stroud 1971, section 2.8): Gauss-Jacobi
/// for the weight 1 - u away from one vertex, Gauss-Legendre along the side opposite to it.
pub fn rule(n: usize) -> Vec<TriangleNode> {
    let n = NonZeroUsize::new(n.max(1)).unwrap_or(NonZeroUsize::MIN);
    let (along, away) = (GaussLegendre::new(n), jacobi(n.get()));
    let mut nodes = Vec::with_capacity(n.get() * n.get());
    for &(u, weight) in &away {
        let (u, rest) = (0.5 * (1.0 + u), 0.5 * (1.0 - u));
        for (&v, &other) in along.nodes().zip(along.weights()) {
            let v = 0.5 * (1.0 + v);
            nodes.push(TriangleNode {
                shares: [u, rest * v, rest * (1.0 - v)],
                weight: 0.25 * weight * other,
            });
        }
    }
    nodes
}

/// Nodes and weights for the weight 1 - u on [-1, 1], whose integral is 2: Radau's rule of N = n + 1 points less the one at u = 1,
/// at the other zeros of P_n - P_N, with the weights (1 - u^2) / (N P_n(u))^2.
fn jacobi(n: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut before, mut last) = (1.0, x);
        for k in 1..=n {
            (before, last) = (last, ((2 * k + 1) as f64 * x * last - k as f64 * before) / (k + 1) as f64);
        }
        [before, last]
    };
    let next = (n + 1) as f64;
    (1..=n)
        .map(|k| {
            let mut x = (PI * (4 * k + 1) as f64 / (4 * n + 4) as f64).cos();
            for _ in 0..10 {
                let [p, q] = legendre(x);
                // (1 - x^2) (P_n - P_N)' by P_n and P_N alone.
                let slope = (next * (x * p - q) - next * (p - x * q)) / ((1.0 - x) * (1.0 + x));
                x -= (p - q) / slope;
            }
            let [p, _] = legendre(x);
            (x, (1.0 - x) * (1.0 + x) / (next * p).powi(2))
        })
        .collect()
}
