//! The part of an ellipsoid that faces both the observer and the Sun.
//!
//! The ellipsoid x = A u, A = diag(a, b, c), is mapped to the unit sphere of u. With e toward the observer
//! and s toward the Sun in body axes, p = A^-1 e and q = A^-1 s, the cosines are mu = p.u / n and mu0 = q.u /
//! n with n = |A^-1 u|, and dS = abc n dOmega. So mu mu0 / (mu + mu0) dS = abc f dOmega with f = (p.u)(q.u) /
//! ((p + q).u).
//!
//! The sphere has its pole k along p x q; a point has the height z = u.k and the longitude l from p toward q.
//! The lune is the region in which p.u and q.u are positive. It lies between the terminator, l = A - pi/2,
//! and the limb, l = pi/2, where A is the angle between p and q. Let rho^2 = 1 - z^2, L the longitude of p +
//! q, gamma = A - L and y = l - L. On a parallel f = rho g(l) with
//!
//!   g = (|p| |q| / |p + q|) cos l cos(l - A) / cos y,
//!   int g dl = (|p| |q| / |p + q|) [ sin(l - gamma) - sin L sin gamma G(y) ],   G(y) = artanh(sin y).
//!
//! Over the whole lune this is the brightness of Muinonen & Lumme (2015), Astron. Astrophys. 584, A23.

use crate::math::{Vec3, perpendicular};

/// A point of a parallel, given by its longitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Longitude {
    /// Sine of the longitude.
    pub sin: f64,
    /// Cosine of the longitude.
    pub cos: f64,
}

/// Intervals of longitudes on a parallel, as their integral of g needs them: the sum of differences of
/// sin(l - gamma), and the product of ratios of exp G, so that one logarithm serves all of them.
#[derive(Debug, Clone, Copy)]
pub struct Intervals {
    unweighted: f64,
    growth: f64,
    decay: f64,
}

impl Default for Intervals {
    fn default() -> Self {
        Self { unweighted: 0.0, growth: 1.0, decay: 1.0 }
    }
}

/// The lune of an ellipsoid: the part that is visible and illuminated.
#[derive(Debug, Clone)]
pub struct Lune {
    /// Unit vectors in the space of u: along p, perpendicular to p toward q, and along the pole.
    pub frame: [Vec3; 3],
    /// The lengths of p and q.
    pub lengths: [f64; 2],
    /// The angle from p to q.
    pub angle: Longitude,
    /// The longitude L of p + q.
    middle: Longitude,
    /// The angle gamma from p + q to q.
    gamma: Longitude,
    /// The length of p + q.
    sum: f64,
}

impl Lune {
    /// Makes the lune of an ellipsoid from p = A^-1 e and q = A^-1 s.
    #[inline]
    pub fn new(p: &Vec3, q: &Vec3) -> Self {
        let lengths = [p.norm(), q.norm()];
        let (first, toward_sun) = (p * (1.0 / lengths[0]), q * (1.0 / lengths[1]));
        let normal = first.cross(&toward_sun);
        // At phase angles of zero and pi any vector perpendicular to p serves as the pole.
        let pole = if normal == Vec3::zeros() { perpendicular(&first) } else { normal.normalize() };
        // The cross product of nearly parallel vectors has round-off along them.
        let along = first.dot(&pole);
        let pole = if along.abs() < 1e-9 { pole - first * along } else { (pole - first * along).normalize() };
        let second = pole.cross(&first);
        let sin = toward_sun.dot(&second).max(0.0);
        let cos = toward_sun.dot(&first);
        // The length is one up to rounding, which a step of Newton's method removes.
        let scale = 1.5 - 0.5 * (sin * sin + cos * cos);
        let angle = Longitude { sin: sin * scale, cos: cos * scale };
        let (along, aside) = (lengths[0] + lengths[1] * angle.cos, lengths[1] * angle.sin);
        // Rounding may leave nothing of the sum of opposite vectors; the lune is then empty.
        let sum = (along * along + aside * aside).sqrt().max(f64::MIN_POSITIVE);
        let inverse = 1.0 / sum;
        let middle = Longitude { sin: aside * inverse, cos: along * inverse };
        let aside = lengths[0] * angle.sin;
        let gamma = Longitude { sin: aside * inverse, cos: (lengths[1] + lengths[0] * angle.cos) * inverse };
        Self { frame: [first, second, pole], lengths, angle, middle, gamma, sum }
    }

