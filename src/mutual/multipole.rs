//! The mutual expansion of two ellipsoids to a total degree N of 2 or 4, with their moments in closed form.
//!
//! The mean of exp(y . k) over an ellipsoid with spread matrix S = R diag(a^2) R^T is sum_n alpha_n (k^T S
//! k)^n with alpha_n = 3 / ((2n+1)! (2n+3)). The mean of 1/|r + y_B - y_A| over both bodies is therefore
//!
//!   U = sum_{n,m} alpha_n alpha_m (grad^T S_A grad)^n (grad^T S_B grad)^m 1/r,
//!
//! The series is truncated at 2 (n + m) <= N; N = 2 is MacCullagh's formula. The force is its gradient, and
//! the torque on A follows from d(k^T S_A k) = 2 dtheta . (S_A k x k). The derivatives of 1/r follow from the
//! recurrence of Lindsay & Krasny (2001), J. Comput. Phys. 172, 879. Other degrees
//! and shapes take [`super::harmonic`].

use super::derivatives::Derivatives;
use super::{Interaction, Pose};
use crate::math::monomials::{add, count, offset, rows};
use crate::math::{Mat3, Vec3};
use crate::shape::Shape;

/// Runs a method of [`SizedExpansion`] for arrays of the size that half the degree requires.
macro_rules! sized {
    ($half:expr, $method:ident($($argument:expr),*)) => {
        match $half {
            0 | 1 => SizedExpansion::<1, 2, { count(2) }, { offset(4) }>::$method($($argument),*),
            2 => SizedExpansion::<2, 3, { count(4) }, { offset(6) }>::$method($($argument),*),
            _ => SizedExpansion::<3, 4, { count(6) }, { offset(8) }>::$method($($argument),*),
        }
    };
}

/// The expansion of one pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Multipole {
    half: usize,
    pub(super) squares: [Vec3; 2],
}

impl Multipole {
    /// Prepares the expansion of ellipsoids or points to a total degree of 2 or 4; `None` for other shapes
    /// and degrees.
    pub fn new(first: &Shape, second: &Shape, degree: usize) -> Option<Self> {
        let squares = |s: &Shape| Vec3::from(s.semi_axes().map(|a| a * a));
        let other = |shape: &&Shape| matches!(shape, Shape::Polyhedron(_) | Shape::Stokes(_));
        let others = [first, second].iter().any(other);
        let squares = [squares(first), squares(second)];
        (!others && matches!(degree, 2 | 4)).then_some(Self { half: degree / 2, squares })
    }

    /// Returns the expansion to a total degree that is higher by two: the additional terms are the first that
    /// this one omits.
    pub fn next(&self) -> Self {
        Self { half: self.half + 1, squares: self.squares }
    }

    /// Returns half the total degree.
    pub(super) fn half(&self) -> usize {
        self.half
    }

    /// Returns force and torques.
    pub fn interaction(&self, pose: &Pose) -> Interaction {
        let (spreads, scale) = self.scaled_spreads(pose);
        let (gradient, torques) = sized!(self.half, forces(&spreads, &(pose.separation / scale)));
        Interaction {
            force_on_first: -gradient / (scale * scale),
            torque_first: pose.rotation_first.transpose() * torques[0] / scale,
            torque_second: pose.rotation_second.transpose() * torques[1] / scale,
        }
    }

    /// Returns the mutual potential U (positive) per unit G m m.
    pub fn mutual_potential(&self, pose: &Pose) -> f64 {
        let (spreads, scale) = self.scaled_spreads(pose);
        sized!(self.half, potential(&spreads, &(pose.separation / scale))) / scale
    }

    /// Returns the spread matrices in units of the separation, so that no power over- or underflows.
    pub(super) fn scaled_spreads(&self, pose: &Pose) -> ([Mat3; 2], f64) {
        let scale = pose.separation.norm();
        let spread = |r: &Mat3, squares: &Vec3| {
            let scaled = squares / (scale * scale);
            let columns = [r.column(0) * scaled.x, r.column(1) * scaled.y, r.column(2) * scaled.z];
            Mat3::from_columns(&columns) * r.transpose()
        };
        (
            [spread(&pose.rotation_first, &self.squares[0]), spread(&pose.rotation_second, &self.squares[1])],
            scale,
        )
    }
}

/// The expansion to half-degree `HALF`. `TERMS` is HALF + 1, `MONOMIALS` the number of monomials of degree 2
/// HALF, and `DERIVATIVES` the number of partial derivatives up to degree 2 HALF + 1.
struct SizedExpansion<const HALF: usize, const TERMS: usize, const MONOMIALS: usize, const DERIVATIVES: usize>;

