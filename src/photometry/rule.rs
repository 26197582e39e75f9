//! Fejér's second rule, which doubles its nodes and then halves an interval until it has converged.
//!
//! The nodes are cos(pi k / n), 0 < k < n, without the ends of the interval, and those for n are among those
//! for 2 n, so that no value is computed twice. The values give the coefficients b_k of f(cos x) sin x = sum
//! of b_k sin(k x), that is of f in Chebyshev's polynomials of the second kind. An interval has converged
//! once the last ones are below the tolerance: the rule's error is then smaller. Several are compared, since those
//! of even functions alternate with zeros, and a single oscillating one may be small by chance.
//! Fejér (1933), Math. Z. 37, 287; Trefethen (2008), SIAM Rev. 50, 67, compares such rules with Gauss's.

use crate::error::{Error, Result};
use crate::math::lanes::{Lanes, replace};
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// The numbers n of the nested rules; each but the first is twice the one before.
const ORDERS: [usize; 3] = [16, 32, 64];

/// Nodes of the largest rule.
const NODES: usize = ORDERS[2] - 1;

/// The number of coefficients from which the error is estimated.
const LAST: usize = 4;

/// The largest number of times that an interval is halved. The integral of a continuous function over the last half is
/// below rounding.
const DEEPEST: u32 = 48;

/// The largest number of pieces of an interval, several times that of any integrand whose breaks are known.
const PIECES: usize = 128;

/// The one set of rules.
pub static RULE: LazyLock<NestedRules> = LazyLock::new(NestedRules::new);

/// Nested rules; the first nodes of all are those of the smallest rule.
#[derive(Debug)]
pub struct NestedRules {
    nodes: [f64; NODES],
    orders: [NestedRule; 3],
}

/// One of the nested rules.
#[derive(Debug)]
struct NestedRule {
    /// Weights of the nodes of this rule, which add up to two.
    weights: Vec<f64>,
    /// For each node the factors of its value in the coefficients b_1, b_2, ..., and zeros up to whole blocks.
    coefficients: Vec<Vec<f64>>,
}

/// A part of an interval on which a rule has converged.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    middle: f64,
    half: f64,
    order: usize,
}

impl NestedRules {
    fn new() -> Self {
        let largest = ORDERS[2];
        // Multiples of the widest spacing come first, then those that each doubling adds.
        let mut indices: Vec<usize> = (1..largest).collect();
        indices.sort_by_key(|index| ORDERS.iter().position(|n| index % (largest / n) == 0));
        let angles: [f64; NODES] = std::array::from_fn(|i| PI * indices[i] as f64 / largest as f64);
        let order = |n: usize| {
            let angles = &angles[..n - 1];
            let scale = 2.0 / n as f64;
            let integral =
                |x: f64| (1..n).step_by(2).map(|k| (k as f64 * x).sin() * 2.0 / k as f64).sum::<f64>();
            NestedRule {
                weights: angles.iter().map(|x| scale * x.sin() * integral(*x)).collect(),
                coefficients: angles
                    .iter()
                    .map(|x| {
                        let factor = |k: usize| scale * x.sin() * (k as f64 * x).sin();
                        (1..=n).map(|k| if k < n { factor(k) } else { 0.0 }).collect()
                    })
                    .collect(),
            }
        };
        Self { nodes: angles.map(f64::cos), orders: ORDERS.map(order) }
    }

    /// Returns the integrals of W functions, each to its tolerance. `accepted` is called with each piece whose sum is
    /// part of them.
    ///
    /// # Errors
    /// [`Error::NotConverged`], and those of the functions.
    pub fn integrate<const W: usize>(
        &self,
        [from, to]: [f64; 2],
        tolerances: &[f64; W],
        f: &mut impl FnMut(f64) -> Result<[f64; W]>,
        accepted: &mut impl FnMut(Piece),
    ) -> Result<[f64; W]> {
        self.integrate_with_values([from, to], tolerances, f, &mut |piece, _| accepted(piece))
    }

    /// Adds to `sums` the integrals of a function from the beginning of an interval to each of some ends in rising
    /// order. An integral to an end outside of the interval ends at the interval's nearest end.
    ///
    /// # Errors
    /// [`Error::NotConverged`], and those of the function.
    pub fn cumulate(
        &self,
        interval: [f64; 2],
        tolerance: f64,
        f: &mut impl FnMut(f64) -> Result<f64>,
        ends: &[f64],
        sums: &mut [f64],
    ) -> Result<f64> {
        let (arch, mut series) = (Arch::new(), [0.0; NODES + 1]);
        let mut add = |Piece { middle, half, order }: Piece, values: &[[f64; 1]]| {
            let factors = &self.orders[order].coefficients;
            arch.dispatch(Antiderivative { factors, values, half, series: &mut series });
            let series = &series[..values.len()];
            let (low, high) = (middle - half, middle + half);
            let (first, last) = (ends.partition_point(|y| *y <= low), ends.partition_point(|y| *y < high));
            let mut integrals = ends[first..last].to_vec();
            arch.dispatch(Integrals { series, middle, half, integrals: &mut integrals });
            sums[first..last].iter_mut().zip(&integrals).for_each(|(sum, integral)| *sum += integral);
            let all = 2.0 * series.iter().step_by(2).sum::<f64>();
            sums[last..].iter_mut().for_each(|sum| *sum += all);
        };
        let [total] = self.integrate_with_values(interval, &[tolerance], &mut |x| Ok([f(x)?]), &mut add)?;
        Ok(total)
    }

