//! The six Kepler elements, their checks, and their conversion to position and velocity.
//!
//! Takes elements in radians and the caller's unit of length; gives position and velocity in the frame of the
//! angles.

use super::anomaly::{EccentricAnomaly, wrapped};
use crate::error::{Error, Result, require_finite, require_positive};
use crate::math::Vec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// A Kepler orbit and the position on it: an ellipse (a > 0, 0 <= e < 1) or a hyperbola (a < 0, e > 1).
///
/// Angles are radians, in a frame whose xy plane is the reference plane. All angles but the inclination may
/// have any real value. [`KeplerElements::from_cartesian`] returns the node, the argument of periapsis and an
/// ellipse's mean anomaly in [0, 2 pi), a hyperbola's mean anomaly with its sign, and
///
/// - on a circle (e = 0) `argument_of_periapsis` = 0, and the mean anomaly counts from the node;
/// - in the reference plane (i = 0 or i = pi) `longitude_of_node` = 0, and the other angles count from x in
///   the direction of motion: for i = pi that is clockwise, seen from +z.
///
/// A state that is converted to elements and back is reproduced to a few 1e-15, except where elements in
/// doubles do not determine it so well: near a parabola the error grows by 1/|1 - e|, and just before an
/// ellipse's periapsis, where the mean anomaly is nearly 2 pi, by up to 1/(1 - e)^(3/2).
///
/// ```
/// use fullbody::math::Vec3;
/// use fullbody::orbit::KeplerElements;
///
/// // A body at periapsis, with sqrt(1.5) times the speed on a circle.
/// let velocity = Vec3::new(0.0, 1.5_f64.sqrt(), 0.0);
/// let orbit = KeplerElements::from_cartesian(&Vec3::new(1.0, 0.0, 0.0), &velocity, 1.0)?;
/// assert!((orbit.eccentricity - 0.5).abs() < 1e-14);
/// assert!((orbit.semi_major_axis - 2.0).abs() < 1e-14);
/// assert!((orbit.period(1.0)? - 32.0_f64.sqrt() * std::f64::consts::PI).abs() < 1e-13);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeplerElements {
    /// Semi-major axis a: above zero for an ellipse, below zero for a hyperbola.
    #[serde(rename = "a")]
    pub semi_major_axis: f64,
    /// Eccentricity e, which must not be 1.
    #[serde(rename = "e")]
    pub eccentricity: f64,
    /// Inclination i: the angle between the orbital angular momentum and z, in [0, pi].
    #[serde(rename = "i")]
    pub inclination: f64,
    /// Longitude of the ascending node, Omega: the angle in the reference plane from x to where the orbit
    /// crosses it towards +z.
    #[serde(rename = "Omega")]
    pub longitude_of_node: f64,
    /// Argument of periapsis, omega: the angle in the orbit from the node to periapsis.
    #[serde(rename = "omega")]
    pub argument_of_periapsis: f64,
    /// Mean anomaly M: the time since periapsis times the mean motion.
    #[serde(rename = "M")]
    pub mean_anomaly: f64,
}

impl KeplerElements {
    /// Checks and stores elements: a and e, then the angles i, Omega, omega and M.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a number that is not finite, a negative eccentricity, the parabola e = 1,
    /// and a semi-major axis whose sign does not agree with the eccentricity.
    pub fn new(
        semi_major_axis: f64,
        eccentricity: f64,
        inclination: f64,
        longitude_of_node: f64,
        argument_of_periapsis: f64,
        mean_anomaly: f64,
    ) -> Result<Self> {
        let elements = Self {
            semi_major_axis,
            eccentricity,
            inclination,
            longitude_of_node,
            argument_of_periapsis,
            mean_anomaly,
        };
        elements.check()?;
        Ok(elements)
    }

    /// Returns the mean motion sqrt(mu / |a|^3), in radians per unit time.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] if `mu` is not above zero, or if an element is invalid.
    pub fn mean_motion(&self, mu: f64) -> Result<f64> {
        require_positive("mu", mu)?;
        self.check()?;
        let size = self.semi_major_axis.abs();
        Ok((mu / size).sqrt() / size)
    }

