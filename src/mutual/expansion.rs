//! The mutual expansion to a total degree N for bodies of any shape, by the moments of their mass.
//!
//! With p_d(k) the mean of (y.k)^d / d! over a body, a homogeneous polynomial whose coefficients are the
//! moments over factorials,
//!
//!   U = sum p_d^A(-grad) p_e^B(grad) 1/r,   d + e <= N.
//!
//! The polynomials are rotated into inertial axes, where each linear form of the body's axes is substituted
//! by Horner's rule. A rotation of the body by dtheta changes p by dtheta . (dp/dk x k), which gives the
//! torques. The series converges where r exceeds the sum of both circumscribed radii.

use super::derivatives::Derivatives;
use super::{Interaction, Method, Pose};
use crate::interrupt::InterruptCheck;
use crate::math::monomials::{add, count, exponents, offset, position, rows};
use crate::math::{Mat3, Vec3};
use crate::shape::Shape;

/// The number of monomials in three variables of the highest degree, and of all degrees.
const MONOMIALS: usize = count(Method::BEYOND);
const ALL: usize = offset(Method::BEYOND + 1);

/// The polynomials p_0 to p_N in this order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Polynomials([f64; ALL]);

/// The expansion of one pair.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Expansion {
    degree: usize,
    pub bodies: [Polynomials; 2],
    /// The semi-axes of the bodies that are ellipsoids.
    pub semi_axes: [Option<[f64; 3]>; 2],
    /// The sum of the circumscribed radii.
    pub reach: f64,
}

impl Expansion {
    pub fn new(first: &Shape, second: &Shape, degree: usize) -> Self {
        Self {
            degree,
            bodies: [first, second].map(|shape| Polynomials::moments(shape, degree + 2)),
            semi_axes: [first, second].map(|shape| match shape {
                Shape::Ellipsoid(ellipsoid) => Some(ellipsoid.semi_axes()),
                _ => None,
            }),
            reach: first.circumradius() + second.circumradius(),
        }
    }

    /// Returns the expansion to a total degree that is higher by two, for which the moments suffice once.
    pub fn next(&self) -> Self {
        Self { degree: self.degree + 2, ..self.clone() }
    }

    /// Returns the expansion of bodies with other moments.
    pub fn with_moments(&self, bodies: [Polynomials; 2]) -> Self {
        Self { bodies, ..self.clone() }
    }

    /// Returns the total degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Returns force and torques.
    pub fn interaction(&self, pose: &Pose) -> Interaction {
        let scale = pose.separation.norm();
        let (a, b) = self.turned(pose, scale);
        let derivatives =
            Derivatives::<{ offset(Method::BEYOND + 2) }>::new(&(pose.separation / scale), self.degree + 1);
        let mut gradient = Vec3::zeros();
        let mut torques = [Vec3::zeros(); 2];
        for d in 0..=self.degree {
            for e in 0..=self.degree - d {
                let (p, q) = (a.of(d), b.of(e));
                gradient += derivatives.gradient(&product(p, d, q, e), d + e);
                for i in 0..3 {
                    if d > 0 {
                        torques[0][i] += derivatives.contract(&product(&variation(p, d, i), d, q, e), d + e);
                    }
                    if e > 0 {
                        torques[1][i] += derivatives.contract(&product(p, d, &variation(q, e, i), e), d + e);
                    }
                }
            }
        }
        Interaction {
            force_on_first: -gradient / (scale * scale),
            torque_first: pose.rotation_first.transpose() * torques[0] / scale,
            torque_second: pose.rotation_second.transpose() * torques[1] / scale,
        }
    }

    /// Returns the mutual potential U (positive) per unit G m m.
    pub fn mutual_potential(&self, pose: &Pose) -> f64 {
        let scale = pose.separation.norm();
        let (a, b) = self.turned(pose, scale);
        let derivatives =
            Derivatives::<{ offset(Method::BEYOND + 2) }>::new(&(pose.separation / scale), self.degree);
        let mut sum = 0.0;
        for d in (0..=self.degree).rev() {
            for e in (0..=self.degree - d).rev() {
                sum += derivatives.contract(&product(a.of(d), d, b.of(e), e), d + e);
            }
        }
        sum / scale
    }

    /// Returns the polynomials of both bodies along inertial axes, in units of the separation; those of the
    /// first body are functions of -k.
    pub fn turned(&self, pose: &Pose, scale: f64) -> (Polynomials, Polynomials) {
        (
            self.bodies[0].turned(&pose.rotation_first, -1.0 / scale, self.degree),
            self.bodies[1].turned(&pose.rotation_second, 1.0 / scale, self.degree),
        )
    }
}

