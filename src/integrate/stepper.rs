//! An adaptive integration: it takes steps with error control, keeps low parts, and interpolates.

mod start;

use super::control::{Controller, Tolerance};
use super::equations::{Equations, Incomplete, evaluate};
use super::memory::{Memory, Statistics};
use super::segment::Segment;
use super::step::Step;
use super::tableau::Tableau;
use crate::error::{Error, Result};
use crate::interrupt::InterruptCheck;
use crate::math::compensated::Compensated;
use crate::math::rows::{Advance, InSinglePart, InTwoParts, Sums, Term, WeightedRows, stride, whole};

/// The state of an integration. It holds numbers only: two equal steppers continue equally.
#[derive(Debug, Clone)]
pub struct Stepper {
    tableau: &'static Tableau,
    tolerance: Tolerance,
    time: Compensated,
    high: Vec<f64>,
    low: Vec<f64>,
    /// The size of the next step; zero before the first.
    next: f64,
    controller: Controller,
    /// The planned size and the controller before the last step.
    plan_before: (f64, Controller),
    statistics: Statistics,
    /// The rates of the stages, one row after the other.
    stages: Vec<f64>,
    /// Whether stage 0 holds the rate at the present vector.
    fresh: bool,
    /// The non-zero weights of every stage, followed by those of the solution.
    terms: Vec<Vec<Term>>,
    /// For each stage, whether it has a weight in the solution or in its interpolant.
    weighted_stages: Vec<bool>,
    /// The vector at the last step's start in both its parts, padded to the length of a row.
    from: [Vec<f64>; 2],
    trial: Vec<f64>,
    /// The low part of the vector at the end of a step, whose high part is `trial`.
    tail: Vec<f64>,
    /// The last step: its start, its size, and its polynomial if that has been requested.
    last: Segment,
    /// The number of stages of the last step that have been computed.
    computed_stages: usize,
    /// Whether the polynomial of the last step has been formed.
    formed: bool,
}

