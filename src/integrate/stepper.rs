//! One integration: takes adaptive steps, keeps what rounding drops, interpolates.

use super::control::{Controller, Tolerance};
use super::segment::Segment;
use super::tableau::Tableau;
use crate::error::{Error, Refusal, Result};
use crate::math::compensated::Compensated;
use crate::math::rows::{
    Advance, InOnePart, InTwoParts, LargestChanges, Sums, Term, WeightedRows, stride, whole,
};
use crate::patience::Patience;
use pulp::Arch;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// What an integrator needs to know of its equations.
pub trait Equations {
    /// The instructions to sum stages with.
    fn arch(&self) -> Arch {
        Arch::default()
    }

    /// Parts in which the rates of change are evaluated, so that the caller can be asked between them.
    fn parts(&self) -> usize {
        1
    }

    /// Units of work of a part, for [`Patience`].
    fn work(&self) -> u64 {
        1
    }

    /// Called between steps, before a step of size `step` from an accepted vector. May allocate.
    fn prepare(&mut self, time: f64, y: &[f64], step: f64, patience: &mut Patience) -> Result<()>;

    /// A part of the evaluation of the rates of change at a trial vector; the last part leaves them in `rate`. `Err` says why
    /// they cannot be had there, and whether to try the step shorter.
    fn derivative(
        &mut self,
        part: usize,
        time: f64,
        y: &[f64],
        rate: &mut [f64],
    ) -> std::result::Result<(), Refusal>;

    /// How many numbers of the vector, its first ones, the rates of change depend on. The others are quadratures.
    fn dependent(&self, dimension: usize) -> usize {
        dimension
    }

    /// Leaves the rates of the quadratures at the time and the vector of the last evaluation in `rate`. Called only where they count.
    fn quadratures(&mut self, _time: f64, _y: &[f64], _rate: &mut [f64]) {}

    /// Size of a difference `v` at `y` in units of the tolerance.
    fn norm(&mut self, y: &[f64], v: &[f64], tolerance: &Tolerance) -> f64;

    /// Brings an accepted vector back onto its constraints.
    fn restore(&mut self, high: &mut [f64], low: &mut [f64]);
}

/// Counts of an integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: u64,
    /// Attempts that were rejected.
    pub rejected: u64,
    /// Evaluations of the rates of change.
    pub evaluations: u64,
}

/// An accepted step by its ends and stages.
#[derive(Debug, Clone, Copy)]
pub struct Step<'a> {
    tableau: &'static Tableau,
    /// The vector at its start.
    pub start: &'a [f64],
    /// The vector at its end.
    pub end: &'a [f64],
    /// The time of its start.
    pub time: f64,
    /// Its size, negative for a run backwards.
    pub size: f64,
    rates: &'a [f64],
}

impl Step<'_> {
    /// The rates of change at the step's start.
    pub fn first_rates(&self) -> &[f64] {
        &self.rates[..self.start.len()]
    }

    /// The tableau that it was made by.
    pub fn tableau(&self) -> &'static Tableau {
        self.tableau
    }

    /// By how much the rates of change of a range of numbers differ from the first ones at most, at the pair's own stages. `out` has
    /// the [`Self::stride`] as its length, and what it holds elsewhere means nothing.
    pub fn changes(&self, arch: Arch, range: Range<usize>, out: &mut [f64]) {
        let rows = &self.rates[..self.tableau.stages * self.stride()];
        arch.dispatch(LargestChanges { rows, range, out });
    }

    /// Length of the rows that the rates are kept in.
    pub fn stride(&self) -> usize {
        stride(self.start.len())
    }

    /// The tableau's [`Tableau::spread`].
    pub fn spread(&self) -> [f64; 2] {
        self.tableau.spread
    }
}

/// The state of an integration. Numbers only: two steppers that are equal go on equally.
#[derive(Debug, Clone)]
pub struct Stepper {
    tableau: &'static Tableau,
    tolerance: Tolerance,
    time: Compensated,
    high: Vec<f64>,
    low: Vec<f64>,
    /// Size of the next step; zero before the first.
    next: f64,
    controller: Controller,
    /// Both before the last step.
    before: (f64, Controller),
    statistics: Statistics,
    /// Rates of the stages, one after the other.
    stages: Vec<f64>,
    /// Whether stage 0 holds the rate at the present vector.
    fresh: bool,
    /// The non-zero weights of every stage, and at the end those of the solution.
    terms: Vec<Vec<Term>>,
    /// Whether a stage has a weight in the solution or in its interpolant.
    counts: Vec<bool>,
    /// The vector of the last step's start in both its parts, of the length of a row.
    from: [Vec<f64>; 2],
    trial: Vec<f64>,
    /// The low part of a step's end.
    tail: Vec<f64>,
    /// The last step: where it began, how long it was, and its polynomial once that was asked for.
    last: Segment,
    /// Stages of it that have been computed.
    known: usize,
    /// Whether the polynomial has been formed.
    formed: bool,
}

