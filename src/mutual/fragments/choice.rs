//! The choice, between steps, of the rule over fragments and of the number of shares of its tolerance.

use super::bound::MOST_DEGREES;
use super::{Accuracy, BoundWeights, FragmentTree, Fragments, Step, WORK_FACTOR};
use crate::error::{Error, Result};
use crate::interrupt::{InterruptCheck, UNITS};
use crate::mutual::harmonic::{Tables, Truncation};
use crate::mutual::{Method, Pair, Pose};
use std::ops::{ControlFlow, Range};
use std::sync::Arc;

/// The least product of two polyhedra's numbers of faces for which fragments can be cheaper than faces.
const FEWEST_FACES: u64 = 40_000;
/// The least number of shares of the tolerance.
const FEWEST_SHARES: u32 = 64;
/// The work of a sum over faces for each pair of a face of one body and a face of the other one, some of which
/// are subdivided. Fragments that take more work are dearer than faces.
const WORK_OF_FACES: u64 = 1024;
/// The most work of an evaluation: some ten seconds.
const MOST_WORK: u64 = 1 << 30;

/// The count of the pairs of fragments at a pose, and their work.
#[derive(Debug, Default)]
struct Census {
    pairs: u32,
    work: u64,
    bound: f64,
    /// The positions at which pieces of about [`UNITS`] of work begin, and the sums of their bounds.
    pieces: Vec<(usize, f64)>,
}

impl Pair {
    /// Chooses the rule over fragments for a pose where it is the cheapest one. Returns whether it is used.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub(in crate::mutual) fn prepare_fragments(
        &mut self,
        pose: &Pose,
        interrupt: &mut InterruptCheck,
    ) -> Result<bool> {
        let used = self.fragments.take();
        let faces = self.product_of_faces();
        if self.method != Method::Focal || self.fixed.is_some() || faces < FEWEST_FACES {
            return Ok(false);
        }
        let shares = used.as_ref().map_or(FEWEST_SHARES, |fragments| fragments.shares);
        let fragments = match used
            .filter(|used| used.trees.iter().all(|tree| tree.count() <= FragmentTree::MOST_FRAGMENTS))
        {
            Some(fragments) => Some(fragments),
            None => self.make_fragments(shares, interrupt)?,
        };
        let Some(mut fragments) = fragments else { return Ok(false) };
        if fragments.choose(pose, MOST_WORK.min(WORK_OF_FACES * faces), interrupt)? {
            (self.fragments, self.rule) = (Some(fragments), None);
        }
        Ok(self.fragments.is_some())
    }

    /// Restores the rule over fragments of an archive.
    pub(in crate::mutual) fn restore_fragments(
        &mut self,
        shares: u32,
        work: u64,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        self.fragments = self.make_fragments(shares, interrupt)?;
        if let Some(fragments) = &mut self.fragments {
            fragments.work = work;
        }
        Ok(())
    }

    /// Returns the product of the numbers of faces; zero unless both shapes are polyhedra.
    fn product_of_faces(&self) -> u64 {
        let faces = |k: usize| self.bodies[k].polyhedron().map_or(0, |polyhedron| polyhedron.faces().len());
        faces(0) as u64 * faces(1) as u64
    }

    /// Makes the rule over fragments; `None` unless both shapes are polyhedra.
    fn make_fragments(&self, shares: u32, interrupt: &mut InterruptCheck) -> Result<Option<Box<Fragments>>> {
        let [Some(first), Some(second)] = self.bodies.each_ref().map(|body| body.polyhedron()) else {
            return Ok(None);
        };
        let degree = degree(self.tolerance);
        let store = &self.bodies[0].store;
        let mut tree = |polyhedron| store.fragments(polyhedron, degree, self.arch, &mut *interrupt);
        let trees = [tree(first)?, tree(second)?];
        Ok(Some(Box::new(Fragments {
            trees,
            tables: Arc::new(Tables::new(degree)),
            weights: Arc::new(BoundWeights::new(degree)),
            truncation: Truncation::new([degree; 2], 2 * degree, 0.0),
            arch: self.arch,
            radii: [first.circumradius(), second.circumradius()],
            tolerance: self.tolerance,
            shares,
            pieces: Vec::new(),
            work: 0,
            bound: 0.0,
        })))
    }

    /// Returns the pieces of the energy at a pose, where the rule over fragments is in use.
    pub(in crate::mutual) fn pieces_of_fragments(
        &self,
        pose: &Pose,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<Vec<Range<usize>>>> {
        let Some(fragments) = &self.fragments else { return Ok(None) };
        let census = fragments.census(pose, fragments.shares, fragments.most_work(), interrupt)?;
        match census.filter(|census| census.bound <= fragments.error_limit(pose)) {
            Some(census) => Ok(Some(ranges(&census.pieces).collect())),
            None => Err(self.fragments_not_converged(pose)),
        }
    }

    /// Returns the error for a sum over fragments that does not reach the tolerance.
    pub(in crate::mutual) fn fragments_not_converged(&self, pose: &Pose) -> Error {
        let [first, second] = self.bodies.each_ref().map(|body| &body.name);
        Error::NotConverged {
            what: format!("sum over fragments of {first} and {second}"),
            detail: format!(
                "at separation {} they take much more work than where the rule was chosen; use a larger \
                 gravity_tolerance",
                pose.separation.norm() * self.unit
            ),
        }
    }
}