impl Stepper {
    /// Starts at a time and a vector `high` + `low`.
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
            plan_before: (0.0, Controller::new()),
            statistics: Statistics::default(),
            terms: tableau.terms(),
            weighted_stages: tableau.weighted_stages(),
            stages: vec![0.0; all_stages * stride(dimension)],
            fresh: false,
            from: [vec![0.0; stride(dimension)], vec![0.0; stride(dimension)]],
            trial: vec![0.0; stride(dimension)],
            tail: vec![0.0; stride(dimension)],
            last: Segment::new(dimension, tableau.interpolant.terms()),
            computed_stages: 0,
            formed: false,
            high,
            low,
        }
    }

    /// Returns the present time.
    pub fn time(&self) -> f64 {
        self.time.value()
    }

    /// Returns the present vector and its low part.
    pub fn vector(&self) -> (&[f64], &[f64]) {
        (&self.high, &self.low)
    }

    /// Returns the data that determine how the integration continues.
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

    /// Continues from the memory of a stepper with the same tableau and tolerance.
    pub fn restore_memory(&mut self, memory: &Memory) {
        self.time = Compensated { high: memory.time[0], low: memory.time[1] };
        self.high.copy_from_slice(&memory.high);
        self.low.copy_from_slice(&memory.low);
        self.next = memory.next;
        self.controller =
            Controller { previous: memory.previous_error, after_rejection: memory.after_rejection };
        self.statistics = memory.statistics;
        self.computed_stages = 0;
    }

    /// Starts anew at a time and a vector and keeps nothing but the counts, so that the further steps depend
    /// on the arguments alone. The first step is tried with the size `next`.
    pub fn restart(&mut self, time: Compensated, high: &[f64], low: &[f64], next: f64) {
        self.time = time;
        self.high.copy_from_slice(high);
        self.low.copy_from_slice(low);
        self.next = next;
        self.controller = Controller::new();
        self.computed_stages = 0;
    }

    /// Moves the integration to a time and a vector near the present ones; the planned step size stays.
    pub fn move_to(&mut self, time: f64, y: &[f64]) {
        self.time = Compensated::new(time);
        self.high.copy_from_slice(y);
        self.low.fill(0.0);
        self.computed_stages = 0;
    }

    /// Counts a step that was made elsewhere.
    pub fn count_step(&mut self) {
        self.statistics.steps += 1;
    }

    /// Returns the counts so far.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Takes one accepted step towards `end`, never beyond it. An interrupted step leaves the integration at
    /// its start.
    pub fn step(
        &mut self,
        equations: &mut impl Equations,
        end: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let direction = if end >= self.time() { 1.0 } else { -1.0 };
        self.fresh = false;
        self.plan_before = (self.next, self.controller);
        if self.next == 0.0 {
            self.next = self.first_step(equations, direction, end, interrupt)?;
        }
        self.next = self.next.abs() * direction;
        loop {
            let (size, ends_there) = self.fit(end);
            // The remainder may be as short as the rounding of the time; it is then taken all the same.
            if size != self.remaining(end) {
                self.refuse_tiny(size, "the error tolerance cannot be met")?;
            }
            equations.prepare(self.time(), &self.high, size, interrupt)?;
            match self.attempt(equations, size, interrupt) {
                Ok(error) if error <= 1.0 => {
                    self.accept(equations, size, end);
                    let factor = self.controller.accepted(error, self.tableau.error_order);
                    // A step that was cut short to end at `end` does not reduce the planned size.
                    self.next = if ends_there {
                        self.next.abs().max(size.abs() * factor)
                    } else {
                        size.abs() * factor
                    };
                    self.next *= direction;
                    return Ok(());
                }
                Ok(error) => {
                    self.statistics.rejected += 1;
                    self.next = size * self.controller.rejected(error, self.tableau.error_order);
                }
                Err(Incomplete::Ended(error)) => return Err(error),
                Err(Incomplete::Refused(reason)) => {
                    self.statistics.rejected += 1;
                    self.next = size * self.controller.rejected(f64::INFINITY, self.tableau.error_order);
                    self.refuse_tiny(self.next, reason)?;
                }
            }
        }
    }

    /// Undoes the last step. Its stages stay until the next step.
    pub fn undo(&mut self) {
        self.time = self.last.time;
        self.high.copy_from_slice(&self.last.high);
        self.low.copy_from_slice(&self.last.low);
        (self.next, self.controller) = self.plan_before;
        self.statistics.steps -= 1;
    }

    /// Undoes the last step and plans it half as long. Returns an error where that no longer advances the time.
    pub fn shorten(&mut self, reason: &str) -> Result<()> {
        self.undo();
        self.statistics.rejected += 1;
        self.next = 0.5 * self.last.size;
        self.controller.after_rejection = true;
        self.refuse_tiny(self.next, reason)
    }

    /// Returns the last step with its ends and stages.
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

    /// Returns the vector at a time within the last step.
    pub fn interpolate(
        &mut self,
        equations: &mut impl Equations,
        time: f64,
        out: &mut [f64],
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let segment = self.segment(equations, interrupt)?;
        segment.at(segment.fraction(time), out);
        Ok(())
    }

    /// Returns the last step as a polynomial. The stages of the interpolant are computed at the first call in
    /// a step.
    pub fn segment(
        &mut self,
        equations: &mut impl Equations,
        interrupt: &mut InterruptCheck,
    ) -> Result<&Segment> {
        if self.computed_stages == 0 {
            return Err(Error::invalid("number of steps", 0, "a step before its interpolation"));
        }
        if !self.formed {
            self.complete_stages(equations, interrupt)?;
            let dimension = self.high.len();
            equations.arch().dispatch(Sums {
                weights: &self.tableau.interpolant.weights,
                rows: &self.stages,
                stride: stride(dimension),
                out: &mut self.last.coefficients,
                length: dimension,
            });
            self.formed = true;
        }
        Ok(&self.last)
    }

    /// Returns the polynomial of the last step that [`Self::segment`] has formed.
    pub fn piece(&self) -> &Segment {
        &self.last
    }

    fn complete_stages(
        &mut self,
        equations: &mut impl Equations,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let dimension = self.high.len();
        while self.computed_stages < self.tableau.a.len() {
            let stage = self.computed_stages;
            self.fill_trial(equations, stage, self.last.size);
            let time = self.last.start() + self.tableau.c[stage] * self.last.size;
            let rates = &mut self.stages[stage * stride(dimension)..][..dimension];
            self.statistics.evaluations += 1;
            let weighted = self.weighted_stages[stage];
            evaluate(equations, time, &self.trial[..dimension], rates, weighted, interrupt).map_err(
                |incomplete| {
                    incomplete.error(|reason| Error::StepSizeTooSmall {
                        time,
                        step: self.last.size,
                        reason: format!("{reason}, while interpolating"),
                    })
                },
            )?;
            self.computed_stages += 1;
        }
        Ok(())
    }

    fn remaining(&self, end: f64) -> f64 {
        (end - self.time.high) - self.time.low
    }

    /// Returns the planned step, shortened to end at `end` or extended a little to avoid a tiny remainder,
    /// and whether it ends there.
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

    /// Computes the stages and the increments of the trial vector. Returns the error in units of the
    /// tolerance, or the reason why there is none.
    fn attempt(
        &mut self,
        equations: &mut impl Equations,
        size: f64,
        interrupt: &mut InterruptCheck,
    ) -> std::result::Result<f64, Incomplete> {
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
        self.computed_stages = first;
        let work = equations.work() * self.tableau.stages as u64;
        let quick = equations.parts() == 1 && interrupt.try_charge(work);
        for stage in first..self.tableau.stages {
            self.fill_trial(equations, stage, size);
            let rates = &mut self.stages[stage * stride(dimension)..][..dimension];
            self.statistics.evaluations += 1;
            let (at, trial) = (time + self.tableau.c[stage] * size, &self.trial[..dimension]);
            if quick {
                equations.derivative(0, at, trial, rates)?;
                if self.weighted_stages[stage] {
                    equations.quadratures(at, trial, rates);
                }
            } else {
                evaluate(equations, at, trial, rates, self.weighted_stages[stage], interrupt)?;
            }
            self.fresh = true;
            self.computed_stages = stage + 1;
        }
        self.trial.fill(0.0);
        for (stage, (b, b_hat)) in self.tableau.b.iter().zip(&self.tableau.b_hat).enumerate() {
            let weight = size * (b - b_hat);
            if weight != 0.0 {
                let rates = &self.stages[stage * stride(dimension)..]
                    [..equations.dimension_without_quadratures(dimension)];
                self.trial.iter_mut().zip(rates).for_each(|(t, k)| *t += weight * k);
            }
        }
        if !quick {
            // The norm takes about as long as one part of an evaluation.
            interrupt.charge(equations.work(), time).map_err(Incomplete::Ended)?;
        }
        let error = equations.norm(&self.high, &self.trial[..dimension], &self.tolerance);
        if error.is_finite() {
            Ok(error)
        } else {
            Err(Incomplete::Refused("the error estimate is not finite"))
        }
    }

    /// Writes y + size sum_j a_ij k_j for the numbers that the rates depend on.
    fn fill_trial(&mut self, equations: &impl Equations, stage: usize, size: f64) {
        let numbers = whole(equations.dimension_without_quadratures(self.high.len()));
        let advance = advance(&self.terms[stage], &self.stages, &self.from, numbers, size);
        equations.arch().dispatch(InSinglePart(advance, &mut self.trial[..numbers]));
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
}

/// Builds the step from a vector along the rates of the stages, for the vector's first numbers.
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