/// Everything that decides how an integration goes on; the layout belongs to the archive's version.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Time and what rounding dropped of it.
    pub time: [f64; 2],
    /// Vector.
    pub high: Vec<f64>,
    /// What rounding dropped of it.
    pub low: Vec<f64>,
    /// Size planned for the next step; zero before the first.
    pub next: f64,
    /// Error of the last accepted step.
    pub previous_error: f64,
    /// Whether the last attempt failed.
    pub after_rejection: bool,
    /// Counts.
    pub statistics: Statistics,
}

impl Stepper {
    /// At a time and a vector `high` + `low`.
    pub fn new(
        tableau: &'static Tableau,
        tolerance: Tolerance,
        time: f64,
        high: Vec<f64>,
        low: Vec<f64>,
    ) -> Self {
        let dimension = high.len();
        let all_stages = tableau.a.len();
        Self {
            tableau,
            tolerance,
            time: Compensated::new(time),
            next: 0.0,
            controller: Controller::new(),
            before: (0.0, Controller::new()),
            statistics: Statistics::default(),
            terms: terms(tableau),
            counts: counts(tableau),
            stages: vec![0.0; all_stages * stride(dimension)],
            fresh: false,
            from: [vec![0.0; stride(dimension)], vec![0.0; stride(dimension)]],
            trial: vec![0.0; stride(dimension)],
            tail: vec![0.0; stride(dimension)],
            last: Segment::new(dimension, tableau.interpolant.terms()),
            known: 0,
            formed: false,
            high,
            low,
        }
    }

    /// Present time.
    pub fn time(&self) -> f64 {
        self.time.value()
    }

    /// Present vector and what rounding dropped of it.
    pub fn vector(&self) -> (&[f64], &[f64]) {
        (&self.high, &self.low)
    }

    /// What decides how the integration goes on.
    pub fn memory(&self) -> Memory {
        Memory {
            time: [self.time.high, self.time.low],
            high: self.high.clone(),
            low: self.low.clone(),
            next: self.next,
            previous_error: self.controller.previous,
            after_rejection: self.controller.after_rejection,
            statistics: self.statistics,
        }
    }

    /// Goes on from where another stepper of the same tableau and tolerance was.
    pub fn recall(&mut self, memory: &Memory) {
        self.time = Compensated { high: memory.time[0], low: memory.time[1] };
        self.high.copy_from_slice(&memory.high);
        self.low.copy_from_slice(&memory.low);
        self.next = memory.next;
        self.controller =
            Controller { previous: memory.previous_error, after_rejection: memory.after_rejection };
        self.statistics = memory.statistics;
        self.known = 0;
    }

    /// Starts anew at a time and a vector with nothing remembered but the counts: what follows depends on the arguments
    /// alone. The first step is tried with the size `next`.
    pub fn restart(&mut self, time: Compensated, high: &[f64], low: &[f64], next: f64) {
        self.time = time;
        self.high.copy_from_slice(high);
        self.low.copy_from_slice(low);
        self.next = next;
        self.controller = Controller::new();
        self.known = 0;
    }

    /// Puts the integration to a time and a vector near the present one; the planned step size stays.
    pub fn place(&mut self, time: f64, y: &[f64]) {
        self.time = Compensated::new(time);
        self.high.copy_from_slice(y);
        self.low.fill(0.0);
        self.known = 0;
    }

