//! Composites: several parts that are rigid together, whose densities add where the parts overlap.
//!
//! The parts are given in a working frame, which the caller chooses freely. The body frame is their principal
//! frame: see [`super::frame`].

use super::frame::{WorkingFrame, check_inertia, principal_axes, quaternion};
use super::tree::{BoundingBox, Tree};
use super::{InputPart, Part, Placement, Shape};
use crate::error::{Error, Result};
use crate::math::compensated::sum;
use crate::math::{Mat3, Vec3};
use std::convert::Infallible;

/// The parts of a composite in their principal frame.
pub(super) struct Assembly {
    pub mass: f64,
    pub parts: Vec<Part>,
    /// The principal moments of inertia.
    pub inertia: Vec3,
    /// The indices of the parts that are not inside another one.
    pub outer: Vec<usize>,
    /// The working frame, seen from the principal frame.
    pub frame: WorkingFrame,
}

impl Assembly {
    /// Assembles the parts; `name` is the body's name in error messages.
    pub fn new(name: &str, input: &[InputPart]) -> Result<Self> {
        if input.is_empty() {
            return Err(Error::invalid(format!("number of parts of {name}"), 0, "at least one"));
        }
        for (index, part) in input.iter().enumerate() {
            part.check(&format!("part {index} of {name}"))?;
        }
        let mass = sum(input.iter().map(|part| part.mass));
        let sum_of_magnitudes: f64 = input.iter().map(|part| part.mass.abs()).sum();
        // A sum that is no larger than the rounding errors of its terms counts as zero.
        if !(mass > 1e-13 * sum_of_magnitudes && mass.is_finite()) {
            let expected = "a finite sum above zero: the voids take away less than there is";
            return Err(Error::invalid(format!("mass of {name}, the sum of its parts',"), mass, expected));
        }
        let placements: Vec<Placement> = input.iter().map(InputPart::placement).collect();
        let weighted = |c: usize| {
            sum(input.iter().zip(&placements).map(|(part, placement)| part.mass * placement.position[c]))
        };
        let centre = Vec3::new(weighted(0), weighted(1), weighted(2)) / mass;
        let (tensor, size) = inertia(input, &placements, &centre);
        let axes = principal_axes(&tensor, size);
        let inertia = (axes * tensor * axes.transpose()).diagonal();
        check_inertia(name, &inertia, size)?;
        let parts: Vec<Part> = input
            .iter()
            .zip(&placements)
            .map(|(part, placement)| Part {
                shape: part.shape.clone(),
                mass: part.mass,
                placement: Some(Placement {
                    position: axes * (placement.position - centre),
                    rotation: axes * placement.rotation,
                }),
            })
            .collect();
        let frame = WorkingFrame { position: Vec3::zeros() - axes * centre, attitude: quaternion(&axes) };
        Ok(Self { mass, inertia, outer: outer(&parts), parts, frame })
    }
}

/// Returns the inertia tensor about a point in the working frame, and the sum of the magnitudes of its terms.
fn inertia(input: &[InputPart], placements: &[Placement], centre: &Vec3) -> (Mat3, f64) {
    let mut tensors = Vec::with_capacity(input.len());
    let mut size = 0.0;
    for (part, placement) in input.iter().zip(placements) {
        let central = part.shape.inertia_tensor_per_mass();
        let arm = placement.position - centre;
        let shifted = Mat3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose();
        let tensor = (placement.rotation * central * placement.rotation.transpose() + shifted) * part.mass;
        size += tensor.trace().abs();
        tensors.push(tensor);
    }
    let tensor = Mat3::from_fn(|i, j| sum(tensors.iter().map(|t| 0.5 * (t[(i, j)] + t[(j, i)]))));
    (tensor, size)
}

/// The relative tolerance for rounding errors with which a part that coincides with another one is inside it.
const ROOM: f64 = 1e-14;

/// Returns the indices of the parts that are not inside another one; of parts that coincide, only the first
/// one counts.
fn outer(parts: &[Part]) -> Vec<usize> {
    let extended: Vec<usize> =
        (0..parts.len()).filter(|&part| parts[part].shape.circumradius() > 0.0).collect();
    // A part whose centre is outside the bounding box of another part is not inside that part. The margin is
    // twice the tolerance in `inside`.
    let bounding_box = |&part: &usize| {
        let (centre, reach) = (parts[part].position(), (1.0 + 2.0 * ROOM) * parts[part].shape.circumradius());
        let rounding = 4.0 * f64::EPSILON * (centre.amax() + reach);
        BoundingBox::around(&[centre.add_scalar(-reach - rounding), centre.add_scalar(reach + rounding)])
    };
    let tree = Tree::new(&extended.iter().map(bounding_box).collect::<Vec<_>>());
    let hidden = |k: usize| {
        let not_hidden_by = |item: u32, _| {
            let other = extended[item as usize];
            let hides = other != k
                && inside(&parts[k], &parts[other])
                && (other < k || !inside(&parts[other], &parts[k]));
            Ok::<f64, Infallible>(if hides { 0.0 } else { 1.0 })
        };
        let bound = |block: &BoundingBox| if block.distance(&parts[k].position()) > 0.0 { 1.0 } else { 0.0 };
        let Ok(least) = tree.least(1.0, bound, not_hidden_by);
        least == 0.0
    };
    (0..parts.len()).filter(|&k| !hidden(k)).collect()
}

/// Returns whether a part is certainly inside another one: in coordinates in which the other one is the unit
/// ball, the part, or a ball around it, is within the unit ball.
fn inside(part: &Part, other: &Part) -> bool {
    // Whether a part is inside a polyhedron is not computed; only coinciding polyhedra are recognised.
    if let Shape::Polyhedron(_) = other.shape {
        return part.shape == other.shape && part.placement == other.placement;
    }
    let offset = part.position() - other.position();
    if offset.norm() > (1.0 + ROOM) * other.shape.circumradius() {
        return false;
    }
    let stretch = Vec3::from(other.shape.semi_axes()).map(|a| 1.0 / a);
    let to_unit_ball = Mat3::from_diagonal(&stretch) * other.rotation().transpose();
    let centre = to_unit_ball * offset;
    let rotation = to_unit_ball * part.rotation();
    // If the other part is a point, the values are NaN or infinite, and the comparisons below are false.
    if let Shape::Polyhedron(polyhedron) = &part.shape {
        return polyhedron.vertices().all(|v| (centre + rotation * v).norm() <= 1.0 + ROOM);
    }
    let axes = rotation * Mat3::from_diagonal(&Vec3::from(part.shape.semi_axes()));
    centre.norm() + axes.singular_values().max() <= 1.0 + ROOM
}