    /// Returns the longitude of the limb.
    pub fn limb(&self) -> Longitude {
        Longitude { sin: 1.0, cos: 0.0 }
    }

    /// Returns the longitude of the terminator.
    pub fn terminator(&self) -> Longitude {
        Longitude { sin: -self.angle.cos, cos: self.angle.sin }
    }

    /// Returns whether nothing is both visible and illuminated, since the Sun is exactly behind the ellipsoid.
    pub fn is_empty(&self) -> bool {
        self.angle.sin == 0.0 && self.angle.cos < 0.0
    }

    /// Returns the longitude in the middle between the terminator and the limb.
    pub fn centre(&self) -> Longitude {
        let half = 0.5 * self.angle.sin.atan2(self.angle.cos);
        Longitude { sin: half.sin(), cos: half.cos() }
    }

    /// Returns the point of the unit sphere at a longitude and a height z, where rho^2 = 1 - z^2.
    pub fn point(&self, l: Longitude, z: f64, rho: f64) -> Vec3 {
        let [first, second, pole] = &self.frame;
        first * (rho * l.cos) + second * (rho * l.sin) + pole * z
    }

    /// Returns y = l - L for a longitude l.
    fn relative_to_middle(&self, l: Longitude) -> Longitude {
        let Longitude { sin, cos } = self.middle;
        // Only rounding brings a point of the lune to cos y = 0, where other factors are zero.
        Longitude { sin: l.sin * cos - l.cos * sin, cos: (l.cos * cos + l.sin * sin).max(f64::EPSILON) }
    }

    /// Returns Q / (P + Q) and P / (P + Q), with P = p.u and Q = q.u.
    pub fn shares(&self, l: Longitude) -> [f64; 2] {
        let sight = self.lengths[0] * l.cos;
        let light = self.lengths[1] * (l.cos * self.angle.cos + l.sin * self.angle.sin).max(0.0);
        let total = sight + light;
        if total > 0.0 { [light / total, sight / total] } else { [0.5, 0.5] }
    }

    /// Returns g at a longitude, with P / rho and Q / rho.
    pub fn kernel(&self, l: Longitude) -> [f64; 3] {
        let sight = self.lengths[0] * l.cos;
        let light = self.lengths[1] * (l.cos * self.angle.cos + l.sin * self.angle.sin).max(0.0);
        let total = sight + light;
        [if total > 0.0 { sight * light / total } else { 0.0 }, sight, light]
    }

    /// Returns the integral of g over the intervals of a parallel.
    #[inline]
    pub fn integral(&self, intervals: &Intervals) -> f64 {
        let log = (intervals.growth / intervals.decay).ln();
        self.lengths[0] * self.lengths[1] / self.sum
            * (intervals.unweighted - self.middle.sin * self.gamma.sin * log)
    }

    /// Adds the interval between two longitudes to those over which g is integrated.
    #[inline]
    pub fn extend(&self, intervals: &mut Intervals, from: Longitude, to: Longitude) {
        let unweighted = |l: Longitude| l.sin * self.gamma.cos - l.cos * self.gamma.sin;
        // exp G(y) = (1 + sin y) / cos y = cos y / (1 - sin y): the form without cancellation is used.
        let growth = |l: Longitude| {
            let y = self.relative_to_middle(l);
            if y.sin >= 0.0 { (1.0 + y.sin, y.cos) } else { (y.cos, 1.0 - y.sin) }
        };
        let ((to_growth, to_decay), (from_growth, from_decay)) = (growth(to), growth(from));
        intervals.unweighted += unweighted(to) - unweighted(from);
        intervals.growth *= to_growth * from_decay;
        intervals.decay *= to_decay * from_growth;
    }

    /// Returns the integral of f between two longitudes of a parallel; if W is four, then those of it times the
    /// components of the point.
    pub fn between<const W: usize>(&self, from: Longitude, to: Longitude, z: f64, rho: f64) -> [f64; W] {
        let mut intervals = Intervals::default();
        self.extend(&mut intervals, from, to);
        let light = rho * self.integral(&intervals);
        let [along, across] = if W > 1 { self.moments(from, to) } else { [0.0; 2] };
        let all = [light, rho * rho * along, rho * rho * across, z * light];
        std::array::from_fn(|k| all[k])
    }

