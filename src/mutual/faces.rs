//! The paper's surface integrals over the faces of a polyhedron in the closed field of an ellipsoid, a sphere
//! or a point: force (Eq. 2), torque (Eq. 3) and mutual potential (Eq. 4).
//!
//! On a face the normal n is constant. With (.) the sum over the nodes of all faces, weighted by areas
//! divided by the volume V,
//!
//!   F = (Phi n),    M = (Phi y cross n),    U = (1/3) (Phi y.n - |y|^2/2 g.n).
//!
//! As over an ellipsoid (see [`super::surface`]) the constant and the linear part of the monopole's potential
//! about the centre are integrated in closed form, and the monopole exerts no torque on its own body.

use super::surface::{BeyondLinear, flux, position_from_field};
use super::{Balance, PartGravity, Roles};
use crate::gravity::FieldKernel;
use crate::math::Vec3;
use crate::math::lanes::{BLOCK, Lanes, Total, cross, dot, load_vector, splat_vector, total_vector};
use crate::quadrature::{Cell, Cells, Demand, Nodes};
use crate::shape::Polyhedron;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// A range of the cells of a body's faces in the field of another body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Faces<'a> {
    pub polyhedron: &'a Polyhedron,
    pub field: &'a PartGravity,
    pub roles: &'a Roles,
    pub nodes: &'a Nodes,
    /// The number of digits of the force that are to be correct.
    pub digits: usize,
    pub range: &'a Range<usize>,
    pub arch: Arch,
}

impl<'a> Faces<'a> {
    /// Returns the cells for the force and the torques.
    #[inline]
    pub fn cells(&self) -> Cells<'a, impl FnMut(&Vec3) -> f64 + use<'a>> {
        self.cells_by(2, self.digits)
    }

    /// Returns the cells for the mutual potential, which integrates the field as well.
    #[inline]
    pub fn energy_cells(&self) -> Cells<'a, impl FnMut(&Vec3) -> f64 + use<'a>> {
        /// The number of additional digits for the energy, since `digits` holds those for the force, which
        /// are somewhat fewer than those of the tolerance.
        const MORE: usize = 2;
        self.cells_by(1, self.digits + MORE)
    }

    /// Returns the cells for the derivatives of force and torques, which integrate the field.
    #[inline]
    pub fn gradient_cells(&self) -> Cells<'a, impl FnMut(&Vec3) -> f64 + use<'a>> {
        self.cells_by(1, self.digits)
    }

    fn cells_by(&self, power: i32, digits: usize) -> Cells<'a, impl FnMut(&Vec3) -> f64 + use<'a>> {
        let Self { polyhedron, field, roles, range, arch, .. } = *self;
        let demand = Demand {
            error: 10.0_f64.powi(-(digits as i32)) / roles.origin.norm_squared(),
            radius: field.shape.circumradius(),
            power: if field.facets.is_some() { power } else { 0 },
        };
        Cells::new(polyhedron, demand, range, move |y| {
            field.singular_distance(arch, &(roles.origin + roles.rotation * y))
        })
    }
}

/// Returns the contribution of the cells to force and torques. Terms in closed form belong to the first cell.
pub(super) fn force_and_torque(kernel: impl FieldKernel, faces: Faces<'_>) -> Balance {
    let roles = faces.roles;
    let [monopole, perturbation] = faces.arch.dispatch(PressureSum { kernel, faces });
    let [force, force_perturbation] = [&monopole, &perturbation].map(|sums| roles.rotation * sums.force);
    let [torque, torque_perturbation] = [&monopole, &perturbation].map(|sums| roles.rotation * sums.torque);
    let r = roles.origin.norm();
    let force = if faces.range.start == 0 { force - roles.origin / r / r / r } else { force };
    Balance {
        force: force + force_perturbation,
        torque: torque + torque_perturbation,
        torque_field: -(torque_perturbation + roles.origin.cross(&force_perturbation)),
    }
}

