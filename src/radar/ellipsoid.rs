//! The echo of one ellipsoid, which others may hide, in bins of frequency and of delay.
//!
//! The ellipsoid x = A s, A = diag(a, b, c), is mapped to the unit sphere of s. With e toward an antenna in body
//! axes, m toward the bisector of both, and n = |A^-1 s|, a point is visible where (A^-1 e).s > 0, the cosine of
//! incidence is (A^-1 m).s / n, and dS = abc n dOmega. Delay and frequency are linear functions of s. With the pole
//! along the gradient of the frequency, a bin of frequency is a zone between two rings, and visibility and delay leave
//! arcs of each ring. The integral over the zone is that of a sum over arcs, as a function of the height z.
//!
//! The sum over all of a ring that is visible, or has a delay below a limit, is expanded between the heights at which
//! its arcs change: its antiderivative gives the echo below any frequency. Differences give the bins. At an end of an
//! arc or of a range of heights, an integrand may go to zero or change with any power of the distance; the
//! substitution x = (3 y - y^3) / 2 doubles that power, and so does each repetition. A range also ends at the height
//! of the peak of a law, near which the nodes are then dense.

use super::arc::Surface;
use super::law::{Law, Roughness};
use super::sphere::{Plane, Quadric, Region};
use crate::error::{Error, Result};
use crate::interrupt::InterruptCheck;
use crate::math::exponential::sin_cos;
use crate::math::lanes::replace;
use crate::math::logarithm::angle;
use crate::math::{Mat3, Vec3, perpendicular};
use crate::photometry::{RULE, in_parallel};
use pulp::{Arch, Simd, WithSimd};

/// The error of an echo, relative to its size; rounding makes it larger for peaks narrower than about 0.03.
const TOLERANCE: f64 = 1e-12;
/// The number of delays for each thread between two interrupt checks.
const GROUP: usize = 8;
/// Units of work of one ring.
const WORK: u64 = 20;

/// A quantity that is a linear function of the position on the surface: its value at the centre, and its gradient.
#[derive(Debug, Clone, Copy)]
pub struct Linear {
    pub at_centre: f64,
    pub gradient: Vec3,
}

/// An ellipsoid that hides one of the two directions from another one, in the axes of that one.
#[derive(Debug, Clone, Copy)]
pub struct HidingEllipsoid {
    /// The direction to the antenna.
    pub direction: Vec3,
    /// The centre of the hiding ellipsoid from that of the other one.
    pub centre: Vec3,
    /// The matrix M of the hiding ellipsoid, with (x - centre).M (x - centre) = 1 on its surface.
    pub matrix: Mat3,
}

/// An ellipsoid as the radar sees it, in its own axes.
#[derive(Debug)]
pub struct Ellipsoid<'a> {
    pub semi_axes: Vec3,
    pub law: &'a Law,
    /// Unit vectors to the receiver and to the transmitter.
    pub directions: [Vec3; 2],
    pub hiding: Vec<HidingEllipsoid>,
    pub frequency: Linear,
    pub delay: Linear,
    /// The time, which an interruption names.
    pub time: f64,
}

/// Returns the substitution x(y) from -1 to 1 and its derivative, applied this many times.
fn smooth(y: f64, times: u32) -> [f64; 2] {
    (0..times).fold([y, 1.0], |[y, slope], _| [0.5 * y * (3.0 - y * y), slope * 1.5 * (1.0 - y) * (1.0 + y)])
}

/// The inverse of the substitution for heights in an interval, which it replaces.
struct Unsmoothed<'a> {
    middle: f64,
    half: f64,
    times: u32,
    heights: &'a mut [f64],
}

impl WithSimd for Unsmoothed<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { middle, half, times, heights } = self;
        replace(
            simd,
            heights,
            #[inline(always)]
            |height| {
                let one = height.constant(1.0);
                let mut x = ((height + (-middle)) * half.recip()).max(-one).min(one);
                for _ in 0..times {
                    let [sine, _] = sin_cos(angle(x, ((one - x) * (one + x)).sqrt()) * (1.0 / 3.0));
                    x = sine + sine;
                }
                x
            },
        );
    }
}

