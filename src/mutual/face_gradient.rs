//! The derivatives of force and torques as sums over the faces of a polyhedron, by the other body's potential
//! and field alone.
//!
//! With (.) the sum of [`super::faces`], n the normals, z the arms from the polyhedron's centre, x = o + z
//! and g the field, the force is F = (Phi n) and the torque M = (Phi z cross n). A displacement of o by do
//! changes Phi by g.do. A rotation of the polyhedron by alpha changes Phi by alpha.(z cross g) and rotates n
//! and z too. A change of all lengths by ds at constant mass changes Phi by g.z ds. It follows that
//!
//! ```text
//! dF/do = (n g^T),   dF/dalpha = (n (z x g)^T) - [F]x,   dM/dalpha = ((z x n) (z x g)^T) - [M]x,
//! dF/ds = (g.z n) - F,   dM/ds = (g.z z x n).
//! ```
//!
//! Both loads are derivatives of one potential, so that (n g^T) is symmetric and the antisymmetric part of
//! the third sum is \[M\]x / 2. The code takes the symmetric parts of the sums, so that transition matrices
//! are symplectic at any tolerance. The field body's torque follows from M + N + o x F = 0.
//!
//! The semi-axes of an ellipsoid act through its potential: with R_i and R_ij of [`crate::gravity`],
//! dPhi/da_i = a_i (3/2 x_i^2 R_ii - 1/2 R_i + 1/2 sum over k other than i of x_k^2 R_ik).

use super::faces::{Faces, blocks, points};
use super::gradient::CanonicalJacobian;
use super::rule::Rule;
use super::surface::position_from_field;
use super::{Balance, Roles, sampled};
use crate::gravity::FieldKernel;
use crate::math::lanes::{Lanes, Total, cross, dot, splat_vector, total_matrix, total_vector};
use crate::math::matrix::cross_times;
use crate::math::{Mat3, Vec3};
use pulp::{Scalar, Simd, WithSimd};
use std::ops::AddAssign;

/// The sums over some cells, in the field body's canonical frame.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FaceSums {
    /// The sum (Phi n), where Phi is relative to its value at the polyhedron's centre.
    force: Vec3,
    /// The sum (Phi z x n).
    torque: Vec3,
    /// The sum (n g^T).
    by_position: Mat3,
    /// The sum (n (z x g)^T).
    by_rotation: Mat3,
    /// The sum ((z x n) (z x g)^T).
    torque_by_rotation: Mat3,
    /// The sums (g.z n) and (g.z z x n).
    by_scale: [Vec3; 2],
}

impl AddAssign for FaceSums {
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.torque += other.torque;
        self.by_position += other.by_position;
        self.by_rotation += other.by_rotation;
        self.torque_by_rotation += other.torque_by_rotation;
        (0..2).for_each(|k| self.by_scale[k] += other.by_scale[k]);
    }
}

impl FaceSums {
    /// Returns the derivatives from the sums over all cells.
    pub fn jacobian(&self, roles: &Roles) -> CanonicalJacobian {
        let symmetric = |m: &Mat3| 0.5 * (m + m.transpose());
        let (force, torque) = (self.force, self.torque);
        let force_by_position = symmetric(&self.by_position);
        let force_by_rotation = self.by_rotation - force.cross_matrix();
        let torque_by_rotation = symmetric(&self.torque_by_rotation) - 0.5 * torque.cross_matrix();
        let on_field = |torque: &Vec3, force: &Vec3| -(torque + roles.origin.cross(force));
        let by_scale = [self.by_scale[0] - force, self.by_scale[1]];
        CanonicalJacobian {
            balance: Balance { force, torque, torque_field: on_field(&torque, &force) },
            force_by_position,
            force_by_rotation,
            torque_by_rotation,
            field_by_position: force.cross_matrix()
                - force_by_rotation.transpose()
                - cross_times(&roles.origin, &force_by_position),
            field_by_rotation: -(torque_by_rotation + cross_times(&roles.origin, &force_by_rotation)),
            by_scale: Balance {
                force: by_scale[0],
                torque: by_scale[1],
                torque_field: on_field(&by_scale[1], &by_scale[0]),
            },
        }
    }
}

/// The running sums over the points.
struct FaceAccumulator<S: Simd> {
    force: [Total<S>; 3],
    torque: [Total<S>; 3],
    by_position: [[Total<S>; 3]; 3],
    by_rotation: [[Total<S>; 3]; 3],
    torque_by_rotation: [[Total<S>; 3]; 3],
    by_scale: [[Total<S>; 3]; 2],
}

