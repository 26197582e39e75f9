//! Mathematics without physics: vectors, rotations, Carlson's integrals, exact sums, splines, solid harmonics, lanes and rows (SIMD).
//!
//! Takes and gives plain numbers and `nalgebra` vectors.

pub mod carlson;
pub mod compensated;
pub mod dual;
pub mod gauss;
pub mod harmonics;
pub mod lanes;
pub mod logarithm;
pub mod matrix;
pub mod monomials;
pub mod rotation;
pub mod rows;
pub mod spline;
pub mod stumpff;
pub mod triangle;

/// A vector of three doubles.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3 x 3 matrix of doubles.
pub type Mat3 = nalgebra::Matrix3<f64>;