impl Ellipsoid<'_> {
    /// Adds the cross section in each bin to `power`: the bins of frequency, or for each bin of delay those of
    /// frequency. Without edges of delay all delays count.
    ///
    /// # Errors
    /// [`Error::NotConverged`](crate::error::Error::NotConverged) and
    /// [`Error::Interrupted`](crate::error::Error::Interrupted).
    pub fn add(
        &self,
        frequencies: &[f64],
        delays: &[f64],
        power: &mut [f64],
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let semi_axes = &self.semi_axes;
        let gradient = self.frequency.gradient.component_mul(semi_axes);
        let size = gradient.norm();
        let toward = (self.directions[0] + self.directions[1]).normalize().component_div(semi_axes);
        let pole = if size > 0.0 { gradient / size } else { perpendicular(&toward) };
        let across = toward - pole * toward.dot(&pole);
        let first = across.try_normalize(1e-9 * toward.norm()).unwrap_or_else(|| perpendicular(&pole));
        let frame = Mat3::from_columns(&[first, pole.cross(&first), pole]);
        // Rows of A^-1 times the frame: the vectors in the sphere's coordinates.
        let [shrunk, stretched] =
            [semi_axes.map(f64::recip), *semi_axes].map(|d| Mat3::from_diagonal(&d) * frame);
        let volume = semi_axes.product();
        let scale = std::f64::consts::PI * volume * toward.norm() * self.law.albedo;
        let (square, bisector) = (shrunk.tr_mul(&shrunk), frame.tr_mul(&toward));
        let mut region = Region::default();
        for direction in &self.directions[..if self.directions[0] == self.directions[1] { 1 } else { 2 }] {
            region.planes.push(Plane::new(&shrunk.tr_mul(direction), 0.0));
        }
        if self.law.least_cosine > 0.0 {
            let least = self.law.least_cosine;
            let matrix = bisector * bisector.transpose() - square * (least * least);
            region.quadrics.push(Quadric { matrix, linear: Vec3::zeros(), constant: 0.0 });
        }
        region.quadrics.extend(self.hiding.iter().map(|hiding| hiding.quadric(&stretched)));
        let tolerance = TOLERANCE.max(self.law.rounding()) * scale;
        let visible = region.heights();
        let surface =
            Surface::new(self.law, semi_axes, (square, bisector), 0.2 * tolerance, &mut region, &visible);
        let heights = |frequency: &f64| match (frequency - self.frequency.at_centre, size > 0.0) {
            (from, true) => from / size,
            // All of the echo has the frequency of the centre, which belongs to the bin that begins there.
            (from, false) => {
                if from > 0.0 {
                    1.0
                } else {
                    -1.0
                }
            }
        };
        let edges: Vec<f64> = frequencies.iter().map(heights).map(|z| z.clamp(-1.0, 1.0)).collect();
        let zones = Zones { surface, edges, tolerance, time: self.time };
        if delays.is_empty() {
            let sums = zones.below(&mut region, visible, interrupt)?;
            zones.add_bins(&region, [&vec![0.0; sums.len()], &sums], power);
            return Ok(());
        }
        let gradient = stretched.tr_mul(&self.delay.gradient);
        let limits: Vec<Plane> =
            delays.iter().map(|delay| Plane::new(&-gradient, delay - self.delay.at_centre)).collect();
        // All of the delays between two interrupt checks together take a few milliseconds.
        let all = in_parallel(&limits, GROUP, &|_| self.time, interrupt, |limits, interrupt| {
            let below = |limit: &Plane| match limit.side() {
                -1 => Ok(vec![0.0; frequencies.len()]),
                _ => {
                    let mut region = region.within(&[*limit]);
                    let heights = region.heights();
                    zones.below(&mut region, heights, interrupt)
                }
            };
            limits.iter().map(below).collect()
        })?;
        let rows = power.chunks_exact_mut(frequencies.len() - 1);
        for ((limits, sums), power) in limits.windows(2).zip(all.windows(2)).zip(rows) {
            zones.add_bins(&region.within(&[limits[0].flipped(), limits[1]]), [&sums[0], &sums[1]], power);
        }
        Ok(())
    }
}