    /// Counts so far.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// One accepted step towards `end`, never beyond it. Where it is interrupted the integration stays at its start.
    pub fn step(&mut self, equations: &mut impl Equations, end: f64, patience: &mut Patience) -> Result<()> {
        let direction = if end >= self.time() { 1.0 } else { -1.0 };
        self.fresh = false;
        self.before = (self.next, self.controller);
        if self.next == 0.0 {
            self.next = self.first_step(equations, direction, end, patience)?;
        }
        self.next = self.next.abs() * direction;
        loop {
            let (size, cut) = self.fit(end);
            // All that is left may be as short as the time's rounding, and is gone all the same.
            if size != self.remaining(end) {
                self.refuse_tiny(size, "the error tolerance cannot be met")?;
            }
            equations.prepare(self.time(), &self.high, size, patience)?;
            match self.attempt(equations, size, patience) {
                Ok(error) if error <= 1.0 => {
                    self.accept(equations, size, end);
                    let factor = self.controller.accepted(error, self.tableau.error_order);
                    // A step cut short to end somewhere says nothing against the size that was planned.
                    self.next =
                        if cut { self.next.abs().max(size.abs() * factor) } else { size.abs() * factor };
                    self.next *= direction;
                    return Ok(());
                }
                Ok(error) => {
                    self.statistics.rejected += 1;
                    self.next = size * self.controller.rejected(error, self.tableau.error_order);
                }
                Err(Unmade::Ended(error)) => return Err(error),
                Err(Unmade::Refused(reason)) => {
                    self.statistics.rejected += 1;
                    self.next = size * self.controller.rejected(f64::INFINITY, self.tableau.error_order);
                    self.refuse_tiny(self.next, reason)?;
                }
            }
        }
    }

    /// Takes the last step back. What it was made of stays until the next one.
    pub fn retreat(&mut self) {
        self.time = self.last.time;
        self.high.copy_from_slice(&self.last.high);
        self.low.copy_from_slice(&self.last.low);
        (self.next, self.controller) = self.before;
        self.statistics.steps -= 1;
    }

    /// Takes the last step back and plans it half as long; refuses where that no longer advances the time.
    pub fn shorten(&mut self, reason: &str) -> Result<()> {
        self.retreat();
        self.statistics.rejected += 1;
        self.next = 0.5 * self.last.size;
        self.controller.after_rejection = true;
        self.refuse_tiny(self.next, reason)
    }

