//! The variational equations over a step at Gauss's nodes, solved by sweeps, a register of columns at a time.
//!
//! The unknowns are the rates of p at the nodes. A sweep computes p from these rates, q from p, and new rates
//! from q and p. All data of a register of columns stay in the cache meanwhile.

use super::products::{DEPTH, product};
use crate::math::Mat3;
use pulp::{Scalar, Simd, WithSimd};
use std::ops::Range;

/// The number of columns that are solved together.
pub(super) const TOGETHER: usize = 8;

/// The largest number of sweeps; a step that takes more should rather be divided.
const MOST_SWEEPS: usize = 30;

/// The number of sweeps after which the change must halve from one to the next.
const FIRST_SWEEPS: usize = 4;

/// The change relative to a column's size below which a further sweep would change no digit.
const ROUNDING: f64 = f64::EPSILON;

/// The change that rounding may keep sweeps from removing.
const NOISE: f64 = 256.0 * f64::EPSILON;

/// The collocation equations of a step at its nodes, one node after the other.
pub(super) struct CollocationStep<'a, const N: usize> {
    /// The number of rows in either half, and the number of columns.
    pub size: [usize; 2],
    /// The number of columns that belong to the initial state; those of the parameters follow.
    pub initial: usize,
    /// Coefficients and weights of the collocation method, times the size of the step.
    pub integrals: [[f64; N]; N],
    pub weights: [f64; N],
    /// The matrices A and B, with half of the rows of the system for each node, and the length of their rows.
    pub by_pose: &'a [f64],
    pub by_rate: &'a [f64],
    pub stride: usize,
    /// The derivatives of the rates with respect to the parameters; empty without parameters.
    pub forcing: &'a [f64],
    /// The index of the row of the first body's theta.
    pub rotation_row: usize,
    /// The attitudes at the nodes, body by body, and at the step's ends.
    pub attitudes: &'a [Mat3],
    pub ends: [&'a [Mat3]; 2],
    /// The factors of the two spins in each of Euler's equations.
    pub euler: &'a [[f64; 2]],
    /// The inverse natural size of every row, and of the rates of p times the size of the step.
    pub inverse: &'a [f64],
    pub inverse_rates: &'a [f64],
    /// The tangent vectors at the start.
    pub columns: &'a [f64],
    /// The rates of p at the nodes of the previous step, and the factors that extrapolate them.
    pub previous_rates: &'a [f64],
    pub factors: Option<[[f64; N]; N]>,
}

/// The solution of a range of columns.
pub(super) struct Sweeps<'a, const N: usize> {
    pub step: &'a CollocationStep<'a, N>,
    pub range: Range<usize>,
    /// The tangent vectors at the end.
    pub out: &'a mut [f64],
    /// The rates of p at the nodes.
    pub p_rates: &'a mut [f64],
    pub work: &'a mut [f64],
    /// The rates of q and p at the nodes, one node after the other as rows of columns, with rotation vectors
    /// in inertial axes; empty where only the end is needed.
    pub rates: &'a mut [f64],
}

impl<const N: usize> WithSimd for Sweeps<'_, N> {
    /// Whether the sweeps converged.
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        if self.step.size[1] < S::F64_LANES { self.solve_columns(Scalar) } else { self.solve_columns(simd) }
    }
}

