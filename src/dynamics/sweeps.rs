//! The equations of departures over a step at Gauss's nodes, solved by sweeps, a register of columns at a time.
//!
//! The unknowns are the rates of p at the nodes. A sweep takes p from them, q from p, and them anew from q and p. Everything that a
//! register of columns needs stays in the fastest memory meanwhile.

use super::products::{DEPTH, product};
use crate::math::Mat3;
use pulp::{Scalar, Simd, WithSimd};
use std::ops::Range;

/// Columns that are solved in one go.
pub(super) const TOGETHER: usize = 8;

/// The most sweeps; with fewer no shorter step would be quicker.
const MOST: usize = 30;

/// Sweeps that may pass before the change must have halved from one to the next.
const FIRST: usize = 4;

/// What is left when a sweep is expected to change no digit, in shares of a column's size.
const ROUNDING: f64 = f64::EPSILON;

/// What sweeps may be unable to remove, by rounding.
const NOISE: f64 = 256.0 * f64::EPSILON;

/// The step's equations at the nodes, one after the other, and its columns.
pub(super) struct Sweeps<'a, const N: usize> {
    /// Half the rows, and columns.
    pub size: [usize; 2],
    /// The columns to be solved.
    pub range: Range<usize>,
    /// Coefficients and weights of the collocation method, times the size of the step.
    pub integrals: [[f64; N]; N],
    pub weights: [f64; N],
    /// A and B, each with half its rows for a node, and the length of their rows.
    pub by_place: &'a [f64],
    pub by_motion: &'a [f64],
    pub stride: usize,
    /// The derivatives by the parameters, or nothing.
    pub forcing: &'a [f64],
    /// The row of the first body's theta.
    pub turn: usize,
    /// The attitudes at the nodes, body after body, and at the step's ends.
    pub attitudes: &'a [Mat3],
    pub ends: [&'a [Mat3]; 2],
    /// The factors of the two spins in every number of Euler's equations.
    pub euler: &'a [[f64; 2]],
    /// One over the natural size of every row; of the second half it is times the step's.
    pub inverse: &'a [f64],
    pub inverse_rates: &'a [f64],
    /// The columns at the start and the end.
    pub columns: &'a [f64],
    pub out: &'a mut [f64],
    /// The rates of p at the nodes of the step before, and the factors that carry them on.
    pub before: &'a [f64],
    pub factors: Option<[[f64; N]; N]>,
    pub pushes: &'a mut [f64],
    pub work: &'a mut [f64],
}

impl<const N: usize> WithSimd for Sweeps<'_, N> {
    /// Whether the sweeps came to an end.
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        if self.size[1] < S::F64_LANES { self.by(Scalar) } else { self.by(simd) }
    }
}