impl Fragments {
    /// Chooses the number of shares, and the pieces of an evaluation. Returns whether the tolerance is reached
    /// with at most this work.
    fn choose(&mut self, pose: &Pose, most_work: u64, interrupt: &mut InterruptCheck) -> Result<bool> {
        const ATTEMPTS: usize = 8;
        for _ in 0..ATTEMPTS {
            let Some(census) = self.census(pose, self.shares, most_work, interrupt)? else {
                return Ok(false);
            };
            let enough = (census.pairs + census.pairs / 4).next_power_of_two().max(FEWEST_SHARES);
            // The number of shares is lowered only where it would fall to less than a quarter.
            if census.pairs <= self.shares && self.shares <= 4 * enough {
                let even = 1.0 / census.pieces.len() as f64;
                let bound_share = |bound: f64| 0.5 * (even + bound / census.bound.max(f64::MIN_POSITIVE));
                self.pieces =
                    census.pieces.iter().map(|(begin, bound)| (*begin, bound_share(*bound))).collect();
                (self.work, self.bound) = (census.work, census.bound);
                return Ok(census.bound <= self.error_limit(pose));
            }
            self.shares = enough;
        }
        Ok(false)
    }

    /// Counts the pairs at a pose and makes their fragments; `None` where they take more than this work.
    fn census(
        &self,
        pose: &Pose,
        shares: u32,
        most_work: u64,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<Census>> {
        let mut census = Census { pieces: vec![(0, 0.0)], ..Census::default() };
        let (mut checked, mut work_of_piece) = (Ok(()), 0);
        let complete = self.walk(pose, Accuracy::Loads, &(0..usize::MAX), shares, |step| {
            checked = interrupt.charge(super::BOUND_WORK, 0.0);
            census.work += step.work();
            work_of_piece += step.work();
            match step {
                Step::Halve(body, fragment) if checked.is_ok() => {
                    checked = self.trees[body].make_halves(fragment, interrupt);
                }
                Step::Halve(..) => {}
                Step::Take(pair) => {
                    if work_of_piece > UNITS
                        && census.pieces.last().is_some_and(|last| last.0 < pair.position)
                    {
                        census.pieces.push((pair.position, 0.0));
                        work_of_piece = 0;
                    }
                    census.pairs += 1;
                    census.bound += pair.series.bound;
                    if let Some(last) = census.pieces.last_mut() {
                        last.1 += pair.series.bound;
                    }
                }
            }
            if checked.is_err() || census.work > most_work {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        checked.map(|()| complete.then_some(census))
    }

    /// Returns the most work of an evaluation before a step is rejected.
    pub(super) fn most_work(&self) -> u64 {
        WORK_FACTOR * self.work.max(UNITS)
    }

    /// Returns the pieces of an evaluation.
    pub fn ranges(&self) -> impl ExactSizeIterator<Item = Range<usize>> + use<'_> {
        ranges(&self.pieces)
    }
}

/// Returns the ranges of positions of pieces, each from its beginning to the next one's.
fn ranges(pieces: &[(usize, f64)]) -> impl ExactSizeIterator<Item = Range<usize>> + use<'_> {
    pieces
        .iter()
        .enumerate()
        .map(|(k, (begin, _))| *begin..pieces.get(k + 1).map_or(usize::MAX, |next| next.0))
}

/// Returns the degree of the fragments' moments with which an evaluation takes about the least time for a
/// tolerance.
fn degree(tolerance: f64) -> usize {
    ((-2.4 * tolerance.log10()) as usize + 4).clamp(8, MOST_DEGREES - 2)
}
