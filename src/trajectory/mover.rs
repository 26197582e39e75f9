//! What carries a simulation from step to step: a Runge-Kutta pair or a composition of flows. Both answer the same calls.

use super::integrator::{Integrator, Steps};
use super::motion::{Motion, SplitMotion};
use crate::dynamics::Splitting;
use crate::error::{Error, Result, require_positive};
use crate::integrate::{FixedStepper, Memory, Segment, Statistics, Stepper, Tolerance, VERNER98};

/// Tolerance of the integration that fills in the time between the ends of a fixed step.
const BRIDGE_TOLERANCE: f64 = 1e-12;

#[derive(Debug, Clone)]
pub(super) enum Mover {
    Adaptive(Box<Stepper>),
    Fixed(Box<Fixed>),
}

/// Steps of one size, and the polynomials between their ends.
#[derive(Debug, Clone)]
pub(super) struct Fixed {
    stepper: FixedStepper,
    splitting: Splitting,
    bridge: Option<Bridge>,
    /// Whether `pieces` are those of the last step.
    formed: bool,
    pieces: Vec<Segment>,
}

/// The integration by Verner 9(8) from the start of the last step to its end.
///
/// It works on a copy of the equations, so that the steps go on as if nobody had looked between their ends. It begins with the
/// rules that are in force in the step and remembers nothing else of earlier steps. The polynomials thus depend on the step
/// alone: they are the same however often one looks, and after a restart.
#[derive(Debug, Clone)]
struct Bridge {
    motion: Motion,
    stepper: Stepper,
}

impl Mover {
    pub fn new(
        integrator: Integrator,
        motion: &Motion,
        time: f64,
        high: Vec<f64>,
        low: Vec<f64>,
    ) -> Result<Self> {
        Ok(match integrator.steps() {
            Steps::Controlled(tableau, tolerance) => {
                Self::Adaptive(Box::new(Stepper::new(tableau, tolerance, time, high, low)))
            }
            Steps::Fixed(composition, parts, size) => {
                require_positive("step", size)?;
                Self::Fixed(Box::new(Fixed {
                    stepper: FixedStepper::new(composition, size, time, high, low),
                    splitting: Splitting::new(&motion.equations, parts)?,
                    bridge: None,
                    formed: false,
                    pieces: Vec::new(),
                }))
            }
        })
    }

    /// Refuses a run of more fixed steps than a double can count: it would not end.
    pub fn check_reach(&self, until: f64) -> Result<()> {
        if let Self::Fixed(fixed) = self {
            let steps = (until - fixed.stepper.time()).abs() / fixed.stepper.size();
            if steps > 1.0 / f64::EPSILON {
                let expected = format!("a longer one; until {until} takes {steps:.1e} of them");
                let size = format!("{:e}", fixed.stepper.size());
                return Err(Error::invalid("step", size, expected));
            }
        }
        Ok(())
    }

    pub fn time(&self) -> f64 {
        match self {
            Self::Adaptive(stepper) => stepper.time(),
            Self::Fixed(fixed) => fixed.stepper.time(),
        }
    }

    pub fn vector(&self) -> (&[f64], &[f64]) {
        match self {
            Self::Adaptive(stepper) => stepper.vector(),
            Self::Fixed(fixed) => fixed.stepper.vector(),
        }
    }

    pub fn statistics(&self) -> Statistics {
        match self {
            Self::Adaptive(stepper) => stepper.statistics(),
            Self::Fixed(fixed) => fixed.stepper.statistics(),
        }
    }

    pub fn step(&mut self, motion: &mut Motion, end: f64) -> Result<()> {
        match self {
            Self::Adaptive(stepper) => stepper.step(motion, end),
            Self::Fixed(fixed) => {
                fixed.formed = false;
                let mut flows =
                    SplitMotion { equations: &mut motion.equations, splitting: &mut fixed.splitting };
                fixed.stepper.step(&mut flows, end)
            }
        }
    }

    /// The last step as polynomials, one after the other.
    pub fn pieces(&mut self, motion: &mut Motion) -> Result<&[Segment]> {
        match self {
            Self::Adaptive(stepper) => Ok(std::slice::from_ref(stepper.segment(motion)?)),
            Self::Fixed(fixed) => fixed.pieces(motion),
        }
    }

    /// Moves the run to a time and a vector within the last step.
    pub fn place(&mut self, time: f64, y: &[f64]) {
        match self {
            Self::Adaptive(stepper) => stepper.place(time, y),
            Self::Fixed(fixed) => {
                fixed.splitting.reset();
                fixed.stepper.place(time, y);
            }
        }
    }

    /// What decides how the run goes on: the stepper's memory, and the loads of the present vector where they are kept.
    pub fn memory(&self) -> (Memory, Option<Vec<[f64; 6]>>) {
        match self {
            Self::Adaptive(stepper) => (stepper.memory(), None),
            Self::Fixed(fixed) => (fixed.stepper.memory(), fixed.splitting.loads()),
        }
    }

    /// The inverse of [`Self::memory`].
    pub fn recall(&mut self, memory: &Memory, loads: Option<&[[f64; 6]]>) {
        match self {
            Self::Adaptive(stepper) => stepper.recall(memory),
            Self::Fixed(fixed) => {
                fixed.stepper.recall(memory);
                match loads {
                    Some(loads) => fixed.splitting.recall(loads),
                    None => fixed.splitting.reset(),
                }
            }
        }
    }
}

impl Fixed {
    /// The last step as polynomials. The bridge misses the end of the step by the step's own error; that difference is spread over
    /// the step in proportion to the time, so that the error inside is that of the step itself.
    fn pieces(&mut self, motion: &Motion) -> Result<&[Segment]> {
        if self.formed {
            return Ok(&self.pieces);
        }
        let (start, high, low) = self.stepper.last();
        let bridge = match &mut self.bridge {
            Some(bridge) => bridge,
            None => {
                let tolerance = Tolerance::new(BRIDGE_TOLERANCE, BRIDGE_TOLERANCE)?;
                let stepper = Stepper::new(&VERNER98, tolerance, start.value(), high.to_vec(), low.to_vec());
                self.bridge.insert(Bridge { motion: motion.clone(), stepper })
            }
        };
        let end = self.stepper.time();
        let size = (end - start.high) - start.low;
        bridge.motion.equations.copy_rules(&motion.equations);
        // One piece is enough for most steps, and its error shortens the others.
        bridge.stepper.restart(start, high, low, size);
        let evaluations = bridge.stepper.statistics().evaluations;
        self.pieces.clear();
        while bridge.stepper.time() != end {
            bridge.stepper.step(&mut bridge.motion, end)?;
            self.pieces.push(bridge.stepper.segment(&mut bridge.motion)?.clone());
        }
        let ((high, low), (reached, tail)) = (self.stepper.vector(), bridge.stepper.vector());
        let missed: Vec<f64> = (0..high.len()).map(|k| (high[k] - reached[k]) + (low[k] - tail[k])).collect();
        let mut from = 0.0;
        for piece in &mut self.pieces {
            let to = from + piece.size() / size;
            piece.tilt(from, to, &missed);
            from = to;
        }
        self.stepper.count(bridge.stepper.statistics().evaluations - evaluations);
        self.formed = true;
        Ok(&self.pieces)
    }
}
