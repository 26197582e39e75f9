//! Principal frames of inertia.
//!
//! A body's frame is its principal frame, rotated as little as possible from the working frame in which the
//! body is given. Among all orders and directions of the principal axes it is the choice for which the axes
//! of both frames are nearest to each other (the trace of the rotation is largest). Where two moments of
//! inertia are equal, only the third axis is rotated, by the shortest rotation; where all are equal, nothing
//! is rotated. A body that is given in a principal frame therefore keeps it.

use crate::error::{Error, Result};
use crate::math::{Mat3, Vec3, ascending};
use nalgebra::{Rotation3, SymmetricEigen, UnitQuaternion};

/// The size, relative to their terms, below which products of inertia and differences of moments count as
/// rounding errors.
pub(super) const ROUNDING: f64 = 1e-14;

/// Where the working frame of a composite or a polyhedron lies in its body frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkingFrame {
    /// The origin of the working frame, in the body frame.
    pub position: Vec3,
    /// The quaternion that rotates vectors of the working frame into the body frame.
    pub attitude: [f64; 4],
}

/// Returns the rotation from the working frame into the principal frame.
pub(super) fn principal_axes(tensor: &Mat3, size: f64) -> Mat3 {
    let small = ROUNDING * size;
    if tensor[(0, 1)].abs().max(tensor[(1, 2)].abs()).max(tensor[(0, 2)].abs()) <= small {
        return Mat3::identity();
    }
    let eigen = SymmetricEigen::new(tensor / size);
    let order = ascending(eigen.eigenvalues.into());
    let [low, middle, high] = order.map(|k| eigen.eigenvalues[k] * size);
    let vector = |k: usize| eigen.eigenvectors.column(order[k]).into_owned();
    match (middle - low <= small, high - middle <= small) {
        (true, true) => Mat3::identity(),
        (true, false) => least_rotation(vector(2)),
        (false, true) => least_rotation(vector(0)),
        (false, false) => nearest_frame([vector(0), vector(1), vector(2)]),
    }
}

/// Returns the smallest rotation that turns the nearest axis of the working frame into the direction of this
/// vector.
fn least_rotation(vector: Vec3) -> Mat3 {
    let axis = vector.iamax();
    let along = vector * vector[axis].signum();
    let mut unit = Vec3::zeros();
    unit[axis] = 1.0;
    // The two directions are less than 60 degrees apart.
    Rotation3::rotation_between(&along, &unit).map_or_else(Mat3::identity, |rotation| rotation.into_inner())
}

/// Returns the frame along these three vectors, ordered and directed so that it is nearest to the working
/// frame.
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

pub(super) fn quaternion(rotation: &Mat3) -> [f64; 4] {
    if *rotation == Mat3::identity() {
        return [1.0, 0.0, 0.0, 0.0];
    }
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    [q.w, q.i, q.j, q.k]
}

/// Returns an error for moments of inertia that no body can have.
pub(super) fn check_inertia(name: &str, inertia: &Vec3, size: f64) -> Result<()> {
    let largest = inertia.max();
    let refuse = |expected: &str| {
        let found = format!("[{}, {}, {}]", inertia.x, inertia.y, inertia.z);
        Err(Error::invalid(format!("moments of inertia of {name}"), found, expected))
    };
    if !inertia.iter().all(|moment| *moment > ROUNDING * size && moment.is_finite()) {
        return refuse(
            "finite numbers above zero: parts with extent or points that are not on one line, and no void \
             beside them",
        );
    }
    if 2.0 * largest - inertia.sum() > ROUNDING * size {
        return refuse("none above the sum of the other two: the voids take away more than there is");
    }
    Ok(())
}
