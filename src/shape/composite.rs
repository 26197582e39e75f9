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

/// The parts of a composite in their principal frame.
pub(super) struct Assembly {
    pub mass: f64,
    pub parts: Vec<Part>,
    pub inertia: Vec3,
    /// The indices of the parts that are not inside another one.
    pub outer: Vec<usize>,
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
        let without_signs: f64 = input.iter().map(|part| part.mass.abs()).sum();
        // A total that is only the rounding of its terms counts as zero.
        if !(mass > 1e-13 * without_signs && mass.is_finite()) {
            let expected = "a finite sum above zero: the voids take away less than there is";
            return Err(Error::invalid(format!("mass of {name}, the sum of its parts',"), mass, expected));
        }
        let placements: Vec<Placement> = input.iter().map(InputPart::placement).collect();
        let weighted =
            |c: usize| sum(input.iter().zip(&placements).map(|(part, place)| part.mass * place.position[c]));
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

/// Returns the inertia tensor about a point, and the size of the terms that add up to it.
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

/// The distance, relative to the size, by which rounding may move a part that coincides with another one.
const ROOM: f64 = 1e-14;

/// Returns the indices of the parts that are not inside another one; of parts that coincide, only the first
/// one counts.
fn outer(parts: &[Part]) -> Vec<usize> {
    let extended: Vec<usize> =
        (0..parts.len()).filter(|&part| parts[part].shape.circumradius() > 0.0).collect();
    // A part whose centre is not in the box around another part is not inside that part. The margin is twice
    // that for rounding in `inside`.
    let around = |&part: &usize| {
        let (centre, reach) = (parts[part].position(), (1.0 + 2.0 * ROOM) * parts[part].shape.circumradius());
        let rounding = 4.0 * f64::EPSILON * (centre.amax() + reach);
        BoundingBox::of(&[centre.add_scalar(-reach - rounding), centre.add_scalar(reach + rounding)])
    };
    let tree = Tree::new(&extended.iter().map(around).collect::<Vec<_>>());
    let hidden = |k: usize| {
        let hides = |item: u32, _| {
            let other = extended[item as usize];
            let hides = other != k
                && inside(&parts[k], &parts[other])
                && (other < k || !inside(&parts[other], &parts[k]));
            if hides { 0.0 } else { 1.0 }
        };
        let bound = |block: &BoundingBox| if block.distance(&parts[k].position()) > 0.0 { 1.0 } else { 0.0 };
        tree.least(1.0, bound, hides) == 0.0
    };
    (0..parts.len()).filter(|&k| !hidden(k)).collect()
}

/// Returns whether a part is certainly inside another one: where the other one is stretched to a ball, the
/// ball around the part lies within it.
fn inside(part: &Part, other: &Part) -> bool {
    // For a polyhedron as the other part this is not decided, and the answer is always no.
    if let Shape::Polyhedron(_) = other.shape {
        return part.shape == other.shape && part.placement == other.placement;
    }
    let apart = part.position() - other.position();
    if apart.norm() > (1.0 + ROOM) * other.shape.circumradius() {
        return false;
    }
    let stretch = Vec3::from(other.shape.semi_axes()).map(|a| 1.0 / a);
    let into = Mat3::from_diagonal(&stretch) * other.rotation().transpose();
    let centre = into * apart;
    let rotation = into * part.rotation();
    // A point as the other part yields NaN or infinity here, which is not below one.
    if let Shape::Polyhedron(polyhedron) = &part.shape {
        return polyhedron.vertices().all(|v| (centre + rotation * v).norm() <= 1.0 + ROOM);
    }
    let axes = rotation * Mat3::from_diagonal(&Vec3::from(part.shape.semi_axes()));
    centre.norm() + axes.singular_values().max() <= 1.0 + ROOM
}