/// A start plus the sums of rates at the nodes.
#[inline(always)]
fn along<S: Simd, const N: usize>(
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

/// Rows of numbers at the nodes.
#[inline(always)]
fn nodes<S: Simd, const N: usize>(values: &mut [f64]) -> &mut [[S::f64s; N]] {
    S::as_mut_simd_f64s(values).0.as_chunks_mut::<N>().0
}

#[inline(always)]
fn turned<S: Simd>(simd: S, m: &Mat3, v: [S::f64s; 3]) -> [S::f64s; 3] {
    [0, 1, 2].map(|c| {
        let sum = simd.mul_f64s(simd.splat_f64s(m[(c, 0)]), v[0]);
        let sum = simd.mul_add_e_f64s(simd.splat_f64s(m[(c, 1)]), v[1], sum);
        simd.mul_add_e_f64s(simd.splat_f64s(m[(c, 2)]), v[2], sum)
    })
}

impl<const N: usize> Sweeps<'_, N> {
    #[inline(always)]
    fn by<S: Simd>(mut self, simd: S) -> bool {
        self.range.clone().step_by(S::F64_LANES).all(|first| self.solve(simd, first))
    }

    #[inline(always)]
    fn solve<S: Simd>(&mut self, simd: S, first: usize) -> bool {
        let Self { size: [half, width], integrals, weights, turn, .. } = *self;
        let (lanes, length) = (S::F64_LANES, half * N * S::F64_LANES);
        // The last lanes overlap those before.
        let at = first.min(width - lanes);
        let place = first * half * N;
        let pushes = nodes::<S, N>(&mut self.pushes[place..place + length]);
        let (q, rest) = self.work.split_at_mut(length);
        let (p, rest) = rest.split_at_mut(length);
        let (q, p) = (nodes::<S, N>(q), nodes::<S, N>(p));
        let (start, last) = S::as_mut_simd_f64s(&mut rest[..3 * half * lanes]).0.split_at_mut(2 * half);
        let bodies = self.ends[0].len();
        let turns = |body: usize| turn + 3 * body..turn + 3 * body + 3;
        let spinning = turn..turn + 3 * bodies;

        // The start, with the rotations in inertial axes.
        let load = |values: &[f64], row: usize| S::as_simd_f64s(&values[row * width + at..][..lanes]).0[0];
        (0..2 * half).for_each(|row| start[row] = load(self.columns, row));
        for (body, attitude) in self.ends[0].iter().enumerate() {
            let theta = &mut start[turns(body)];
            theta.copy_from_slice(&turned(simd, attitude, [theta[0], theta[1], theta[2]]));
        }
        let mut scale = simd.splat_f64s(f64::MIN_POSITIVE);
        for (value, inverse) in start.iter().zip(self.inverse) {
            scale = simd.mul_add_e_f64s(simd.abs_f64s(*value), simd.splat_f64s(*inverse), scale);
        }
        match &self.factors {
            Some(factors) => {
                let before = S::as_simd_f64s(&self.before[place..place + length]).0.as_chunks::<N>().0;
                for (push, before) in pushes.iter_mut().zip(before) {
                    *push = along(simd, simd.splat_f64s(0.0), before, factors);
                }
            }
            None => pushes.fill([simd.splat_f64s(0.0); N]),
        }
        for row in 0..half {
            p[row] = along(simd, start[half + row], &pushes[row], &integrals);
        }

        let mut share_before = f64::NAN;
        for sweep in 1.. {
            for row in (0..half).filter(|row| !spinning.contains(row)) {
                q[row] = along(simd, start[row], &p[row], &integrals);
            }
            for body in 0..bodies {
                let rates = turning(simd, &self.attitudes[N * body..][..N], turn + 3 * body, p);
                for (row, rates) in turns(body).zip(&rates) {
                    q[row] = along(simd, start[row], rates, &integrals);
                }
            }
            for row in 0..half {
                last[row] = pushes[row][N - 1];
            }
            for i in 0..N {
                for row in 0..half {
                    pushes[row][i] = if self.forcing.is_empty() {
                        simd.splat_f64s(0.0)
                    } else {
                        load(self.forcing, i * half + row)
                    };
                }
                for (matrix, from) in [(self.by_place, &*q), (self.by_motion, &*p)] {
                    let matrix = matrix.chunks_exact(half * self.stride).nth(i).unwrap_or(&[]);
                    for block in (0..half).step_by(DEPTH) {
                        let mut rows = [simd.splat_f64s(0.0); DEPTH];
                        for (k, from) in from[block..].iter().take(DEPTH).enumerate() {
                            rows[k] = from[i];
                        }
                        for (push, line) in pushes.iter_mut().zip(matrix.chunks_exact(self.stride)) {
                            let weights = &line.as_chunks::<DEPTH>().0[block / DEPTH];
                            push[i] = product(simd, weights, &rows, push[i]);
                        }
                    }
                }
                for body in 0..bodies {
                    let row = turn + 3 * body;
                    for (c, [a, b]) in self.euler[3 * (i * bodies + body)..][..3].iter().enumerate() {
                        let (j, k) = (row + (c + 1) % 3, row + (c + 2) % 3);
                        let sum = simd.mul_add_e_f64s(simd.splat_f64s(*a), p[j][i], pushes[row + c][i]);
                        pushes[row + c][i] = simd.mul_add_e_f64s(simd.splat_f64s(*b), p[k][i], sum);
                    }
                }
            }
            for row in 0..half {
                p[row] = along(simd, start[half + row], &pushes[row], &integrals);
            }
            // The change is measured at the last node, since it grows with the time within the step.
            let mut change = simd.splat_f64s(0.0);
            let mut scale = scale;
            for (row, inverse) in self.inverse_rates.iter().enumerate() {
                let (inverse, now) = (simd.splat_f64s(*inverse), pushes[row][N - 1]);
                let by = simd.abs_f64s(simd.sub_f64s(now, last[row]));
                change = simd.mul_add_e_f64s(by, inverse, change);
                scale = simd.mul_add_e_f64s(simd.abs_f64s(now), inverse, scale);
            }
            let share = simd.reduce_sum_f64s(simd.div_f64s(change, scale));
            // Of the first sweep it is not a number.
            let ratio = share / share_before;
            // What further sweeps would change, if each changes as much less as this one.
            if share <= ROUNDING || ratio < 0.5 && share * ratio <= (1.0 - ratio) * ROUNDING {
                break;
            }
            if sweep >= FIRST && !(ratio < 0.5) {
                if share <= NOISE {
                    break;
                }
                return false;
            }
            if sweep == MOST {
                return false;
            }
            share_before = share;
        }

        let mut end = |row: usize, value: S::f64s| {
            S::as_mut_simd_f64s(&mut self.out[row * width + at..][..lanes]).0[0] = value;
        };
        let step = |start: S::f64s, rates: &[S::f64s; N]| {
            let sum = (0..N).fold(simd.splat_f64s(0.0), |sum, i| {
                simd.mul_add_e_f64s(simd.splat_f64s(weights[i]), rates[i], sum)
            });
            simd.add_f64s(start, sum)
        };
        for row in 0..half {
            if !spinning.contains(&row) {
                end(row, step(start[row], &p[row]));
            }
            end(half + row, step(start[half + row], &pushes[row]));
        }
        for (body, attitude) in self.ends[1].iter().enumerate() {
            let row = turn + 3 * body;
            let rates = turning(simd, &self.attitudes[N * body..][..N], row, p);
            let theta = [0, 1, 2].map(|c| step(start[row + c], &rates[c]));
            let theta = turned(simd, &attitude.transpose(), theta);
            (0..3).for_each(|c| end(row + c, theta[c]));
        }
        true
    }
}

/// The rates of a body's rotation vector in inertial axes, at the nodes: the spin's departure there.
#[inline(always)]
fn turning<S: Simd, const N: usize>(
    simd: S,
    attitudes: &[Mat3],
    row: usize,
    p: &[[S::f64s; N]],
) -> [[S::f64s; N]; 3] {
    let mut rates = [[simd.splat_f64s(0.0); N]; 3];
    for (i, attitude) in attitudes.iter().enumerate() {
        let turned = turned(simd, attitude, [p[row][i], p[row + 1][i], p[row + 2][i]]);
        (0..3).for_each(|c| rates[c][i] = turned[c]);
    }
    rates
}
