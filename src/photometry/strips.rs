//! The brightness of an ellipsoid of which others hide parts, by strips along the parallels of its lune.
//!
//! On a parallel every outline covers one interval of longitudes, and [`ScatteringKernel`] integrates the brightness
//! over the uncovered intervals. Over the height z Fejér's rule is taken between the heights at which the number or
//! the kind of these intervals changes, in t with z = m + h t (3 - t^2) / 2, so that the square roots at either end
//! are smooth. Where the order of the outlines' ends at either end of such an interval is not that in its
//! middle, the change is sought and the interval divided there.
//!
//! Where the outline moves, x by dx at a constant height, the brightness over abc changes by |p| Q/(P+Q) T dx
//! dz for an occultation, since dOmega = dx dz / (p.u / |p|), and by |q| P/(P+Q) T dx dz for an eclipse.

use super::kernel::{PARTIAL_TOLERANCE, PARTIALS, ScatteringKernel};
use super::lune::{Intervals, Longitude};
use super::outline::{HidingEllipsoid, Outline};
use super::rule::RULE;
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;
use nalgebra::Matrix3;

/// The effect of an outline's shift on the brightness over abc, as sums over the outline's visible points
/// with weights w: v are points of the hiding ellipsoid's unit sphere, u those of the other one's, and h is
/// the distance from the second to the first along the hidden light.
#[derive(Debug, Clone, Default)]
pub struct StripMoments {
    /// Sum of w v.
    pub v: Vec3,
    /// Sum of w h v.
    pub depth_v: Vec3,
    /// Sum of w v u^T.
    pub v_u: Matrix3<f64>,
    /// Sum of w v v^T.
    pub v_v: Matrix3<f64>,
}

/// An end of an uncovered interval of a parallel: its longitude, the outline that it belongs to, and whether it is the
/// upper end of that outline's interval.
type End = (Longitude, Option<(usize, bool)>);

/// The distance from the ends of an interval of heights at which the order of the outlines' ends is compared, as a
/// share of the interval.
const NEXT: f64 = 1e-11;
/// The least such distance, since the error of a break would otherwise divide a narrow interval again and again.
const LEAST: f64 = 8.0 * f64::EPSILON;
/// The largest number of intervals that are divided.
const DIVISIONS: usize = 24;

/// The tolerance of an integral over the height, relative to that of the integrals along parallels, whose errors are
/// noise for it.
const ACROSS: f64 = 8.0;

/// The number that stands for strips that no outline meets, in place of the order of outlines.
const UNCOVERED: u64 = 0;

/// Units of work of a parallel.
const PARALLEL: u64 = 10;

/// A lune under outlines.
pub struct Strips<'a> {
    pub kernel: &'a ScatteringKernel<'a>,
    pub outlines: &'a [Outline],
}

