//! Integrals of a scattering law along arcs of a ring on the unit sphere of an ellipsoid.
//!
//! A Gauss rule is chosen once for an ellipsoid: the smallest that agrees with the next one on arcs of some rings. Where
//! a law is not smooth, an arc is the sum or difference of two arcs that begin at that point, and on each the nodes
//! follow from the substitution t^p. If the exponent of the cosine is not an integer, the integrand goes to zero at the
//! limb with a power that is not an integer either, which the substitution makes large. Near a peak the substitution
//! makes the nodes dense. Arcs for which no rule is accurate are integrated adaptively.

use super::law::{LIMB, Law, Roughness};
use super::sphere::{Region, wrapped};
use crate::error::Result;
use crate::math::exponential::sin_cos;
use crate::math::lanes::{BLOCK, Lanes, Total};
use crate::math::{Mat3, Vec3};
use crate::photometry::RULE;
use gauss_quad::GaussLegendre;
use pulp::{Arch, Scalar, Simd, WithSimd};
use std::f64::consts::PI;
use std::num::NonZeroUsize;
use std::sync::LazyLock;

/// The numbers of nodes of the rules.
const ORDERS: [usize; 6] = [16, 32, 48, 64, 96, 144];
/// The power of the substitution at a peak.
const PEAK: usize = 3;
/// Heights of rings on which rules are compared, between the lowest and the highest ring of the echo.
const HEIGHTS: [f64; 5] = [-0.9, -0.5, 0.0, 0.5, 0.9];
/// The shares of an arc by which it is shortened at both ends for the comparison of rules, where a law is not smooth.
const SHORTENING: [f64; 2] = [0.0, 0.1];
/// The distance of an arc from the limb, in lengths of the arc, from which on the limb has no effect on the rule.
const LIMB_DISTANCE: f64 = 0.125;
/// The largest shift of the longitude of a peak with the height, which is linear near the peak alone.
const LARGEST_SHIFT: f64 = 0.2;
/// The largest half of a ring's arc from limb to limb; a longer one has both limbs near each other.
const LONGEST: f64 = 0.75 * PI;

/// The nodes of a rule and their weights, with nodes of no weight up to whole registers.
#[derive(Debug)]
struct Rule {
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

/// The rules on [-1, 1] without a substitution, and then for each power p those on [0, 1] with the substitution t^p.
static RULES: LazyLock<Vec<[Rule; ORDERS.len()]>> = LazyLock::new(|| {
    let unsubstituted = ORDERS.map(|order| Rule::new(order, |x| [x, 1.0]));
    let substituted = |p: i32| {
        let map = move |t: f64| [t.powi(p), 0.5 * f64::from(p) * t.powi(p - 1)];
        ORDERS.map(|order| Rule::new(order, |x| map(0.5 * (1.0 + x))))
    };
    std::iter::once(unsubstituted).chain((1..=LIMB as i32).map(substituted)).collect()
});

impl Rule {
    /// Makes a rule with the nodes and weights that a map and its derivative give.
    fn new(order: usize, map: impl Fn(f64) -> [f64; 2]) -> Self {
        // The orders are above zero.
        let rule = GaussLegendre::new(NonZeroUsize::new(order).unwrap_or(NonZeroUsize::MIN));
        let size = order.next_multiple_of(BLOCK);
        let (mut nodes, mut weights) = (vec![0.5; size], vec![0.0; size]);
        for (k, (x, weight)) in rule.nodes().zip(rule.weights()).enumerate() {
            let [node, derivative] = map(*x);
            (nodes[k], weights[k]) = (node, weight * derivative);
        }
        Self { nodes, weights }
    }
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
    /// Where the cosine of incidence is one.
    pub peak: Vec3,
    /// The longitude of the peak of the law, or of the middle of the lit arcs, and how it changes with the height.
    azimuth: f64,
    slope: f64,
    /// The index of the rule.
    rule: Option<usize>,
    arch: Arch,
}

impl<'a> Surface<'a> {
    /// Takes the law and the ellipsoid, and chooses the rule for the arcs of a region.
    pub fn new(
        law: &'a Law,
        semi_axes: &Vec3,
        (square, bisector): (Mat3, Vec3),
        tolerance: f64,
        region: &mut Region,
        heights: &[f64],
    ) -> Self {
        // The cosine of incidence is one where the normal A^-1 s is along A^-1 (square^-1 bisector).
        let peak = square.try_inverse().map_or(bisector, |inverse| (inverse * bisector).normalize());
        let middle = if law.roughness() == Roughness::Peak { peak } else { bisector };
        let mut surface = Self {
            law,
            volume: semi_axes.product(),
            square,
            bisector,
            tolerance,
            peak,
            azimuth: middle.y.atan2(middle.x),
            slope: 0.0,
            rule: None,
            arch: Arch::new(),
        };
        if law.roughness() == Roughness::Peak {
            // Near the peak, n^2 times the squared sine of incidence is this quadratic form of the distance from it.
            let form = square - bisector * bisector.transpose();
            let rho = peak.x.hypot(peak.y);
            let along = Vec3::new(-peak.y, peak.x, 0.0);
            let up = Vec3::new(-peak.x * peak.z, -peak.y * peak.z, rho * rho) / (rho * rho);
            let derivative = -up.dot(&(form * along)) / along.dot(&(form * along));
            // A peak at the pole has no longitude.
            surface.slope = if derivative.is_finite() { derivative } else { 0.0 };
        }
        let mut arcs = Vec::new();
        let (low, high) = (heights.first().map_or(0.0, |z| *z), heights.last().map_or(0.0, |z| *z));
        let rings = HEIGHTS.map(|share| 0.5 * (low + high + share * (high - low)));
        let shares: &[f64] = if law.roughness() == Roughness::None { &[0.0] } else { &SHORTENING };
        for z in rings.into_iter().chain([peak.z]) {
            region.arcs(z, |from, to| {
                arcs.extend(
                    shares.iter().map(|share| [z, from + share * (to - from), to - share * (to - from)]),
                );
            });
        }
        let sums = |rule: usize| {
            let sum = |[z, from, to]: &[f64; 3]| surface.by_rule(rule, *z, *from, *to);
            arcs.iter().map(sum).collect::<Vec<_>>()
        };
        let mut coarse = sums(0);
        let agree = |(one, other): (&Option<f64>, &Option<f64>)| match (one, other) {
            (Some(one), Some(other)) => (one - other).abs() <= tolerance + 4.0 * law.rounding() * other.abs(),
            _ => true,
        };
        for rule in 1..ORDERS.len() {
            let fine = sums(rule);
            if fine.iter().any(Option::is_some) && coarse.iter().zip(&fine).all(agree) {
                surface.rule = Some(rule - 1);
                break;
            }
            coarse = fine;
        }
        surface
    }