impl<const N: usize> Sweeps<'_, N> {
    #[inline(always)]
    fn solve_columns<S: Simd>(mut self, simd: S) -> bool {
        for first in self.range.clone().step_by(S::F64_LANES) {
            if !self.solve(simd, first) {
                return false;
            }
        }
        true
    }

    #[inline(always)]
    fn solve<S: Simd>(&mut self, simd: S, first: usize) -> bool {
        let step = self.step;
        let ([half, width], lanes) = (step.size, S::F64_LANES);
        let length = half * N * lanes;
        // The last lanes overlap those before them.
        let at = first.min(width - lanes);
        let offset = first * half * N;
        let p_rates = nodes::<S, N>(&mut self.p_rates[offset..offset + length]);
        let (q, remainder) = self.work.split_at_mut(length);
        let (p, remainder) = remainder.split_at_mut(length);
        let (q, p) = (nodes::<S, N>(q), nodes::<S, N>(p));
        let (start, last) = S::as_mut_simd_f64s(&mut remainder[..3 * half * lanes]).0.split_at_mut(2 * half);

        let scale = step.begin(simd, at, start);
        match &step.factors {
            Some(factors) => {
                let previous =
                    S::as_simd_f64s(&step.previous_rates[offset..offset + length]).0.as_chunks::<N>().0;
                for row in 0..half {
                    p_rates[row] = integrals_at_nodes(simd, simd.splat_f64s(0.0), &previous[row], factors);
                }
            }
            None => p_rates.fill([simd.splat_f64s(0.0); N]),
        }
        step.momenta_at_nodes(simd, start, p_rates, p);
        let mut previous_share = f64::NAN;
        for sweep in 1.. {
            step.coordinates_at_nodes(simd, start, p, q);
            for row in 0..half {
                last[row] = p_rates[row][N - 1];
            }
            for i in 0..N {
                step.rates(simd, (i, at), q, p, p_rates);
            }
            step.momenta_at_nodes(simd, start, p_rates, p);
            let share = step.change(simd, scale, p_rates, last);
            // After the first sweep the ratio is not a number.
            let ratio = share / previous_share;
            // This is the sum of all further changes if each decreases by the same factor.
            if share <= ROUNDING || ratio < 0.5 && share * ratio <= (1.0 - ratio) * ROUNDING {
                break;
            }
            if sweep >= FIRST_SWEEPS && (ratio >= 0.5 || ratio.is_nan()) {
                if share <= NOISE {
                    break;
                }
                return false;
            }
            if sweep == MOST_SWEEPS {
                return false;
            }
            previous_share = share;
        }
        step.end(simd, at, start, [p, p_rates], self.out);
        if !self.rates.is_empty() {
            step.store_rates(simd, at, [p, p_rates], self.rates);
        }
        true
    }
}

