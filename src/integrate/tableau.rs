//! An embedded Runge-Kutta pair as data that are read from a file.

use crate::math::rows::Term;
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// The coefficients of an explicit embedded Runge-Kutta pair.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tableau {
    /// The name, which contains the orders.
    pub name: String,
    /// The order of the solution with which the integration continues.
    pub order: u32,
    /// The order of the comparison solution.
    pub error_order: u32,
    /// The number of stages of the pair.
    pub stages: usize,
    /// The nodes, including those of the interpolant's stages.
    pub c: Vec<f64>,
    /// The coefficients; row i holds those of the earlier stages in stage i.
    pub a: Vec<Vec<f64>>,
    /// The low parts of the pair's coefficients. Without them every step would have the same error, which
    /// would grow with the number of steps and not with its square root.
    pub a_low: Vec<Vec<f64>>,
    /// The weights of the solution.
    pub b: Vec<f64>,
    /// The low parts of the weights.
    pub b_low: Vec<f64>,
    /// The weights of the comparison solution.
    pub b_hat: Vec<f64>,
    /// The continuous extension.
    pub interpolant: Interpolant,
    /// The numbers in a bound of how far a path x with dx/dt = v, dv/dt = a departs from its chord within a
    /// step of size h. With a_0 the acceleration at the first stage, the interpolant and the positions of its
    /// own stages lie no further from the chord between the step's ends than
    ///
    /// h^2 ( |a_0| / 8 + spread\[0\] max |a_j - a_0| + spread\[1\] max |a_k - a_0| ),
    ///
    /// with j over the stages of the pair and k over those of the interpolant alone. The velocity at a stage
    /// is v + h sum_j a_ij a_j, so that the interpolant is x + theta h v + h^2 sum_j D_j(theta) a_j with D_j
    /// = sum_i b_i(theta) a_ij. The two numbers are the largest sums of |D_j(theta) - theta D_j(1)| over the
    /// stages of either kind, for the interpolant and for the stages' own positions.
    pub spread: [f64; 2],
}

/// Returns what a file of this crate holds, in JSON; its decimals are rounded to the nearest doubles.
///
/// # Panics
/// Panics if the file does not hold it, which no input can cause: the file is part of the program.
pub(super) fn read<T: DeserializeOwned>(text: &str) -> T {
    serde_json::from_str(text).expect("a file of this crate is valid")
}

impl Tableau {
    /// Returns the non-zero weights of every stage, followed by those of the solution.
    pub(super) fn terms(&self) -> Vec<Vec<Term>> {
        let nonzero = |weights: &[f64], low: &[f64]| {
            let term = |(row, &weight): (usize, &f64)| Term {
                row,
                weight,
                low: low.get(row).copied().unwrap_or(0.0),
            };
            weights.iter().enumerate().map(term).filter(|term| term.weight != 0.0).collect()
        };
        let low = |stage: usize| self.a_low.get(stage).map_or(&[][..], Vec::as_slice);
        let stages = self.a.iter().enumerate().map(|(stage, row)| nonzero(row, low(stage)));
        stages.chain([nonzero(&self.b, &self.b_low)]).collect()
    }

    /// Returns, for each stage, whether it has a weight in the solution or in its interpolant.
    pub(super) fn weighted_stages(&self) -> Vec<bool> {
        let weighted = |stage: usize| {
            let within = self.interpolant.weights.get(stage).is_some_and(|row| row.iter().any(|w| *w != 0.0));
            within || self.b.get(stage).is_some_and(|b| *b != 0.0)
        };
        (0..self.a.len()).map(weighted).collect()
    }
}

/// The continuous extension y(t + theta h) = y + h sum_i b_i(theta) k_i.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interpolant {
    /// The order of the interpolant.
    pub order: u32,
    /// The weights; row i holds w_0, w_1, ... in b_i = theta sum_k w_k T_k(2 theta - 1), with T_k the
    /// Chebyshev polynomials.
    ///
    /// In powers of theta the coefficients would be of order 1e4 and cancel; in this basis they are of order
    /// one.
    pub weights: Vec<Vec<f64>>,
}

impl Interpolant {
    /// Returns the number of coefficients of every b_i.
    pub fn terms(&self) -> usize {
        self.weights.iter().map(Vec::len).max().unwrap_or(0)
    }
}
