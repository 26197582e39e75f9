//! Gauss's rule on an interval from -1 to 1, which is halved until the rule has converged.
//!
//! The values at the nodes give the coefficients of Legendre's series. Those of a smooth function fall like a power of their
//! degree, and the rule has the error of the coefficient of twice its number of nodes. That one is estimated from the last
//! coefficients and from those of two thirds their degree. Several are looked at, since those of even functions
//! alternate with zeros, and where they oscillate one alone may be small by chance.

use crate::math::gauss::legendre;
use gauss_quad::GaussLegendre;
use std::num::NonZeroUsize;

/// Nodes of the rule.
const NODES: usize = 32;

/// Coefficients in each of the two groups.
const GROUP: usize = 4;
/// Degree of the first coefficient of each group.
const FIRST: [usize; 2] = [2 * NODES / 3 - GROUP, NODES - GROUP];

/// The estimated error is taken this number of times.
const CAUTION: f64 = 2.0;

/// Intervals are halved at most so often. What a continuous integrand leaves on the last one is below rounding.
const DEEPEST: u32 = 48;

/// The nodes, weights and the factors of values in the coefficients of Legendre's series that tell the error.
#[derive(Debug, Clone)]
pub struct Rule {
    /// Nodes from -1 to 1, with weights that add up to two.
    nodes: [[f64; 2]; NODES],
    /// Factors of the values in the two groups of coefficients.
    coefficients: [[[f64; NODES]; GROUP]; 2],
}

impl Default for Rule {
    fn default() -> Self {
        let gauss = GaussLegendre::new(const { NonZeroUsize::new(NODES).unwrap() });
        let mut nodes = [[0.0; 2]; NODES];
        let given = gauss.nodes().zip(gauss.weights());
        nodes.iter_mut().zip(given).for_each(|(node, (x, weight))| *node = [*x, *weight]);
        let of = |k: usize| nodes.map(|[x, weight]| (k as f64 + 0.5) * weight * legendre(x, k)[k]);
        let coefficients = FIRST.map(|first| std::array::from_fn(|k| of(first + k)));
        Self { nodes, coefficients }
    }
}

impl Rule {
    /// The integrals of W functions from -1 to 1, the first of them to these tolerances.
    pub fn integrate<const W: usize>(
        &self,
        tolerances: &[f64],
        f: &mut impl FnMut(f64) -> [f64; W],
    ) -> [f64; W] {
        let mut total = [0.0; W];
        self.add(0.0, 1.0, DEEPEST, tolerances, f, &mut total);
        total
    }

    fn add<const W: usize>(
        &self,
        middle: f64,
        half: f64,
        left: u32,
        tolerances: &[f64],
        f: &mut impl FnMut(f64) -> [f64; W],
        total: &mut [f64; W],
    ) {
        let mut values = [[0.0; W]; NODES];
        values.iter_mut().zip(&self.nodes).for_each(|(value, [x, _])| *value = f(middle + half * x));
        if left > 0 && !(0..tolerances.len()).all(|k| self.converged(&values, k, tolerances[k] / half)) {
            for side in [-0.5, 0.5] {
                self.add(middle + side * half, 0.5 * half, left - 1, tolerances, f, total);
            }
            return;
        }
        for (value, [_, weight]) in values.iter().zip(&self.nodes) {
            total.iter_mut().zip(value).for_each(|(sum, v)| *sum += half * weight * v);
        }
    }

    fn converged<const W: usize>(&self, values: &[[f64; W]; NODES], k: usize, tolerance: f64) -> bool {
        let of = |factors: &[f64; NODES]| {
            factors.iter().zip(values).map(|(factor, value)| factor * value[k]).sum::<f64>().abs()
        };
        let [before, last] =
            self.coefficients.each_ref().map(|group| group.iter().map(of).fold(0.0, f64::max));
        // What is not a number ends the search: whoever asks for the sum sees it.
        let fall = (last / before.max(f64::MIN_POSITIVE)).min(1.0);
        if CAUTION * last * fall <= tolerance {
            return true;
        }
        // Rounding has coefficients of any order.
        let size = values.iter().map(|value| value[k].abs()).fold(0.0, f64::max);
        last <= 64.0 * f64::EPSILON * size
    }
}