impl<const N: usize> CollocationStep<'_, N> {
    fn bodies(&self) -> usize {
        self.ends[0].len()
    }

    /// Loads the tangent vectors at the start, with rotation vectors in inertial axes, and their sizes.
    #[inline(always)]
    fn begin<S: Simd>(&self, simd: S, at: usize, start: &mut [S::f64s]) -> S::f64s {
        let mut scale = simd.splat_f64s(f64::MIN_POSITIVE);
        for row in 0..start.len() {
            start[row] = load::<S>(self.columns, row * self.size[1] + at);
            scale = simd.mul_add_e_f64s(size(simd, start[row]), simd.splat_f64s(self.inverse[row]), scale);
        }
        for body in 0..self.bodies() {
            let row = self.rotation_row + 3 * body;
            let theta = rotate(simd, &self.ends[0][body], [start[row], start[row + 1], start[row + 2]]);
            start[row..row + 3].copy_from_slice(&theta);
        }
        scale
    }

    /// Computes p at the nodes.
    #[inline(always)]
    fn momenta_at_nodes<S: Simd>(
        &self,
        simd: S,
        start: &[S::f64s],
        p_rates: &[[S::f64s; N]],
        p: &mut [[S::f64s; N]],
    ) {
        let half = self.size[0];
        for row in 0..half {
            p[row] = integrals_at_nodes(simd, start[half + row], &p_rates[row], &self.integrals);
        }
    }

    /// Computes q at the nodes.
    #[inline(always)]
    fn coordinates_at_nodes<S: Simd>(
        &self,
        simd: S,
        start: &[S::f64s],
        p: &[[S::f64s; N]],
        q: &mut [[S::f64s; N]],
    ) {
        let spinning = self.rotation_row..self.rotation_row + 3 * self.bodies();
        for row in 0..self.size[0] {
            if !spinning.contains(&row) {
                q[row] = integrals_at_nodes(simd, start[row], &p[row], &self.integrals);
            }
        }
        for body in 0..self.bodies() {
            let (row, rates) = (self.rotation_row + 3 * body, self.rotation_rates(simd, body, p));
            for c in 0..3 {
                q[row + c] = integrals_at_nodes(simd, start[row + c], &rates[c], &self.integrals);
            }
        }
    }

    /// Computes the rates of p at a node.
    #[inline(always)]
    fn rates<S: Simd>(
        &self,
        simd: S,
        (i, at): (usize, usize),
        q: &[[S::f64s; N]],
        p: &[[S::f64s; N]],
        p_rates: &mut [[S::f64s; N]],
    ) {
        let [half, width] = self.size;
        let forced = at + S::F64_LANES > self.initial && !self.forcing.is_empty();
        for row in 0..half {
            p_rates[row][i] = if forced {
                load::<S>(self.forcing, (i * half + row) * width + at)
            } else {
                simd.splat_f64s(0.0)
            };
        }
        for (matrix, from) in [(self.by_pose, q), (self.by_rate, p)] {
            if matrix.is_empty() {
                continue;
            }
            let blocks = self.stride / DEPTH;
            let matrix = &matrix.as_chunks::<DEPTH>().0[i * half * blocks..][..half * blocks];
            for block in 0..blocks {
                let mut rows = [simd.splat_f64s(0.0); DEPTH];
                for k in 0..DEPTH.min(half - DEPTH * block) {
                    rows[k] = from[DEPTH * block + k][i];
                }
                for row in 0..half {
                    p_rates[row][i] = product(simd, &matrix[row * blocks + block], &rows, p_rates[row][i]);
                }
            }
        }
        for body in 0..self.bodies() {
            let row = self.rotation_row + 3 * body;
            for c in 0..3 {
                let [a, b] = self.euler[3 * (i * self.bodies() + body) + c];
                let (j, k) = (row + (c + 1) % 3, row + (c + 2) % 3);
                let sum = simd.mul_add_e_f64s(simd.splat_f64s(a), p[j][i], p_rates[row + c][i]);
                p_rates[row + c][i] = simd.mul_add_e_f64s(simd.splat_f64s(b), p[k][i], sum);
            }
        }
    }

    /// Returns the change by a sweep as a share of the columns' sizes: at the last node, since it grows with
    /// the time within the step.
    #[inline(always)]
    fn change<S: Simd>(
        &self,
        simd: S,
        mut scale: S::f64s,
        p_rates: &[[S::f64s; N]],
        last: &[S::f64s],
    ) -> f64 {
        let mut change = simd.splat_f64s(0.0);
        for row in 0..last.len() {
            let (inverse, now) = (simd.splat_f64s(self.inverse_rates[row]), p_rates[row][N - 1]);
            let difference = size(simd, simd.sub_f64s(now, last[row]));
            change = simd.mul_add_e_f64s(difference, inverse, change);
            scale = simd.mul_add_e_f64s(size(simd, now), inverse, scale);
        }
        largest::<S>(simd.div_f64s(change, scale))
    }

    /// Writes the tangent vectors at the end.
    #[inline(always)]
    fn end<S: Simd>(
        &self,
        simd: S,
        at: usize,
        start: &[S::f64s],
        [p, p_rates]: [&[[S::f64s; N]]; 2],
        out: &mut [f64],
    ) {
        let ([half, width], weights) = (self.size, &self.weights);
        let spinning = self.rotation_row..self.rotation_row + 3 * self.bodies();
        for row in 0..half {
            if !spinning.contains(&row) {
                store::<S>(out, row * width + at, weighted_end(simd, start[row], &p[row], weights));
            }
            store::<S>(
                out,
                (half + row) * width + at,
                weighted_end(simd, start[half + row], &p_rates[row], weights),
            );
        }
        for body in 0..self.bodies() {
            let (row, rates) = (self.rotation_row + 3 * body, self.rotation_rates(simd, body, p));
            let mut theta = [start[row]; 3];
            for c in 0..3 {
                theta[c] = weighted_end(simd, start[row + c], &rates[c], weights);
            }
            let theta = rotate(simd, &self.ends[1][body].transpose(), theta);
            for c in 0..3 {
                store::<S>(out, (row + c) * width + at, theta[c]);
            }
        }
    }

    /// Writes the rates of q and p at the nodes.
    #[inline(always)]
    fn store_rates<S: Simd>(&self, simd: S, at: usize, [p, p_rates]: [&[[S::f64s; N]]; 2], out: &mut [f64]) {
        let [half, width] = self.size;
        for row in 0..half {
            for i in 0..N {
                let first = (2 * half * i + row) * width + at;
                store::<S>(out, first, p[row][i]);
                store::<S>(out, first + half * width, p_rates[row][i]);
            }
        }
        for body in 0..self.bodies() {
            let (row, rates) = (self.rotation_row + 3 * body, self.rotation_rates(simd, body, p));
            for c in 0..3 {
                for i in 0..N {
                    store::<S>(out, (2 * half * i + row + c) * width + at, rates[c][i]);
                }
            }
        }
    }

    /// Returns the rates of a body's rotation vector in inertial axes at the nodes, which are the changes of
    /// the spin there.
    #[inline(always)]
    fn rotation_rates<S: Simd>(&self, simd: S, body: usize, p: &[[S::f64s; N]]) -> [[S::f64s; N]; 3] {
        let (row, attitudes) = (self.rotation_row + 3 * body, &self.attitudes[N * body..][..N]);
        let mut rates = [[simd.splat_f64s(0.0); N]; 3];
        for i in 0..N {
            let rate = rotate(simd, &attitudes[i], [p[row][i], p[row + 1][i], p[row + 2][i]]);
            for c in 0..3 {
                rates[c][i] = rate[c];
            }
        }
        rates
    }
}

