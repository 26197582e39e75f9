//! Composites: several parts that are rigid together, of densities that add where the parts overlap.
//!
//! The parts are given in a working frame, which is any. The body frame is their principal frame, turned as little as possible
//! from the working frame: of all ways to name and to direct the principal axes the one for which the axes of both frames are
//! nearest to each other (the trace of the rotation is largest). Where two moments of inertia are equal, only the third axis is
//! turned, on the shortest way; where all are, nothing is. A composite that is given in a principal frame therefore keeps it.

use super::{GivenPart, Part, Place};
use crate::error::{Error, Result};
use crate::math::compensated::sum;
use crate::math::{Mat3, Vec3};
use nalgebra::{Rotation3, SymmetricEigen, UnitQuaternion};

/// Products of inertia and differences of its moments smaller than this share of what adds up to them are rounding.
const ROUNDING: f64 = 1e-14;

/// Where the working frame of a composite lies in its body frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkingFrame {
    /// Its origin.
    pub position: Vec3,
    /// Quaternion that turns its vectors into those of the body frame.
    pub attitude: [f64; 4],
}

/// The parts in their principal frame.
pub(super) struct Assembly {
    pub mass: f64,
    pub parts: Vec<Part>,
    pub inertia: Vec3,
    /// Places of the parts that are not inside another one.
    pub outer: Vec<usize>,
    pub frame: WorkingFrame,
}

impl Assembly {
    /// The name is for errors.
    pub fn new(name: &str, given: &[GivenPart]) -> Result<Self> {
        if given.is_empty() {
            return Err(Error::invalid(format!("number of parts of {name}"), 0, "at least one"));
        }
        for (index, part) in given.iter().enumerate() {
            part.check(&format!("part {index} of {name}"))?;
        }
        let mass = sum(given.iter().map(|part| part.mass));
        let without_signs: f64 = given.iter().map(|part| part.mass.abs()).sum();
        // A total that is only the rounding of its terms is none.
        if !(mass > 1e-13 * without_signs && mass.is_finite()) {
            let expected = "a finite sum above zero: the voids take away less than there is";
            return Err(Error::invalid(format!("mass of {name}, the sum of its parts',"), mass, expected));
        }
        let places: Vec<Place> = given.iter().map(GivenPart::place).collect();
        let weighted =
            |c: usize| sum(given.iter().zip(&places).map(|(part, place)| part.mass * place.position[c]));
        let centre = Vec3::new(weighted(0), weighted(1), weighted(2)) / mass;
        let (tensor, size) = inertia(given, &places, &centre);
        let axes = principal_axes(&tensor, size);
        let inertia = (axes * tensor * axes.transpose()).diagonal();
        check_inertia(name, &inertia, size)?;
        let parts: Vec<Part> = given
            .iter()
            .zip(&places)
            .map(|(part, place)| Part {
                shape: part.shape.clone(),
                mass: part.mass,
                place: Some(Place {
                    position: axes * (place.position - centre),
                    rotation: axes * place.rotation,
                }),
            })
            .collect();
        let frame = WorkingFrame { position: Vec3::zeros() - axes * centre, attitude: quaternion(&axes) };
        Ok(Self { mass, inertia, outer: outer(&parts), parts, frame })
    }
}

/// The inertia tensor about a point, and the size of what adds up to it.
fn inertia(given: &[GivenPart], places: &[Place], centre: &Vec3) -> (Mat3, f64) {
    let mut tensors = Vec::with_capacity(given.len());
    let mut size = 0.0;
    for (part, place) in given.iter().zip(places) {
        let own = part.shape.inertia_tensor_per_mass();
        let arm = place.position - centre;
        let shifted = Mat3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose();
        let tensor = (place.rotation * own * place.rotation.transpose() + shifted) * part.mass;
        size += tensor.trace().abs();
        tensors.push(tensor);
    }
    let tensor = Mat3::from_fn(|i, j| sum(tensors.iter().map(|t| 0.5 * (t[(i, j)] + t[(j, i)]))));
    (tensor, size)
}

