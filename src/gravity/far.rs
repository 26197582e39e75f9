//! The field away from the body: a power series in u = 1/(kappa + mean a^2).
//!
//! With m the mean of the a_i^2, d_i = a_i^2 - m, and sbar = kappa + m, every integral of the field is
//! int_sbar^inf dT / (sqrt(T^3 + e2 T + e3) ...), since the sum of the d_i is zero; e2 and e3 are the
//! elementary symmetric functions of the d_i. Expanding in 1/T gives
//!
//!   R_i = u^(3/2) sum_n 3 k_n / (2n + 3) u^n,
//!                         k = coefficients of (1 + e2 z^2 + e3 z^3)^(-1/2) / (1 + d_i z),
//!   R_F = u^(1/2) sum_n h_n / (2n + 1) u^n,     h = coefficients of (1 + e2 z^2 + e3 z^3)^(-1/2),
//!
//! The coefficients depend on the body alone. The series of R_j - R_i has the last factor (d_i - d_j)/((1 +
//! d_i z)(1 + d_j z)) and is exact for nearly equal axes. The series converge for max |d_i| < sbar,
//! geometrically.
//!
//! sbar is a root of a cubic; with w = r^2/sbar it reads w = 1 + w^2 (p + q w), p = (e2 + sum d_i x_i^2)/r^4,
//! q = (e3 - sum d_j d_k x_i^2)/r^6, both small at a distance, where Newton's iteration from their series
//! converges at once.

use super::{FieldKernel, PointField};
use crate::math::lanes::{Lanes, dot, polynomials};
use crate::shape::Shape;
use pulp::Simd;

/// The largest number of terms of a series; beyond it [`super::Near`] is faster.
const MAX_TERMS: usize = 28;

/// The coefficients of one body's series.
#[derive(Debug, Clone, PartialEq)]
pub struct FarSeries {
    deviation: [f64; 3],
    /// The values of [`FieldKernel::square_differences`].
    differences: [f64; 3],
    e2: f64,
    e3: f64,
    mean: f64,
    /// Coefficients by powers of u, beyond the leading 1 of R_1, of (R_1 u^(-3/2) - 1) / u, (R_2 - R_1)
    /// u^(-5/2) and (R_3 - R_1) u^(-5/2).
    rd: [[f64; 3]; MAX_TERMS],
    /// Coefficients of R_ij u^(-5/2), in the order of [`FieldKernel::second_integrals`].
    second_integrals: [[f64; 3]; MAX_TERMS],
    /// Coefficients of (R_F u^(-1/2) - 1) / u^2.
    rf: [[f64; 1]; MAX_TERMS],
}

impl FarSeries {
    /// Computes the series of a shape; a point and a sphere have a series of one term.
    pub fn new(shape: &Shape) -> Self {
        let [a, b, c] = match shape {
            Shape::Ellipsoid(e) => e.sorted(),
            // Other shapes have no such series; nothing evaluates it.
            _ => [0.0; 3],
        };
        // Differences of squares are formed as products, exact for nearly equal axes.
        let (ab, bc, ca) = ((a - b) * (a + b), (b - c) * (b + c), (c - a) * (c + a));
        let d = [(ab - ca) / 3.0, (bc - ab) / 3.0, (ca - bc) / 3.0];
        let e2 = d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
        let e3 = d[0] * d[1] * d[2];

        let h = inverse_root_series(e2, e3);
        let geometric = |series: &[f64; MAX_TERMS], d: f64| {
            let mut out = *series;
            for n in 1..MAX_TERMS {
                out[n] -= d * out[n - 1];
            }
            out
        };
        let k1 = geometric(&h, d[0]);
        let (k12, k13) = (geometric(&k1, d[1]), geometric(&k1, d[2]));
        let k23 = geometric(&geometric(&h, d[1]), d[2]);
        let coefficient = |n: usize| 3.0 / (2 * n + 3) as f64;
        Self {
            deviation: d,
            differences: [-bc, -ca, -ab],
            e2,
            e3,
            mean: (a * a + b * b + c * c) / 3.0,
            rd: std::array::from_fn(|n| {
                let next = k1.get(n + 1).copied().unwrap_or(0.0);
                [next, ab * k12[n], -ca * k13[n]].map(|k| k * coefficient(n + 1))
            }),
            second_integrals: std::array::from_fn(|n| {
                [k23[n], k13[n], k12[n]].map(|k| k * coefficient(n + 1))
            }),
            rf: std::array::from_fn(|n| [h.get(n + 2).map_or(0.0, |h| h / (2 * n + 5) as f64)]),
        }
    }

