//! Places on one orbit at any time.

use super::KeplerElements;
use super::anomaly::EccentricPlace;
use super::elements::OrbitAxes;
use crate::error::{Result, require_finite, require_positive};
use crate::math::Vec3;
use crate::math::lanes::WIDEST;
use pulp::Simd;
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

    /// The path of the centre about the body: the same, mirrored at the centre.
    pub fn mirrored(self) -> Self {
        Self { to_periapsis: -self.to_periapsis, across: -self.across, ..self }
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

/// A position, and powers of its distance r.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The position.
    pub position: Vec3,
    /// 1 / r^2.
    pub inverse_square: f64,
    /// 1 / r^3.
    pub inverse_cube: f64,
}

impl Place {
    #[inline(always)]
    fn new(position: Vec3, inverse: f64) -> Self {
        let inverse_square = inverse * inverse;
        Self { position, inverse_square, inverse_cube: inverse_square * inverse }
    }
}

impl From<Vec3> for Place {
    fn from(position: Vec3) -> Self {
        Self::new(position, 1.0 / position.norm())
    }
}

/// Places many times in a row, from the polynomial of the stretch of time around them. Stretches are laid out once and for
/// all, so that a place does not depend on what was asked before.
#[derive(Debug, Clone)]
pub struct OrbitCells {
    orbit: OrbitPath,
    half_width: f64,
    per_half_width: f64,
    /// The stretch in hand, and the one before it: the stages of a step go to and fro between two.
    cells: [Cell; 2],
}

/// A stretch of time.
#[derive(Debug, Clone)]
struct Cell {
    /// Its middle, in half widths.
    middle: f64,
    /// Of the position and 1/r, by powers of the time in the stretch, from -1 to 1: of an even power and of the next one in a row.
    coefficients: [[f64; WIDEST]; OrbitCells::TERMS / 2],
}

impl Cell {
    /// The time in the stretch, where it is in it.
    #[inline(always)]
    fn within(&self, widths: f64) -> Option<f64> {
        let x = widths - self.middle;
        (-1.0..1.0).contains(&x).then_some(x)
    }
}

impl OrbitCells {
    /// Terms of a polynomial.
    const TERMS: usize = 12;

    /// Of an orbit.
    pub fn new(orbit: OrbitPath) -> Self {
        let half_width = orbit.half_width();
        let none = Cell { middle: f64::NAN, coefficients: [[0.0; WIDEST]; Self::TERMS / 2] };
        Self { orbit, half_width, per_half_width: 1.0 / half_width, cells: [none.clone(), none] }
    }

    /// The orbit.
    pub fn orbit(&self) -> &OrbitPath {
        &self.orbit
    }

    /// The place a time after that of the elements.
    #[inline(always)]
    pub fn after<S: Simd>(&mut self, simd: S, time: f64) -> Result<Place> {
        let widths = time * self.per_half_width;
        let x = match self.cells[0].within(widths) {
            Some(x) => x,
            None => self.turn_to(widths)?,
        };
        // Powers of x^4 in two sums, that neither waits for the other.
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
        Ok(Place::new(Vec3::new(number(0), number(1), number(2)), number(3)))
    }

    /// Takes the stretch of a time in hand; gives the time in it.
    #[cold]
    fn turn_to(&mut self, widths: f64) -> Result<f64> {
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
        // By powers of the time: the terms fall so fast that nothing is lost.
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
        self.cells[0] = Cell { middle, coefficients };
        Ok(())
    }
}
