//! The derivatives of force and torques by the mutual expansion.
//!
//! Let U be a function of the separation and of both spread matrices, and M = dU/dS for a body. The torque on
//! the body is the axial vector of 2 S M, and a rotation of the body by theta changes its S by \[theta\]x S -
//! S \[theta\]x. M is a contraction of the second derivatives of 1/r, and its own derivatives are
//! contractions of the third and fourth ones. A change of a semi-axis a by da changes the S of its body by 2
//! a e e^T da, with e the direction of the axis.

use super::derivatives::Derivatives;
use super::multipole::{Multipole, Terms};
use super::{Interaction, Jacobian, Pose, ShapeDerivatives};
use crate::math::matrix::{times, transposed_times};
use crate::math::monomials::{count, exponents, offset, position};
use crate::math::rotation::rotate_back;
use crate::math::{Mat3, Vec3};

/// Calls [`contractions`] with arrays of the size that half the degree needs.
macro_rules! sized {
    ($half:expr, $($argument:expr),*) => {
        match $half {
            0 | 1 => contractions::<2, { count(2) }, { offset(5) }>($($argument),*),
            2 => contractions::<3, { count(4) }, { offset(7) }>($($argument),*),
            _ => contractions::<4, { count(6) }, { offset(9) }>($($argument),*),
        }
    };
}

impl Multipole {
    /// Returns the derivatives of force and torques with respect to the pose.
    pub fn jacobian(&self, pose: &Pose) -> Jacobian {
        let (spreads, scale) = self.scaled_spreads(pose);
        let s = series_jacobian(&spreads, &sized!(self.half(), &spreads, &(pose.separation / scale)));
        let rotations = [&pose.rotation_first, &pose.rotation_second];
        let torques = [0, 1].map(|b| rotate_back(rotations[b], &s.torques[b]) / scale);
        let by_rotation = |b: usize, c: usize| {
            transposed_times(rotations[b], &times(&s.by_rotation[b][c], rotations[c])) / scale
        };
        Jacobian {
            loads: Interaction {
                force_on_first: -s.gradient / (scale * scale),
                torque_first: torques[0],
                torque_second: torques[1],
            },
            force_by_separation: -s.hessian / (scale * scale * scale),
            torque_by_separation: [0, 1]
                .map(|b| transposed_times(rotations[b], &s.by_position[b]) / (scale * scale)),
            torque_by_rotation: [0, 1].map(|b| by_rotation(b, b) + torques[b].cross_matrix()),
            torque_first_by_second: by_rotation(0, 1),
        }
    }

    /// Returns the derivatives of force and torques with respect to the lengths of both bodies.
    pub fn shape_derivatives(&self, pose: &Pose) -> ShapeDerivatives {
        let (spreads, scale) = self.scaled_spreads(pose);
        let c = sized!(self.half(), &spreads, &(pose.separation / scale));
        let rotations = [&pose.rotation_first, &pose.rotation_second];
        let mut out = ShapeDerivatives::ZERO;
        for body in 0..2 {
            for axis in 0..3 {
                let e = rotations[body].column(axis) / scale;
                let change = e * e.transpose() * (2.0 * self.squares[body][axis].sqrt());
                let force = Vec3::from_fn(|l, _| contracted(&change, |i, j| c.third[body][index([i, j, l])]));
                let torque = |of: usize| {
                    let spread_change = c.spread_change(of + body, &change);
                    let direct = if of == body { axial(&change, &c.by_spread(of)) } else { Vec3::zeros() };
                    rotate_back(rotations[of], &(axial(&spreads[of], &spread_change) + direct)) / scale
                };
                out.axes[body][axis] = Interaction {
                    force_on_first: -force / (scale * scale),
                    torque_first: torque(0),
                    torque_second: torque(1),
                };
            }
        }
        out
    }
}

/// Force, torques and their derivatives in inertial axes and in units of the separation.
struct SeriesJacobian {
    gradient: Vec3,
    hessian: Mat3,
    torques: [Vec3; 2],
    by_position: [Mat3; 2],
    /// The derivatives of the torque on one body with respect to the rotation of one body.
    by_rotation: [[Mat3; 2]; 2],
}

/// The derivatives of the contractions of the derivatives of 1/r, in units of the separation.
struct Contractions {
    gradient: [f64; 3],
    hessian: [f64; 6],
    /// The matrix dU/dS of either body, and its derivatives with respect to the position.
    second: [[f64; 6]; 2],
    third: [[f64; 10]; 2],
    /// The derivatives d^2 U/dS dS: by the first spread twice, by both, and by the second twice.
    fourth: [[f64; 15]; 3],
}

impl Contractions {
    /// Returns dU/dS of a body.
    fn by_spread(&self, body: usize) -> Mat3 {
        symmetric(|i, j| self.second[body][index([i, j])])
    }

