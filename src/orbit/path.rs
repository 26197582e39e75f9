//! Places on one orbit at any time.

use super::KeplerElements;
use super::anomaly::EccentricPlace;
use super::elements::OrbitAxes;
use crate::error::{Result, require_finite, require_positive};
use crate::math::Vec3;

/// An orbit about a centre of known mu, with all in it that does not change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbitPath {
    to_periapsis: Vec3,
    across: Vec3,
    eccentricity: f64,
    gap: f64,
    width: f64,
    size: f64,
    /// sqrt(mu / |a|).
    speed: f64,
    mean_anomaly: f64,
    mean_motion: f64,
}

impl OrbitPath {
    /// From elements at a time, and mu = G (m_1 + m_2).
    pub fn new(elements: &KeplerElements, mu: f64) -> Result<Self> {
        require_positive("mu", mu)?;
        elements.check()?;
        let size = elements.semi_major_axis.abs();
        let axes = OrbitAxes::new(elements.longitude_of_node, elements.inclination);
        let (sin, cos) = elements.argument_of_periapsis.sin_cos();
        let speed = (mu / size).sqrt();
        Ok(Self {
            to_periapsis: axes.node * cos + axes.ahead * sin,
            across: axes.ahead * cos - axes.node * sin,
            eccentricity: elements.eccentricity,
            gap: elements.gap(),
            width: elements.width(),
            size,
            speed,
            mean_anomaly: elements.mean_anomaly,
            mean_motion: speed / size,
        })
    }

    /// Position and velocity a time after that of the elements.
    pub fn after(&self, time: f64) -> Result<(Vec3, Vec3)> {
        let mean = self.mean_anomaly + self.mean_motion * time;
        let place = EccentricPlace::from_mean(mean, self.eccentricity)?;
        // In units of |a|; every sum but that of `x` has one sign, and `x` is never larger than `radius`.
        let radius = self.gap + self.eccentricity * place.versine;
        let (x, y) = (self.gap - place.versine, self.width * place.sine);
        let speed = self.speed / radius;
        let position = (self.to_periapsis * x + self.across * y) * self.size;
        let velocity = (self.across * (self.width * place.cosine) - self.to_periapsis * place.sine) * speed;
        require_finite("position on the orbit", position.as_slice())?;
        require_finite("velocity on the orbit", velocity.as_slice())?;
        Ok((position, velocity))
    }

    /// Unit vector along the orbital angular momentum.
    pub fn normal(&self) -> Vec3 {
        self.to_periapsis.cross(&self.across)
    }
}