impl Strips<'_> {
    /// Returns intervals of z, in each of which the integrand is smooth but for square roots at the ends.
    ///
    /// Many of the heights at which outlines cross each other or an edge of the lune change nothing, since the crossing
    /// is covered by another outline or lies on the far side. The intervals on both sides are then one.
    fn panels(&self) -> Vec<[f64; 2]> {
        let edges = self.kernel.edge_heights();
        let mut breaks = vec![-1.0, 1.0];
        breaks.extend(edges.into_iter().flatten());
        for (index, outline) in self.outlines.iter().enumerate() {
            outline.breaks(self.kernel.lune, &mut breaks);
            for other in &self.outlines[index + 1..] {
                outline.crossings(other, self.kernel.lune, &mut breaks);
            }
        }
        breaks.retain(|z| z.abs() <= 1.0);
        breaks.sort_unstable_by(f64::total_cmp);
        let pairs = breaks.windows(2).map(|pair| [pair[0], pair[1]]);
        let (mut divisions, mut covered) = (DIVISIONS, Vec::new());
        let mut all: Vec<[f64; 2]> = Vec::new();
        let mut previous = None;
        let mut add = |[low, high]: [f64; 2], order: Option<u64>| {
            let is_edge = edges.is_some_and(|edges| edges.contains(&low));
            match all.last_mut() {
                Some(last) if order.is_some() && order == previous && !is_edge => last[1] = high,
                _ => all.push([low, high]),
            }
            previous = order;
        };
        let mut ahead: Vec<_> = pairs.rev().collect();
        while let Some([low, high]) = ahead.pop() {
            if high - low <= 4.0 * f64::EPSILON {
                continue;
            }
            if !self.is_covered(low, high) {
                add([low, high], Some(UNCOVERED));
                continue;
            }
            let within = |share: f64| low + share * (high - low);
            let middle = within(0.5);
            let expected = self.order(middle, &mut covered);
            let next = NEXT.max(LEAST / (high - low)).min(0.5);
            let ends = [within(next), within(1.0 - next)];
            match ends.into_iter().find(|end| self.order(*end, &mut covered) != expected) {
                Some(end) if divisions > 0 => {
                    divisions -= 1;
                    let change = self.change(expected, middle, end, &mut covered);
                    ahead.extend([[change, high], [low, change]]);
                }
                Some(_) => add([low, high], None),
                None => add([low, high], Some(expected)),
            }
        }
        all
    }

    /// Returns a number that identifies the outlines that bound the uncovered intervals of a parallel, in their order.
    fn order(&self, z: f64, covered: &mut Vec<[End; 2]>) -> u64 {
        let (mut order, (z, rho)) = (1, height(z));
        self.uncovered(z, rho, covered, |from, to| {
            for end in [from.1, to.1] {
                let end_code = end.map_or(0, |(index, upper)| 2 * index as u64 + u64::from(upper) + 1);
                order = (order ^ end_code).wrapping_mul(0x100000001b3);
            }
        });
        order
    }

    /// Returns a height at which the order ceases to be the expected one, between a height with it and one without.
    fn change(&self, expected: u64, mut with: f64, mut without: f64, covered: &mut Vec<[End; 2]>) -> f64 {
        loop {
            let middle = 0.5 * (with + without);
            if (middle - with).abs() <= f64::EPSILON || (without - middle).abs() <= f64::EPSILON {
                return without;
            }
            *(if self.order(middle, covered) == expected { &mut with } else { &mut without }) = middle;
        }
    }

    /// Calls `between` with the ends of each part of a parallel that no outline covers.
    #[inline]
    fn uncovered(&self, z: f64, rho: f64, covered: &mut Vec<[End; 2]>, mut between: impl FnMut(End, End)) {
        let lune = self.kernel.lune;
        covered.clear();
        for (index, outline) in self.outlines.iter().enumerate() {
            if let Some([(low, low_is_outline), (high, high_is_outline)]) = outline.covers(lune, z, rho) {
                let ends = [
                    (low, low_is_outline.then_some((index, false))),
                    (high, high_is_outline.then_some((index, true))),
                ];
                covered.push(ends);
            }
        }
        if covered.len() > 1 {
            covered.sort_unstable_by(|a, b| a[0].0.sin.total_cmp(&b[0].0.sin));
        }
        let mut covered_to: End = (lune.terminator(), None);
        for &[low, high] in &*covered {
            if low.0.sin > covered_to.0.sin {
                between(covered_to, low);
            }
            if high.0.sin > covered_to.0.sin {
                covered_to = high;
            }
        }
        let limb = lune.limb();
        if limb.sin > covered_to.0.sin {
            between(covered_to, (limb, None));
        }
    }

    /// Returns whether an outline covers a part of the strip between two heights.
    fn is_covered(&self, low: f64, high: f64) -> bool {
        self.outlines.iter().any(|outline| outline.meets_parallels(low, high))
    }

    /// Returns whether the strip between two heights has a closed form, since no outline covers a part of it.
    fn has_closed_form(&self, low: f64, high: f64) -> bool {
        self.kernel.constant.is_some() && !self.is_covered(low, high)
    }

    /// Returns the integral of the brightness over the uncovered intervals of a parallel, as
    /// [`ScatteringKernel::between`] does for one interval.
    fn parallel<const W: usize>(
        &self,
        z: f64,
        rho: f64,
        covered: &mut Vec<[End; 2]>,
        interrupt: &mut InterruptCheck,
    ) -> Result<[f64; W]> {
        interrupt.charge(PARALLEL, self.kernel.time)?;
        if let (Some(constant), 1) = (self.kernel.constant, W) {
            let mut intervals = Intervals::default();
            self.uncovered(z, rho, covered, |from, to| {
                self.kernel.lune.extend(&mut intervals, from.0, to.0);
            });
            return Ok([constant * rho * self.kernel.lune.integral(&intervals); W]);
        }
        let mut sums = Ok([0.0; W]);
        self.uncovered(z, rho, covered, |from, to| {
            if let Ok(sums_so_far) = &mut sums {
                match self.kernel.between::<W>(from.0, to.0, z, rho, interrupt) {
                    Ok(part) => sums_so_far.iter_mut().zip(part).for_each(|(sum, part)| *sum += part),
                    Err(error) => sums = Err(error),
                }
            }
        });
        sums
    }

    /// Returns the brightness over a b c; if W is four, then also the integrals of the brightness times the components
    /// of u along p + q, across it and along the pole.
    pub fn light<const W: usize>(&self, interrupt: &mut InterruptCheck) -> Result<[f64; W]> {
        let mut covered = Vec::with_capacity(self.outlines.len());
        let mut total = [0.0; W];
        for [low, high] in self.panels() {
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
            if self.has_closed_form(low, high) {
                let lune = self.kernel.lune;
                let all: [f64; W] =
                    self.kernel.between(lune.terminator(), lune.limb(), 1.0, 1.0, interrupt)?;
                let [across, _, product] = widths(low, high);
                let squared = (high - low) - (high.powi(3) - low.powi(3)) / 3.0;
                let sizes = [across, squared, squared, product];
                (0..W).for_each(|k| total[k] += all[k] * sizes[k]);
                continue;
            }
            let mut f = |t: f64| {
                let (abscissa, slope) = smoothed(t);
                let (z, rho) = height(middle + half * abscissa);
                Ok(self.parallel::<W>(z, rho, &mut covered, interrupt)?.map(|sum| half * slope * sum))
            };
            let tolerances = [ACROSS * self.kernel.tolerance(); W];
            let sums = RULE.integrate([-1.0, 1.0], &tolerances, &mut f, &mut |_| {})?;
            total.iter_mut().zip(sums).for_each(|(total, sum)| *total += sum);
        }
        Ok(total)
    }

    /// Returns the brightness over a b c with its derivatives, and the moments that give the effect of a shift of each
    /// outline. `hiding` are the ellipsoids of the outlines, and `lights` the directions to the observer and to the
    /// Sun, in the ellipsoid's frame.
    pub fn partials(
        &self,
        hiding: &[HidingEllipsoid],
        lights: &[Vec3; 2],
        interrupt: &mut InterruptCheck,
    ) -> Result<([f64; PARTIALS], Vec<StripMoments>)> {
        let mut covered = Vec::with_capacity(self.outlines.len());
        let mut total = [0.0; PARTIALS];
        let mut moments = vec![StripMoments::default(); self.outlines.len()];
        let longest = self.kernel.lune.lengths[0].max(self.kernel.lune.lengths[1]);
        let mut tolerances = [PARTIAL_TOLERANCE * longest; PARTIALS + 1];
        tolerances[..PARTIALS].copy_from_slice(&self.kernel.tolerances());
        tolerances.iter_mut().for_each(|t| *t *= ACROSS);
        for [low, high] in self.panels() {
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
            if self.has_closed_form(low, high) {
                let lune = self.kernel.lune;
                let [across, along, _] = widths(low, high);
                // The third of the derivatives with respect to p and q is that along the pole, with z in
                // place of rho.
                let all =
                    self.kernel.partials_between(lune.terminator(), lune.limb(), 1.0, 1.0, interrupt)?;
                let size = |k: usize| if k == 3 || k == 6 { along } else { across };
                (0..PARTIALS).for_each(|k| total[k] += all[k] * size(k));
                continue;
            }
            let mut accepted = Vec::new();
            let mut f = |t: f64| {
                let (abscissa, slope) = smoothed(t);
                let (z, rho) = height(middle + half * abscissa);
                interrupt.charge(PARALLEL, self.kernel.time)?;
                let mut ends = Vec::new();
                self.uncovered(z, rho, &mut covered, |from, to| ends.push([from, to]));
                let mut sums = [0.0; PARTIALS + 1];
                for [from, to] in ends {
                    let part = self.kernel.partials_between(from.0, to.0, z, rho, interrupt)?;
                    sums.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
                    for end in [from, to] {
                        sums[PARTIALS] += self.flux(end, z, rho).map_or(0.0, |(_, flux)| flux);
                    }
                }
                Ok(sums.map(|sum| half * slope * sum))
            };
            let take = &mut |piece| accepted.push(piece);
            let sums = RULE.integrate([-1.0, 1.0], &tolerances, &mut f, take)?;
            (0..PARTIALS).for_each(|k| total[k] += sums[k]);
            for [t, weight] in accepted.into_iter().flat_map(|piece| RULE.nodes(piece)) {
                let (abscissa, slope) = smoothed(t);
                let (z, rho) = height(middle + half * abscissa);
                let weight = weight * half * slope;
                self.uncovered(z, rho, &mut covered, |from, to| {
                    for end in [from, to] {
                        self.add(end, z, rho, weight, hiding, lights, &mut moments);
                    }
                });
            }
        }
        Ok((total, moments))
    }

    /// Returns the tangent point on the hiding ellipsoid's unit sphere that belongs to an end, and the rate at which
    /// the brightness over abc rises with half the outline's level.
    fn flux(&self, (l, end): End, z: f64, rho: f64) -> Option<(Vec3, f64)> {
        let (index, upper) = end?;
        let outline = &self.outlines[index];
        let crossing = outline.crossing(z, upper)?;
        let light = outline.light as usize;
        let along = self.kernel.lune.lengths[light] * self.kernel.lune.shares(l)[light];
        Some((crossing.tangent, along * self.kernel.factor(l, z, rho) * crossing.shift))
    }

    /// Adds what an end contributes to the moments of its outline.
    #[expect(clippy::too_many_arguments)]
    fn add(
        &self,
        end: End,
        z: f64,
        rho: f64,
        weight: f64,
        hiding: &[HidingEllipsoid],
        lights: &[Vec3; 2],
        moments: &mut [StripMoments],
    ) {
        let (Some((index, _)), Some((v, flux))) = (end.1, self.flux(end, z, rho)) else { return };
        let (hiding, sums) = (&hiding[index], &mut moments[index]);
        let u = self.kernel.lune.point(end.0, z, rho);
        let surface = u.component_mul(self.kernel.semi_axes);
        let tangent = hiding.centre + hiding.rotation * v.component_mul(&hiding.semi_axes);
        let depth = (tangent - surface).dot(&lights[hiding.light as usize]);
        let weighted = v * (weight * flux);
        sums.v += weighted;
        sums.depth_v += weighted * depth;
        sums.v_u += weighted * u.transpose();
        sums.v_v += weighted * v.transpose();
    }
}

/// Returns t (3 - t^2) / 2, which maps [-1, 1] to itself and makes square roots at both ends smooth, and its
/// derivative.
fn smoothed(t: f64) -> (f64, f64) {
    (0.5 * t * (3.0 - t * t), 1.5 * (1.0 - t * t))
}

/// Returns the integrals over the height of the radius of the parallel, of the height, and of the product of both.
fn widths(low: f64, high: f64) -> [f64; 3] {
    let antiderivatives =
        |(z, rho): (f64, f64)| [0.5 * (z * rho + z.atan2(rho)), 0.5 * z * z, -rho.powi(3) / 3.0];
    let (high, low) = (antiderivatives(height(high)), antiderivatives(height(low)));
    [0, 1, 2].map(|k| high[k] - low[k])
}

/// Returns a height, clamped to the sphere, and the radius of its parallel.
fn height(z: f64) -> (f64, f64) {
    let z = z.clamp(-1.0, 1.0);
    (z, ((1.0 - z) * (1.0 + z)).sqrt())
}