    /// Returns the change of dU/dS by a change of a spread, where the index is the sum of the indices of both
    /// bodies.
    fn spread_change(&self, sum_of_bodies: usize, change: &Mat3) -> Mat3 {
        symmetric(|i, j| contracted(change, |k, l| self.fourth[sum_of_bodies][index([i, j, k, l])]))
    }
}

/// Returns the sum of the products of all components.
fn contracted(change: &Mat3, of: impl Fn(usize, usize) -> f64) -> f64 {
    let mut sum = 0.0;
    for k in 0..3 {
        for l in 0..3 {
            sum += of(k, l) * change[(k, l)];
        }
    }
    sum
}

/// Returns the axial vector of 2 S M.
fn axial(spread: &Mat3, m: &Mat3) -> Vec3 {
    let p = 2.0 * times(spread, m);
    Vec3::new(p.m23 - p.m32, p.m31 - p.m13, p.m12 - p.m21)
}

fn contractions<const TERMS: usize, const MONOMIALS: usize, const DERIVATIVES: usize>(
    spreads: &[Mat3; 2],
    x: &Vec3,
) -> Contractions {
    let terms = Terms::<TERMS, MONOMIALS>::new(spreads);
    let derivatives = Derivatives::<DERIVATIVES>::new(x, 2 * TERMS);
    let mut gradient = [0.0; 3];
    let mut hessian = [0.0; 6];
    for (s, potential) in terms.potential.iter().enumerate() {
        derivatives.add_higher(&mut gradient, potential, 2 * s, 1);
        derivatives.add_higher(&mut hessian, potential, 2 * s, 2);
    }
    let (mut second, mut third) = ([[0.0; 6]; 2], [[0.0; 10]; 2]);
    for body in 0..2 {
        for (s, variation) in terms.variation[body].iter().enumerate().skip(1) {
            derivatives.add_higher(&mut second[body], variation, 2 * s - 2, 2);
            derivatives.add_higher(&mut third[body], variation, 2 * s - 2, 3);
        }
    }
    let mut fourth = [[0.0; 15]; 3];
    for (pair, sum) in fourth.iter_mut().enumerate() {
        for (s, variation) in Terms::<TERMS, MONOMIALS>::second(spreads, pair).iter().enumerate().skip(2) {
            derivatives.add_higher(sum, variation, 2 * s - 4, 4);
        }
    }
    Contractions { gradient, hessian, second, third, fourth }
}

fn series_jacobian(spreads: &[Mat3; 2], c: &Contractions) -> SeriesJacobian {
    let m = [0, 1].map(|b| c.by_spread(b));
    let torques = [0, 1].map(|b| axial(&spreads[b], &m[b]));
    let by_position = [0, 1].map(|b| {
        let along = |l: usize| symmetric(|i, j| c.third[b][index([i, j, l])]);
        Mat3::from_columns(&[0, 1, 2].map(|l| axial(&spreads[b], &along(l))))
    });
    let by_rotation = [0, 1].map(|b| {
        [0, 1].map(|other| {
            Mat3::from_columns(&[Vec3::x(), Vec3::y(), Vec3::z()].map(|theta| {
                let generator = theta.cross_matrix();
                let change = times(&generator, &spreads[other]) - times(&spreads[other], &generator);
                let spread_change = c.spread_change(b + other, &change);
                let direct = if b == other { axial(&change, &m[b]) } else { Vec3::zeros() };
                axial(&spreads[b], &spread_change) + direct
            }))
        })
    });
    SeriesJacobian {
        gradient: Vec3::from(c.gradient),
        hessian: symmetric(|i, j| c.hessian[index([i, j])]),
        torques,
        by_position,
        by_rotation,
    }
}

/// Returns the index of a derivative along these axes among those of its order.
pub(super) fn index<const ORDER: usize>(axes: [usize; ORDER]) -> usize {
    let times = |axis: usize| axes.iter().filter(|a| **a == axis).count();
    position(ORDER, times(0), times(1))
}

pub(super) fn symmetric(of: impl Fn(usize, usize) -> f64) -> Mat3 {
    Mat3::from_fn(|i, j| of(i.min(j), i.max(j)))
}

impl<const DERIVATIVES: usize> Derivatives<DERIVATIVES> {
    /// Adds the derivatives of an order of the contraction with p.
    pub(super) fn add_higher(&self, sum: &mut [f64], p: &[f64], degree: usize, order: usize) {
        let raised = &self.values[offset(degree + order)..];
        for (value, (a, b)) in sum.iter_mut().zip(exponents(order)) {
            for (p, (i, j)) in p.iter().zip(exponents(degree)) {
                *value += p * raised[position(degree + order, i + a, j + b)];
            }
        }
    }
}
