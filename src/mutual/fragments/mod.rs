//! The interaction of two polyhedra near each other, as the sum over pairs of their fragments.
//!
//! Two fragments attract by the harmonic series about their centres of mass where the bound of its error is
//! below their share of the tolerance. Otherwise the larger fragment is replaced by its two halves. The walk
//! over the pairs begins with the whole polyhedra at every pose, so that the result depends on the pose, the
//! tolerance and the number of pairs that share it, and not on earlier poses.
//!
//! Every pair has the same share, since a smaller error of a pair costs about as much in any of them. The
//! number of shares is chosen between steps, by counting the pairs. The bounds add up to less than the
//! tolerance, relative to the force of two points and for the torques to this force times the radius. Where
//! the sum would exceed the tolerance, as with overlapping bodies within a trial step, the result is NaN,
//! which rejects the step.
//!
//! The series of fragments in contact does not converge, but the field of a fragment is bounded by its volume:
//! where this bound of a pair's interaction is below their share, the fragments count as points.

mod bound;
mod choice;
mod derivatives;
mod tree;

use super::harmonic::{Series, Tables, Truncation};
use super::part_offsets::PartOffsets;
use super::{Interaction, Pose};
use crate::interrupt::UNITS;
use crate::math::rotation::rotate;
use crate::math::{Mat3, Vec3};
use crate::shape::Placement;
use bound::{BoundWeights, SeriesDegrees};
use pulp::Arch;
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use tree::Fragment;
pub(super) use tree::FragmentTree;

/// The factor by which an evaluation may exceed the work for which its piece was made before a step is
/// rejected.
const WORK_FACTOR: u64 = 8;
/// The largest number of pairs on the stack of the walk: twice the halvings of both polyhedra.
const MOST_PAIRS: usize = 256;
/// The work of bounding a pair of fragments.
const BOUND_WORK: u64 = 20;

/// The rule over fragments of a pair of polyhedra.
#[derive(Debug, Clone)]
pub(super) struct Fragments {
    trees: [Arc<FragmentTree>; 2],
    tables: Arc<Tables>,
    weights: Arc<BoundWeights>,
    truncation: Truncation,
    arch: Arch,
    radii: [f64; 2],
    tolerance: f64,
    /// The number of equal shares of the tolerance.
    pub shares: u32,
    /// The beginnings of the pieces of an evaluation in the order of the walk, with the largest sums of
    /// bounds that they may have, relative to the tolerance.
    pieces: Vec<(usize, f64)>,
    /// The work of an evaluation at the pose for which the rule was chosen.
    pub work: u64,
    /// The sum of the bounds at the pose for which the rule was chosen.
    pub bound: f64,
}

/// The quantities that are to be within the tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Accuracy {
    Loads,
    Derivatives,
}

/// Two fragments whose interaction is evaluated without further halving.
struct PairOfFragments<'a> {
    fragments: [&'a Fragment; 2],
    series: SeriesDegrees,
    /// The pair's position in the order of the walk.
    position: usize,
}

/// A step of the walk.
enum Step<'a, 'b> {
    /// A fragment of the first or the second polyhedron is replaced by its halves.
    Halve(usize, &'a Fragment),
    /// A pair is evaluated.
    Take(&'b PairOfFragments<'a>),
}

impl Step<'_, '_> {
    fn work(&self) -> u64 {
        match self {
            Self::Halve(..) => BOUND_WORK,
            Self::Take(pair) => BOUND_WORK + pair.work(),
        }
    }
}

/// Two fragments on the stack of the walk, with the first position of their pairs and the number of positions.
type StackEntry<'a> = ([&'a Fragment; 2], usize, usize);

impl PairOfFragments<'_> {
    fn work(&self) -> u64 {
        let [p, q] = self.series.degrees.map(|degree| degree as u64);
        (p * p * p + q * q * q + p * q * (p + q)) / 12
    }

    /// Returns the fragments as two parts of the polyhedra.
    fn offsets(&self) -> PartOffsets {
        let [first, second] = self.fragments;
        let placement =
            |fragment: &Fragment| Some(Placement { position: fragment.centre, rotation: Mat3::identity() });
        PartOffsets {
            parts: [0, 0],
            share: first.share * second.share,
            placements: [placement(first), placement(second)],
        }
    }
}

impl Fragments {
    /// Returns the largest sum of the bounds of all pairs, relative to the force of two points:
    /// the tolerance at a separation, or where the circumscribed spheres overlap at the sum of their radii.
    fn error_limit(&self, pose: &Pose) -> f64 {
        let [first, second] = self.radii;
        self.tolerance / pose.separation.norm().max(first + second).powi(2)
    }