impl<const HALF: usize, const TERMS: usize, const MONOMIALS: usize, const DERIVATIVES: usize>
    SizedExpansion<HALF, TERMS, MONOMIALS, DERIVATIVES>
{
    /// Returns the gradient of U and the torques, inertial.
    fn forces(spreads: &[Mat3; 2], x: &Vec3) -> (Vec3, [Vec3; 2]) {
        let terms = Terms::<TERMS, MONOMIALS>::new(spreads);
        let derivatives = Derivatives::<DERIVATIVES>::new(x, 2 * HALF + 1);
        let mut gradient = Vec3::zeros();
        for (s, potential) in terms.potential.iter().enumerate() {
            gradient += derivatives.gradient(potential, 2 * s);
        }
        let mut torques = [Vec3::zeros(); 2];
        for (body, torque) in torques.iter_mut().enumerate() {
            // These are the second derivatives of the term with which the body's spread is contracted.
            let mut second = [0.0; 6];
            for (s, variation) in terms.variation[body].iter().enumerate().skip(1) {
                derivatives.add_second(&mut second, variation, 2 * s - 2);
            }
            let [xx, xy, xz, yy, yz, zz] = second;
            // The torque follows from d(k^T S k) = 2 dtheta . (S k x k), with k k^T the second derivatives.
            let m = 2.0 * spreads[body] * Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
            *torque = Vec3::new(m.m23 - m.m32, m.m31 - m.m13, m.m12 - m.m21);
        }
        (gradient, torques)
    }

    /// Returns the mutual potential U.
    fn potential(spreads: &[Mat3; 2], x: &Vec3) -> f64 {
        let terms = Terms::<TERMS, MONOMIALS>::new(spreads);
        let derivatives = Derivatives::<DERIVATIVES>::new(x, 2 * HALF);
        (0..TERMS).rev().map(|s| derivatives.contract(&terms.potential[s], 2 * s)).sum()
    }
}

/// For each half-degree s the polynomial sum_n alpha_n alpha_{s-n} A^n B^{s-n}, and its variations by A and
/// by B.
pub(super) struct Terms<const TERMS: usize, const MONOMIALS: usize> {
    pub potential: [[f64; MONOMIALS]; TERMS],
    pub variation: [[[f64; MONOMIALS]; TERMS]; 2],
}

impl<const TERMS: usize, const MONOMIALS: usize> Terms<TERMS, MONOMIALS> {
    pub fn new(spreads: &[Mat3; 2]) -> Self {
        let half = TERMS - 1;
        let forms = [quadratic_form(&spreads[0]), quadratic_form(&spreads[1])];
        let empty = [[0.0; MONOMIALS]; TERMS];
        let mut terms = Self { potential: empty, variation: [empty; 2] };
        // Products A^n B^m, row by row; each one enters the potential and both variations.
        let mut power_of_a = [0.0; MONOMIALS];
        power_of_a[0] = 1.0;
        for n in 0..=half {
            let mut product = power_of_a;
            for m in 0..=(half - n) {
                let s = n + m;
                let degree = 2 * s;
                add(&mut terms.potential[s], &product, degree, ALPHA[n] * ALPHA[m]);
                if s < half {
                    let (a, b) = (ALPHA[n + 1] * ALPHA[m], ALPHA[n] * ALPHA[m + 1]);
                    add(&mut terms.variation[0][s + 1], &product, degree, (n + 1) as f64 * a);
                    add(&mut terms.variation[1][s + 1], &product, degree, (m + 1) as f64 * b);
                    product = times_quadratic(&product, degree, &forms[1]);
                }
            }
            if n < half {
                power_of_a = times_quadratic(&power_of_a, 2 * n, &forms[0]);
            }
        }
        terms
    }
}

impl<const TERMS: usize, const MONOMIALS: usize> Terms<TERMS, MONOMIALS> {
    /// Returns the second variations: by A twice, by A and B, or by B twice.
    pub fn second(spreads: &[Mat3; 2], which: usize) -> [[f64; MONOMIALS]; TERMS] {
        let [raised_a, raised_b] = [2 - which, which];
        let forms = [quadratic_form(&spreads[0]), quadratic_form(&spreads[1])];
        let mut sums = [[0.0; MONOMIALS]; TERMS];
        let mut power_of_a = [0.0; MONOMIALS];
        power_of_a[0] = 1.0;
        // The r-th derivative of A^(n + r) has the factor (n + r)! / n!.
        let fall = |n: usize, r: usize| (n + 1..=n + r).map(|k| k as f64).product::<f64>();
        for n in 0..TERMS.saturating_sub(2) {
            let mut product = power_of_a;
            for m in 0..TERMS - 2 - n {
                let factor =
                    ALPHA[n + raised_a] * ALPHA[m + raised_b] * fall(n, raised_a) * fall(m, raised_b);
                add(&mut sums[n + m + 2], &product, 2 * (n + m), factor);
                if m + 1 < TERMS - 2 - n {
                    product = times_quadratic(&product, 2 * (n + m), &forms[1]);
                }
            }
            if n + 3 < TERMS {
                power_of_a = times_quadratic(&power_of_a, 2 * n, &forms[0]);
            }
        }
        sums
    }
}

/// The moment coefficients alpha_n = 3 / ((2n+1)! (2n+3)).
const ALPHA: [f64; 4] = {
    let mut alpha = [1.0; 4];
    let (mut n, mut factorial) = (1, 1.0);
    while n < alpha.len() {
        factorial *= (2 * n * (2 * n + 1)) as f64;
        alpha[n] = 3.0 / (factorial * (2 * n + 3) as f64);
        n += 1;
    }
    alpha
};

/// Returns k^T S k in the order of [`rows`]; polynomials in k are homogeneous, of a degree known from the
/// context.
fn quadratic_form(s: &Mat3) -> [f64; 6] {
    [s[(0, 0)], 2.0 * s[(0, 1)], 2.0 * s[(0, 2)], s[(1, 1)], 2.0 * s[(1, 2)], s[(2, 2)]]
}

fn times_quadratic<const MONOMIALS: usize>(
    p: &[f64; MONOMIALS],
    degree: usize,
    form: &[f64; 6],
) -> [f64; MONOMIALS] {
    let mut out = [0.0; MONOMIALS];
    for row in rows(degree) {
        for k in row.monomials() {
            for (q, raised) in form.iter().zip(row.raised_twice(k)) {
                out[raised] += p[k] * q;
            }
        }
    }
    out
}