    /// Returns the time from one periapsis to the next.
    ///
    /// # Errors
    /// Returns the errors of [`Self::mean_motion`], and [`Error::InvalidInput`] for a hyperbola, which has
    /// one periapsis.
    pub fn period(&self, mu: f64) -> Result<f64> {
        let motion = self.mean_motion(mu)?;
        if self.eccentricity > 1.0 {
            return Err(Error::invalid(
                "eccentricity of an orbit whose period is asked for",
                self.eccentricity,
                "less than 1: a hyperbolic orbit has no period",
            ));
        }
        Ok(TAU / motion)
    }

    /// Returns E in [0, 2 pi) on an ellipse, and H with its sign on a hyperbola.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] if an element is invalid.
    pub fn eccentric_anomaly(&self) -> Result<f64> {
        Ok(self.in_range(self.solve()?.anomaly))
    }

    /// Returns the true anomaly: the angle at the focus from periapsis to the body, in [0, 2 pi) on an
    /// ellipse and in (-pi, pi) on a hyperbola.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] if an element is invalid.
    pub fn true_anomaly(&self) -> Result<f64> {
        let solved = self.solve()?;
        let anomaly = (self.width() * solved.sine).atan2(self.gap() - solved.versine);
        Ok(self.in_range(anomaly))
    }

    /// Returns the smallest distance, a (1 - e).
    pub fn periapsis_distance(&self) -> f64 {
        self.semi_major_axis * (1.0 - self.eccentricity)
    }

    /// Returns an error for numbers that describe no orbit. The fields are public and may hold anything, so
    /// that every method that computes with them checks them first.
    pub(super) fn check(&self) -> Result<()> {
        let (a, e, i) = (self.semi_major_axis, self.eccentricity, self.inclination);
        let named = [
            ("semi-major axis", a),
            ("eccentricity", e),
            ("inclination", i),
            ("longitude of the node", self.longitude_of_node),
            ("argument of periapsis", self.argument_of_periapsis),
            ("mean anomaly", self.mean_anomaly),
        ];
        for (what, value) in named {
            require_finite(what, &[value])?;
        }
        if e < 0.0 {
            return Err(Error::invalid("eccentricity", e, "zero or above"));
        }
        if e == 1.0 {
            return Err(Error::invalid("eccentricity", e, "not 1: a parabola has no semi-major axis"));
        }
        if e < 1.0 && a <= 0.0 {
            return Err(Error::invalid("semi-major axis", a, format!("above zero for an ellipse (e = {e})")));
        }
        if e > 1.0 && a >= 0.0 {
            return Err(Error::invalid(
                "semi-major axis",
                a,
                format!("below zero for a hyperbola (e = {e})"),
            ));
        }
        if !(0.0..=PI).contains(&i) {
            return Err(Error::invalid("inclination", i, "radians in [0, pi]"));
        }
        Ok(())
    }

    fn solve(&self) -> Result<EccentricAnomaly> {
        self.check()?;
        EccentricAnomaly::from_mean(self.mean_anomaly, self.eccentricity)
    }

    /// Returns |1 - e|, exact near e = 1.
    pub(super) fn gap(&self) -> f64 {
        (1.0 - self.eccentricity).abs()
    }

    /// Returns sqrt|1 - e^2|: the ratio of the semi-minor to the semi-major axis.
    pub(super) fn width(&self) -> f64 {
        self.gap().sqrt() * (1.0 + self.eccentricity).sqrt()
    }

    fn in_range(&self, anomaly: f64) -> f64 {
        if self.eccentricity < 1.0 { wrapped(anomaly) } else { anomaly }
    }
}

/// Two unit vectors that span the orbital plane.
pub(super) struct OrbitAxes {
    /// The direction of the ascending node.
    pub(super) node: Vec3,
    /// The direction a quarter turn further along the motion.
    pub(super) ahead: Vec3,
}

impl OrbitAxes {
    pub(super) fn new(longitude_of_node: f64, inclination: f64) -> Self {
        let (sin_node, cos_node) = longitude_of_node.sin_cos();
        let (sin, cos) = inclination.sin_cos();
        Self {
            node: Vec3::new(cos_node, sin_node, 0.0),
            ahead: Vec3::new(-sin_node * cos, cos_node * cos, sin),
        }
    }
}