    /// Returns the integrals of g cos y and of g sin y between two longitudes.
    ///
    /// With c = cos y and s = sin y the integrands are, over |p| |q| / |p + q|, the product of (cos L c - sin L s)
    /// and (cos gamma c + sin gamma s), times one or s / c.
    fn moments(&self, from: Longitude, to: Longitude) -> [f64; 2] {
        let (middle, gamma) = (self.middle, self.gamma);
        let (both_cos, both_sin) = (middle.cos * gamma.cos, middle.sin * gamma.sin);
        let mixed = middle.cos * gamma.sin - middle.sin * gamma.cos;
        let antiderivatives = |l: Longitude| {
            let y = self.relative_to_middle(l);
            let (angle, product, square) = (y.sin.atan2(y.cos), y.sin * y.cos, 0.5 * y.sin * y.sin);
            let (cosines, sines) = (0.5 * (angle + product), 0.5 * (angle - product));
            [
                both_cos * cosines + mixed * square - both_sin * sines,
                both_cos * square + mixed * sines + both_sin * (y.cos.ln() + square),
            ]
        };
        let (low, high) = (antiderivatives(from), antiderivatives(to));
        [0, 1].map(|k| self.lengths[0] * self.lengths[1] / self.sum * (high[k] - low[k]))
    }

    /// Returns antiderivatives with respect to y of (Q / (P + Q))^2 and (P / (P + Q))^2, each times 1, cos y
    /// and sin y.
    ///
    /// With kappa = |q| / |p + q| the first ratio is kappa (cos gamma + sin gamma tan y), and the second one
    /// likewise with |p| and -L in place of gamma.
    pub fn squares(&self, l: Longitude) -> [[f64; 3]; 2] {
        let y = self.relative_to_middle(l);
        let (angle, log) = (y.sin.atan2(y.cos), -y.cos.ln());
        let (secant, gd) = (1.0 / y.cos, inverse_gudermannian(y));
        let antiderivatives = |length: f64, cos: f64, sin: f64| {
            let (cc, cs, ss) = (cos * cos, 2.0 * cos * sin, sin * sin);
            let factor = (length / self.sum).powi(2);
            [
                factor * (cc * angle + cs * log + ss * (y.sin * secant - angle)),
                factor * (cc * y.sin - cs * y.cos + ss * (gd - y.sin)),
                factor * (-cc * y.cos + cs * (gd - y.sin) + ss * (secant + y.cos)),
            ]
        };
        [
            antiderivatives(self.lengths[1], self.gamma.cos, self.gamma.sin),
            antiderivatives(self.lengths[0], self.middle.cos, -self.middle.sin),
        ]
    }

    /// Returns the components of the point at a longitude and a height: along p + q, perpendicular to it, and
    /// along the pole.
    pub fn components(&self, l: Longitude, z: f64, rho: f64) -> [f64; 3] {
        let y = self.relative_to_middle(l);
        [rho * y.cos, rho * y.sin, z]
    }

    /// Returns the vector in the space of u that has these components along p + q, perpendicular to it, and
    /// along the pole.
    pub fn vector_of(&self, [x, y, z]: [f64; 3]) -> Vec3 {
        let [first, second, pole] = &self.frame;
        let Longitude { sin, cos } = self.middle;
        first * (x * cos - y * sin) + second * (x * sin + y * cos) + pole * z
    }

    /// Returns the natural size of the integral of f over the lune.
    pub fn size(&self) -> f64 {
        self.kernel(self.centre())[0] * self.angle.sin.atan2(-self.angle.cos)
    }

    /// Returns whether the lune is so thin that the closed forms lose digits.
    pub fn is_thin(&self) -> bool {
        self.angle.cos < -0.95
    }
}

/// Returns G(y) = artanh(sin y).
fn inverse_gudermannian(y: Longitude) -> f64 {
    ((1.0 + y.sin.abs()) / y.cos).ln().copysign(y.sin)
}