    /// Returns how many terms of the series meet a relative tolerance wherever kappa >= `kappa_min`, or
    /// `None` where that takes too many.
    pub fn truncation_for(&self, kappa_min: f64, tolerance: f64) -> Option<FarTruncation> {
        let deviation = self.deviation.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        let ratio = deviation / (kappa_min.max(0.0) + self.mean);
        if deviation == 0.0 {
            return Some(FarTruncation::default());
        }
        // The coefficients of z^n are below (n + 1) max|d|^n; the factor 3/(2n + 3) compensates the n + 1.
        let terms = (tolerance.max(1e-17).ln() / ratio.ln()).ceil();
        // The starting value is accurate to 654 ratio^6, and a Newton step reduces an error e to 1.3 ratio
        // e^2.
        let newton = match ratio {
            r if r < 0.022 => 1,
            r if r < 0.08 => 2,
            r if r < 0.17 => 3,
            _ => 4,
        };
        (ratio < 0.25 && terms < MAX_TERMS as f64).then_some(FarTruncation { terms: terms as usize, newton })
    }

    /// Returns the kappa beyond which this many terms meet a relative tolerance; it may be below zero.
    pub fn kappa_from(&self, terms: u32, tolerance: f64) -> f64 {
        let deviation = self.deviation.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        // This is a little less than the ratio at which one more term is needed.
        deviation / (tolerance.powf(1.0 / f64::from(terms)) * (1.0 - 1e-9)) - self.mean
    }

    /// Returns the kernel with the terms of a truncation.
    #[inline]
    pub fn truncated(&self, truncation: FarTruncation) -> Far<'_> {
        Far { series: self, truncation }
    }
}

/// Returns the coefficients of (1 + e2 z^2 + e3 z^3)^(-1/2), by the recurrence from P h' = -P' h / 2.
fn inverse_root_series(e2: f64, e3: f64) -> [f64; MAX_TERMS] {
    let mut h = [0.0; MAX_TERMS];
    h[0] = 1.0;
    for n in 1..MAX_TERMS {
        let m = n as f64;
        let two = if n >= 2 { e2 * (m - 1.0) * h[n - 2] } else { 0.0 };
        let three = if n >= 3 { e3 * (m - 1.5) * h[n - 3] } else { 0.0 };
        h[n] = -(two + three) / m;
    }
    h
}

/// The numbers of terms and of Newton steps that a distance needs; the default is that of a point mass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FarTruncation {
    terms: usize,
    newton: u32,
}

/// A series with the truncation that says which of its terms are summed.
#[derive(Debug, Clone, Copy)]
pub struct Far<'a> {
    series: &'a FarSeries,
    truncation: FarTruncation,
}