impl<S: Simd> FaceAccumulator<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        let zero = [Total::zero(simd); 3];
        Self {
            force: zero,
            torque: zero,
            by_position: [zero; 3],
            by_rotation: [zero; 3],
            torque_by_rotation: [zero; 3],
            by_scale: [zero; 2],
        }
    }

    /// Adds points with their weights, potentials, arms, normals and fields.
    #[inline(always)]
    fn add<const N: usize>(
        &mut self,
        weight: Lanes<S, N>,
        potential: Lanes<S, N>,
        z: [Lanes<S, N>; 3],
        n: [Lanes<S, N>; 3],
        g: [Lanes<S, N>; 3],
    ) {
        let (lever, torque) = (cross(z, n), cross(z, g));
        let (pressure, growth) = (weight * potential, weight * dot(g, z));
        for i in 0..3 {
            self.force[i].add_product(pressure, n[i]);
            self.torque[i].add_product(pressure, lever[i]);
            self.by_scale[0][i].add_product(growth, n[i]);
            self.by_scale[1][i].add_product(growth, lever[i]);
            let (area, moment) = (weight * n[i], weight * lever[i]);
            for j in 0..3 {
                self.by_position[i][j].add_product(area, g[j]);
                self.by_rotation[i][j].add_product(area, torque[j]);
                self.torque_by_rotation[i][j].add_product(moment, torque[j]);
            }
        }
    }

    #[inline(always)]
    fn sums(self) -> FaceSums {
        FaceSums {
            force: total_vector(self.force),
            torque: total_vector(self.torque),
            by_position: total_matrix(self.by_position),
            by_rotation: total_matrix(self.by_rotation),
            torque_by_rotation: total_matrix(self.torque_by_rotation),
            by_scale: [total_vector(self.by_scale[0]), total_vector(self.by_scale[1])],
        }
    }
}

/// Returns the sums over the cells in the field of an ellipsoid, a sphere or a point.
pub(super) fn sums(kernel: impl FieldKernel, faces: Faces<'_>) -> FaceSums {
    faces.arch.dispatch(FaceGradientSum { kernel, faces })
}

/// Returns the sums over the cells in the field of another polyhedron.
pub(super) fn sums_beside_polyhedron(faces: Faces<'_>, rule: &Rule) -> FaceSums {
    let Faces { arch, roles, field, .. } = faces;
    let mut running = FaceAccumulator::new(Scalar);
    let lane = |value: f64| Lanes::<Scalar, 1>::splat(Scalar, value);
    let (at_centre, _) = sampled::field(arch, field, &rule.kernel, &roles.origin);
    for cell in faces.gradient_cells() {
        let n = splat_vector(Scalar, &(roles.rotation * cell.normal));
        for (y, weight) in sampled::points(&rule.nodes, &cell) {
            let z = roles.rotation * y;
            let (potential, g) = sampled::field(arch, field, &rule.kernel, &(roles.origin + z));
            let (z, g) = (splat_vector(Scalar, &z), splat_vector(Scalar, &g));
            running.add(lane(weight), lane(potential - at_centre), z, n, g);
        }
    }
    running.sums()
}

struct FaceGradientSum<'a, K> {
    kernel: K,
    faces: Faces<'a>,
}

impl<K: FieldKernel> WithSimd for FaceGradientSum<'_, K> {
    type Output = FaceSums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> FaceSums {
        let roles = self.faces.roles;
        let origin: [Lanes<S>; 3] = splat_vector(simd, &roles.origin);
        let at_centre = self.kernel.potential(origin);
        let mut running = FaceAccumulator::new(simd);
        for cell in self.faces.gradient_cells() {
            let n = splat_vector(simd, &(roles.rotation * cell.normal));
            for block in blocks::<S>(&cell) {
                let (y, weight) = points(simd, self.faces.nodes, &cell, block);
                let x = position_from_field(y, roles);
                let (perturbation, field) = self.kernel.potential_perturbation(x);
                let potential = weight.constant(1.0) / dot(x, x).sqrt() + perturbation - at_centre;
                let z = [x[0] - origin[0], x[1] - origin[1], x[2] - origin[2]];
                let g = [-(x[0] * field.rd[0]), -(x[1] * field.rd[1]), -(x[2] * field.rd[2])];
                running.add(weight, potential, z, n, g);
            }
        }
        running.sums()
    }
}

/// Returns the contribution of the cells to the derivatives of the loads with respect to the semi-axes of the
/// field body.
pub(super) fn semi_axis_derivatives(kernel: impl FieldKernel, faces: Faces<'_>) -> [[Vec3; 2]; 3] {
    faces.arch.dispatch(FaceAxisSum { kernel, faces })
}

struct FaceAxisSum<'a, K> {
    kernel: K,
    faces: Faces<'a>,
}

impl<K: FieldKernel> WithSimd for FaceAxisSum<'_, K> {
    /// The force and the torque on the polyhedron, for each semi-axis.
    type Output = [[Vec3; 2]; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [[Vec3; 2]; 3] {
        let roles = self.faces.roles;
        let origin: [Lanes<S>; 3] = splat_vector(simd, &roles.origin);
        let zero = Total::zero(simd);
        let mut totals = [[[zero; 3]; 2]; 3];
        for cell in self.faces.gradient_cells() {
            let n = splat_vector(simd, &(roles.rotation * cell.normal));
            for block in blocks::<S>(&cell) {
                let (y, weight) = points(simd, self.faces.nodes, &cell, block);
                let x = position_from_field(y, roles);
                let (field, second) = self.kernel.second_integrals(x);
                let potential = field.potential_by_axes(x, second);
                let lever = cross([x[0] - origin[0], x[1] - origin[1], x[2] - origin[2]], n);
                for axis in 0..3 {
                    let pressure = weight * potential[axis];
                    for i in 0..3 {
                        totals[axis][0][i].add_product(pressure, n[i]);
                        totals[axis][1][i].add_product(pressure, lever[i]);
                    }
                }
            }
        }
        let mut sums = [[Vec3::zeros(); 2]; 3];
        for axis in 0..3 {
            for k in 0..2 {
                sums[axis][k] = total_vector(totals[axis][k]);
            }
        }
        sums
    }
}
