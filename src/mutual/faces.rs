//! The paper's surface integrals over the faces of a polyhedron in the closed field of an ellipsoid, a sphere or a point: force
//! (Eq. 2), torque (Eq. 3) and mutual potential (Eq. 4).
//!
//! On a face the normal n is constant; with (.) the sum over the nodes of all faces, of shares of areas over the volume V,
//!
//!   F = (Phi n),    M = (Phi y cross n),    U = (1/3) (Phi y.n - |y|^2/2 g.n).
//!
//! As over an ellipsoid (see [`super::surface`]) the constant and the linear part of the monopole's potential about the centre are
//! integrated in closed form, and the monopole exerts no torque on its own body.

use super::surface::{BeyondLinear, flux, place};
use super::{Balance, Roles};
use crate::gravity::FieldKernel;
use crate::math::Vec3;
use crate::math::lanes::{BLOCK, Lanes, Total, cross, dot, load_vector, splat_vector, total_vector};
use crate::quadrature::Nodes;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// The share of some nodes, whole blocks of them, in force and torques. What is in closed form belongs to the first.
pub(super) fn force_and_torque(
    arch: Arch,
    kernel: impl FieldKernel,
    nodes: &Nodes,
    roles: &Roles,
    range: Range<usize>,
) -> Balance {
    let first = range.start == 0;
    let [monopole, excess] = arch.dispatch(PressureSum { kernel, nodes, roles, range });
    let [force, force_excess] = [&monopole, &excess].map(|sums| roles.turn * sums.force);
    let [torque, torque_excess] = [&monopole, &excess].map(|sums| roles.turn * sums.torque);
    let r = roles.origin.norm();
    let force = if first { force - roles.origin / r / r / r } else { force };
    Balance {
        force: force + force_excess,
        torque: torque + torque_excess,
        torque_field: -(torque_excess + roles.origin.cross(&force_excess)),
    }
}

/// The share of some nodes in the paper's U of Eq. (4) per unit G m m: a positive number, minus the potential energy.
pub(super) fn mutual_potential(
    arch: Arch,
    kernel: impl FieldKernel,
    nodes: &Nodes,
    roles: &Roles,
    range: Range<usize>,
) -> f64 {
    arch.dispatch(EnergySum { kernel, nodes, roles, range })
}

/// The blocks of lanes of a range of nodes.
#[inline(always)]
fn blocks<S: Simd>(range: &Range<usize>) -> [usize; 2] {
    let start = range.start / BLOCK * Lanes::<S>::PER_BLOCK;
    [start, range.end.div_ceil(BLOCK) * Lanes::<S>::PER_BLOCK - start]
}

struct PressureSum<'a, K> {
    kernel: K,
    nodes: &'a Nodes,
    roles: &'a Roles,
    range: Range<usize>,
}

/// The sums of a part of the potential, in the polyhedron's frame.
struct Sums {
    force: Vec3,
    torque: Vec3,
}

impl<K: FieldKernel> WithSimd for PressureSum<'_, K> {
    /// The sums of the monopole and of the rest.
    type Output = [Sums; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Sums; 2] {
        let (points, normals) = (&self.nodes.points, &self.nodes.normals);
        let origin = splat_vector(simd, &self.roles.origin);
        let beyond_linear = BeyondLinear::new(simd, self.roles);
        let (excess_at_centre, _) = self.kernel.excess_potential(origin);
        let zero = Total::zero(simd);
        let (mut force, mut torque) = ([[zero; 3]; 2], [[zero; 3]; 2]);
        let [start, count] = blocks::<S>(&self.range);
        let weights = Lanes::blocks(simd, &self.nodes.weights).enumerate();
        for (block, weight) in weights.skip(start).take(count) {
            let y = load_vector(simd, points, block);
            let n = load_vector(simd, normals, block);
            let x = place(y, self.roles);
            let (excess, _) = self.kernel.excess_potential(x);
            let parts = [weight * beyond_linear.at(y, x), weight * (excess - excess_at_centre)];
            let lever = cross(y, n);
            for (part, f) in parts.into_iter().enumerate() {
                for i in 0..3 {
                    force[part][i].add_product(f, n[i]);
                    torque[part][i].add_product(f, lever[i]);
                }
            }
        }
        [
            Sums { force: total_vector(force[0]), torque: total_vector(torque[0]) },
            Sums { force: total_vector(force[1]), torque: total_vector(torque[1]) },
        ]
    }
}

struct EnergySum<'a, K> {
    kernel: K,
    nodes: &'a Nodes,
    roles: &'a Roles,
    range: Range<usize>,
}

impl<K: FieldKernel> WithSimd for EnergySum<'_, K> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let splat = |v| Lanes::splat(simd, v);
        let (points, normals) = (&self.nodes.points, &self.nodes.normals);
        let mut total = Total::zero(simd);
        let [start, count] = blocks::<S>(&self.range);
        let weights = Lanes::blocks(simd, &self.nodes.weights).enumerate();
        for (block, weight) in weights.skip(start).take(count) {
            let y = load_vector(simd, points, block);
            let n = load_vector(simd, normals, block);
            let x = place(y, self.roles);
            let (excess, field) = self.kernel.excess_potential(x);
            let phi = splat(1.0) / dot(x, x).sqrt() + excess;
            let flux = flux(n, x, field.rd, self.roles);
            let value = phi * dot(y, n) - splat(0.5) * dot(y, y) * flux;
            total.add_product(weight, value);
        }
        total.value() / 3.0
    }
}
