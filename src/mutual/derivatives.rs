//! The partial derivatives of 1/r, by the recurrence of Lindsay & Krasny (2001), J. Comput. Phys. 172, 879.

use crate::math::Vec3;
use crate::math::monomials::{Row, count, offset, rows};

/// All partial derivatives of 1/r at a point, up to a degree.
pub(super) struct Derivatives<const DERIVATIVES: usize> {
    pub(super) values: [f64; DERIVATIVES],
}

impl<const DERIVATIVES: usize> Derivatives<DERIVATIVES> {
    pub(super) fn new(x: &Vec3, degree: usize) -> Self {
        let mut values = [0.0; DERIVATIVES];
        let r2 = x.norm_squared();
        values[0] = 1.0 / r2.sqrt();
        for d in 1..=degree {
            let n = d as f64;
            let (once, twice) = ((2.0 * n - 1.0) / (n * r2), (n - 1.0) / (n * r2));
            let (lower, present) = values.split_at_mut(offset(d));
            let (below, lowest) = (&lower[offset(d - 1)..], &lower[offset(d.max(2) - 2)..]);
            for Row { power, power_of_yz, start } in rows(d) {
                // The recurrence refers to the row above for a monomial without one y or z, and to the one
                // above that for a monomial without two of them.
                let (above, second) =
                    (start.wrapping_sub(power_of_yz), start.wrapping_sub(2 * power_of_yz).wrapping_add(1));
                let i = power as f64;
                for l in 0..=power_of_yz {
                    let (j, k) = ((power_of_yz - l) as f64, l as f64);
                    let (mut first_sum, mut second_sum) = (0.0, 0.0);
                    if power >= 1 {
                        first_sum += i * x.x * below[start + l];
                    }
                    if l < power_of_yz {
                        first_sum += j * x.y * below[above + l];
                    }
                    if l >= 1 {
                        first_sum += k * x.z * below[above + l - 1];
                    }
                    if power >= 2 {
                        second_sum += i * (i - 1.0) * lowest[start + l];
                    }
                    if l + 1 < power_of_yz {
                        second_sum += j * (j - 1.0) * lowest[second + l];
                    }
                    if l >= 2 {
                        second_sum += k * (k - 1.0) * lowest[second + l - 2];
                    }
                    present[start + l] = -(once * first_sum + twice * second_sum);
                }
            }
        }
        Self { values }
    }

    pub(super) fn contract(&self, p: &[f64], degree: usize) -> f64 {
        let start = offset(degree);
        p.iter().zip(&self.values[start..start + count(degree)]).map(|(c, t)| c * t).sum()
    }

    pub(super) fn gradient(&self, p: &[f64], degree: usize) -> Vec3 {
        let raised = &self.values[offset(degree + 1)..];
        let mut sum = Vec3::zeros();
        for row in rows(degree) {
            for k in row.monomials() {
                for (axis, raised_by) in row.raised_once(k).into_iter().enumerate() {
                    sum[axis] += p[k] * raised[raised_by];
                }
            }
        }
        sum
    }

    /// Adds the six second derivatives of the contraction with p, xx, xy, xz, yy, yz and zz.
    pub(super) fn add_second(&self, sum: &mut [f64; 6], p: &[f64], degree: usize) {
        let raised = &self.values[offset(degree + 2)..];
        for row in rows(degree) {
            for k in row.monomials() {
                for (sum, raised_by) in sum.iter_mut().zip(row.raised_twice(k)) {
                    *sum += p[k] * raised[raised_by];
                }
            }
        }
    }
}
