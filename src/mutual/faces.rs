//! The paper's surface integrals over the faces of a polyhedron in the closed field of an ellipsoid, a sphere or a point: force
//! (Eq. 2), torque (Eq. 3) and mutual potential (Eq. 4).
//!
//! On a face the normal n is constant; with (.) the sum over the nodes of all faces, of shares of areas over the volume V,
//!
//!   F = (Phi n),    M = (Phi y cross n),    U = (1/3) (Phi y.n - |y|^2/2 g.n).
//!
//! As over an ellipsoid (see [`super::surface`]) the constant and the linear part of the monopole's potential about the centre are
//! integrated in closed form, and the monopole exerts no torque on its own body.

use super::{Balance, Roles};
use crate::gravity::FieldKernel;
use crate::math::Vec3;
use crate::math::lanes::{BLOCK, Lanes, Total, dot, splat_vector, total_vector};
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

/// A node from the field body's centre, in its canonical frame.
#[inline(always)]
fn place<S: Simd>(y: [Lanes<S>; 3], roles: &Roles) -> [Lanes<S>; 3] {
    let c = |value| y[0].constant(value);
    let mut x = [c(roles.origin.x), c(roles.origin.y), c(roles.origin.z)];
    for i in 0..3 {
        for k in 0..3 {
            x[i] = y[k].mul_add(c(roles.turn[(i, k)]), x[i]);
        }
    }
    x
}

impl<K: FieldKernel> WithSimd for PressureSum<'_, K> {
    /// The sums of the monopole and of the rest.
    type Output = [Sums; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Sums; 2] {
        let splat = |v| Lanes::splat(simd, v);
        let (points, normals) = (&self.nodes.points, &self.nodes.normals);
        let origin = self.roles.origin;
        let inverse_centre = splat(1.0 / origin.norm());
        let inverse_square = inverse_centre * inverse_centre;
        let half_inverse_centre = splat(0.5) * inverse_centre;
        let twice_origin = splat_vector(simd, &(self.roles.turn.transpose() * origin * 2.0));
        let (excess_at_centre, _) = self.kernel.excess_potential(splat_vector(simd, &origin));
        let zero = Total::zero(simd);
        let (mut force, mut torque) = ([[zero; 3]; 2], [[zero; 3]; 2]);
        let [start, count] = blocks::<S>(&self.range);
        let weights = Lanes::blocks(simd, &self.nodes.weights).enumerate();
        for (block, weight) in weights.skip(start).take(count) {
            let y = [
                Lanes::load(simd, &points[0], block),
                Lanes::load(simd, &points[1], block),
                Lanes::load(simd, &points[2], block),
            ];
            let n = [
                Lanes::load(simd, &normals[0], block),
                Lanes::load(simd, &normals[1], block),
                Lanes::load(simd, &normals[2], block),
            ];
            let x = place(y, self.roles);
            let (excess, _) = self.kernel.excess_potential(x);
            // The monopole beyond its linear part, as over an ellipsoid.
            let sum = [y[0] + twice_origin[0], y[1] + twice_origin[1], y[2] + twice_origin[2]];
            let s = dot(x, x).sqrt() * inverse_centre;
            let beyond = dot(y, sum) * inverse_square / (s + splat(1.0));
            let monopole = beyond * beyond * (s + splat(2.0)) / s - dot(y, y) * inverse_square;
            let parts = [weight * (monopole * half_inverse_centre), weight * (excess - excess_at_centre)];
            let lever = [y[1] * n[2] - y[2] * n[1], y[2] * n[0] - y[0] * n[2], y[0] * n[1] - y[1] * n[0]];
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
        let turn = &self.roles.turn;
        let mut total = Total::zero(simd);
        let [start, count] = blocks::<S>(&self.range);
        let weights = Lanes::blocks(simd, &self.nodes.weights).enumerate();
        for (block, weight) in weights.skip(start).take(count) {
            let y = [
                Lanes::load(simd, &points[0], block),
                Lanes::load(simd, &points[1], block),
                Lanes::load(simd, &points[2], block),
            ];
            let n = [
                Lanes::load(simd, &normals[0], block),
                Lanes::load(simd, &normals[1], block),
                Lanes::load(simd, &normals[2], block),
            ];
            let x = place(y, self.roles);
            let (excess, rd) = self.kernel.excess_potential(x);
            let phi = splat(1.0) / dot(x, x).sqrt() + excess;
            // n . g with g_i = -x_i R_i in the field's frame.
            let mut flux = splat(0.0);
            for i in 0..3 {
                let row = [splat(turn[(i, 0)]), splat(turn[(i, 1)]), splat(turn[(i, 2)])];
                flux = (dot(n, row) * x[i]).mul_add(-rd[i], flux);
            }
            let value = phi * dot(y, n) - splat(0.5) * dot(y, y) * flux;
            total.add_product(weight, value);
        }
        total.value() / 3.0
    }
}
