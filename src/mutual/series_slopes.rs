//! The derivatives of force and torques by the mutual expansion.
//!
//! With U a function of the separation and of both spread matrices, M = dU/dS of a body and the torque on it the axial vector of
//! 2 S M, a turn of a body by theta changes its S by \[theta\]x S - S \[theta\]x. M is a contraction of the second derivatives of 1/r, its
//! own derivatives are those of the third and the fourth.

use super::derivatives::Derivatives;
use super::multipole::{Multipole, Terms};
use super::{Interaction, Jacobian, Pose};
use crate::math::matrix::{times, transposed_times};
use crate::math::monomials::{count, exponents, offset, position};
use crate::math::rotation::turned_back;
use crate::math::{Mat3, Vec3};

/// Runs [`slopes`] for arrays of just the size that half the degree takes.
macro_rules! sized {
    ($half:expr, $($argument:expr),*) => {
        match $half {
            0 | 1 => slopes::<2, { count(2) }, { offset(5) }>($($argument),*),
            2 => slopes::<3, { count(4) }, { offset(7) }>($($argument),*),
            3 => slopes::<4, { count(6) }, { offset(9) }>($($argument),*),
            4 => slopes::<5, { count(8) }, { offset(11) }>($($argument),*),
            5 => slopes::<6, { count(10) }, { offset(13) }>($($argument),*),
            6 => slopes::<7, { count(12) }, { offset(15) }>($($argument),*),
            7 => slopes::<8, { count(14) }, { offset(17) }>($($argument),*),
            _ => slopes::<9, { count(16) }, { offset(19) }>($($argument),*),
        }
    };
}

impl Multipole {
    /// Derivatives of force and torques; those of shapes other than ellipsoids and points have been refused.
    pub fn jacobian(&self, pose: &Pose) -> Jacobian {
        let (spreads, scale) = self.scaled_spreads(pose);
        let s = sized!(self.half(), &spreads, &(pose.separation / scale));
        let rotations = [&pose.rotation_first, &pose.rotation_second];
        let torques = [0, 1].map(|b| turned_back(rotations[b], &s.torques[b]) / scale);
        let by_turn = |b: usize, c: usize| {
            transposed_times(rotations[b], &times(&s.by_turn[b][c], rotations[c])) / scale
        };
        Jacobian {
            loads: Interaction {
                force_on_first: -s.gradient / (scale * scale),
                torque_first: torques[0],
                torque_second: torques[1],
            },
            force_by_separation: -s.hessian / (scale * scale * scale),
            torque_by_separation: [0, 1]
                .map(|b| transposed_times(rotations[b], &s.by_place[b]) / (scale * scale)),
            torque_by_rotation: [0, 1].map(|b| by_turn(b, b) + torques[b].cross_matrix()),
            torque_first_by_second: by_turn(0, 1),
        }
    }
}

/// All in inertial axes and in units of the separation.
struct Slopes {
    gradient: Vec3,
    hessian: Mat3,
    torques: [Vec3; 2],
    by_place: [Mat3; 2],
    /// Of the torque on a body with the turn of a body.
    by_turn: [[Mat3; 2]; 2],
}

fn slopes<const TERMS: usize, const MONOMIALS: usize, const DERIVATIVES: usize>(
    spreads: &[Mat3; 2],
    x: &Vec3,
) -> Slopes {
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
    let m = second.map(|sum| symmetric(|i, j| sum[index([i, j])]));
    let axial = |spread: &Mat3, m: &Mat3| {
        let p = 2.0 * times(spread, m);
        Vec3::new(p.m23 - p.m32, p.m31 - p.m13, p.m12 - p.m21)
    };
    let torques = [0, 1].map(|b| axial(&spreads[b], &m[b]));
    let by_place = [0, 1].map(|b| {
        let along = |l: usize| symmetric(|i, j| third[b][index([i, j, l])]);
        Mat3::from_columns(&[0, 1, 2].map(|l| axial(&spreads[b], &along(l))))
    });
    let by_turn = [0, 1].map(|b| {
        [0, 1].map(|c| {
            Mat3::from_columns(&[Vec3::x(), Vec3::y(), Vec3::z()].map(|theta| {
                let turn = theta.cross_matrix();
                let change = times(&turn, &spreads[c]) - times(&spreads[c], &turn);
                let moved = symmetric(|i, j| {
                    let mut sum = 0.0;
                    for k in 0..3 {
                        for l in 0..3 {
                            sum += fourth[b + c][index([i, j, k, l])] * change[(k, l)];
                        }
                    }
                    sum
                });
                let own = if b == c { axial(&change, &m[b]) } else { Vec3::zeros() };
                axial(&spreads[b], &moved) + own
            }))
        })
    });
    Slopes {
        gradient: Vec3::from(gradient),
        hessian: symmetric(|i, j| hessian[index([i, j])]),
        torques,
        by_place,
        by_turn,
    }
}

/// The place of a derivative along these axes among those of its order.
fn index<const ORDER: usize>(axes: [usize; ORDER]) -> usize {
    let times = |axis: usize| axes.iter().filter(|a| **a == axis).count();
    position(ORDER, times(0), times(1))
}

fn symmetric(of: impl Fn(usize, usize) -> f64) -> Mat3 {
    Mat3::from_fn(|i, j| of(i.min(j), i.max(j)))
}

impl<const DERIVATIVES: usize> Derivatives<DERIVATIVES> {
    /// Adds the derivatives of an order of the contraction with p.
    fn add_higher(&self, sum: &mut [f64], p: &[f64], degree: usize, order: usize) {
        let raised = &self.values[offset(degree + order)..];
        for (value, (a, b)) in sum.iter_mut().zip(exponents(order)) {
            for (p, (i, j)) in p.iter().zip(exponents(degree)) {
                *value += p * raised[position(degree + order, i + a, j + b)];
            }
        }
    }
}
