//! The six elements, their checks, and the way from them to position and velocity.
//!
//! Takes elements in radians and the caller's length; gives position and velocity in the frame of the angles.

use super::anomaly::{EccentricPlace, wrapped};
use crate::error::{Error, Result, require_finite, require_positive};
use crate::math::Vec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// A Kepler orbit and the place on it: ellipse (a > 0, 0 <= e < 1) or hyperbola (a < 0, e > 1).
///
/// Angles are radians, in a frame whose xy plane is the plane of reference. Any real value is welcome for the
/// three angles other than the inclination. [`KeplerElements::from_cartesian`] gives the node, the argument
/// of periapsis and an ellipse's mean anomaly in [0, 2 pi), a hyperbola's mean anomaly with its sign, and
///
/// - on a circle (e = 0) `argument_of_periapsis` = 0, and the mean anomaly counts from the node;
/// - in the plane of reference (i = 0 or i = pi) `longitude_of_node` = 0, and the other angles count from x in
///   the direction of motion: for i = pi that is clockwise, seen from +z.
///
/// A state that is converted to elements and back returns to a few 1e-15, except where elements as doubles do not
/// determine it so well: near a parabola the error grows by 1/|1 - e|, and just before an ellipse's periapsis, where the
/// mean anomaly is nearly 2 pi, by up to 1/(1 - e)^(3/2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeplerElements {
    /// a: length, above zero for an ellipse, below zero for a hyperbola.
    #[serde(rename = "a")]
    pub semi_major_axis: f64,
    /// e: not 1.
    #[serde(rename = "e")]
    pub eccentricity: f64,
    /// i: angle between the orbital angular momentum and z, in [0, pi].
    #[serde(rename = "i")]
    pub inclination: f64,
    /// Omega: angle in the plane of reference from x to where the orbit crosses it towards +z.
    #[serde(rename = "Omega")]
    pub longitude_of_node: f64,
    /// omega: angle in the orbit from the node to periapsis.
    #[serde(rename = "omega")]
    pub argument_of_periapsis: f64,
    /// M: time since periapsis times the mean motion.
    #[serde(rename = "M")]
    pub mean_anomaly: f64,
}

impl KeplerElements {
    /// Checked elements: a and e, then the angles i, Omega, omega, M.
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

    /// Mean motion, sqrt(mu / |a|^3): radians per unit time.
    pub fn mean_motion(&self, mu: f64) -> Result<f64> {
        require_positive("mu", mu)?;
        self.check()?;
        let size = self.semi_major_axis.abs();
        Ok((mu / size).sqrt() / size)
    }

    /// Time from periapsis to periapsis; an error on a hyperbola, which does not come back.
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

    /// E in [0, 2 pi) on an ellipse; H, with its sign, on a hyperbola.
    pub fn eccentric_anomaly(&self) -> Result<f64> {
        Ok(self.in_range(self.place()?.anomaly))
    }

    /// Angle at the focus from periapsis to the body: in [0, 2 pi) on an ellipse, in (-pi, pi) on a hyperbola.
    pub fn true_anomaly(&self) -> Result<f64> {
        let place = self.place()?;
        let anomaly = (self.width() * place.sine).atan2(self.gap() - place.versine);
        Ok(self.in_range(anomaly))
    }

    /// Smallest distance, a (1 - e).
    pub fn periapsis_distance(&self) -> f64 {
        self.semi_major_axis * (1.0 - self.eccentricity)
    }

    /// Refuses numbers that are no orbit. The fields are public and may hold anything, so that every method that
    /// computes with them checks them first.
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

    fn place(&self) -> Result<EccentricPlace> {
        self.check()?;
        EccentricPlace::from_mean(self.mean_anomaly, self.eccentricity)
    }

    /// |1 - e|, exact near e = 1.
    pub(super) fn gap(&self) -> f64 {
        (1.0 - self.eccentricity).abs()
    }

    /// sqrt|1 - e^2|: the semi-minor axis over the semi-major one.
    pub(super) fn width(&self) -> f64 {
        self.gap().sqrt() * (1.0 + self.eccentricity).sqrt()
    }

    fn in_range(&self, anomaly: f64) -> f64 {
        if self.eccentricity < 1.0 { wrapped(anomaly) } else { anomaly }
    }
}

/// Two unit vectors of the orbit's plane.
pub(super) struct OrbitAxes {
    /// To the ascending node.
    pub(super) node: Vec3,
    /// A quarter turn further in the direction of motion.
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
