//! Mathematics without physics: vectors, rotations, Carlson's integrals, exact sums, splines, solid
//! harmonics, lanes and rows (SIMD).
//!
//! Takes and gives plain numbers and `nalgebra` vectors.

#[doc(hidden)]
pub mod carlson;
#[doc(hidden)]
pub mod compensated;
#[doc(hidden)]
pub mod difference;
#[doc(hidden)]
pub mod dual;
#[doc(hidden)]
pub mod exchange;
#[doc(hidden)]
pub mod exponential;
#[doc(hidden)]
pub mod gauss;
#[doc(hidden)]
pub mod harmonics;
#[doc(hidden)]
pub mod lanes;
#[doc(hidden)]
pub mod logarithm;
#[doc(hidden)]
pub mod matrix;
#[doc(hidden)]
pub mod monomials;
pub mod rotation;
#[doc(hidden)]
pub mod rows;
pub mod spline;
#[doc(hidden)]
pub mod stumpff;
#[doc(hidden)]
pub mod triangle;

#[doc(inline)]
pub use lanes::VectorPath;

/// A vector of three doubles.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3 x 3 matrix of doubles.
pub type Mat3 = nalgebra::Matrix3<f64>;

/// Returns the indices of three numbers from the smallest to the largest; equal numbers keep their order.
#[doc(hidden)]
pub fn ascending(numbers: [f64; 3]) -> [usize; 3] {
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| numbers[i].total_cmp(&numbers[j]));
    order
}

/// Returns a unit vector perpendicular to a vector.
#[doc(hidden)]
pub fn perpendicular(v: &Vec3) -> Vec3 {
    let mut axis = Vec3::zeros();
    axis[v.iamin()] = 1.0;
    v.cross(&axis).normalize()
}
