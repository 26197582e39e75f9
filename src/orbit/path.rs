//! Places on one orbit at any time.

use super::KeplerElements;
use super::anomaly::EccentricPlace;
use super::elements::OrbitAxes;
use crate::error::{Result, require_finite, require_positive};
use crate::math::Vec3;
use std::f64::consts::PI;

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

    /// Half the time over which a polynomial of [`OrbitCells::TERMS`] terms follows the orbit to round-off. In the complex plane of the
    /// mean anomaly the nearest singularity, where 1 = e cos E, lies ln((1 + w)/e) - w from the real axis for an ellipse, w - arccos(1/e)
    /// for a hyperbola, with w = sqrt|1 - e^2|.
    fn half_width(&self) -> f64 {
        let (e, w) = (self.eccentricity, self.width);
        let away = match e {
            // Near a parabola both differences lose their digits; this is the first term of either.
            _ if w < 0.1 => w * w * w / 3.0,
            _ if e < 1.0 => ((1.0 + w) / e.max(1e-3)).ln() - w,
            _ => w - (1.0 / e).acos(),
        };
        away / 16.0 / self.mean_motion
    }

    /// Unit vector along the orbital angular momentum.
    pub fn normal(&self) -> Vec3 {
        self.to_periapsis.cross(&self.across)
    }
}

impl KeplerElements {
    /// Position and velocity for mu = G (m_1 + m_2).
    pub fn to_cartesian(&self, mu: f64) -> Result<(Vec3, Vec3)> {
        OrbitPath::new(self, mu)?.after(0.0)
    }
}

/// The same positions many times in a row, from the Chebyshev polynomial of the stretch of time around them. Stretches are laid out
/// once and for all, so that a position does not depend on what was asked before.
#[derive(Debug, Clone)]
pub struct OrbitCells {
    orbit: OrbitPath,
    half_width: f64,
    /// The stretch in hand.
    cell: f64,
    coefficients: [Vec3; Self::TERMS],
}

impl OrbitCells {
    /// Terms of a polynomial.
    const TERMS: usize = 12;

    /// Of an orbit.
    pub fn new(orbit: OrbitPath) -> Self {
        let coefficients = [Vec3::zeros(); Self::TERMS];
        Self { orbit, half_width: orbit.half_width(), cell: f64::NAN, coefficients }
    }

    /// The position a time after that of the elements.
    pub fn after(&mut self, time: f64) -> Result<Vec3> {
        let cell = (0.5 * time / self.half_width).floor();
        if cell != self.cell {
            self.fill(cell)?;
        }
        let twice = 2.0 * (time / self.half_width - (2.0 * cell + 1.0));
        let (mut next, mut after) = (Vec3::zeros(), Vec3::zeros());
        for c in self.coefficients[1..].iter().rev() {
            (next, after) = (c + twice * next - after, next);
        }
        Ok(self.coefficients[0] + 0.5 * twice * next - after)
    }

    fn fill(&mut self, cell: f64) -> Result<()> {
        let n = Self::TERMS as f64;
        self.cell = f64::NAN;
        self.coefficients.fill(Vec3::zeros());
        for k in 0..Self::TERMS {
            let angle = PI * (k as f64 + 0.5) / n;
            let (position, _) = self.orbit.after((2.0 * cell + 1.0 + angle.cos()) * self.half_width)?;
            for (j, c) in self.coefficients.iter_mut().enumerate() {
                *c += position * ((j as f64 * angle).cos() * if j == 0 { 1.0 } else { 2.0 } / n);
            }
        }
        self.cell = cell;
        Ok(())
    }
}
