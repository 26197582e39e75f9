//! Gauss-Legendre quadrature on an interval, and the polynomial through values at its nodes.
//!
//! On [0, 1], let P_k be the Legendre polynomials of x = 2 c - 1 and b_j the weights. The polynomial of
//! lowest degree that is one at node j and zero at the others is l_j = b_j sum_k (2 k + 1) P_k(x_j) P_k(x).
//! The integral of P_k from 0 to c is (P_(k+1) - P_(k-1)) / (2 (2 k + 1)) for k > 0, and c for P_0.

use gauss_quad::GaussLegendre;
use std::num::NonZeroUsize;

/// The nodes of a rule with their weights and the integrals of the Lagrange polynomials.
#[derive(Debug, Clone, PartialEq)]
pub struct Gauss {
    /// The nodes, in [0, 1].
    pub nodes: Vec<f64>,
    /// The weights, which are the integrals of the l_j from 0 to 1.
    pub weights: Vec<f64>,
    /// The coefficients of the collocation method of order 2 n: row i holds the integrals of the l_j from 0
    /// to node i.
    pub integrals: Vec<Vec<f64>>,
    /// The factors b_j (2 k + 1) P_k(x_j), with j as the row.
    legendre: Vec<Vec<f64>>,
}

impl Gauss {
    /// Computes the rule with `count` nodes.
    pub fn new(count: NonZeroUsize) -> Self {
        let rule = GaussLegendre::new(count);
        let mut both: Vec<_> = rule.nodes().copied().zip(rule.weights().copied()).collect();
        both.sort_by(|one, other| one.0.total_cmp(&other.0));
        let n = count.get();
        let polynomials: Vec<_> = both.iter().map(|&(x, _)| legendre(x, n)).collect();
        let factor = |k: usize| (2 * k + 1) as f64;
        let legendre: Vec<Vec<_>> = (0..n)
            .map(|j| (0..n).map(|k| 0.5 * both[j].1 * factor(k) * polynomials[j][k]).collect())
            .collect();
        let mut gauss = Self {
            nodes: both.iter().map(|(x, _)| 0.5 * (1.0 + x)).collect(),
            weights: both.iter().map(|(_, weight)| 0.5 * weight).collect(),
            integrals: vec![vec![0.0; n]; n],
            legendre,
        };
        let mut integrals = std::mem::take(&mut gauss.integrals);
        integrals.iter_mut().zip(&gauss.nodes).for_each(|(row, &node)| gauss.integrals_to(node, row));
        Self { integrals, ..gauss }
    }

    /// Writes the weights with which values at the nodes add up to the value of their polynomial at c, which
    /// may lie outside of [0, 1].
    pub fn factors(&self, c: f64, out: &mut [f64]) {
        let x = 2.0 * c - 1.0;
        out.fill(0.0);
        let (mut previous, mut present) = (0.0, 1.0);
        for k in 0..self.nodes.len() {
            out.iter_mut().zip(&self.legendre).for_each(|(out, row)| *out += row[k] * present);
            (previous, present) = (present, next(k, x, previous, present));
        }
    }

    /// Iterates over the weights with which values at the nodes add up to the coefficient of the Legendre
    /// polynomial of highest degree in their polynomial.
    pub fn highest(&self) -> impl Iterator<Item = f64> {
        self.legendre.iter().filter_map(|row| row.last().copied())
    }

    /// Writes the integrals of the Lagrange polynomials from 0 to c.
    pub fn integrals_to(&self, c: f64, out: &mut [f64]) {
        let x = 2.0 * c - 1.0;
        out.fill(0.0);
        let (mut before, mut present, mut after) = (0.0, 1.0, x);
        for k in 0..self.nodes.len() {
            let integral = if k == 0 { c } else { 0.5 * (after - before) / (2 * k + 1) as f64 };
            out.iter_mut().zip(&self.legendre).for_each(|(out, row)| *out += row[k] * integral);
            (before, present, after) = (present, after, next(k + 1, x, present, after));
        }
    }
}

/// Returns the Legendre polynomials P_0, ..., P_n at x.
fn legendre(x: f64, n: usize) -> Vec<f64> {
    let mut all = vec![1.0];
    for k in 0..n {
        let previous = if k == 0 { 0.0 } else { all[k - 1] };
        all.push(next(k, x, previous, all[k]));
    }
    all
}

/// Returns P_(k+1) by the recurrence from P_(k-1) and P_k.
fn next(k: usize, x: f64, previous: f64, present: f64) -> f64 {
    ((2 * k + 1) as f64 * x * present - k as f64 * previous) / (k + 1) as f64
}
