//! What moves a simulation: a Runge-Kutta pair or a composition of flows, with one face.

use super::integrator::{Integrator, Steps};
use super::motion::{Motion, Parted};
use crate::dynamics::{Inner, Splitting};
use crate::error::{Error, Result, require_positive};
use crate::integrate::{FixedStepper, Memory, Segment, Statistics, Stepper, Tolerance, VERNER98};

/// Tolerance of the runs between the ends of fixed steps.
const BRIDGE_TOLERANCE: f64 = 1e-12;

#[derive(Debug, Clone)]
pub(super) enum Mover {
    Adaptive(Box<Stepper>),
    Fixed(Box<Fixed>),
}

/// Fixed steps, and how to see between their ends.
#[derive(Debug, Clone)]
pub(super) struct Fixed {
    stepper: FixedStepper,
    splitting: Splitting,
    bridge: Option<Bridge>,
    /// Whether the pieces belong to the last step.
    formed: bool,
    pieces: Vec<Segment>,
}

/// Verner 9(8) from the last step's start to its end. It works on a copy of the equations, so that looking between the ends
/// does not disturb the steps, and begins with the rules that were in force in the step and with nothing else from before: the
/// pieces depend on the step alone, however often one looks, and after a restart too.
#[derive(Debug, Clone)]
struct Bridge {
    motion: Motion,
    stepper: Stepper,
}

impl Mover {
    pub fn new(integrator: Integrator, motion: &Motion, inner: &Inner, time: f64) -> Result<Self> {
        let (high, low) = (inner.high.clone(), inner.low.clone());
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

    /// Refuses a run of more fixed steps than a double counts, which would not end.
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
                let mut flows = Parted { equations: &mut motion.equations, splitting: &mut fixed.splitting };
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

    /// Puts the run to a place on the last step.
    pub fn place(&mut self, time: f64, y: &[f64]) {
        match self {
            Self::Adaptive(stepper) => stepper.place(time, y),
            Self::Fixed(fixed) => {
                fixed.splitting.reset();
                fixed.stepper.place(time, y);
            }
        }
    }

    /// What decides how the run goes on.
    pub fn memory(&self) -> (Memory, Option<Vec<[f64; 6]>>) {
        match self {
            Self::Adaptive(stepper) => (stepper.memory(), None),
            Self::Fixed(fixed) => (fixed.stepper.memory(), fixed.splitting.loads()),
        }
    }

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
    /// Verner 9(8) at a tight tolerance from the step's start; what it misses of the step's end is spread over the step, in
    /// proportion to the time. The error inside is then that of the step itself.
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
