//! The focal rule: a homogeneous ellipsoid is attracted exactly as its focal ellipse is.
//!
//! Outside itself, an ellipsoid (a >= b >= c) attracts like its focal ellipse, x^2/(a^2-c^2) + y^2/(b^2-c^2) <= 1,
//! carrying mass in proportion to sqrt(1 - x^2/(a^2-c^2) - y^2/(b^2-c^2)): Maclaurin's theorem on confocal ellipsoids,
//! taken to the flattest of the family. By the third law the force, torque and energy of two separate ellipsoids are then
//! the means of the other body's g, r x g and Phi over that ellipse.

use super::{Balance, Roles};
use crate::gravity::FieldKernel;
use crate::math::Vec3;
use crate::math::lanes::{Lanes, Total, dot, splat_vector, total_vector};
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
        let [y0, y1, _] = &self.nodes.points;
        let (y0, y1) = (Lanes::blocks(simd, y0), Lanes::blocks(simd, y1));
        let weights = Lanes::blocks(simd, &self.nodes.weights);
        let origin = splat_vector(simd, &self.origin);
        let axes = [splat_vector(simd, &self.axes[0]), splat_vector(simd, &self.axes[1])];
        let zero = Total::zero(simd);
        let (mut force, mut moment, mut torque) = ([zero; 3], [[zero; 3]; 2], [zero; 3]);
        for ((y0, y1), w) in y0.zip(y1).zip(weights) {
            let x = place(axes, y0, y1, origin);
            let field = self.kernel.field(x);
            let wx = [w * x[0], w * x[1], w * x[2]];
            for i in 0..3 {
                let pull = wx[i] * field.rd[i];
                force[i].add_product(wx[i], field.rd[i]);
                moment[0][i].add_product(pull, y0);
                moment[1][i].add_product(pull, y1);
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                torque[i].add_product(wx[j] * x[k], field.rd_difference[i]);
            }
        }
        Sums {
            force: -total_vector(force),
            moment: [-total_vector(moment[0]), -total_vector(moment[1])],
            torque_field: total_vector(torque),
        }
    }
}

/// The node (y0, y1) of the unit disc, from the field body's centre.
#[inline(always)]
fn place<S: Simd>(
    axes: [[Lanes<S>; 3]; 2],
    y0: Lanes<S>,
    y1: Lanes<S>,
    origin: [Lanes<S>; 3],
) -> [Lanes<S>; 3] {
    [
        axes[0][0].mul_add(y0, axes[1][0].mul_add(y1, origin[0])),
        axes[0][1].mul_add(y0, axes[1][1].mul_add(y1, origin[1])),
        axes[0][2].mul_add(y0, axes[1][2].mul_add(y1, origin[2])),
    ]
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
        let [y0, y1, _] = &self.nodes.points;
        let (y0, y1) = (Lanes::blocks(simd, y0), Lanes::blocks(simd, y1));
        let weights = Lanes::blocks(simd, &self.nodes.weights);
        let origin = splat_vector(simd, &self.origin);
        let axes = [splat_vector(simd, &self.axes[0]), splat_vector(simd, &self.axes[1])];
        let mut sum = Total::zero(simd);
        for ((y0, y1), w) in y0.zip(y1).zip(weights) {
            let x = place(axes, y0, y1, origin);
            let (excess, _) = self.kernel.excess_potential(x);
            sum.add_product(w, w.constant(1.0) / dot(x, x).sqrt() + excess);
        }
        sum.value()
    }
}