/// Refuses moments of inertia that no body has.
fn check_inertia(name: &str, inertia: &Vec3, size: f64) -> Result<()> {
    let largest = inertia.max();
    let refuse = |expected: &str| {
        let found = format!("[{}, {}, {}]", inertia.x, inertia.y, inertia.z);
        Err(Error::invalid(format!("moments of inertia of {name}"), found, expected))
    };
    if !inertia.iter().all(|moment| *moment > ROUNDING * size && moment.is_finite()) {
        return refuse(
            "finite numbers above zero: parts with extent or points that are not on one line, and no void beside them",
        );
    }
    if 2.0 * largest - inertia.sum() > ROUNDING * size {
        return refuse("none above the sum of the other two: the voids take away more than there is");
    }
    Ok(())
}

/// The rotation from the working frame into the principal frame.
fn principal_axes(tensor: &Mat3, size: f64) -> Mat3 {
    let small = ROUNDING * size;
    if tensor[(0, 1)].abs().max(tensor[(1, 2)].abs()).max(tensor[(0, 2)].abs()) <= small {
        return Mat3::identity();
    }
    let eigen = SymmetricEigen::new(tensor / size);
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    let [low, middle, high] = order.map(|k| eigen.eigenvalues[k] * size);
    let vector = |k: usize| eigen.eigenvectors.column(order[k]).into_owned();
    match (middle - low <= small, high - middle <= small) {
        (true, true) => Mat3::identity(),
        (true, false) => turned_least_about(vector(2)),
        (false, true) => turned_least_about(vector(0)),
        (false, false) => nearest_frame([vector(0), vector(1), vector(2)]),
    }
}

/// The smallest turn that makes the nearest axis of the working frame one along this vector.
fn turned_least_about(vector: Vec3) -> Mat3 {
    let axis = vector.iamax();
    let along = vector * vector[axis].signum();
    let mut unit = Vec3::zeros();
    unit[axis] = 1.0;
    // The two are less than 60 degrees apart.
    Rotation3::rotation_between(&along, &unit).map_or_else(Mat3::identity, |turn| turn.into_inner())
}

/// The frame along these three vectors, named and directed so that it is nearest to the working frame.
fn nearest_frame(vectors: [Vec3; 3]) -> Mat3 {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let mut best = Mat3::identity();
    let mut trace = f64::NEG_INFINITY;
    for order in ORDERS {
        let mut axes = [0, 1, 2].map(|k| vectors[order[k]] * vectors[order[k]][k].signum());
        if axes[0].cross(&axes[1]).dot(&axes[2]) < 0.0 {
            let least = (1..3).fold(0, |least, k| if axes[k][k] < axes[least][least] { k } else { least });
            axes[least] = -axes[least];
        }
        let sum = axes[0].x + axes[1].y + axes[2].z;
        if sum > trace {
            trace = sum;
            best = Mat3::from_columns(&axes).transpose();
        }
    }
    best
}

fn quaternion(rotation: &Mat3) -> [f64; 4] {
    if *rotation == Mat3::identity() {
        return [1.0, 0.0, 0.0, 0.0];
    }
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    [q.w, q.i, q.j, q.k]
}

/// Places of the parts that are not inside another one; of parts that coincide the first.
fn outer(parts: &[Part]) -> Vec<usize> {
    let extended: Vec<usize> =
        (0..parts.len()).filter(|&part| parts[part].shape.circumradius() > 0.0).collect();
    let hidden = |k: usize| {
        extended.iter().any(|&other| {
            other != k && inside(&parts[k], &parts[other]) && (other < k || !inside(&parts[other], &parts[k]))
        })
    };
    (0..parts.len()).filter(|&k| !hidden(k)).collect()
}

/// Whether a part is surely inside another one: the ball around it is, where the other one is stretched to a ball.
fn inside(part: &Part, other: &Part) -> bool {
    /// By how much rounding may move a part that coincides with another one.
    const ROOM: f64 = 1e-14;
    let apart = part.position() - other.position();
    if apart.norm() > (1.0 + ROOM) * other.shape.circumradius() {
        return false;
    }
    let stretch = Vec3::from(other.shape.semi_axes()).map(|a| 1.0 / a);
    let into = Mat3::from_diagonal(&stretch) * other.rotation().transpose();
    let centre = into * apart;
    let axes = into * part.rotation() * Mat3::from_diagonal(&Vec3::from(part.shape.semi_axes()));
    // A point has no inside: NaN and infinities are not below one.
    centre.norm() + axes.singular_values().max() <= 1.0 + ROOM
}
