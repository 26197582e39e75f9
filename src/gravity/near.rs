//! The field at any distance, down to the surface: Newton's iteration for kappa and Carlson's duplication.
//!
//! kappa solves h(kappa) = 1/s(kappa) - 1 = 0 with s = sum x_i^2/(a_i^2 + kappa). 1/s is r^-2 times a
//! weighted harmonic mean of the (a_i^2 + kappa), hence increasing and concave in kappa. A harmonic mean
//! never exceeds the arithmetic one, so that kappa_0 = max(0, r^2 - sum a_i^2 x_i^2/r^2) lies at or below the
//! root of an outer point. Newton's iterates rise monotonically from there to the root, which needs neither a
//! bracket nor a safeguard.

use super::{FieldKernel, PointField};
use crate::math::carlson::{duplications_needed, rd_triple};
use crate::math::dual::Dual;
use crate::math::lanes::{Lanes, dot};
use crate::shape::Ellipsoid;
use pulp::Simd;

/// The largest number of Newton steps; the slowest points seen take 9.
const MAX_NEWTON: usize = 40;

/// The field of one ellipsoid by Carlson's integrals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near {
    squares: [f64; 3],
    duplications: u32,
}

impl Near {
    /// Returns the kernel that is exact wherever kappa >= `kappa_min` >= 0.
    pub fn new(ellipsoid: &Ellipsoid, kappa_min: f64) -> Self {
        let squares = ellipsoid.sorted().map(|a| a * a);
        Self { squares, duplications: duplications_needed(squares.map(|s| s + kappa_min.max(0.0))) }
    }

    /// Returns whether the shortest semi-axis is below a thirtieth of the longest.
    pub fn is_flat(&self) -> bool {
        900.0 * self.squares[2] < self.squares[0]
    }

    /// Returns Phi, the field, and a mask that is 1 outside and 0 inside. Inside, kappa is zero, and Phi and
    /// R_i have the same formulas. The result in a lane does not depend on the other lanes.
    #[inline(always)]
    pub fn anywhere<S: Simd, const N: usize>(
        &self,
        x: [Lanes<S, N>; 3],
    ) -> (Lanes<S, N>, PointField<S, N>, Lanes<S, N>) {
        let c = |value| x[0].constant(value);
        let x2 = [x[0] * x[0], x[1] * x[1], x[2] * x[2]];
        let [a2, b2, c2] = self.squares;
        let normalised_square = x2[0].mul_add(c(1.0 / a2), x2[1].mul_add(c(1.0 / b2), x2[2] * c(1.0 / c2)));
        // Points that are meant to lie on the surface may round to just inside it.
        let surface = c(1.0 - 1e-12);
        let outside = normalised_square.if_less(surface, c(0.0), c(1.0));
        // A point inside is replaced by the end of the longest axis, where the iteration has converged.
        let outer = |inner: f64, x2: Lanes<S, N>| normalised_square.if_less(surface, c(inner), x2);
        let kappa =
            root::<S, N, true>([outer(a2, x2[0]), outer(0.0, x2[1]), outer(0.0, x2[2])], self.squares);
        let (phi, field) = self.field_at_kappa(x2, kappa);
        (phi, field, outside)
    }

    /// Returns Phi and the field from the squares of a point's coordinates.
    #[inline(always)]
    fn phi<S: Simd, const N: usize>(&self, x2: [Lanes<S, N>; 3]) -> (Lanes<S, N>, PointField<S, N>) {
        self.field_at_kappa(x2, kappa(x2, self.squares))
    }

    #[inline(always)]
    fn field_at_kappa<S: Simd, const N: usize>(
        &self,
        x2: [Lanes<S, N>; 3],
        kappa: Lanes<S, N>,
    ) -> (Lanes<S, N>, PointField<S, N>) {
        let [a2, b2, c2] = self.squares;
        let s = [kappa + kappa.constant(a2), kappa + kappa.constant(b2), kappa + kappa.constant(c2)];
        let rd = rd_triple(s, self.duplications);
        let twice = (s[0] - x2[0]).mul_add(rd[0], (s[1] - x2[1]).mul_add(rd[1], (s[2] - x2[2]) * rd[2]));
        let rd_difference = [rd[2] - rd[1], rd[0] - rd[2], rd[1] - rd[0]];
        (twice * twice.constant(0.5), PointField { rd, rd_difference, squares: s })
    }
}