    /// Calls a function with each pair of fragments in a range of positions. Returns false where it stops the
    /// walk, or where the halves are too many.
    fn walk<'a>(
        &'a self,
        pose: &Pose,
        accuracy: Accuracy,
        range: &Range<usize>,
        shares: u32,
        mut visit: impl FnMut(Step<'a, '_>) -> ControlFlow<()>,
    ) -> bool {
        let [first, second] = self.trees.each_ref().map(|tree| &tree.root);
        let share = 0.5 * self.error_limit(pose) / f64::from(shares);
        let mut stack: [StackEntry<'a>; MOST_PAIRS] = [([first, second], 0, usize::MAX); MOST_PAIRS];
        let mut length = 1;
        while length > 0 {
            length -= 1;
            let (fragments, position, span) = stack[length];
            if let Some(series) = self.series_degrees(fragments, pose, accuracy, share) {
                let pair = PairOfFragments { fragments, series, position };
                if range.contains(&position) && visit(Step::Take(&pair)).is_break() {
                    return false;
                }
                continue;
            }
            let larger = usize::from(fragments[1].radius > fragments[0].radius);
            if length + 2 > MOST_PAIRS || visit(Step::Halve(larger, fragments[larger])).is_break() {
                return false;
            }
            let halves = self.trees[larger].halves(fragments[larger]);
            let half = span / 2;
            for (k, start) in [(1, position + half), (0, position)] {
                let mut next = fragments;
                next[larger] = &halves[k];
                // A pair of no span has the position of its first pair.
                if start < range.end && start.saturating_add(half.max(1)) > range.start {
                    stack[length] = (next, start, half);
                    length += 1;
                }
            }
        }
        true
    }

    /// Returns the degrees of two fragments for which the error is below a share of the force of two points;
    /// degrees of zero where the centres alone suffice, `None` where no degrees do.
    fn series_degrees(
        &self,
        [a, b]: [&Fragment; 2],
        pose: &Pose,
        accuracy: Accuracy,
        share: f64,
    ) -> Option<SeriesDegrees> {
        let separation = pose.separation + rotate(&pose.rotation_second, &b.centre)
            - rotate(&pose.rotation_first, &a.centre);
        let (distance, masses) = (separation.norm(), a.share * b.share);
        // Torques are about the polyhedra's centres, and their errors relative to the force times the radii.
        let arm = |k: usize, fragment: &Fragment| (fragment.centre.norm() + distance) / self.radii[k];
        let mut weight = masses * arm(0, a).max(arm(1, b)).max(1.0);
        if accuracy == Accuracy::Derivatives {
            // The next derivative of a term of degree n has the factor (n + 2)/d.
            let near = distance.max(a.radius + b.radius);
            weight *= (2 * self.trees[0].degree + 2) as f64 * (self.radii[0] + self.radii[1]) / near;
        }
        let scale = weight / (distance * distance);
        if let Some(SeriesDegrees { degrees, bound }) = self.weights.degrees([a, b], distance, share / scale)
        {
            return Some(SeriesDegrees { degrees, bound: bound * scale });
        }
        // Both the force and that of two points are below this bound.
        let bound = 2.0 * weight * a.field_bound.min(b.field_bound).max((a.radius + b.radius).powi(-2));
        (masses == 0.0 || bound <= share)
            .then_some(SeriesDegrees { degrees: [0; 2], bound: bound.min(share) })
    }

    /// Evaluates all pairs of fragments in a range of positions. Returns false where the sum of their bounds
    /// exceeds the tolerance, or where they take much more work than at the pose for which the rule was chosen.
    fn evaluate<'a>(
        &'a self,
        pose: &Pose,
        accuracy: Accuracy,
        range: &Range<usize>,
        mut add: impl FnMut(&Series<'_>, &PartOffsets, &Pose, [&'a Fragment; 2]),
    ) -> bool {
        let piece = self.ranges().position(|piece| piece == *range);
        let part = piece.map_or(1.0, |piece| self.pieces[piece].1);
        let most_work = if piece.is_some() { WORK_FACTOR * UNITS } else { self.most_work() };
        let (mut work_left, mut bound_left) = (most_work, part * self.error_limit(pose));
        self.walk(pose, accuracy, range, self.shares, |step| {
            let Some(remainder) = work_left.checked_sub(step.work()) else { return ControlFlow::Break(()) };
            work_left = remainder;
            let Step::Take(pair) = step else { return ControlFlow::Continue(()) };
            bound_left -= pair.series.bound;
            if bound_left < 0.0 {
                return ControlFlow::Break(());
            }
            self.add_pair(pose, pair, &mut add);
            ControlFlow::Continue(())
        })
    }

    /// Calls a function with the series of a pair and its pose.
    fn add_pair<'a>(
        &'a self,
        pose: &Pose,
        pair: &PairOfFragments<'a>,
        add: &mut impl FnMut(&Series<'_>, &PartOffsets, &Pose, [&'a Fragment; 2]),
    ) {
        let offsets = pair.offsets();
        let mut pose = offsets.pose(pose);
        // Fragments that overlap count as points at the sum of their radii.
        let (distance, near) = (pose.separation.norm(), pair.fragments.map(|f| f.radius).iter().sum());
        if pair.series.degrees == [0; 2] && distance < near {
            let direction = if distance > 0.0 { pose.separation / distance } else { Vec3::x() };
            pose.separation = direction * near;
        }
        if offsets.share > 0.0 {
            add(&self.series(pair), &offsets, &pose, pair.fragments);
        }
    }

    fn series<'a>(&'a self, pair: &PairOfFragments<'a>) -> Series<'a> {
        let moments = pair.fragments.map(|fragment| fragment.moments.as_slice());
        let radii = pair.fragments.map(|fragment| fragment.radius);
        let (degrees, factors) = (pair.series.degrees, &self.truncation.factors);
        Series { tables: &self.tables, moments, radii, degrees, factors, arch: self.arch }
    }

    /// Returns force and torques from the pairs in a range of positions; NaN where the tolerance is not kept.
    pub fn interaction(&self, pose: &Pose, range: &Range<usize>) -> Interaction {
        let mut sum = Interaction::ZERO;
        let complete = self.evaluate(pose, Accuracy::Loads, range, |series, offsets, at, _| {
            sum.add(&offsets.about_centres(pose, series.interaction(at)));
        });
        if complete { sum } else { sum.times(f64::NAN) }
    }

    /// Returns the mutual potential U (positive) per unit G m m, NaN where the tolerance is not kept.
    pub fn mutual_potential(&self, pose: &Pose, range: &Range<usize>) -> f64 {
        let mut sum = 0.0;
        let complete = self.evaluate(pose, Accuracy::Loads, range, |series, offsets, at, _| {
            sum += offsets.share * series.mutual_potential(at);
        });
        if complete { sum } else { f64::NAN }
    }
}
