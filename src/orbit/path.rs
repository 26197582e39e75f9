//! Positions on one orbit at many times.

use super::KeplerElements;
use super::anomaly::EccentricAnomaly;
use super::elements::OrbitAxes;
use crate::error::{Result, require_finite, require_positive};
use crate::math::Vec3;
use crate::math::lanes::WIDEST;
use pulp::Simd;
use std::f64::consts::PI;

/// An orbit about a centre of known mu, with everything precomputed that does not depend on time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbitPath {
    /// The unit vector to periapsis.
    to_periapsis: Vec3,
    /// The unit vector in the orbital plane a quarter turn ahead of periapsis.
    across: Vec3,
    /// The unit vector to the ascending node.
    node: Vec3,
    eccentricity: f64,
    /// The value |1 - e|.
    gap: f64,
    /// The value sqrt|1 - e^2|.
    width: f64,
    /// The value |a|.
    size: f64,
    /// The speed sqrt(mu / |a|).
    speed: f64,
    mean_anomaly: f64,
    mean_motion: f64,
}

impl OrbitPath {
    /// Takes elements, which are valid at time zero, and mu = G (m_1 + m_2).
    ///
    /// # Errors
    /// [`Error::InvalidInput`](crate::error::Error::InvalidInput) if `mu` is not above zero, if an element is
    /// invalid, or if the orbit is so small that its mean motion overflows.
    pub fn new(elements: &KeplerElements, mu: f64) -> Result<Self> {
        require_positive("mu", mu)?;
        elements.check()?;
        let size = elements.semi_major_axis.abs();
        let axes = OrbitAxes::new(elements.longitude_of_node, elements.inclination);
        let (sin, cos) = elements.argument_of_periapsis.sin_cos();
        let speed = (mu / size).sqrt();
        require_finite("mean motion", &[speed / size])?;
        Ok(Self {
            to_periapsis: axes.node * cos + axes.ahead * sin,
            across: axes.ahead * cos - axes.node * sin,
            node: axes.node,
            eccentricity: elements.eccentricity,
            gap: elements.gap(),
            width: elements.width(),
            size,
            speed,
            mean_anomaly: elements.mean_anomaly,
            mean_motion: speed / size,
        })
    }