impl Polynomials {
    fn moments(shape: &Shape, degree: usize) -> Self {
        let mut all = [0.0; ALL];
        let mut put = |mean: &dyn Fn([usize; 3]) -> f64| {
            for d in 0..=degree {
                for (i, j) in exponents(d) {
                    let e = [i, j, d - i - j];
                    let factorials: f64 =
                        e.iter().map(|&n| (1..=n).map(|k| k as f64).product::<f64>()).product();
                    all[offset(d) + position(d, i, j)] = mean(e) / factorials;
                }
            }
        };
        match shape {
            Shape::Point => put(&|e| if e == [0; 3] { 1.0 } else { 0.0 }),
            Shape::Ellipsoid(ellipsoid) => {
                let axes = ellipsoid.semi_axes();
                // The moment is 3 / (n + 3) times the mean over the sphere, (i-1)!! (j-1)!! (l-1)!! / (n+1)!!
                // for even exponents.
                let odd = |n: usize| (1..n).step_by(2).map(|k| k as f64).product::<f64>();
                put(&|e| {
                    if e.iter().any(|n| n % 2 == 1) {
                        return 0.0;
                    }
                    let n: usize = e.iter().sum();
                    let power: f64 = (0..3).map(|k| axes[k].powi(e[k] as i32) * odd(e[k])).product();
                    power / odd(n + 2) * 3.0 / (n + 3) as f64
                });
            }
            Shape::Polyhedron(polyhedron) => {
                // The means were computed before, where an interrupt could be checked. This check cannot
                // interrupt, so that the call cannot fail.
                let means =
                    polyhedron.monomial_means(degree, &mut InterruptCheck::never()).unwrap_or_default();
                let radius = polyhedron.circumradius();
                put(&|e| {
                    let n: usize = e.iter().sum();
                    let mean = means.get(offset(n) + position(n, e[0], e[1]));
                    mean.map_or(f64::NAN, |mean| mean * radius.powi(n as i32))
                });
            }
        }
        Self(all)
    }

    /// Returns the coefficients multiplied by factors that depend on their exponents.
    pub fn weighted(&self, factor: impl Fn([usize; 3]) -> f64) -> Self {
        let mut out = *self;
        for d in 0..=Method::BEYOND {
            for (i, j) in exponents(d) {
                out.0[offset(d) + position(d, i, j)] *= factor([i, j, d - i - j]);
            }
        }
        out
    }

    pub fn of(&self, d: usize) -> &[f64] {
        &self.0[offset(d)..offset(d + 1)]
    }

    /// Returns the polynomials of k along the outer axes, times powers of a factor: k along the body's axes
    /// is R^T k.
    fn turned(&self, rotation: &Mat3, factor: f64, degree: usize) -> Self {
        let [u, v, w] = [0, 1, 2].map(|axis| rotation.column(axis) * factor);
        let mut powers = [[0.0; MONOMIALS]; Method::BEYOND + 1];
        powers[0][0] = 1.0;
        for n in 0..degree {
            powers[n + 1] = times_form(&powers[n], n, &w);
        }
        let mut out = Self([0.0; ALL]);
        for d in 0..=degree {
            // The sum sum_i u^i sum_j v^j c_ij w^(d-i-j) is formed from the highest powers down.
            let own = self.of(d);
            let mut outer = [0.0; MONOMIALS];
            for i in (0..=d).rev() {
                if i < d {
                    outer = times_form(&outer, d - i - 1, &u);
                }
                let rest = d - i;
                let mut inner = [0.0; MONOMIALS];
                for j in (0..=rest).rev() {
                    if j < rest {
                        inner = times_form(&inner, rest - j - 1, &v);
                    }
                    let c = own[position(d, i, j)];
                    add(&mut inner, &powers[rest - j], rest - j, c);
                }
                add(&mut outer, &inner, rest, 1.0);
            }
            out.0[offset(d)..offset(d + 1)].copy_from_slice(&outer[..count(d)]);
        }
        out
    }
}

/// Returns a polynomial times a linear form.
fn times_form(p: &[f64; MONOMIALS], degree: usize, form: &Vec3) -> [f64; MONOMIALS] {
    let mut out = [0.0; MONOMIALS];
    for row in rows(degree) {
        for k in row.monomials() {
            for (axis, raised) in row.times_one(k).into_iter().enumerate() {
                out[raised] += p[k] * form[axis];
            }
        }
    }
    out
}

pub(super) fn product(p: &[f64], d: usize, q: &[f64], e: usize) -> [f64; MONOMIALS] {
    let mut out = [0.0; MONOMIALS];
    for (a, (i, j)) in p.iter().zip(exponents(d)) {
        for (b, (k, l)) in q.iter().zip(exponents(e)) {
            out[position(d + e, i + k, j + l)] += a * b;
        }
    }
    out
}

/// Returns the component dp/dk_j k_l - dp/dk_l k_j, with (i, j, l) in cyclic order.
pub(super) fn variation(p: &[f64], degree: usize, i: usize) -> [f64; MONOMIALS] {
    let (j, l) = ((i + 1) % 3, (i + 2) % 3);
    let mut out = [0.0; MONOMIALS];
    for (c, (x, y)) in p.iter().zip(exponents(degree)) {
        let powers = [x, y, degree - x - y];
        for (from, to, sign) in [(j, l, 1.0), (l, j, -1.0)] {
            if powers[from] > 0 {
                let mut moved = powers;
                moved[from] -= 1;
                moved[to] += 1;
                out[position(degree, moved[0], moved[1])] += sign * powers[from] as f64 * c;
            }
        }
    }
    out
}
