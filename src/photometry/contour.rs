//! The brightness of an ellipsoid of which others hide parts, by integrals along their outlines.
//!
//! Let F(l, z) be the integral along the parallel at z from the terminator to the longitude l, which is [`Kernel::below`]. On a
//! parallel an outline covers an interval of longitudes and hides F at its upper end less F at its lower end. The sum over all
//! parallels is a contour integral:
//!
//!   B = int F(limb, z) dz - sum over outlines of int F(l, z) dz,
//!
//! each outline taken round from low to high z at large longitudes and back at small ones. Ends beyond the limb or the terminator
//! are moved onto them. Where outlines overlap, an end within another outline does not count, and of several outlines that
//! reach over a point of the limb only the first one does.
//!
//! An outline is divided into arcs where it crosses the limb, the terminator or another outline. Whether an arc counts is decided at
//! its middle. A crossing that is not found belongs to a near tangency, and what it would change is below rounding. On an arc Gauss's
//! rule is taken in s with the angle m + h s (3 - s^2) / 2, so that square roots at its ends are smooth.
//!
//! Where the outline moves, x by dx at a constant height, the brightness over abc changes by |p| Q/(P+Q) T dx dz for an
//! occultation, since dOmega = dx dz / (p.u / |p|), and by |q| P/(P+Q) T dx dz for an eclipse.

use super::kernel::{Kernel, PARTIAL_TOLERANCE, PARTIALS};
use super::outline::{Hiding, Outline, Spot};
use crate::math::Vec3;
use nalgebra::Matrix3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// What the shift of an outline does to the brightness over abc, as sums over the outline's visible points with weights w: v are
/// points of the hiding ellipsoid's unit sphere, u those of the other one's, and reach is the way from the second to the first
/// along the hidden light.
#[derive(Debug, Clone, Default)]
pub struct Moments {
    /// Sum of w v.
    pub v: Vec3,
    /// Sum of w reach v.
    pub reach_v: Vec3,
    /// Sum of w v u^T.
    pub v_u: Matrix3<f64>,
    /// Sum of w v v^T.
    pub v_v: Matrix3<f64>,
}

/// Sums along an arc: brightness and derivatives, the change by a shift of the outline, and the components of [`Moments`].
const SUMS: usize = PARTIALS + 1 + 24;

/// An arc of an outline: the outline's index, and the middle and half the width of the arc's angles.
type Arc = (usize, f64, f64);

/// A lune under outlines.
pub struct Contour<'a> {
    pub kernel: &'a Kernel<'a>,
    pub outlines: &'a [Outline],
}