    /// The last step by its ends and stages.
    pub fn last(&self) -> Step<'_> {
        Step {
            tableau: self.tableau,
            start: &self.last.high,
            end: &self.high,
            time: self.last.start(),
            size: self.last.size,
            rates: &self.stages,
        }
    }

    /// The vector at a time within the last step.
    pub fn interpolate(
        &mut self,
        equations: &mut impl Equations,
        time: f64,
        out: &mut [f64],
        patience: &mut Patience,
    ) -> Result<()> {
        let segment = self.segment(equations, patience)?;
        segment.at(segment.fraction(time), out);
        Ok(())
    }

    /// The last step as a polynomial. Computes the interpolant's stages when first asked for in a step.
    pub fn segment(&mut self, equations: &mut impl Equations, patience: &mut Patience) -> Result<&Segment> {
        if self.known == 0 {
            return Err(Error::invalid("number of steps", 0, "a step before its interpolation"));
        }
        if !self.formed {
            self.complete_stages(equations, patience)?;
            let dimension = self.high.len();
            equations.arch().dispatch(Sums {
                weights: self.tableau.interpolant.weights,
                rows: &self.stages,
                stride: stride(dimension),
                out: &mut self.last.coefficients,
                length: dimension,
            });
            self.formed = true;
        }
        Ok(&self.last)
    }

    /// The last step as the polynomial that [`Self::segment`] has formed.
    pub fn piece(&self) -> &Segment {
        &self.last
    }

    fn complete_stages(&mut self, equations: &mut impl Equations, patience: &mut Patience) -> Result<()> {
        let dimension = self.high.len();
        while self.known < self.tableau.a.len() {
            let stage = self.known;
            self.fill_trial(equations, stage, self.last.size);
            let time = self.last.start() + self.tableau.c[stage] * self.last.size;
            let rates = &mut self.stages[stage * stride(dimension)..][..dimension];
            self.statistics.evaluations += 1;
            let counts = self.counts[stage];
            evaluate(equations, time, &self.trial[..dimension], rates, counts, patience).map_err(
                |unmade| {
                    unmade.error(|reason| Error::StepSizeTooSmall {
                        time,
                        step: self.last.size,
                        reason: format!("{reason}, while interpolating"),
                    })
                },
            )?;
            self.known += 1;
        }
        Ok(())
    }

    fn remaining(&self, end: f64) -> f64 {
        (end - self.time.high) - self.time.low
    }

    /// The planned step, shortened to end at `end` or stretched a little to avoid a tiny remainder.
    fn fit(&self, end: f64) -> (f64, bool) {
        let remaining = self.remaining(end);
        if self.next.abs() >= remaining.abs() {
            (remaining, true)
        } else if 2.0 * self.next.abs() > remaining.abs() {
            (0.5 * remaining, true)
        } else {
            (self.next, false)
        }
    }

    fn refuse_tiny(&self, size: f64, reason: &str) -> Result<()> {
        let time = self.time();
        if size.abs() > 4.0 * f64::EPSILON * time.abs() && size.abs() > f64::MIN_POSITIVE {
            Ok(())
        } else {
            Err(Error::StepSizeTooSmall { time, step: size, reason: reason.to_owned() })
        }
    }

    /// Computes the stages and the trial vector's increments; gives the error in units of the tolerance, or why there is none.
    fn attempt(
        &mut self,
        equations: &mut impl Equations,
        size: f64,
        patience: &mut Patience,
    ) -> std::result::Result<f64, Unmade> {
        let dimension = self.high.len();
        let time = self.time();
        self.formed = false;
        self.last.time = self.time;
        self.last.size = size;
        self.last.high.copy_from_slice(&self.high);
        self.last.low.copy_from_slice(&self.low);
        self.from[0][..dimension].copy_from_slice(&self.high);
        self.from[1][..dimension].copy_from_slice(&self.low);
        let first = usize::from(self.fresh);
        self.known = first;
        let work = equations.work() * self.tableau.stages as u64;
        let quick = equations.parts() == 1 && patience.affords(work);
        for stage in first..self.tableau.stages {
            self.fill_trial(equations, stage, size);
            let rates = &mut self.stages[stage * stride(dimension)..][..dimension];
            self.statistics.evaluations += 1;
            let (at, trial) = (time + self.tableau.c[stage] * size, &self.trial[..dimension]);
            if quick {
                equations.derivative(0, at, trial, rates)?;
                if self.counts[stage] {
                    equations.quadratures(at, trial, rates);
                }
            } else {
                evaluate(equations, at, trial, rates, self.counts[stage], patience)?;
            }
            self.fresh = true;
            self.known = stage + 1;
        }
        self.trial.fill(0.0);
        for (stage, (b, b_hat)) in self.tableau.b.iter().zip(self.tableau.b_hat).enumerate() {
            let weight = size * (b - b_hat);
            if weight != 0.0 {
                let rates = &self.stages[stage * stride(dimension)..][..equations.dependent(dimension)];
                self.trial.iter_mut().zip(rates).for_each(|(t, k)| *t += weight * k);
            }
        }
        if !quick {
            // The norm takes about as long as a part.
            patience.spend(equations.work(), time).map_err(Unmade::Ended)?;
        }
        let error = equations.norm(&self.high, &self.trial[..dimension], &self.tolerance);
        if error.is_finite() { Ok(error) } else { Err(Unmade::Refused("the error estimate is not finite")) }
    }

    /// y + size sum_j a_ij k_j, of the numbers that matter.
    fn fill_trial(&mut self, equations: &impl Equations, stage: usize, size: f64) {
        let numbers = whole(equations.dependent(self.high.len()));
        let advance = advance(&self.terms[stage], &self.stages, &self.from, numbers, size);
        equations.arch().dispatch(InOnePart(advance, &mut self.trial[..numbers]));
    }

    fn accept(&mut self, equations: &mut impl Equations, size: f64, end: f64) {
        let dimension = self.high.len();
        let terms = &self.terms[self.tableau.a.len()];
        let advance = advance(terms, &self.stages, &self.from, whole(dimension), size);
        let parts = [&mut self.trial[..whole(dimension)], &mut self.tail[..whole(dimension)]];
        equations.arch().dispatch(InTwoParts(advance, parts));
        self.high.copy_from_slice(&self.trial[..dimension]);
        self.low.copy_from_slice(&self.tail[..dimension]);
        equations.restore(&mut self.high, &mut self.low);
        if self.remaining(end) == size {
            self.time = Compensated::new(end);
        } else {
            self.time.add(size);
        }
        self.fresh = false;
        self.statistics.steps += 1;
    }

    /// The starting step of Hairer, Norsett & Wanner, section II.4.
    fn first_step(
        &mut self,
        equations: &mut impl Equations,
        direction: f64,
        end: f64,
        patience: &mut Patience,
    ) -> Result<f64> {
        let dimension = self.high.len();
        let remaining = (end - self.time()).abs();
        let time = self.time();
        equations.prepare(time, &self.high, 0.0, patience)?;
        let failed = |reason: &str| Error::StepSizeTooSmall { time, step: 0.0, reason: reason.to_owned() };
        let unit = Tolerance { relative: 1.0, absolute: 0.0 };
        let (first, rest) = self.stages.split_at_mut(stride(dimension));
        let first = &mut first[..dimension];
        evaluate(equations, time, &self.high, first, true, patience)
            .map_err(|unmade| unmade.error(failed))?;
        self.statistics.evaluations += 2;
        // In units of the scales everything is of order one, so that the rate's norm is an inverse time.
        let rate = equations.norm(&self.high, first, &unit);
        let guess = if rate > 0.0 { 0.01 / rate } else { remaining };
        let guess = guess.min(remaining);
        for (t, (y, k)) in self.trial.iter_mut().zip(self.high.iter().zip(first.iter())) {
            *t = y + direction * guess * k;
        }
        let second = &mut rest[..dimension];
        let (at, trial) = (time + direction * guess, &self.trial[..dimension]);
        let curvature = match evaluate(equations, at, trial, second, false, patience) {
            Err(Unmade::Ended(error)) => return Err(error),
            Err(Unmade::Refused(_)) => f64::INFINITY,
            Ok(()) => {
                second.iter_mut().zip(first.iter()).for_each(|(s, f)| *s = (*s - f) / guess);
                equations.norm(&self.high, second, &unit)
            }
        };
        self.fresh = true;
        let exponent = 1.0 / f64::from(self.tableau.error_order + 1);
        let tolerance = self.tolerance.relative + self.tolerance.absolute;
        let scale = (curvature.sqrt()).max(rate);
        let step = if scale > 0.0 { (0.01 * tolerance).powf(exponent) * 10.0 / scale } else { remaining };
        Ok(direction * step.min(100.0 * guess).min(remaining).max(f64::MIN_POSITIVE))
    }
}