/// Returns the contribution of the cells to the paper's U of Eq. (4) per unit G m m: a positive number, minus
/// the potential energy.
pub(super) fn mutual_potential(kernel: impl FieldKernel, faces: Faces<'_>) -> f64 {
    faces.arch.dispatch(FaceEnergySum { kernel, faces })
}

/// Returns the blocks of lanes that hold the rule of a cell.
#[inline(always)]
pub(super) fn blocks<S: Simd>(cell: &Cell) -> Range<usize> {
    let (start, points) = (Nodes::triangle_start(cell.points), cell.points * cell.points);
    let start = start / BLOCK * Lanes::<S>::PER_BLOCK;
    start..start + (points * Lanes::<S>::PER_BLOCK).div_ceil(BLOCK)
}

/// Returns the points of a block and their weights: areas divided by the volume.
#[inline(always)]
pub(super) fn points<S: Simd>(
    simd: S,
    nodes: &Nodes,
    cell: &Cell,
    block: usize,
) -> ([Lanes<S>; 3], Lanes<S>) {
    let shares = load_vector(simd, &nodes.points, block);
    let weight = Lanes::load(simd, &nodes.weights, block) * Lanes::splat(simd, cell.share);
    let mut y = [Lanes::splat(simd, 0.0); 3];
    for k in 0..3 {
        let corner = splat_vector(simd, &cell.corners[k]);
        for i in 0..3 {
            y[i] = shares[k].mul_add(corner[i], y[i]);
        }
    }
    (y, weight)
}

struct PressureSum<'a, K> {
    kernel: K,
    faces: Faces<'a>,
}

/// The sums for one part of the potential, in the polyhedron's frame.
struct PressureSums {
    force: Vec3,
    torque: Vec3,
}

impl<K: FieldKernel> WithSimd for PressureSum<'_, K> {
    /// The sums for the monopole and for the perturbation of its potential.
    type Output = [PressureSums; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [PressureSums; 2] {
        let roles = self.faces.roles;
        let origin = splat_vector(simd, &roles.origin);
        let beyond_linear = BeyondLinear::new(simd, roles);
        let (perturbation_at_centre, _) = self.kernel.potential_perturbation(origin);
        let zero = Total::zero(simd);
        let (mut force, mut torque) = ([[zero; 3]; 2], [[zero; 3]; 2]);
        for cell in self.faces.cells() {
            let n = splat_vector(simd, &cell.normal);
            for block in blocks::<S>(&cell) {
                let (y, weight) = points(simd, self.faces.nodes, &cell, block);
                let x = position_from_field(y, roles);
                let (perturbation, _) = self.kernel.potential_perturbation(x);
                let parts =
                    [weight * beyond_linear.at(y, x), weight * (perturbation - perturbation_at_centre)];
                let lever = cross(y, n);
                for (part, f) in parts.into_iter().enumerate() {
                    for i in 0..3 {
                        force[part][i].add_product(f, n[i]);
                        torque[part][i].add_product(f, lever[i]);
                    }
                }
            }
        }
        [
            PressureSums { force: total_vector(force[0]), torque: total_vector(torque[0]) },
            PressureSums { force: total_vector(force[1]), torque: total_vector(torque[1]) },
        ]
    }
}

struct FaceEnergySum<'a, K> {
    kernel: K,
    faces: Faces<'a>,
}

impl<K: FieldKernel> WithSimd for FaceEnergySum<'_, K> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let splat = |v| Lanes::splat(simd, v);
        let roles = self.faces.roles;
        let mut total = Total::zero(simd);
        for cell in self.faces.energy_cells() {
            let n = splat_vector(simd, &cell.normal);
            for block in blocks::<S>(&cell) {
                let (y, weight) = points(simd, self.faces.nodes, &cell, block);
                let x = position_from_field(y, roles);
                let (perturbation, field) = self.kernel.potential_perturbation(x);
                let phi = splat(1.0) / dot(x, x).sqrt() + perturbation;
                let flux = flux(n, x, field.rd, roles);
                let value = phi * dot(y, n) - splat(0.5) * dot(y, y) * flux;
                total.add_product(weight, value);
            }
        }
        total.value() / 3.0
    }
}
