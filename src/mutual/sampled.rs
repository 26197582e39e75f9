//! A body's attraction in the field of a polyhedron, taken at single points: its centre, its layer, or its faces.
//!
//! Over a layer or at a centre force, torque and energy are the means of g, y cross g and Phi (see [`super::means`]); over the faces
//! they are the paper's surface integrals (see [`super::faces`]).

use super::rule::{Kernel, Rule};
use super::store::Carrier;
use super::{Balance, BodyGravity, Roles};
use crate::math::Vec3;
use pulp::Arch;
use std::ops::Range;

/// Phi and g of the field body at a point from its centre.
#[inline]
fn field(arch: Arch, body: &BodyGravity, kernel: &Kernel, x: &Vec3) -> (f64, Vec3) {
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

fn vector(list: &[Vec<f64>; 3], k: usize) -> Vec3 {
    Vec3::new(list[0][k], list[1][k], list[2][k])
}

/// The share of some nodes in force and torques.
pub(super) fn force_and_torque(
    arch: Arch,
    body: &BodyGravity,
    rule: &Rule,
    roles: &Roles,
    range: Range<usize>,
) -> Balance {
    let nodes = &*rule.nodes;
    let (mut force, mut torque, mut torque_field) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
    let over_faces = rule.carrier == Carrier::Faces;
    let at_centre = if over_faces { field(arch, body, &rule.kernel, &roles.origin).0 } else { 0.0 };
    for k in range.start..range.end.min(nodes.len()) {
        let y = roles.turn * vector(&nodes.points, k);
        let x = roles.origin + y;
        let (potential, pull) = field(arch, body, &rule.kernel, &x);
        if over_faces {
            let pressure =
                roles.turn * vector(&nodes.normals, k) * (nodes.weights[k] * (potential - at_centre));
            force += pressure;
            torque += y.cross(&pressure);
        } else {
            let pull = pull * nodes.weights[k];
            force += pull;
            torque += y.cross(&pull);
            torque_field -= x.cross(&pull);
        }
    }
    if over_faces {
        torque_field = -(torque + roles.origin.cross(&force));
    }
    Balance { force, torque, torque_field }
}

/// The share of some nodes in the mutual potential, positive.
pub(super) fn mutual_potential(
    arch: Arch,
    body: &BodyGravity,
    rule: &Rule,
    roles: &Roles,
    range: Range<usize>,
) -> f64 {
    let nodes = &*rule.nodes;
    let mut sum = 0.0;
    for k in range.start..range.end.min(nodes.len()) {
        let y = roles.turn * vector(&nodes.points, k);
        let (potential, pull) = field(arch, body, &rule.kernel, &(roles.origin + y));
        sum += nodes.weights[k]
            * if rule.carrier == Carrier::Faces {
                let n = roles.turn * vector(&nodes.normals, k);
                (potential * y.dot(&n) - 0.5 * y.norm_squared() * pull.dot(&n)) / 3.0
            } else {
                potential
            };
    }
    sum
}
