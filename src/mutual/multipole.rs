//! The mutual expansion to a total degree N, with the moments of homogeneous ellipsoids in closed form.
//!
//! The mean of exp(y . k) over an ellipsoid with spread matrix S = R diag(a^2) R^T is sum_n alpha_n (k^T S k)^n with
//! alpha_n = 3 / ((2n+1)! (2n+3)). The mean of 1/|r + y_B - y_A| over both bodies is therefore
//!
//!   U = sum_{n,m} alpha_n alpha_m (grad^T S_A grad)^n (grad^T S_B grad)^m 1/r,
//!
//! cut at 2 (n + m) <= N; N = 2 is MacCullagh's formula. The force is its gradient and the torque on A comes from
//! d(k^T S_A k) = 2 dtheta . (S_A k x k). The derivatives of 1/r follow from the recurrence of Lindsay & Krasny (2001),
//! J. Comput. Phys. 172, 879. Other programs stop at N = 2 or 4.

use super::derivatives::Derivatives;
use super::expansion::Expansion;
use super::{Interaction, Method, Pose};
use crate::math::monomials::{count, exponents, offset, position};
use crate::math::{Mat3, Vec3};
use crate::shape::Shape;

/// Runs a method of [`Cut`] for arrays of just the size that half the degree takes.
macro_rules! sized {
    ($half:expr, $method:ident($($argument:expr),*)) => {
        match $half {
            0 | 1 => Cut::<1, 2, { count(2) }, { offset(4) }>::$method($($argument),*),
            2 => Cut::<2, 3, { count(4) }, { offset(6) }>::$method($($argument),*),
            3 => Cut::<3, 4, { count(6) }, { offset(8) }>::$method($($argument),*),
            4 => Cut::<4, 5, { count(8) }, { offset(10) }>::$method($($argument),*),
            5 => Cut::<5, 6, { count(10) }, { offset(12) }>::$method($($argument),*),
            6 => Cut::<6, 7, { count(12) }, { offset(14) }>::$method($($argument),*),
            7 => Cut::<7, 8, { count(14) }, { offset(16) }>::$method($($argument),*),
            _ => Cut::<8, 9, { count(16) }, { offset(18) }>::$method($($argument),*),
        }
    };
}

/// The expansion of one pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Multipole {
    half: usize,
    squares: [Vec3; 2],
    /// Of shapes other than ellipsoids and points.
    general: Option<Box<Expansion>>,
}

impl Multipole {
    /// To total degree `degree`, even and at most [`Method::MAX_DEGREE`].
    pub fn new(first: &Shape, second: &Shape, degree: usize) -> Self {
        let squares = |s: &Shape| Vec3::from(s.semi_axes().map(|a| a * a));
        let faceted = [first, second].iter().any(|shape| matches!(shape, Shape::Polyhedron(_)));
        Self {
            half: (degree / 2).min(Method::MAX_DEGREE / 2),
            squares: [squares(first), squares(second)],
            general: faceted.then(|| Box::new(Expansion::new(first, second, degree))),
        }
    }

    /// The separation down to which the series converges, where shapes other than ellipsoids take part.
    pub fn converges_from(&self) -> f64 {
        self.general.as_ref().map_or(0.0, |general| general.reach)
    }

    /// Force and torques.
    pub fn interaction(&self, pose: &Pose) -> Interaction {
        if let Some(general) = &self.general {
            return general.interaction(pose);
        }
        let (spreads, scale) = self.scaled_spreads(pose);
        let (gradient, torques) = sized!(self.half, forces(&spreads, &(pose.separation / scale)));
        Interaction {
            force_on_first: -gradient / (scale * scale),
            torque_first: pose.rotation_first.transpose() * torques[0] / scale,
            torque_second: pose.rotation_second.transpose() * torques[1] / scale,
        }
    }

    /// The mutual potential U (positive) per unit G m m.
    pub fn mutual_potential(&self, pose: &Pose) -> f64 {
        if let Some(general) = &self.general {
            return general.mutual_potential(pose);
        }
        let (spreads, scale) = self.scaled_spreads(pose);
        sized!(self.half, potential(&spreads, &(pose.separation / scale))) / scale
    }

    /// The spread matrices in units of the separation, so that no power over- or underflows.
    fn scaled_spreads(&self, pose: &Pose) -> ([Mat3; 2], f64) {
        let scale = pose.separation.norm();
        let spread =
            |r: &Mat3, squares: &Vec3| r * Mat3::from_diagonal(&(squares / (scale * scale))) * r.transpose();
        (
            [spread(&pose.rotation_first, &self.squares[0]), spread(&pose.rotation_second, &self.squares[1])],
            scale,
        )
    }
}