impl Far<'_> {
    /// Returns w - 1 with w = r^2 / (kappa + mean a^2), and 1/r^2.
    #[inline(always)]
    fn root<S: Simd, const N: usize>(&self, squares: [Lanes<S, N>; 3]) -> (Lanes<S, N>, Lanes<S, N>) {
        let [xx, yy, zz] = squares;
        let c = |value| xx.constant(value);
        let inverse = c(1.0) / (xx + yy + zz);
        if self.truncation.newton == 0 {
            return (c(0.0), inverse);
        }
        let series = self.series;
        let [d1, d2, d3] = series.deviation;
        let p = xx.mul_add(c(d1), yy.mul_add(c(d2), zz.mul_add(c(d3), c(series.e2)))) * inverse * inverse;
        let q = xx.mul_add(c(-d2 * d3), yy.mul_add(c(-d3 * d1), zz.mul_add(c(-d1 * d2), c(series.e3))))
            * inverse
            * inverse
            * inverse;
        // The starting value is Lagrange's series of the root, to fifth order in p ~ sqrt(q).
        let pure = p.mul_add(p.mul_add(p.mul_add(p.mul_add(c(42.0), c(14.0)), c(5.0)), c(2.0)), c(1.0));
        let mixed = p.mul_add(p.mul_add(p.mul_add(c(84.0), c(21.0)), c(5.0)), c(1.0));
        let mut eta = p.mul_add(pure, q * q.mul_add(p.mul_add(c(28.0), c(3.0)), mixed));
        for _ in 0..self.truncation.newton {
            let w = eta + c(1.0);
            let slope = q.mul_add(w, p);
            let f = eta - w * w * slope;
            // The derivative of f is 1 - d.
            let d = w * (slope + slope + q * w);
            let correction = if self.truncation.newton == 1 {
                // The number d is so small that (1 + d) (1 + d^2) (1 + d^4) equals 1 / (1 - d) to round-off.
                let d2 = d * d;
                let d4 = d2 * d2;
                let partial = d.mul_add(d2, d) + d2;
                f * d4.mul_add(partial + c(1.0), partial + c(1.0))
            } else {
                f / (c(1.0) - d)
            };
            eta = eta - correction;
        }
        (eta, inverse)
    }

    /// Returns s_i = 1/u + d_i.
    #[inline(always)]
    fn squares<S: Simd, const N: usize>(&self, u: Lanes<S, N>) -> [Lanes<S, N>; 3] {
        let [d1, d2, d3] = self.series.deviation;
        let sbar = u.constant(1.0) / u;
        [sbar + u.constant(d1), sbar + u.constant(d2), sbar + u.constant(d3)]
    }

    /// Returns R_i - 1/r^3, the excess of the field over that of a point, and the differences of the R_i,
    /// accurate to their own last digits. With w = r^2 u the former is ((w^3 - 1) / (w^(3/2) + 1) + w^(3/2)
    /// (R_i/u^(3/2) - 1)) / r^3.
    #[inline(always)]
    pub fn field_perturbation<S: Simd, const N: usize>(&self, x: [Lanes<S, N>; 3]) -> PointField<S, N> {
        let (eta, inverse) = self.root([x[0] * x[0], x[1] * x[1], x[2] * x[2]]);
        let c = |value| eta.constant(value);
        let w = eta + c(1.0);
        let u = w * inverse;
        let [first, second, third] = polynomials(&self.series.rd[..self.truncation.terms], u);
        let cube = w * w.sqrt();
        let stretched = eta * eta.mul_add(eta + c(3.0), c(3.0)) / (cube + c(1.0));
        let unit = inverse * inverse.sqrt();
        let fifth = unit * (cube * u);
        let (second, third) = (fifth * second, fifth * third);
        let first = fifth.mul_add(first, unit * stretched);
        PointField {
            rd: [first, first + second, first + third],
            rd_difference: [third - second, -third, second],
            squares: self.squares(u),
        }
    }

    /// Returns Phi r - 1, 1/r and the field. With v = sqrt(w): Phi r - 1 = -(v-1)^2 (v+2)/2 + 3/2 v
    /// (R_F/u^(1/2) - 1) - v^3/2 sum x_i^2/r^2 (R_i/u^(3/2) - 1).
    #[inline(always)]
    fn perturbation_and_field<S: Simd, const N: usize>(
        &self,
        x: [Lanes<S, N>; 3],
    ) -> (Lanes<S, N>, Lanes<S, N>, PointField<S, N>) {
        let squares = [x[0] * x[0], x[1] * x[1], x[2] * x[2]];
        let (eta, inverse) = self.root(squares);
        let c = |value| eta.constant(value);
        let w = eta + c(1.0);
        let v = w.sqrt();
        let near = inverse.sqrt();
        let u = w * inverse;
        let [first, second, third] = polynomials(&self.series.rd[..self.truncation.terms], u);
        let [rf] = polynomials(&self.series.rf[..self.truncation.terms], u);
        let rf = u * u * rf;
        let beyond = [u * first, u * (first + second), u * (first + third)];
        let weighted = dot(squares, beyond) * inverse;
        // v - 1 = eta / (v + 1) has no cancellation.
        let v_minus_one = eta / (v + c(1.0));
        let perturbation =
            c(-0.5) * v_minus_one * v_minus_one * (v + c(2.0)) + c(1.5) * v * rf + c(-0.5) * v * w * weighted;
        let cube = u * v * near;
        let rd =
            [cube.mul_add(beyond[0], cube), cube.mul_add(beyond[1], cube), cube.mul_add(beyond[2], cube)];
        let (second, third) = (cube * u * second, cube * u * third);
        let rd_difference = [third - second, -third, second];
        (perturbation, near, PointField { rd, rd_difference, squares: self.squares(u) })
    }

    /// Returns Phi of a unit GM and the field.
    #[inline(always)]
    pub fn potential_and_field<S: Simd, const N: usize>(
        &self,
        x: [Lanes<S, N>; 3],
    ) -> (Lanes<S, N>, PointField<S, N>) {
        let (perturbation, near, field) = self.perturbation_and_field(x);
        (near.mul_add(perturbation, near), field)
    }
}

