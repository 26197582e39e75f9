//! The homogeneous ellipsoid: semi-axes, volume, inertia, and its canonical frame.

use crate::error::{Result, require_positive};
use crate::math::{Mat3, Vec3, ascending};
use std::f64::consts::PI;

/// A homogeneous ellipsoid with semi-axes (a, b, c) along the body frame's x, y, z.
///
/// The gravity is written for a >= b >= c; [`Ellipsoid::canonical`] is the rotation into that frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipsoid {
    semi_axes: [f64; 3],
    sorted: [f64; 3],
    canonical: Mat3,
}

impl Ellipsoid {
    /// Makes an ellipsoid of semi-axes in any order of size.
    ///
    /// # Errors
    /// [`Error::InvalidInput`](crate::error::Error::InvalidInput) names the semi-axis that is not a finite
    /// number above zero.
    pub fn new(semi_axes: [f64; 3]) -> Result<Self> {
        for (axis, label) in semi_axes.iter().zip(["a", "b", "c"]) {
            require_positive(&format!("semi-axis {label}"), *axis)?;
        }
        let order = ascending(semi_axes.map(|a| -a));
        let mut canonical = Mat3::zeros();
        for (row, &column) in order.iter().enumerate() {
            canonical[(row, column)] = 1.0;
        }
        // An ellipsoid is symmetric, so that one axis may be reversed to make the permutation a rotation.
        let sign = canonical.determinant();
        canonical.row_mut(2).scale_mut(sign);
        Ok(Self { semi_axes, sorted: order.map(|i| semi_axes[i]), canonical })
    }

    /// Returns the shape with all lengths multiplied by a factor above zero.
    #[doc(hidden)]
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            semi_axes: self.semi_axes.map(|a| a * factor),
            sorted: self.sorted.map(|a| a * factor),
            canonical: self.canonical,
        }
    }

    /// Returns the semi-axes along the body frame's x, y, z.
    pub fn semi_axes(&self) -> [f64; 3] {
        self.semi_axes
    }

    /// Returns the semi-axes from the largest to the smallest.
    pub fn sorted(&self) -> [f64; 3] {
        self.sorted
    }

    /// Returns the rotation matrix from the body frame into the frame in which the axes are sorted.
    pub fn canonical(&self) -> Mat3 {
        self.canonical
    }

    /// Returns the volume, 4 pi a b c / 3.
    pub fn volume(&self) -> f64 {
        let [a, b, c] = self.semi_axes;
        4.0 * PI / 3.0 * a * b * c
    }

    /// Returns the principal moments of inertia of unit mass: (b^2 + c^2, c^2 + a^2, a^2 + b^2) / 5.
    pub fn inertia_per_mass(&self) -> Vec3 {
        let [a, b, c] = self.semi_axes;
        Vec3::new(b * b + c * c, c * c + a * a, a * a + b * b) / 5.0
    }

    /// Returns the semi-axes (p, q), p >= q, of the focal ellipse x^2/p^2 + y^2/q^2 <= 1 in the canonical
    /// frame: p^2 = a^2 - c^2, q^2 = b^2 - c^2.
    pub fn focal_axes(&self) -> [f64; 2] {
        let [a, b, c] = self.sorted;
        [((a - c) * (a + c)).sqrt(), ((b - c) * (b + c)).sqrt()]
    }
}
