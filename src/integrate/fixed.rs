//! Steps of fixed size by a composition of flows.

use super::composition::{Composition, Flows};
use super::memory::{Memory, Statistics};
use crate::error::{Error, Result};
use crate::interrupt::InterruptCheck;
use crate::math::compensated::Compensated;

/// An integration with steps of fixed size, of a vector `high` + `low`.
#[derive(Debug, Clone)]
pub struct FixedStepper {
    composition: &'static Composition,
    size: f64,
    time: Compensated,
    high: Vec<f64>,
    low: Vec<f64>,
    statistics: Statistics,
    /// The time, size and vector with which the last step began.
    last_time: Compensated,
    last_size: f64,
    last_high: Vec<f64>,
    last_low: Vec<f64>,
}

impl FixedStepper {
    /// Starts at a time and a vector `high` + `low`, with steps of a size above zero.
    pub fn new(
        composition: &'static Composition,
        size: f64,
        time: f64,
        high: Vec<f64>,
        low: Vec<f64>,
    ) -> Self {
        Self {
            composition,
            size,
            time: Compensated::new(time),
            statistics: Statistics::default(),
            last_time: Compensated::new(time),
            last_size: 0.0,
            last_high: high.clone(),
            last_low: low.clone(),
            high,
            low,
        }
    }

    /// Returns the present time.
    pub fn time(&self) -> f64 {
        self.time.value()
    }

    /// Returns the size of the steps.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Returns the present vector and its low part.
    pub fn vector(&self) -> (&[f64], &[f64]) {
        (&self.high, &self.low)
    }

    /// Returns the time and the vector at which the last step began, whether or not it was completed.
    pub fn last(&self) -> (Compensated, &[f64], &[f64]) {
        (self.last_time, &self.last_high, &self.last_low)
    }

    /// Returns the size of the last step, negative for a run backwards.
    pub fn last_size(&self) -> f64 {
        self.last_size
    }

    /// Undoes the last step.
    pub fn undo(&mut self) {
        self.time = self.last_time;
        self.high.copy_from_slice(&self.last_high);
        self.low.copy_from_slice(&self.last_low);
        self.statistics.steps -= 1;
    }

    /// Returns the counts so far.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Repeats the last step with other flows, which follow the same motion.
    pub fn again(&self, flows: &mut impl Flows, interrupt: &mut InterruptCheck) -> Result<()> {
        let (mut high, mut low) = (self.last_high.clone(), self.last_low.clone());
        flows.prepare(self.last_time.value(), &high, self.last_size, interrupt)?;
        self.composition.step(flows, self.last_size, [&mut high, &mut low], interrupt).map(drop)
    }

    /// Adds evaluations that were made for this integration elsewhere.
    pub fn count(&mut self, evaluations: u64) {
        self.statistics.evaluations += evaluations;
    }

    /// Returns the data that determine how the integration continues.
    pub fn memory(&self) -> Memory {
        Memory {
            time: [self.time.high, self.time.low],
            high: self.high.clone(),
            low: self.low.clone(),
            // The step size belongs to the integrator's settings.
            next: 0.0,
            previous_error: 1.0,
            after_rejection: false,
            statistics: self.statistics,
        }
    }

    /// Continues from the memory of a stepper with the same composition and step.
    pub fn restore_memory(&mut self, memory: &Memory) {
        self.time = Compensated { high: memory.time[0], low: memory.time[1] };
        self.high.copy_from_slice(&memory.high);
        self.low.copy_from_slice(&memory.low);
        self.statistics = memory.statistics;
    }

    /// Moves the integration to a time and a vector.
    pub fn move_to(&mut self, time: f64, y: &[f64]) {
        self.time = Compensated::new(time);
        self.high.copy_from_slice(y);
        self.low.fill(0.0);
    }

    /// Takes one step towards `end`; only a step that would pass it is cut short. A step that is not
    /// completed leaves the integration at its start.
    pub fn step(&mut self, flows: &mut impl Flows, end: f64, interrupt: &mut InterruptCheck) -> Result<()> {
        let remaining = (end - self.time.high) - self.time.low;
        // A remainder that differs from the step only by the rounding of `end` counts as a whole step.
        let arrives = remaining.abs() <= self.size * (1.0 + 1e-9);
        let size = if arrives { remaining } else { self.size.copysign(remaining) };
        let time = self.time();
        if size.abs() <= 4.0 * f64::EPSILON * time.abs() && !arrives {
            let reason = "steps this short are lost in the time's rounding".to_owned();
            return Err(Error::StepSizeTooSmall { time, step: size, reason });
        }
        self.last_time = self.time;
        self.last_size = size;
        self.last_high.copy_from_slice(&self.high);
        self.last_low.copy_from_slice(&self.low);
        flows.prepare(time, &self.high, size, interrupt)?;
        match self.composition.step(flows, size, [&mut self.high, &mut self.low], interrupt) {
            Ok(evaluations) => self.statistics.evaluations += evaluations,
            Err(error) => {
                self.high.copy_from_slice(&self.last_high);
                self.low.copy_from_slice(&self.last_low);
                return Err(error);
            }
        }
        flows.restore(&mut self.high, &mut self.low);
        if arrives {
            self.time = Compensated::new(end);
        } else {
            self.time.add(size);
        }
        self.statistics.steps += 1;
        Ok(())
    }
}
