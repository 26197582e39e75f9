//! The partial derivatives of 1/r, by the recurrence of Lindsay & Krasny (2001), J. Comput. Phys. 172, 879.

use crate::math::Vec3;
use crate::math::monomials::{count, exponents, index, offset};

/// All partial derivatives of 1/r at a point, up to a degree.
pub(super) struct Derivatives<const DERIVATIVES: usize> {
    values: [f64; DERIVATIVES],
}

impl<const DERIVATIVES: usize> Derivatives<DERIVATIVES> {
    pub(super) fn new(x: &Vec3, degree: usize) -> Self {
        let mut values = [0.0; DERIVATIVES];
        let r2 = x.norm_squared();
        values[0] = 1.0 / r2.sqrt();
        for d in 1..=degree {
            let n = d as f64;
            for (i, j) in exponents(d) {
                let e = [i, j, d - i - j];
                let (mut one, mut two) = (0.0, 0.0);
                for axis in 0..3 {
                    let k = e[axis] as f64;
                    if e[axis] >= 1 {
                        one += k * x[axis] * values[index(lowered(e, axis, 1))];
                    }
                    if e[axis] >= 2 {
                        two += k * (k - 1.0) * values[index(lowered(e, axis, 2))];
                    }
                }
                values[index(e)] = -((2.0 * n - 1.0) * one + (n - 1.0) * two) / (n * r2);
            }
        }
        Self { values }
    }

    pub(super) fn contract(&self, p: &[f64], degree: usize) -> f64 {
        let start = offset(degree);
        p.iter().zip(&self.values[start..start + count(degree)]).map(|(c, t)| c * t).sum()
    }

    pub(super) fn gradient(&self, p: &[f64], degree: usize) -> Vec3 {
        let mut sum = Vec3::zeros();
        for (c, (i, j)) in p.iter().zip(exponents(degree)) {
            let l = degree - i - j;
            sum.x += c * self.values[index([i + 1, j, l])];
            sum.y += c * self.values[index([i, j + 1, l])];
            sum.z += c * self.values[index([i, j, l + 1])];
        }
        sum
    }
}

fn lowered(mut e: [usize; 3], axis: usize, by: usize) -> [usize; 3] {
    e[axis] -= by;
    e
}