    /// Integrates as [`Self::integrate`], and calls `accepted` with each piece and the values at its nodes.
    fn integrate_with_values<const W: usize>(
        &self,
        [from, to]: [f64; 2],
        tolerances: &[f64; W],
        f: &mut impl FnMut(f64) -> Result<[f64; W]>,
        accepted: &mut impl FnMut(Piece, &[[f64; W]]),
    ) -> Result<[f64; W]> {
        let mut total = [0.0; W];
        let mut stack = vec![(0.5 * (from + to), 0.5 * (to - from), 0)];
        let mut values = [[0.0; W]; NODES];
        let (mut pieces, mut size) = (0, [0.0; W]);
        while let Some((middle, half, depth)) = stack.pop() {
            let (mut evaluated, mut order) = (0, None);
            for (index, rule) in self.orders.iter().enumerate() {
                let count = ORDERS[index] - 1;
                for (value, x) in values[evaluated..count].iter_mut().zip(&self.nodes[evaluated..]) {
                    *value = f(middle + half * x)?;
                    size.iter_mut().zip(*value).for_each(|(size, v)| *size = v.abs().max(*size));
                }
                evaluated = count;
                if rule.converged(&values[..count], half, tolerances, &size) {
                    order = Some(index);
                    break;
                }
            }
            pieces += 1;
            if pieces > PIECES {
                let what = "brightness".to_string();
                let detail = format!("has not converged in {PIECES} intervals of a height or a longitude");
                return Err(Error::NotConverged { what, detail });
            }
            if order.is_none() && depth < DEEPEST {
                stack.extend([0.5, -0.5].map(|side| (middle + side * half, 0.5 * half, depth + 1)));
                continue;
            }
            let order = order.unwrap_or(ORDERS.len() - 1);
            for (value, weight) in values.iter().zip(&self.orders[order].weights) {
                total.iter_mut().zip(value).for_each(|(sum, v)| *sum += half * weight * v);
            }
            accepted(Piece { middle, half, order }, &values[..ORDERS[order] - 1]);
        }
        Ok(total)
    }

    /// Iterates over the nodes on a piece of an interval and their weights.
    pub fn nodes(&self, piece: Piece) -> impl Iterator<Item = [f64; 2]> {
        let weights = &self.orders[piece.order].weights;
        self.nodes.iter().zip(weights).map(move |(x, w)| [piece.middle + piece.half * x, piece.half * w])
    }
}

impl NestedRule {
    /// Returns whether the last coefficients of each function are below its tolerance, or are rounding errors of values
    /// of these sizes.
    fn converged<const W: usize>(
        &self,
        values: &[[f64; W]],
        half: f64,
        tolerances: &[f64; W],
        sizes: &[f64; W],
    ) -> bool {
        (0..W).all(|k| {
            let mut last = [0.0; LAST];
            for (factors, value) in self.coefficients.iter().zip(values) {
                let factors = &factors[values.len() - LAST..];
                last.iter_mut().zip(factors).for_each(|(sum, factor)| *sum += factor * value[k]);
            }
            let last = last.into_iter().map(f64::abs).fold(0.0, f64::max);
            // Rounding has coefficients of any order. A value that is not a number stays in the sum, which is
            // then refused.
            !(2.0 * half * last > tolerances[k] && last > 64.0 * f64::EPSILON * sizes[k])
        })
    }
}

/// Computes from values at nodes the coefficients c_k of the antiderivative sum of c_k T_k(y), k from 1 on, since the
/// integral of b_k sin(k x) is -b_k cos(k x) / k, and cos(k x) is Chebyshev's polynomial of y = cos x.
struct Antiderivative<'a> {
    factors: &'a [Vec<f64>],
    values: &'a [[f64; 1]],
    half: f64,
    series: &'a mut [f64],
}

impl WithSimd for Antiderivative<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for block in 0..(self.values.len() + 1) / (2 * S::F64_LANES) {
            let mut sum: Lanes<S> = Lanes::splat(simd, 0.0);
            for (factors, [value]) in self.factors.iter().zip(self.values) {
                sum = Lanes::load(simd, factors, block).mul_add(sum.constant(*value), sum);
            }
            sum.store(self.series, block);
        }
        for (k, coefficient) in self.series[..self.values.len()].iter_mut().enumerate() {
            *coefficient *= self.half / (k + 1) as f64;
        }
    }
}

/// Replaces ends within an interval by the values of an antiderivative, minus that at the beginning of the interval.
struct Integrals<'a> {
    series: &'a [f64],
    middle: f64,
    half: f64,
    integrals: &'a mut [f64],
}

impl WithSimd for Integrals<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { series, middle, half, integrals } = self;
        let start: f64 = series.iter().enumerate().map(|(k, c)| if k % 2 == 0 { -c } else { *c }).sum();
        replace(
            simd,
            integrals,
            #[inline(always)]
            |end| {
                let y = (end + (-middle)) * half.recip();
                let (twice, mut next, mut present) = (y + y, y.constant(0.0), y.constant(0.0));
                // Clenshaw's recurrence.
                for c in series.iter().rev() {
                    let value = twice.mul_add(present, y.constant(*c) - next);
                    (next, present) = (present, value);
                }
                y.mul_add(present, -next) + (-start)
            },
        );
    }
}
