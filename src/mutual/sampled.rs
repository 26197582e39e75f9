//! A body's attraction in the field of a polyhedron, evaluated at single points: its centre, its layer, or
//! its faces.
//!
//! Over a layer or at a centre, force, torque and energy are the means of g, y cross g and Phi (see
//! [`super::means`]); over the faces they are the paper's surface integrals (see [`super::faces`]).

use super::faces::Faces;
use super::rule::{Kernel, Rule};
use super::{Balance, PartGravity, Roles};
use crate::math::{Mat3, Vec3};
use crate::quadrature::{Cell, Nodes};
use pulp::Arch;
use std::ops::Range;

/// Returns Phi and g of the field body at a point relative to its centre.
#[inline]
pub(super) fn field(arch: Arch, body: &PartGravity, kernel: &Kernel, x: &Vec3) -> (f64, Vec3) {
    match (kernel, &body.facets) {
        (Kernel::Layer(layer), _) => {
            let (potential, field, _) = layer.at(arch, x);
            (potential, field)
        }
        (_, Some(facets)) => {
            let at = facets.field(arch, x);
            (at.potential, at.field)
        }
        (_, None) => (f64::NAN, Vec3::repeat(f64::NAN)),
    }
}

/// Returns g of the field body at a point relative to its centre, and dg/dx.
pub(super) fn gradient(arch: Arch, body: &PartGravity, kernel: &Kernel, x: &Vec3) -> (Vec3, Mat3) {
    match (kernel, &body.facets) {
        (Kernel::Layer(layer), _) => {
            let (_, field, gradient) = layer.at(arch, x);
            (field, gradient)
        }
        (_, Some(facets)) => {
            let at = facets.at(arch, x);
            (at.field, at.gradient)
        }
        (_, None) => (Vec3::repeat(f64::NAN), Mat3::repeat(f64::NAN)),
    }
}

pub(super) fn vector(list: &[Vec<f64>; 3], k: usize) -> Vec3 {
    Vec3::new(list[0][k], list[1][k], list[2][k])
}

/// Returns the contribution of some nodes to force and torques.
pub(super) fn force_and_torque(
    arch: Arch,
    body: &PartGravity,
    rule: &Rule,
    roles: &Roles,
    range: Range<usize>,
) -> Balance {
    let nodes = &*rule.nodes;
    let (mut force, mut torque, mut torque_field) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
    for k in range.start..range.end.min(nodes.len()) {
        let y = roles.rotation * vector(&nodes.points, k);
        let x = roles.origin + y;
        let attraction = field(arch, body, &rule.kernel, &x).1 * nodes.weights[k];
        force += attraction;
        torque += y.cross(&attraction);
        torque_field -= x.cross(&attraction);
    }
    Balance { force, torque, torque_field }
}

/// Returns the contribution of some nodes to the mutual potential, positive.
pub(super) fn mutual_potential(
    arch: Arch,
    body: &PartGravity,
    rule: &Rule,
    roles: &Roles,
    range: Range<usize>,
) -> f64 {
    let nodes = &*rule.nodes;
    let potential = |k: usize| {
        field(arch, body, &rule.kernel, &(roles.origin + roles.rotation * vector(&nodes.points, k))).0
    };
    (range.start..range.end.min(nodes.len())).map(|k| nodes.weights[k] * potential(k)).sum()
}

/// Iterates over the points of a cell's rule with their weights.
pub(super) fn points(nodes: &Nodes, cell: &Cell) -> impl Iterator<Item = (Vec3, f64)> {
    let start = Nodes::triangle_start(cell.points);
    let Cell { corners: [a, b, c], share, .. } = *cell;
    (start..start + cell.points * cell.points).map(move |k| {
        let shares = vector(&nodes.points, k);
        (a * shares.x + b * shares.y + c * shares.z, nodes.weights[k] * share)
    })
}

/// Returns the contribution of the cells to force and torques, by the pressure on the faces.
pub(super) fn force_and_torque_over(faces: Faces<'_>, rule: &Rule) -> Balance {
    let Faces { arch, roles, field: body, .. } = faces;
    let (mut force, mut torque) = (Vec3::zeros(), Vec3::zeros());
    let (at_centre, _) = field(arch, body, &rule.kernel, &roles.origin);
    for cell in faces.cells() {
        let normal = roles.rotation * cell.normal;
        for (y, weight) in points(&rule.nodes, &cell) {
            let y = roles.rotation * y;
            let (potential, _) = field(arch, body, &rule.kernel, &(roles.origin + y));
            let pressure = normal * (weight * (potential - at_centre));
            force += pressure;
            torque += y.cross(&pressure);
        }
    }
    Balance { force, torque, torque_field: -(torque + roles.origin.cross(&force)) }
}

/// Returns the contribution of the cells to the mutual potential, positive.
pub(super) fn mutual_potential_over(faces: Faces<'_>, rule: &Rule) -> f64 {
    let Faces { arch, roles, field: body, .. } = faces;
    let mut sum = 0.0;
    for cell in faces.energy_cells() {
        let normal = roles.rotation * cell.normal;
        for (y, weight) in points(&rule.nodes, &cell) {
            let y = roles.rotation * y;
            let (potential, attraction) = field(arch, body, &rule.kernel, &(roles.origin + y));
            sum += weight * (potential * y.dot(&normal) - 0.5 * y.norm_squared() * attraction.dot(&normal));
        }
    }
    sum / 3.0
}
