//! Integrals of a scattering law along arcs of a ring on the unit sphere of an ellipsoid.
//!
//! A Gauss rule is chosen once for an ellipsoid: the smallest that agrees with the next one on arcs of some rings, from
//! limb to limb and, where the law is not smooth at the limb, a little shorter. A law with a peak that is too sharp for the
//! largest rule is integrated adaptively. With an exponent of the cosine that is no whole number the integrand goes to
//! zero at the limb with a power that is not whole either; the substitution x(y) of Korobov's kind, with x' in proportion to
//! (1 - y^2)^3, quadruples that power.

use super::law::Law;
use super::sphere::Region;
use crate::error::Result;
use crate::math::{Mat3, Vec3};
use crate::photometry::RULE;
use gauss_quad::GaussLegendre;
use std::num::NonZeroUsize;
use std::sync::LazyLock;

/// The numbers of nodes of the rules.
const ORDERS: [usize; 8] = [12, 16, 24, 32, 48, 64, 96, 144];
/// Heights of rings on which rules are compared, between the lowest and the highest ring of the echo.
const HEIGHTS: [f64; 5] = [-0.9, -0.5, 0.0, 0.5, 0.9];

/// The shares of an arc that are cut off at both its ends.
const SHORTER: [f64; 4] = [0.0, 1e-3, 1e-2, 1e-1];

/// The nodes above zero of a symmetric rule on [-1, 1], with their weights.
type HalfRule = Vec<[f64; 2]>;

/// The plain rules, and those with the substitution.
static RULES: LazyLock<[Vec<HalfRule>; 2]> = LazyLock::new(|| {
    let rules = |map: fn(f64) -> [f64; 2]| {
        let half = |order: &usize| {
            // The orders are above zero.
            let rule = GaussLegendre::new(NonZeroUsize::new(*order).unwrap_or(NonZeroUsize::MIN));
            let positive = rule.nodes().zip(rule.weights()).filter(|(y, _)| **y > 0.0);
            positive.map(|(y, weight)| [map(*y)[0], weight * map(*y)[1]]).collect()
        };
        ORDERS.iter().map(half).collect()
    };
    [rules(|y| [y, 1.0]), rules(korobov)]
});

/// The substitution x(y) from -1 to 1 and its derivative.
fn korobov(y: f64) -> [f64; 2] {
    let square = y * y;
    [
        y * (35.0 + square * (-35.0 + square * (21.0 - 5.0 * square))) / 16.0,
        35.0 / 16.0 * (1.0 - square).powi(3),
    ]
}

/// The law over the surface of an ellipsoid, in the coordinates of its unit sphere.
pub struct Surface<'a> {
    pub law: &'a Law,
    /// The product of the semi-axes.
    pub volume: f64,
    /// The matrix of n^2, with n = |A^-1 s|.
    pub square: Mat3,
    /// The vector A^-1 m, with m toward the bisector of the directions to the antennas.
    pub bisector: Vec3,
    /// The error of an integral over an arc.
    pub tolerance: f64,
    rule: Option<&'static HalfRule>,
}

