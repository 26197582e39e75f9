//! Gauss's rule that halves an interval until it has converged.
//!
//! The values at the nodes give the coefficients of Legendre's series. An interval has converged once the last ones are below
//! the tolerance: the rule's error is then smaller, that of a smooth function by far. Several are looked at, since those of even
//! functions alternate with zeros, and where they oscillate one alone may be small by chance.

use crate::math::gauss::legendre;
use gauss_quad::GaussLegendre;
use std::num::NonZeroUsize;

/// Nodes of the rule.
pub const NODES: usize = 24;

/// Coefficients that tell the error.
const LAST: usize = 4;

/// Intervals are halved at most so often. What a continuous integrand leaves on the last one is below rounding.
const DEEPEST: u32 = 48;

/// The nodes, weights and the factors of values in the coefficients of Legendre's series that tell the error.
#[derive(Debug, Clone)]
pub struct Rule {
    /// Nodes from -1 to 1, with weights that add up to two.
    pub nodes: [[f64; 2]; NODES],
    /// Factors of the values in the last coefficients.
    coefficients: [[f64; NODES]; LAST],
}

impl Default for Rule {
    fn default() -> Self {
        let gauss = GaussLegendre::new(const { NonZeroUsize::new(NODES).unwrap() });
        let mut nodes = [[0.0; 2]; NODES];
        let given = gauss.nodes().zip(gauss.weights());
        nodes.iter_mut().zip(given).for_each(|(node, (x, weight))| *node = [*x, *weight]);
        let coefficients = std::array::from_fn(|k| {
            let k = NODES - 1 - k;
            nodes.map(|[x, weight]| (k as f64 + 0.5) * weight * legendre(x, k)[k])
        });
        Self { nodes, coefficients }
    }
}

impl Rule {
    /// The integrals of W functions, each to its tolerance. `accepted` is called with the middle and half the width of each
    /// interval whose sum was taken.
    pub fn integrate<const W: usize>(
        &self,
        [from, to]: [f64; 2],
        tolerances: &[f64; W],
        f: &mut impl FnMut(f64) -> [f64; W],
        accepted: &mut impl FnMut(f64, f64),
    ) -> [f64; W] {
        let mut total = [0.0; W];
        let mut stack = vec![(0.5 * (from + to), 0.5 * (to - from), 0)];
        while let Some((middle, half, depth)) = stack.pop() {
            let mut values = [[0.0; W]; NODES];
            values.iter_mut().zip(&self.nodes).for_each(|(value, [x, _])| *value = f(middle + half * x));
            if depth < DEEPEST && !self.converged(&values, half, tolerances) {
                stack.extend([0.5, -0.5].map(|side| (middle + side * half, 0.5 * half, depth + 1)));
                continue;
            }
            for (value, [_, weight]) in values.iter().zip(&self.nodes) {
                total.iter_mut().zip(value).for_each(|(sum, v)| *sum += half * weight * v);
            }
            accepted(middle, half);
        }
        total
    }

    fn converged<const W: usize>(
        &self,
        values: &[[f64; W]; NODES],
        half: f64,
        tolerances: &[f64; W],
    ) -> bool {
        (0..W).all(|k| {
            let size = values.iter().map(|value| value[k].abs()).fold(0.0, f64::max);
            let of = |factors: &[f64; NODES]| {
                factors.iter().zip(values).map(|(factor, value)| factor * value[k]).sum::<f64>().abs()
            };
            let last = self.coefficients.iter().map(of).fold(0.0, f64::max);
            // Rounding has coefficients of any order. What is not a number never converges: whoever asks for the sum will see it.
            !(2.0 * half * last > tolerances[k] && last > 64.0 * f64::EPSILON * size)
        })
    }
}
