//! The complete state of a simulation, which determines its continuation.

use super::Simulation;
use crate::dynamics::{AttitudeChart, Layout};
use crate::error::{Error, Result, require_finite, require_positive};
use crate::forces::Switch;
use crate::integrate::Memory;
use crate::interrupt::InterruptCheck;
use crate::mutual::RuleMemory;
use serde::{Deserialize, Serialize};

/// The largest count, which a double represents exactly.
const MOST_STEPS: u64 = 1 << 53;

/// The largest deviation of a squared quaternion length from one; that of a simulation is far smaller.
const UNIT_TOLERANCE: f64 = 1e-9;

/// All quantities of a simulation that steps change. Two simulations of one system and integrator with equal
/// checkpoints continue identically, bit for bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Checkpoint {
    /// Time, vector with its low part, step control, counts.
    memory: Memory,
    /// Accelerations and rates of spin at the present vector, where the integrator keeps them.
    loads: Option<Vec<[f64; 6]>>,
    /// The quadrature rules in use.
    rules: Vec<Option<RuleMemory>>,
    /// Which external forces are switched on.
    switches: Vec<Option<Switch>>,
    /// Whether the present state was set rather than reached by a step.
    state_was_set: bool,
}

impl Checkpoint {
    /// Returns the time, and the vector in two parts.
    #[cfg(feature = "archives")]
    pub fn vector(&self) -> (f64, &[f64], &[f64]) {
        (self.memory.time[0], &self.memory.high, &self.memory.low)
    }

    /// Returns an error for numbers that no simulation with this layout can have.
    pub fn check(&self, layout: Layout) -> Result<()> {
        self.check_lengths(layout)?;
        let memory = &self.memory;
        let [time, time_low] = memory.time;
        require_finite("time of a simulation", &memory.time)?;
        require_finite("vector of a simulation", &memory.high)?;
        for (high, low) in memory.high.iter().zip(&memory.low).chain([(&time, &time_low)]) {
            // For a low part that is NaN this comparison is true as well.
            if high + low != *high {
                let value = format!("{low:e} beside {high:e}");
                return Err(Error::invalid("low part of a simulation", value, "less than its rounding"));
            }
        }
        require_finite("next step of a simulation", &[memory.next])?;
        require_positive("last error of a simulation", memory.previous_error)?;
        let counts = memory.statistics;
        if [counts.steps, counts.rejected, counts.evaluations].iter().any(|count| *count > MOST_STEPS) {
            return Err(Error::invalid(
                "counts of a simulation",
                format!("{counts:?}"),
                format!("{MOST_STEPS} at most"),
            ));
        }
        self.loads.iter().flatten().try_for_each(|load| require_finite("loads of a simulation", load))?;
        for rule in self.rules.iter().flatten() {
            if !(rule.valid_from() >= 0.0 && rule.valid_from().is_finite()) {
                return Err(Error::invalid(
                    "least separation of a rule",
                    rule.valid_from(),
                    "a finite number from 0 on",
                ));
            }
        }
        for body in 0..layout.bodies {
            let a = layout.attitude(body);
            let square: f64 = memory.high[a..a + layout.chart.width()].iter().map(|q| q * q).sum();
            if layout.chart == AttitudeChart::Quaternion && (square - 1.0).abs() > UNIT_TOLERANCE {
                let what = format!("square of the length of the quaternion of body {body}");
                return Err(Error::invalid(what, square, "1"));
            }
        }
        Ok(())
    }

    fn check_lengths(&self, layout: Layout) -> Result<()> {
        let dimension = layout.dimension();
        let lengths = (self.memory.high.len(), self.memory.low.len());
        let loads = self.loads.as_ref().map_or(layout.bodies, Vec::len);
        if lengths == (dimension, dimension) && loads == layout.bodies {
            return Ok(());
        }
        let lengths_text = format!("{}, {} and {loads}", lengths.0, lengths.1);
        let expected = format!("{dimension}, {dimension} and {}", layout.bodies);
        Err(Error::invalid("length of the vectors of a simulation", lengths_text, expected))
    }
}

impl Simulation {
    pub(super) fn checkpoint(&self) -> Checkpoint {
        let (memory, loads) = self.propagator.memory();
        let (rules, switches) = self.motion.equations.memory();
        Checkpoint { memory, loads, rules, switches, state_was_set: self.state_was_set }
    }

    /// Continues from a checkpoint of this system and integrator.
    pub(super) fn restore_checkpoint(
        &mut self,
        checkpoint: &Checkpoint,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let Checkpoint { memory, loads, rules, switches, state_was_set } = checkpoint;
        checkpoint.check(self.frame().layout)?;
        self.motion.equations.restore_memory(rules, switches, interrupt)?;
        self.propagator.restore_memory(memory, loads.as_deref());
        self.state_was_set = *state_was_set;
        Ok(())
    }
}