    /// Returns the longitude on a ring near which the law has its peak, or the middle of the lit arc.
    fn azimuth(&self, z: f64) -> f64 {
        self.azimuth + (self.slope * (z - self.peak.z)).clamp(-LARGEST_SHIFT, LARGEST_SHIFT)
    }

    /// Returns the integral of the law over an arc of a ring.
    pub fn arc(&self, z: f64, from: f64, to: f64) -> Result<f64> {
        if let Some(sum) = self.rule.and_then(|rule| self.by_rule(rule, z, from, to)) {
            return Ok(sum);
        }
        let peak = from + (self.azimuth(z) - from).rem_euclid(2.0 * PI);
        if self.law.roughness() == Roughness::Peak && peak < to {
            return Ok(self.adaptive(z, from, peak)? + self.adaptive(z, peak, to)?);
        }
        self.adaptive(z, from, to)
    }

    /// Returns the integral over an arc to the tolerance.
    fn adaptive(&self, z: f64, from: f64, to: f64) -> Result<f64> {
        let (half, ring) = (0.5 * (to - from), Ring::new(self, z).about(0.5 * (from + to)));
        // The substitution doubles a power of the distance from the limb, and makes the nodes dense at both ends.
        let mut f = |y: f64| {
            let x = 0.5 * y * (3.0 - y * y);
            let angle = Lanes::<_, 1>::splat(Scalar, half * x);
            Ok([ring.values(self.law, angle).first() * 1.5 * (1.0 - y) * (1.0 + y)])
        };
        let scale = self.volume * half;
        // The error of a short arc may be as large as that of a longer one.
        let tolerance = self.tolerance / scale.max(1e-3 * self.volume);
        let [sum] = RULE.integrate([-1.0, 1.0], &[tolerance], &mut f, &mut |_| {})?;
        Ok(scale * sum)
    }