/// Returns the largest root of sum x_i^2/(a_i^2 + kappa) = 1 that is not below zero; `x2` and `a2` are
/// squares.
#[inline(always)]
pub fn kappa<S: Simd, const N: usize>(x2: [Lanes<S, N>; 3], a2: [f64; 3]) -> Lanes<S, N> {
    root::<S, N, false>(x2, a2)
}

/// Solves for kappa. With `KEEP_CONVERGED` a lane that has converged does not change while the others iterate.
#[inline(always)]
fn root<S: Simd, const N: usize, const KEEP_CONVERGED: bool>(
    x2: [Lanes<S, N>; 3],
    a2: [f64; 3],
) -> Lanes<S, N> {
    let c = |value| x2[0].constant(value);
    let squares = [c(a2[0]), c(a2[1]), c(a2[2])];
    let r2 = x2[0] + x2[1] + x2[2];
    let mut kappa = (r2 - dot(x2, squares) / r2).max(c(0.0));
    let mut error = c(1.0);
    for _ in 0..MAX_NEWTON {
        // One division serves three reciprocals.
        let s = [kappa + squares[0], kappa + squares[1], kappa + squares[2]];
        let product = s[0] * s[1];
        let shared = c(1.0) / (product * s[2]);
        let last = shared * s[2];
        let inverse = [last * s[1], last * s[0], shared * product];
        let term = [x2[0] * inverse[0], x2[1] * inverse[1], x2[2] * inverse[2]];
        let s = term[0] + term[1] + term[2];
        let slope = dot(term, inverse);
        // Newton's step on 1/s is (1 - 1/s) / (1/s)' = s (s - 1) / slope.
        let mut step = s * (s - c(1.0)) / slope;
        if KEEP_CONVERGED {
            step = c(0.0).if_less(error, step, c(0.0));
        }
        kappa = (kappa + step).max(c(0.0));
        // After the last correction the error is its square.
        error = step.abs() - c(1e-9) * (kappa + c(a2[2]));
        if error.reduce_max() <= 0.0 {
            break;
        }
    }
    kappa
}

impl FieldKernel for Near {
    #[inline(always)]
    fn field<S: Simd, const N: usize>(&self, x: [Lanes<S, N>; 3]) -> PointField<S, N> {
        self.phi([x[0] * x[0], x[1] * x[1], x[2] * x[2]]).1
    }

    /// Returns the integrals as derivatives of R_D with respect to its arguments: R_12 = -2 dR_1/ds_2.
    #[inline(always)]
    fn second_integrals<S: Simd, const N: usize>(
        &self,
        x: [Lanes<S, N>; 3],
    ) -> (PointField<S, N>, [Lanes<S, N>; 3]) {
        let field = self.field(x);
        // The truncation error falls more slowly for derivatives, so that one more duplication is needed.
        let [first, second, _] = rd_triple(Dual::variables(field.squares), self.duplications + 1);
        let minus_two = x[0].constant(-2.0);
        (
            field,
            [minus_two * second.gradient[2], minus_two * first.gradient[2], minus_two * first.gradient[1]],
        )
    }

    fn square_differences(&self) -> [f64; 3] {
        let [a2, b2, c2] = self.squares;
        [c2 - b2, a2 - c2, b2 - a2]
    }

    #[inline(always)]
    fn potential_perturbation<S: Simd, const N: usize>(
        &self,
        x: [Lanes<S, N>; 3],
    ) -> (Lanes<S, N>, PointField<S, N>) {
        let x2 = [x[0] * x[0], x[1] * x[1], x[2] * x[2]];
        let (phi, field) = self.phi(x2);
        let r2 = x2[0] + x2[1] + x2[2];
        (phi - r2.constant(1.0) / r2.sqrt(), field)
    }

    /// Returns the potential without splitting off 1/r, which over the middle of a flat body is many times
    /// Phi and would cost that many digits.
    #[inline(always)]
    fn potential<S: Simd, const N: usize>(&self, x: [Lanes<S, N>; 3]) -> Lanes<S, N> {
        if self.is_flat() {
            self.phi([x[0] * x[0], x[1] * x[1], x[2] * x[2]]).0
        } else {
            x[0].constant(1.0) / dot(x, x).sqrt() + self.potential_perturbation(x).0
        }
    }
}