/// Integrals over the zones of the sphere between edges, which are heights.
struct Zones<'a> {
    surface: Surface<'a>,
    edges: Vec<f64>,
    /// The error of an echo.
    tolerance: f64,
    time: f64,
}

impl Zones<'_> {
    /// Returns the echo of a region below each edge of frequency, given the heights between which its arcs are smooth.
    fn below(
        &self,
        region: &mut Region,
        mut heights: Vec<f64>,
        interrupt: &mut InterruptCheck,
    ) -> Result<Vec<f64>> {
        let (surface, time, arch) = (&self.surface, self.time, Arch::new());
        let times = if matches!(surface.law.roughness(), Roughness::Limb(3..)) { 2 } else { 1 };
        let mut sums = vec![0.0; self.edges.len()];
        let peak = surface.peak.z;
        let above = heights.partition_point(|z| *z < peak);
        if surface.law.roughness() == Roughness::Peak && (1..heights.len()).contains(&above) {
            heights.insert(above, peak);
        }
        for pair in heights.windows(2) {
            let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
            if half < 1e-15 {
                continue;
            }
            // The edges above the interval follow with the last one.
            let first = self.edges.partition_point(|z| *z <= pair[0]);
            let last = self.edges.partition_point(|z| *z < pair[1]);
            let mut ends = self.edges[first..last].to_vec();
            arch.dispatch(Unsmoothed { middle, half, times, heights: &mut ends });
            ends.resize(self.edges.len() - first, 1.0);
            let mut f = |y: f64| {
                interrupt.charge(WORK, time)?;
                let [x, slope] = smooth(y, times);
                let z = middle + half * x;
                let mut sum = Ok(0.0);
                region.arcs(z, |from, to| {
                    if let Ok(total) = &sum {
                        sum = surface.arc(z, from, to).map(|value| total + value);
                    }
                });
                Ok(sum? * half * slope)
            };
            RULE.cumulate([-1.0, 1.0], self.tolerance, &mut f, &ends, &mut sums[first..])?;
        }
        if sums.iter().any(|sum| !sum.is_finite()) {
            let detail = "is no finite number, since the ellipsoid is too flat".to_string();
            return Err(Error::NotConverged { what: "radar echo".to_string(), detail });
        }
        Ok(sums)
    }

    /// Adds to `power` the echo in each bin, given the echoes below its edges up to two delays. The bins beyond the region
    /// between the two delays have none.
    fn add_bins(&self, region: &Region, [lower, upper]: [&[f64]; 2], power: &mut [f64]) {
        let heights = region.corners();
        let (Some(&lowest), Some(&highest)) = (heights.first(), heights.last()) else { return };
        for (k, power) in power.iter_mut().enumerate() {
            if self.edges[k] < highest && self.edges[k + 1] > lowest {
                *power += ((upper[k + 1] - upper[k]) - (lower[k + 1] - lower[k])).max(0.0);
            }
        }
    }
}

impl HidingEllipsoid {
    /// Returns the part of the other ellipsoid's sphere that is not hidden, x = A s = stretched s': the part outside of
    /// the cylinder along the direction.
    fn quadric(&self, stretched: &Mat3) -> Quadric {
        let along = self.matrix * self.direction;
        let section = self.matrix - along * along.transpose() / along.dot(&self.direction);
        let across = stretched.tr_mul(&(section * self.centre));
        Quadric {
            matrix: stretched.tr_mul(&(section * stretched)),
            linear: across * -2.0,
            constant: self.centre.dot(&(section * self.centre)) - 1.0,
        }
    }
}