/// The expansion to half-degree `HALF`, with `TERMS` = HALF + 1, `MONOMIALS` those of degree 2 HALF, and `DERIVATIVES` the
/// partial derivatives up to degree 2 HALF + 1.
struct Cut<const HALF: usize, const TERMS: usize, const MONOMIALS: usize, const DERIVATIVES: usize>;

impl<const HALF: usize, const TERMS: usize, const MONOMIALS: usize, const DERIVATIVES: usize>
    Cut<HALF, TERMS, MONOMIALS, DERIVATIVES>
{
    /// Gradient of U and the torques, inertial.
    fn forces(spreads: &[Mat3; 2], x: &Vec3) -> (Vec3, [Vec3; 2]) {
        let terms = Terms::<TERMS, MONOMIALS>::new(spreads);
        let derivatives = Derivatives::<DERIVATIVES>::new(x, 2 * HALF + 1);
        let mut gradient = Vec3::zeros();
        for (s, potential) in terms.potential.iter().enumerate() {
            gradient += derivatives.gradient(potential, 2 * s);
        }
        let mut torques = [Vec3::zeros(); 2];
        for (body, torque) in torques.iter_mut().enumerate() {
            let forms = turning_forms(&spreads[body]);
            for (s, variation) in terms.variation[body].iter().enumerate().skip(1) {
                for i in 0..3 {
                    let turned = times_quadratic(variation, 2 * s - 2, &forms[i]);
                    torque[i] += derivatives.contract(&turned, 2 * s);
                }
            }
        }
        (gradient, torques)
    }

    /// U.
    fn potential(spreads: &[Mat3; 2], x: &Vec3) -> f64 {
        let terms = Terms::<TERMS, MONOMIALS>::new(spreads);
        let derivatives = Derivatives::<DERIVATIVES>::new(x, 2 * HALF);
        (0..TERMS).rev().map(|s| derivatives.contract(&terms.potential[s], 2 * s)).sum()
    }
}

/// For each half-degree s: sum_n alpha_n alpha_{s-n} A^n B^{s-n}, and its variations with A and with B.
struct Terms<const TERMS: usize, const MONOMIALS: usize> {
    potential: [[f64; MONOMIALS]; TERMS],
    variation: [[[f64; MONOMIALS]; TERMS]; 2],
}

impl<const TERMS: usize, const MONOMIALS: usize> Terms<TERMS, MONOMIALS> {
    fn new(spreads: &[Mat3; 2]) -> Self {
        let half = TERMS - 1;
        let forms = spreads.map(|s| quadratic_form(&s));
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
                add(&mut terms.potential[s], &product, degree, alpha(n) * alpha(m));
                if s < half {
                    let (a, b) = (alpha(n + 1) * alpha(m), alpha(n) * alpha(m + 1));
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

/// Moment coefficient alpha_n = 3 / ((2n+1)! (2n+3)).
fn alpha(n: usize) -> f64 {
    3.0 / ((1..=2 * n + 1).map(|k| k as f64).product::<f64>() * (2 * n + 3) as f64)
}

fn add(sum: &mut [f64], term: &[f64], degree: usize, factor: f64) {
    for (s, t) in sum.iter_mut().zip(term).take(count(degree)) {
        *s += factor * t;
    }
}

/// k^T S k in the order of [`exponents`]; polynomials in k are homogeneous, of a degree known from the context.
fn quadratic_form(s: &Mat3) -> [f64; 6] {
    [s[(0, 0)], 2.0 * s[(0, 1)], 2.0 * s[(0, 2)], s[(1, 1)], 2.0 * s[(1, 2)], s[(2, 2)]]
}

/// The three quadratic forms 2 (S k x k).
fn turning_forms(s: &Mat3) -> [[f64; 6]; 3] {
    [0, 1, 2].map(|i| {
        let (j, l) = ((i + 1) % 3, (i + 2) % 3);
        let mut form = Mat3::zeros();
        for column in 0..3 {
            form[(column, l)] += s[(j, column)];
            form[(column, j)] -= s[(l, column)];
        }
        quadratic_form(&(form + form.transpose()))
    })
}

fn times_quadratic<const MONOMIALS: usize>(
    p: &[f64; MONOMIALS],
    degree: usize,
    form: &[f64; 6],
) -> [f64; MONOMIALS] {
    let mut out = [0.0; MONOMIALS];
    for (c, (i, j)) in p.iter().zip(exponents(degree)) {
        for (q, (di, dj)) in form.iter().zip(exponents(2)) {
            out[position(degree + 2, i + di, j + dj)] += c * q;
        }
    }
    out
}
