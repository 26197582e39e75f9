//! What decides how a simulation goes on.

use super::Simulation;
use crate::dynamics::Layout;
use crate::environment::Switch;
use crate::error::{Error, Result};
use crate::integrate::Memory;
use crate::mutual::RuleMemory;
use crate::patience::Patience;
use serde::{Deserialize, Serialize};

/// All that steps change in a simulation: two of one system and integrator that agree in it go on equally, bit for bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Checkpoint {
    /// Time, vector with its low part, step control, counts.
    memory: Memory,
    /// Accelerations and rates of spin that the present vector has, where the integrator keeps them.
    loads: Option<Vec<[f64; 6]>>,
    /// The quadrature rules in force.
    rules: Vec<Option<RuleMemory>>,
    /// Which forces from outside are switched on.
    switches: Vec<Option<Switch>>,
    /// Whether the present state was given and not reached by a step.
    given: bool,
}

impl Checkpoint {
    /// Time and vector.
    pub fn place(&self) -> (f64, &[f64], &[f64]) {
        (self.memory.time[0], &self.memory.high, &self.memory.low)
    }

    /// Refuses vectors of other lengths than a layout's.
    pub fn check(&self, layout: Layout) -> Result<()> {
        let dimension = layout.dimension();
        let lengths = (self.memory.high.len(), self.memory.low.len());
        let loads = self.loads.as_ref().map_or(layout.bodies, Vec::len);
        if lengths == (dimension, dimension) && loads == layout.bodies {
            return Ok(());
        }
        let found = format!("{}, {} and {loads}", lengths.0, lengths.1);
        let expected = format!("{dimension}, {dimension} and {}", layout.bodies);
        Err(Error::invalid("length of the vectors of a simulation", found, expected))
    }
}

impl Simulation {
    pub(super) fn checkpoint(&self) -> Checkpoint {
        let (memory, loads) = self.mover.memory();
        let (rules, switches) = self.motion.equations.memory();
        Checkpoint { memory, loads, rules, switches, given: self.given }
    }

    /// Goes on from a checkpoint of this system and integrator.
    pub(super) fn go_back(&mut self, checkpoint: &Checkpoint, patience: &mut Patience) -> Result<()> {
        let Checkpoint { memory, loads, rules, switches, given } = checkpoint;
        checkpoint.check(self.frame().layout)?;
        self.motion.equations.recall(rules, switches, patience)?;
        self.mover.recall(memory, loads.as_deref());
        self.given = *given;
        Ok(())
    }
}