/// Returns a start plus the sums of rates at the nodes.
#[inline(always)]
fn integrals_at_nodes<S: Simd, const N: usize>(
    simd: S,
    start: S::f64s,
    rates: &[S::f64s; N],
    integrals: &[[f64; N]; N],
) -> [S::f64s; N] {
    let mut out = [start; N];
    for j in 0..N {
        for i in 0..N {
            out[i] = simd.mul_add_e_f64s(simd.splat_f64s(integrals[i][j]), rates[j], out[i]);
        }
    }
    out
}

/// Returns a start plus the weighted sum of rates at the nodes.
#[inline(always)]
fn weighted_end<S: Simd, const N: usize>(
    simd: S,
    start: S::f64s,
    rates: &[S::f64s; N],
    weights: &[f64; N],
) -> S::f64s {
    let mut sum = simd.splat_f64s(0.0);
    for i in 0..N {
        sum = simd.mul_add_e_f64s(simd.splat_f64s(weights[i]), rates[i], sum);
    }
    simd.add_f64s(start, sum)
}

/// Returns |x|.
#[inline(always)]
fn size<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    simd.max_f64s(x, simd.sub_f64s(simd.splat_f64s(0.0), x))
}

/// Returns the largest lane, or NaN where a lane is NaN.
#[inline(always)]
fn largest<S: Simd>(lanes: S::f64s) -> f64 {
    let mut values = [0.0; 8];
    store::<S>(&mut values, 0, lanes);
    let mut largest = 0.0;
    for value in values {
        largest = if value > largest || value.is_nan() { value } else { largest };
    }
    largest
}

#[inline(always)]
fn load<S: Simd>(values: &[f64], at: usize) -> S::f64s {
    S::as_simd_f64s(&values[at..][..S::F64_LANES]).0[0]
}

#[inline(always)]
fn store<S: Simd>(values: &mut [f64], at: usize, lanes: S::f64s) {
    S::as_mut_simd_f64s(&mut values[at..][..S::F64_LANES]).0[0] = lanes;
}

/// Returns rows of numbers at the nodes.
#[inline(always)]
fn nodes<S: Simd, const N: usize>(values: &mut [f64]) -> &mut [[S::f64s; N]] {
    S::as_mut_simd_f64s(values).0.as_chunks_mut::<N>().0
}

#[inline(always)]
fn rotate<S: Simd>(simd: S, m: &Mat3, v: [S::f64s; 3]) -> [S::f64s; 3] {
    let mut out = [simd.splat_f64s(0.0); 3];
    for j in 0..3 {
        for c in 0..3 {
            out[c] = simd.mul_add_e_f64s(simd.splat_f64s(m[(c, j)]), v[j], out[c]);
        }
    }
    out
}