impl FieldKernel for Far<'_> {
    #[inline(always)]
    fn field<S: Simd, const N: usize>(&self, x: [Lanes<S, N>; 3]) -> PointField<S, N> {
        let (eta, inverse) = self.root([x[0] * x[0], x[1] * x[1], x[2] * x[2]]);
        let u = (eta + eta.constant(1.0)) * inverse;
        let cube = u * u.sqrt();
        let fifth = cube * u;
        let [first, second, third] = polynomials(&self.series.rd[..self.truncation.terms], u);
        let first = fifth.mul_add(first, cube);
        let (second, third) = (fifth * second, fifth * third);
        PointField {
            rd: [first, first + second, first + third],
            rd_difference: [third - second, -third, second],
            squares: self.squares(u),
        }
    }

    #[inline(always)]
    fn second_integrals<S: Simd, const N: usize>(
        &self,
        x: [Lanes<S, N>; 3],
    ) -> (PointField<S, N>, [Lanes<S, N>; 3]) {
        let (eta, inverse) = self.root([x[0] * x[0], x[1] * x[1], x[2] * x[2]]);
        let c = |value| eta.constant(value);
        let u = (eta + c(1.0)) * inverse;
        let cube = u * u.sqrt();
        let fifth = cube * u;
        // The truncation of the monopole has no terms, but the first term of these integrals is not zero.
        let terms = self.truncation.terms.max(1);
        let [r23, r31, r12] = polynomials(&self.series.second_integrals[..terms], u);
        let second = [fifth * r23, fifth * r31, fifth * r12];
        let [first, ..] = polynomials(&self.series.rd[..self.truncation.terms], u);
        let first = fifth.mul_add(first, cube);
        let [bc, ca, ab] = self.series.differences;
        let rd_difference = [c(-bc) * second[0], c(-ca) * second[1], c(-ab) * second[2]];
        let rd = [first, first + rd_difference[2], first - rd_difference[1]];
        (PointField { rd, rd_difference, squares: self.squares(u) }, second)
    }

    fn square_differences(&self) -> [f64; 3] {
        self.series.differences
    }

    #[inline(always)]
    fn potential_perturbation<S: Simd, const N: usize>(
        &self,
        x: [Lanes<S, N>; 3],
    ) -> (Lanes<S, N>, PointField<S, N>) {
        let (perturbation, near, field) = self.perturbation_and_field(x);
        (perturbation * near, field)
    }
}