impl Contour<'_> {
    /// The arcs that count.
    fn arcs(&self) -> Vec<Arc> {
        let lune = self.kernel.lune;
        let mut breaks: Vec<(usize, f64)> = Vec::with_capacity(16);
        for (index, outline) in self.outlines.iter().enumerate() {
            outline.poles(|angle| breaks.push((index, angle)));
            outline.edges(lune, |angle, z| {
                breaks.push((index, angle));
                // Where an outline begins to cover the limb, others that reach over the limb no longer count.
                for (later, other) in self.outlines.iter().enumerate().skip(index + 1) {
                    other.beyond(lune, z, |angle| breaks.push((later, angle)));
                }
            });
            for (later, other) in self.outlines.iter().enumerate().skip(index + 1) {
                outline.crossings(other, lune, |angle, on_other| {
                    breaks.extend([(index, angle), (later, on_other)]);
                });
            }
        }
        breaks.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut arcs = Vec::with_capacity(breaks.len() + 2);
        let mut rest = &breaks[..];
        for index in 0..self.outlines.len() {
            let (own, later) = rest.split_at(rest.iter().take_while(|one| one.0 == index).count());
            rest = later;
            let mut add = |from: f64, to: f64| {
                let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
                if half > 4.0 * f64::EPSILON && self.counts(index, middle, half) {
                    arcs.push((index, middle, half));
                }
            };
            match own {
                [] => [-FRAC_PI_2, FRAC_PI_2].iter().for_each(|&from| add(from, from + PI)),
                [(_, first), .., (_, last)] | [(_, first @ last)] => {
                    own.windows(2).for_each(|pair| add(pair[0].1, pair[1].1));
                    add(*last, first + TAU);
                }
            }
        }
        arcs
    }

    /// Whether an arc counts, by its middle. An outline along the limb has arcs of which only an end is on the lune.
    fn counts(&self, index: usize, middle: f64, half: f64) -> bool {
        let (lune, outline) = (self.kernel.lune, &self.outlines[index]);
        let mut places = [0.0, -0.98, 0.98].into_iter().map(|share| middle + share * half);
        let Some(spot) = places.find_map(|angle| outline.spot(lune, angle.sin_cos())) else { return false };
        let mut others = self.outlines.iter().enumerate();
        // Of outlines that coincide the first one counts.
        others.all(|(other, hiding)| match other.cmp(&index) {
            std::cmp::Ordering::Equal => true,
            std::cmp::Ordering::Less => hiding.level(lune, &spot) > hiding.level_rounding,
            std::cmp::Ordering::Greater => !spot.own || hiding.level(lune, &spot) > -hiding.level_rounding,
        })
    }

    /// The integrals of functions of the spots along an arc, the angle's sine and cosine, and the factor of the function by which the
    /// angle changes.
    fn along<const W: usize>(
        &self,
        (index, middle, half): Arc,
        tolerances: &[f64],
        f: impl Fn(&Spot, (f64, f64)) -> [f64; W],
    ) -> [f64; W] {
        let (lune, outline) = (self.kernel.lune, &self.outlines[index]);
        self.kernel.rule.integrate(tolerances, &mut |s| {
            let [share, rate] = spread(s);
            let angle = (middle + half * share).sin_cos();
            match outline.spot(lune, angle) {
                Some(spot) => f(&spot, angle).map(|value| half * rate * value),
                None => [0.0; W],
            }
        })
    }

    /// The integral over all parallels of W functions of their height and radius.
    fn over_parallels<const W: usize>(
        &self,
        tolerances: &[f64],
        f: impl Fn(f64, f64) -> [f64; W],
    ) -> [f64; W] {
        let [low, high] = self.kernel.edge_heights().unwrap_or([0.0; 2]);
        let mut total = [0.0; W];
        for [from, to] in [[-1.0, low], [low, high], [high, 1.0]] {
            if to <= from {
                continue;
            }
            let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
            let sums = self.kernel.rule.integrate(tolerances, &mut |s| {
                let [share, rate] = spread(s);
                let z = middle + half * share;
                f(z, ((1.0 - z) * (1.0 + z)).max(0.0).sqrt()).map(|value| half * rate * value)
            });
            total.iter_mut().zip(sums).for_each(|(total, sum)| *total += sum);
        }
        total
    }

    /// The brightness over a b c.
    pub fn brightness(&self) -> f64 {
        let (kernel, limb) = (self.kernel, self.kernel.lune.limb());
        let tolerance = [kernel.tolerance()];
        let [whole] = match kernel.constant {
            // Over the parallels rho^2 has the integral of cos^2 b.
            Some(_) => [FRAC_PI_2 * kernel.below(limb, 0.0, 1.0)],
            None => self.over_parallels(&tolerance, |z, rho| [kernel.below(limb, z, rho)]),
        };
        let arcs = self.arcs().into_iter();
        let hidden = arcs.map(|arc| {
            let height = self.outlines[arc.0].half[1];
            let [sum] = self.along(arc, &tolerance, |spot, (_, cos)| {
                [height * cos * kernel.below(spot.l, spot.z, spot.rho)]
            });
            sum
        });
        whole - hidden.sum::<f64>()
    }

    /// The brightness over a b c with its derivatives, and what the shift of each outline does to it. `hiding` are the ellipsoids
    /// of the outlines, and `lights` the directions to the observer and to the Sun, in the ellipsoid's frame.
    pub fn partials(&self, hiding: &[Hiding], lights: &[Vec3; 2]) -> ([f64; PARTIALS], Vec<Moments>) {
        let (kernel, lune) = (self.kernel, self.kernel.lune);
        let limb = lune.limb();
        let mut tolerances = [PARTIAL_TOLERANCE * lune.lengths[0].max(lune.lengths[1]); PARTIALS + 1];
        tolerances[..PARTIALS].copy_from_slice(&kernel.tolerances());
        let mut total = match kernel.constant {
            // The integral of z is that of an odd function.
            Some(_) => kernel.partials_below(limb, 0.0, 1.0).map(|value| value * FRAC_PI_2),
            None => {
                self.over_parallels(&tolerances[..PARTIALS], |z, rho| kernel.partials_below(limb, z, rho))
            }
        };
        let mut moments = vec![Moments::default(); self.outlines.len()];
        for arc in self.arcs() {
            let (outline, hiding) = (&self.outlines[arc.0], &hiding[arc.0]);
            let light = outline.light as usize;
            let sums: [f64; SUMS] = self.along(arc, &tolerances, |spot, (sin, cos)| {
                let mut all = [0.0; SUMS];
                let below = kernel.partials_below(spot.l, spot.z, spot.rho);
                let height = outline.half[1] * cos;
                all.iter_mut().zip(below).for_each(|(all, value)| *all = height * value);
                if spot.own {
                    let along = lune.lengths[light] * lune.shares(spot.l)[light];
                    // A shift dx by the level of the outline's equation is the width over the cosine.
                    let weight =
                        along * kernel.factor(spot.l, spot.z, spot.rho) * outline.half[0] * outline.half[1];
                    let v = outline.tangent(sin, cos);
                    let u = lune.point(spot.l, spot.z, spot.rho);
                    let tangent = hiding.centre + hiding.rotation * v.component_mul(&hiding.semi_axes);
                    let reach = (tangent - u.component_mul(kernel.semi_axes)).dot(&lights[light]);
                    let weighted = v * weight;
                    all[PARTIALS] = weight;
                    let moments = &mut all[PARTIALS + 1..];
                    moments[..3].copy_from_slice(weighted.as_slice());
                    moments[3..6].copy_from_slice((weighted * reach).as_slice());
                    moments[6..15].copy_from_slice((weighted * u.transpose()).as_slice());
                    moments[15..].copy_from_slice((weighted * v.transpose()).as_slice());
                }
                all
            });
            total.iter_mut().zip(sums).for_each(|(total, sum)| *total -= sum);
            let (found, part) = (&mut moments[arc.0], &sums[PARTIALS + 1..]);
            found.v += Vec3::from_column_slice(&part[..3]);
            found.reach_v += Vec3::from_column_slice(&part[3..6]);
            found.v_u += Matrix3::from_column_slice(&part[6..15]);
            found.v_v += Matrix3::from_column_slice(&part[15..]);
        }
        (total, moments)
    }
}

/// A place between -1 and 1 for s between them, and its derivative, which is zero at both ends.
fn spread(s: f64) -> [f64; 2] {
    [0.5 * s * (3.0 - s * s), 1.5 * (1.0 - s) * (1.0 + s)]
}