    /// Returns the orbit of the centre about the body: the same orbit mirrored at the centre.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { to_periapsis: -self.to_periapsis, across: -self.across, ..self }
    }

    /// Returns position and velocity at a time after the epoch of the elements.
    ///
    /// # Errors
    /// [`Error::InvalidInput`](crate::error::Error::InvalidInput) for a time at which the position is not a
    /// finite number.
    pub fn after(&self, time: f64) -> Result<(Vec3, Vec3)> {
        self.at(&self.anomaly(time)?)
    }

    fn anomaly(&self, time: f64) -> Result<EccentricAnomaly> {
        EccentricAnomaly::from_mean(self.mean_anomaly + self.mean_motion * time, self.eccentricity)
    }

    fn at(&self, anomaly: &EccentricAnomaly) -> Result<(Vec3, Vec3)> {
        // Lengths are in units of |a|. Every sum but that of `x` has terms of one sign, and `x` is never
        // larger than `radius`.
        let radius = self.gap + self.eccentricity * anomaly.versine;
        let (x, y) = (self.gap - anomaly.versine, self.width * anomaly.sine);
        let speed = self.speed / radius;
        let position = (self.to_periapsis * x + self.across * y) * self.size;
        let velocity =
            (self.across * (self.width * anomaly.cosine) - self.to_periapsis * anomaly.sine) * speed;
        require_finite("position on the orbit", position.as_slice())?;
        require_finite("velocity on the orbit", velocity.as_slice())?;
        Ok((position, velocity))
    }

    /// Returns the position at a time after the epoch of the elements, and its derivatives with respect to a, e,
    /// i, Omega, omega, M, the epoch, and mu.
    ///
    /// At a fixed mean anomaly the eccentric anomaly has dE/de = sin E / (1 - e cos E), and on a hyperbola
    /// dH/de = -sinh H / (e cosh H - 1). The mean motion is sqrt(mu / |a|^3).
    ///
    /// # Errors
    /// Returns the errors of [`Self::after`].
    pub fn derivatives(&self, time: f64) -> Result<(Vec3, [Vec3; 8])> {
        let anomaly = self.anomaly(time)?;
        let (position, velocity) = self.at(&anomaly)?;
        let sign = if self.eccentricity < 1.0 { 1.0 } else { -1.0 };
        let anomaly_by_eccentricity = sign * anomaly.sine / (self.gap + self.eccentricity * anomaly.versine);
        let along = -anomaly.sine * anomaly_by_eccentricity - sign;
        let aside = self.width * anomaly.cosine * anomaly_by_eccentricity
            - sign * self.eccentricity / self.width * anomaly.sine;
        let derivatives = [
            (position - velocity * (1.5 * time)) / (sign * self.size),
            (self.to_periapsis * along + self.across * aside) * self.size,
            self.node.cross(&position),
            Vec3::z().cross(&position),
            self.normal().cross(&position),
            velocity / self.mean_motion,
            -velocity,
            velocity * (0.5 * time / (self.speed * self.speed * self.size)),
        ];
        Ok((position, derivatives))
    }

    /// Returns half of the time over which a polynomial of [`OrbitCells::TERMS`] terms follows the orbit to
    /// round-off.
    ///
    /// In the complex plane of the mean anomaly the nearest singularity, where 1 = e cos E, lies ln((1 +
    /// w)/e) - w from the real axis for an ellipse, and w - arccos(1/e) for a hyperbola, with w = sqrt|1 -
    /// e^2|.
    fn half_width(&self) -> f64 {
        let (e, w) = (self.eccentricity, self.width);
        let away = match e {
            // Near a parabola both differences lose their digits; this is their common first term.
            _ if w < 0.1 => w * w * w / 3.0,
            _ if e < 1.0 => ((1.0 + w) / e.max(1e-3)).ln() - w,
            _ => w - (1.0 / e).acos(),
        };
        // Over an interval of half width away/16 the terms of the polynomial fall by a factor of 32 each: twelve
        // reach round-off, 32^-12 = 1e-18.
        away / 16.0 / self.mean_motion
    }

    /// Returns the unit vector along the orbital angular momentum.
    pub fn normal(&self) -> Vec3 {
        self.to_periapsis.cross(&self.across)
    }
}

impl KeplerElements {
    /// Returns position and velocity for mu = G (m_1 + m_2).
    ///
    /// # Errors
    /// Returns the errors of [`OrbitPath::new`].
    pub fn to_cartesian(&self, mu: f64) -> Result<(Vec3, Vec3)> {
        OrbitPath::new(self, mu)?.after(0.0)
    }
}

/// A position on an orbit, and inverse powers of its distance r from the centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbitPosition {
    /// The position.
    pub position: Vec3,
    /// The inverse square 1 / r^2.
    pub inverse_square: f64,
    /// The inverse cube 1 / r^3.
    pub inverse_cube: f64,
}

impl OrbitPosition {
    #[inline(always)]
    fn new(position: Vec3, inverse: f64) -> Self {
        let inverse_square = inverse * inverse;
        Self { position, inverse_square, inverse_cube: inverse_square * inverse }
    }
}

impl From<Vec3> for OrbitPosition {
    fn from(position: Vec3) -> Self {
        Self::new(position, 1.0 / position.norm())
    }
}

/// Computes positions at many times in a row, from a polynomial over the interval of time that contains them.
/// The intervals have fixed boundaries, so that a position does not depend on earlier calls.
#[derive(Debug, Clone)]
pub struct OrbitCells {
    orbit: OrbitPath,
    half_width: f64,
    per_half_width: f64,
    /// The interval in use and the one before it, since the stages of a step alternate between two.
    cells: [OrbitCell; 2],
}

/// The polynomial over one interval of time.
#[derive(Debug, Clone)]
struct OrbitCell {
    /// The middle of the interval, in half widths.
    middle: f64,
    /// The coefficients of the position and of 1/r by powers of the time in the interval, scaled to [-1, 1].
    /// A row holds the coefficients of an even power and of the next one.
    coefficients: [[f64; WIDEST]; OrbitCells::TERMS / 2],
}

impl OrbitCell {
    /// Returns the scaled time in the interval, or `None` outside of it.
    #[inline(always)]
    fn within(&self, widths: f64) -> Option<f64> {
        let x = widths - self.middle;
        (-1.0..1.0).contains(&x).then_some(x)
    }
}