/// Why an evaluation or an attempt was not made to its end.
enum Unmade {
    /// The equations refuse; a shorter step may do.
    Refused(&'static str),
    /// The caller does not want to go on, or the equations cannot.
    Ended(Error),
}

impl From<Refusal> for Unmade {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Shorter(reason) => Self::Refused(reason),
            Refusal::Failed(error) => Self::Ended(*error),
        }
    }
}

impl Unmade {
    /// The error that ends the integration, made from the reason of a refusal.
    fn error(self, of: impl FnOnce(&str) -> Error) -> Error {
        match self {
            Self::Refused(reason) => of(reason),
            Self::Ended(error) => error,
        }
    }
}

/// The rates of change at a trial vector, with those of the quadratures where the stage counts.
fn evaluate(
    equations: &mut impl Equations,
    time: f64,
    y: &[f64],
    rate: &mut [f64],
    counts: bool,
    patience: &mut Patience,
) -> std::result::Result<(), Unmade> {
    for part in 0..equations.parts() {
        patience.spend(equations.work(), time).map_err(Unmade::Ended)?;
        equations.derivative(part, time, y, rate)?;
    }
    if counts {
        equations.quadratures(time, y, rate);
    }
    Ok(())
}

/// A step from a vector along the rates of stages, of its first numbers.
fn advance<'a>(
    terms: &'a [Term],
    rates: &'a [f64],
    from: &'a [Vec<f64>; 2],
    numbers: usize,
    size: f64,
) -> Advance<'a> {
    let rows = WeightedRows { terms, rows: rates, stride: from[0].len() };
    Advance { rows, from: [&from[0][..numbers], &from[1][..numbers]], size }
}

fn counts(tableau: &Tableau) -> Vec<bool> {
    let weighted = |stage: usize| {
        let within = tableau.interpolant.weights.get(stage).is_some_and(|row| row.iter().any(|w| *w != 0.0));
        within || tableau.b.get(stage).is_some_and(|b| *b != 0.0)
    };
    (0..tableau.a.len()).map(weighted).collect()
}

fn terms(tableau: &Tableau) -> Vec<Vec<Term>> {
    let nonzero = |weights: &[f64], low: &[f64]| {
        let term =
            |(row, &weight): (usize, &f64)| Term { row, weight, low: low.get(row).copied().unwrap_or(0.0) };
        weights.iter().enumerate().map(term).filter(|term| term.weight != 0.0).collect()
    };
    let low = |stage: usize| tableau.a_low.get(stage).copied().unwrap_or(&[]);
    let stages = tableau.a.iter().enumerate().map(|(stage, row)| nonzero(row, low(stage)));
    stages.chain([nonzero(tableau.b, tableau.b_low)]).collect()
}