    /// Returns the integral over an arc by rules of one order, or `None` if no rule serves, because the ends of the lit arc
    /// of the ring are near each other or the arc goes round the ring.
    fn by_rule(&self, rule: usize, z: f64, from: f64, to: f64) -> Option<f64> {
        let ring = Ring::new(self, z);
        let piece = |power: usize, base: f64, length: f64| {
            let rule = &RULES[power][rule];
            let ring = ring.about(base);
            self.volume * length * self.arch.dispatch(Sum { law: self.law, ring: &ring, rule, length })
        };
        let unsubstituted = || piece(0, 0.5 * (from + to), 0.5 * (to - from));
        let power = match self.law.roughness() {
            Roughness::None => return Some(unsubstituted()),
            Roughness::Limb(power) => power,
            Roughness::Peak => {
                let peak = self.azimuth(z);
                let middle = wrapped(0.5 * (from + to) - peak);
                let [start, end] = [-0.5, 0.5].map(|share| middle + share * (to - from));
                let beside = |end: f64| piece(PEAK, peak, end);
                return (start >= -PI && end <= PI).then(|| beside(end) - beside(start));
            }
        };
        let (azimuth, half) = (self.azimuth, ring.half_lit()?);
        // The ends of the arc from the middle of the lit arc.
        let start = wrapped(0.5 * (from + to) - azimuth) - 0.5 * (to - from);
        let (start, end) = (start.max(-half), (start + to - from).min(half));
        let length = end - start;
        if (half + start).min(half - end) >= LIMB_DISTANCE * length {
            return Some(unsubstituted());
        }
        // The integrals from one limb; they are exact up to a share of the distance to the other one.
        let lower = |end: f64| if end > -half { piece(power, azimuth - half, end + half) } else { 0.0 };
        let upper = |start: f64| if start < half { piece(power, azimuth + half, start - half) } else { 0.0 };
        Some(if 2.0 * (half - end) >= end + half {
            lower(end) - lower(start)
        } else if 2.0 * (half + start) >= half - start {
            upper(end) - upper(start)
        } else {
            lower(0.0) - lower(start) + upper(end) - upper(0.0)
        })
    }
}

/// The quadratic form n^2 and the linear one A^-1 m on a ring, as functions of the longitude from a base.
struct Ring {
    constant: f64,
    linear: [f64; 2],
    /// The factors of the cosine and sine of twice the longitude.
    double: [f64; 2],
    along: f64,
    across: [f64; 2],
}

impl Ring {
    fn new(Surface { square: q, bisector: m, .. }: &Surface<'_>, z: f64) -> Self {
        let square = ((1.0 - z) * (1.0 + z)).max(0.0);
        let rho = square.sqrt();
        Self {
            constant: q[(2, 2)] * z * z + 0.5 * square * (q[(0, 0)] + q[(1, 1)]),
            linear: [0, 1].map(|k| 2.0 * q[(k, 2)] * z * rho),
            double: [0.5 * square * (q[(0, 0)] - q[(1, 1)]), square * q[(0, 1)]],
            along: m.z * z,
            across: [m.x * rho, m.y * rho],
        }
    }

    /// Returns half the length of the arc on which the cosine of incidence is above zero, if there is one whose ends are
    /// apart from each other.
    fn half_lit(&self) -> Option<f64> {
        let [x, y] = self.across;
        let half = (-self.along / (x * x + y * y).sqrt()).acos();
        (half <= LONGEST).then_some(half)
    }

    /// Returns the same functions of the longitude from a base.
    fn about(&self, base: f64) -> Self {
        let (sin, cos) = base.sin_cos();
        let rotated = |[x, y]: [f64; 2], sin: f64, cos: f64| [x * cos + y * sin, y * cos - x * sin];
        Self {
            constant: self.constant,
            linear: rotated(self.linear, sin, cos),
            double: rotated(self.double, 2.0 * sin * cos, (cos - sin) * (cos + sin)),
            along: self.along,
            across: rotated(self.across, sin, cos),
        }
    }

    /// Returns n times the law at longitudes from -pi to pi about the base; nothing is reflected from behind the limb,
    /// which only rounding reaches.
    #[inline(always)]
    fn values<S: Simd, const N: usize>(&self, law: &Law, longitude: Lanes<S, N>) -> Lanes<S, N> {
        let c = |value| longitude.constant(value);
        let [sin, cos] = sin_cos(longitude);
        let by_sine = sin.mul_add(c(-2.0 * self.double[0]), cos * (2.0 * self.double[1]));
        let by_sine = by_sine + c(self.linear[1]);
        let constant = cos.mul_add(c(self.linear[0]), c(self.constant + self.double[0]));
        let square = sin.mul_add(by_sine, constant);
        let across = cos.mul_add(c(self.across[0]), c(self.along));
        let product = sin.mul_add(c(self.across[1]), across);
        law.times_length(product, square)
    }
}

/// The weighted sum of values at the nodes of a rule, times the length of the arc.
struct Sum<'a> {
    law: &'a Law,
    ring: &'a Ring,
    rule: &'a Rule,
    length: f64,
}

impl WithSimd for Sum<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let mut total = Total::zero(simd);
        let weights = Lanes::<S>::blocks(simd, &self.rule.weights);
        for (node, weight) in Lanes::<S>::blocks(simd, &self.rule.nodes).zip(weights) {
            total.add_product(weight, self.ring.values(self.law, node * self.length));
        }
        total.value()
    }
}