impl<'a> Surface<'a> {
    /// Takes what is integrated, and chooses the rule for the arcs of a region.
    pub fn new(
        law: &'a Law,
        (volume, square, bisector): (f64, Mat3, Vec3),
        tolerance: f64,
        region: &mut Region,
    ) -> Self {
        let mut surface = Self { law, volume, square, bisector, tolerance, rule: None };
        let rules = &RULES[usize::from(law.is_rough_at_limb())];
        // The cosine of incidence is one where the normal A^-1 s is along A^-1 (square^-1 bisector).
        let peak = square.try_inverse().map_or(0.0, |inverse| (inverse * bisector).normalize().z);
        let (mut arcs, heights) = (Vec::new(), region.corners());
        let (low, high) = (heights.first().map_or(0.0, |z| *z), heights.last().map_or(0.0, |z| *z));
        let rings = HEIGHTS.map(|share| 0.5 * (low + high + share * (high - low)));
        let shares: &[f64] = if law.has_whole_power() { &[0.0] } else { &SHORTER };
        for z in rings.into_iter().chain([peak]) {
            region.arcs(z, |from, to| {
                arcs.extend(
                    shares.iter().map(|share| [z, from + share * (to - from), to - share * (to - from)]),
                );
            });
        }
        let sums = |rule: &HalfRule| arcs.iter().map(|arc| surface.gauss(*arc, rule)).collect::<Vec<_>>();
        let mut coarse = sums(&rules[0]);
        for pair in rules.windows(2) {
            let fine = sums(&pair[1]);
            if coarse.iter().zip(&fine).all(|(one, other)| (one - other).abs() <= tolerance) {
                surface.rule = Some(&pair[0]);
                break;
            }
            coarse = fine;
        }
        surface
    }

    /// Returns the integral of the law over an arc of a ring.
    pub fn arc(&self, z: f64, from: f64, to: f64) -> Result<f64> {
        if let Some(rule) = self.rule {
            return Ok(self.gauss([z, from, to], rule));
        }
        let (ring, half) = (Ring::new(self, z), 0.5 * (to - from));
        let mut f = |y: f64| {
            let [x, slope] = if self.law.is_rough_at_limb() { korobov(y) } else { [y, 1.0] };
            let (sin, cos) = (0.5 * (from + to) + half * x).sin_cos();
            Ok([ring.value(self.law, sin, cos) * slope])
        };
        let scale = self.volume * half;
        // The error of a short arc may be as large as that of a longer one.
        let tolerance = self.tolerance / scale.max(1e-3 * self.volume);
        let [sum] = RULE.integrate([-1.0, 1.0], &[tolerance], &mut f, &mut |_| {})?;
        Ok(scale * sum)
    }

    fn gauss(&self, [z, from, to]: [f64; 3], rule: &HalfRule) -> f64 {
        let (ring, half) = (Ring::new(self, z), 0.5 * (to - from));
        let (sin, cos) = (0.5 * (from + to)).sin_cos();
        let mut sum = 0.0;
        for [x, weight] in rule {
            let (s, c) = (half * x).sin_cos();
            let (sc, cs, ss, cc) = (sin * c, cos * s, sin * s, cos * c);
            sum += weight * (ring.value(self.law, sc + cs, cc - ss) + ring.value(self.law, sc - cs, cc + ss));
        }
        self.volume * half * sum
    }
}

/// The quadratic form n^2 and the linear one A^-1 m on a ring, as functions of cosine and sine of the longitude.
struct Ring {
    constant: f64,
    linear: [f64; 2],
    quadratic: [f64; 3],
    along: f64,
    across: [f64; 2],
}

impl Ring {
    fn new(Surface { square: q, bisector: m, .. }: &Surface<'_>, z: f64) -> Self {
        let rho = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        Self {
            constant: q[(2, 2)] * z * z,
            linear: [0, 1].map(|k| 2.0 * q[(k, 2)] * z * rho),
            quadratic: [q[(0, 0)], 2.0 * q[(0, 1)], q[(1, 1)]].map(|value| value * rho * rho),
            along: m.z * z,
            across: [m.x * rho, m.y * rho],
        }
    }

    /// Returns n times the law at a longitude; nothing is reflected from behind the limb, which only rounding reaches.
    #[inline]
    fn value(&self, law: &Law, sin: f64, cos: f64) -> f64 {
        let n = (self.constant
            + cos * (self.linear[0] + self.quadratic[0] * cos + self.quadratic[1] * sin)
            + sin * (self.linear[1] + self.quadratic[2] * sin))
            .sqrt();
        let cosine = (self.along + self.across[0] * cos + self.across[1] * sin) / n;
        n * law.cross_section(cosine.max(0.0))
    }
}
