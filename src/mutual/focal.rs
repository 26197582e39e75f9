//! The focal rule: a homogeneous ellipsoid is attracted exactly as its focal ellipse is.
//!
//! Outside itself, an ellipsoid (a >= b >= c) attracts like its focal ellipse, x^2/(a^2-c^2) + y^2/(b^2-c^2) <= 1,
//! carrying mass in proportion to sqrt(1 - x^2/(a^2-c^2) - y^2/(b^2-c^2)): Maclaurin's theorem on confocal ellipsoids,
//! taken to the flattest of the family. By the third law the force, torque and energy of two separate ellipsoids are then
//! the means of the other body's g, r x g and Phi over that ellipse.

use super::{Balance, Roles};
use crate::gravity::FieldKernel;
use crate::math::Vec3;
use crate::math::lanes::Lanes;
use crate::quadrature::Nodes;
use pulp::{Arch, Simd, WithSimd};

/// Force and torques; `focal` are the semi-axes of the focal ellipse that is integrated over.
pub(super) fn force_and_torque(
    arch: Arch,
    kernel: impl FieldKernel,
    nodes: &Nodes,
    focal: [f64; 2],
    roles: &Roles,
) -> Balance {
    let axes = [roles.turn.column(0) * focal[0], roles.turn.column(1) * focal[1]];
    let sums = arch.dispatch(ForceSum { kernel, nodes, origin: roles.origin, axes });
    Balance {
        force: sums.force,
        torque: axes[0].cross(&sums.moment[0]) + axes[1].cross(&sums.moment[1]),
        torque_field: sums.torque_field,
    }
}

/// Mean of Phi over the focal ellipse.
pub(super) fn mean_potential(
    arch: Arch,
    kernel: impl FieldKernel,
    nodes: &Nodes,
    focal: [f64; 2],
    roles: &Roles,
) -> f64 {
    let axes = [roles.turn.column(0) * focal[0], roles.turn.column(1) * focal[1]];
    arch.dispatch(PotentialSum { kernel, nodes, origin: roles.origin, axes })
}

struct ForceSum<'a, K> {
    kernel: K,
    nodes: &'a Nodes,
    origin: Vec3,
    axes: [Vec3; 2],
}

struct Sums {
    /// Mean of g.
    force: Vec3,
    /// Means of y_k g, y the node on the unit disc.
    moment: [Vec3; 2],
    /// Mean of -x cross g.
    torque_field: Vec3,
}

impl<K: FieldKernel> WithSimd for ForceSum<'_, K> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Sums {
        let (y0, _) = S::as_simd_f64s(&self.nodes.points[0]);
        let (y1, _) = S::as_simd_f64s(&self.nodes.points[1]);
        let (weights, _) = S::as_simd_f64s(&self.nodes.weights);
        let splat = |v| Lanes::splat(simd, v);
        let origin = [splat(self.origin.x), splat(self.origin.y), splat(self.origin.z)];
        let axes = self.axes.map(|a| [splat(a.x), splat(a.y), splat(a.z)]);
        let zero = splat(0.0);
        let (mut force, mut moment, mut torque) = ([zero; 3], [[zero; 3]; 2], [zero; 3]);
        for ((&y0, &y1), &w) in y0.iter().zip(y1).zip(weights) {
            let (y0, y1, w) = (Lanes::new(simd, y0), Lanes::new(simd, y1), Lanes::new(simd, w));
            let x = [0, 1, 2].map(|i| axes[0][i].mul_add(y0, axes[1][i].mul_add(y1, origin[i])));
            let field = self.kernel.field(x);
            let wx = [w * x[0], w * x[1], w * x[2]];
            for i in 0..3 {
                let pull = wx[i] * field.rd[i];
                force[i] += pull;
                moment[0][i] = pull.mul_add(y0, moment[0][i]);
                moment[1][i] = pull.mul_add(y1, moment[1][i]);
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                torque[i] = (wx[j] * x[k]).mul_add(field.rd_difference[i], torque[i]);
            }
        }
        let total = |v: [Lanes<S>; 3]| Vec3::new(v[0].reduce_sum(), v[1].reduce_sum(), v[2].reduce_sum());
        Sums { force: -total(force), moment: moment.map(|m| -total(m)), torque_field: total(torque) }
    }
}

struct PotentialSum<'a, K> {
    kernel: K,
    nodes: &'a Nodes,
    origin: Vec3,
    axes: [Vec3; 2],
}

impl<K: FieldKernel> WithSimd for PotentialSum<'_, K> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let (y0, _) = S::as_simd_f64s(&self.nodes.points[0]);
        let (y1, _) = S::as_simd_f64s(&self.nodes.points[1]);
        let (weights, _) = S::as_simd_f64s(&self.nodes.weights);
        let splat = |v| Lanes::splat(simd, v);
        let mut sum = splat(0.0);
        for ((&y0, &y1), &w) in y0.iter().zip(y1).zip(weights) {
            let (y0, y1, w) = (Lanes::new(simd, y0), Lanes::new(simd, y1), Lanes::new(simd, w));
            let x = [0, 1, 2].map(|i| {
                splat(self.axes[0][i]).mul_add(y0, splat(self.axes[1][i]).mul_add(y1, splat(self.origin[i])))
            });
            let (excess, _) = self.kernel.excess_potential(x);
            let r2 = x[0].mul_add(x[0], x[1].mul_add(x[1], x[2] * x[2]));
            sum = w.mul_add(splat(1.0) / r2.sqrt() + excess, sum);
        }
        sum.reduce_sum()
    }
}