impl OrbitCells {
    /// The number of terms of a polynomial.
    const TERMS: usize = 12;

    /// Prepares the intervals of an orbit.
    pub fn new(orbit: OrbitPath) -> Self {
        let half_width = orbit.half_width();
        let none = OrbitCell { middle: f64::NAN, coefficients: [[0.0; WIDEST]; Self::TERMS / 2] };
        Self { orbit, half_width, per_half_width: 1.0 / half_width, cells: [none.clone(), none] }
    }

    /// Returns the orbit.
    pub fn orbit(&self) -> &OrbitPath {
        &self.orbit
    }

    /// Returns the position at a time after the epoch of the elements.
    #[inline(always)]
    pub fn after<S: Simd>(&mut self, simd: S, time: f64) -> Result<OrbitPosition> {
        let widths = time * self.per_half_width;
        let x = match self.cells[0].within(widths) {
            Some(x) => x,
            None => self.select_interval(widths)?,
        };
        // Even and odd powers of x^2 are summed separately, so that the two sums are computed in parallel.
        let (square, mut sums) = (simd.splat_f64s(x * x), [0.0; WIDEST]);
        let fourth = simd.mul_f64s(square, square);
        for (register, out) in S::as_mut_simd_f64s(&mut sums).0.iter_mut().enumerate() {
            let (mut even, mut odd) = (simd.splat_f64s(0.0), simd.splat_f64s(0.0));
            for [a, b] in self.cells[0].coefficients.as_chunks().0.iter().rev() {
                even = simd.mul_add_f64s(even, fourth, S::as_simd_f64s(a).0[register]);
                odd = simd.mul_add_f64s(odd, fourth, S::as_simd_f64s(b).0[register]);
            }
            *out = simd.mul_add_f64s(odd, square, even);
        }
        let number = |k: usize| sums[k] + sums[k + 4] * x;
        Ok(OrbitPosition::new(Vec3::new(number(0), number(1), number(2)), number(3)))
    }

    /// Computes the polynomial of the interval that holds a time. Returns the scaled time in it.
    #[cold]
    fn select_interval(&mut self, widths: f64) -> Result<f64> {
        self.cells.swap(0, 1);
        if self.cells[0].within(widths).is_none() {
            self.fill(2.0 * (0.5 * widths).floor() + 1.0)?;
        }
        Ok(widths - self.cells[0].middle)
    }

    fn fill(&mut self, middle: f64) -> Result<()> {
        let n = Self::TERMS as f64;
        self.cells[0].middle = f64::NAN;
        let mut chebyshev = [[0.0; 4]; Self::TERMS];
        for k in 0..Self::TERMS {
            let angle = PI * (k as f64 + 0.5) / n;
            let (position, _) = self.orbit.after((middle + angle.cos()) * self.half_width)?;
            let numbers = [position.x, position.y, position.z, 1.0 / position.norm()];
            for (j, c) in chebyshev.iter_mut().enumerate() {
                let weight = (j as f64 * angle).cos() * if j == 0 { 1.0 } else { 2.0 } / n;
                c.iter_mut().zip(numbers).for_each(|(c, number)| *c += weight * number);
            }
        }
        // The terms fall so fast that converting to powers of the time loses nothing.
        let mut by_powers = [[0.0; 4]; Self::TERMS];
        let (mut last, mut present) = ([0.0; Self::TERMS], [0.0; Self::TERMS]);
        present[0] = 1.0;
        for (j, c) in chebyshev.iter().enumerate() {
            for (coefficients, power) in by_powers.iter_mut().zip(present) {
                coefficients.iter_mut().zip(c).for_each(|(sum, c)| *sum += c * power);
            }
            let factor = if j == 0 { 1.0 } else { 2.0 };
            let next = |k: usize| (if k > 0 { factor * present[k - 1] } else { 0.0 }) - last[k];
            (last, present) = (present, std::array::from_fn(next));
        }
        let mut coefficients = [[0.0; WIDEST]; Self::TERMS / 2];
        for (power, numbers) in by_powers.iter().enumerate() {
            coefficients[power / 2][4 * (power % 2)..][..4].copy_from_slice(numbers);
        }
        self.cells[0] = OrbitCell { middle, coefficients };
        Ok(())
    }
}
