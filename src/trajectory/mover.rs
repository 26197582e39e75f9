//! What carries a simulation from step to step: a Runge-Kutta pair or a composition of flows. Both answer the same calls.

use super::approach::Contact;
use super::integrator::{Integrator, Steps};
use super::motion::{Motion, SplitMotion};
use crate::dynamics::Splitting;
use crate::error::{Error, Result, require_positive};
use crate::integrate::{
    FixedStepper, Memory, Segment, Statistics, Step, Stepper, Tableau, Tolerance, VERNER98,
};
use crate::patience::Patience;

/// Tolerance of the integration that fills in the time between the ends of a fixed step.
const BRIDGE_TOLERANCE: f64 = 1e-12;

/// The most steps of such a run; more would take gigabytes of memory.
const MOST_PIECES: usize = 4096;

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
    /// The contact with which they end.
    met: Option<Contact>,
    /// Whether the last step was not taken because bodies meet in it.
    blocked: bool,
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
                    met: None,
                    blocked: false,
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

    /// One step towards `end`. A step that cannot be taken because bodies meet in it is left to [`Self::contact`].
    pub fn step(&mut self, motion: &mut Motion, end: f64, patience: &mut Patience) -> Result<()> {
        match self {
            Self::Adaptive(stepper) => stepper.step(motion, end, patience),
            Self::Fixed(fixed) => {
                (fixed.formed, fixed.blocked, fixed.met) = (false, false, None);
                let mut flows =
                    SplitMotion { equations: &mut motion.equations, splitting: &mut fixed.splitting };
                let Err(error) = fixed.stepper.step(&mut flows, end, patience) else { return Ok(()) };
                fixed.splitting.reset();
                if !matches!(error, Error::NotConverged { .. }) {
                    return Err(error);
                }
                let (start, ..) = fixed.stepper.last();
                match fixed.cross(motion, start.value() + fixed.stepper.last_size(), patience) {
                    Err(interrupted @ Error::Interrupted { .. }) => Err(interrupted),
                    Ok(()) if fixed.met.is_some() => {
                        (fixed.formed, fixed.blocked) = (true, true);
                        Ok(())
                    }
                    _ => Err(error),
                }
            }
        }
    }

    /// The first contact in the last step. `looked` says that the step is to be looked into for other reasons as well.
    pub fn contact(
        &mut self,
        motion: &mut Motion,
        looked: bool,
        patience: &mut Patience,
    ) -> Result<Option<Contact>> {
        let layout = motion.equations.layout();
        match self {
            Self::Adaptive(stepper) => {
                let arch = motion.equations.system().arch();
                if !looked && motion.approach.excludes(arch, layout, &stepper.last(), patience)? {
                    return Ok(None);
                }
                let piece = stepper.segment(motion, patience)?;
                motion.approach.search(layout, piece, 0, patience)
            }
            Self::Fixed(fixed) => {
                if !fixed.formed && (looked || !fixed.excludes(motion, patience)?) {
                    fixed.form(motion, patience)?;
                }
                Ok(fixed.met)
            }
        }
    }

    /// Makes the polynomials of the last step, of a Runge-Kutta pair. Those of a fixed step are made by [`Self::contact`] alone.
    pub fn form(&mut self, motion: &mut Motion, patience: &mut Patience) -> Result<()> {
        match self {
            Self::Adaptive(stepper) => stepper.segment(motion, patience).map(drop),
            Self::Fixed(_) => Ok(()),
        }
    }

    /// The last step as polynomials, one after the other, up to the one in which bodies meet; of a step that was looked into.
    pub fn pieces(&self) -> &[Segment] {
        match self {
            Self::Adaptive(stepper) => std::slice::from_ref(stepper.piece()),
            Self::Fixed(fixed) => &fixed.pieces,
        }
    }

    /// The last step by its stages, of a Runge-Kutta pair.
    pub fn last(&self) -> Option<Step<'_>> {
        match self {
            Self::Adaptive(stepper) => Some(stepper.last()),
            Self::Fixed(_) => None,
        }
    }

    /// The stepper of fixed steps and its flows.
    pub fn fixed(&self) -> Option<(&FixedStepper, &Splitting)> {
        match self {
            Self::Adaptive(_) => None,
            Self::Fixed(fixed) => Some((&fixed.stepper, &fixed.splitting)),
        }
    }

    /// The tableau of a Runge-Kutta pair.
    pub fn tableau(&self) -> Option<&'static Tableau> {
        self.last().map(|step| step.tableau())
    }

    /// Takes the last step back.
    pub fn retreat(&mut self) {
        match self {
            Self::Adaptive(stepper) => stepper.retreat(),
            Self::Fixed(fixed) => {
                fixed.splitting.reset();
                if !fixed.blocked {
                    fixed.stepper.retreat();
                }
            }
        }
    }

    /// Takes back a step whose inside cannot be computed because of this error, and plans it shorter. Returns the error
    /// where that does not help.
    pub fn shorten(&mut self, error: Error) -> Result<()> {
        match (self, error) {
            (Self::Adaptive(stepper), Error::StepSizeTooSmall { reason, .. }) => stepper.shorten(&reason),
            (mover, error) => {
                mover.retreat();
                Err(error)
            }
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
    /// Whether no two bodies can have met in the last step, by its ends alone.
    fn excludes(&self, motion: &mut Motion, patience: &mut Patience) -> Result<bool> {
        let ((time, start, _), (end, _)) = (self.stepper.last(), self.stepper.vector());
        let (layout, size) = (motion.equations.layout(), self.stepper.last_size());
        motion.approach.excludes_between(layout, time.value(), [start, end], size, patience)
    }

    /// The pieces of the last step. What the run across it misses of its end is spread over it, in proportion to the time: the error
    /// inside is then that of the step itself. Where bodies meet on the way the pieces end.
    fn form(&mut self, motion: &mut Motion, patience: &mut Patience) -> Result<()> {
        let (start, ..) = self.stepper.last();
        let end = self.stepper.time();
        self.cross(motion, end, patience)?;
        self.formed = true;
        let (Some(bridge), None) = (&self.bridge, self.met) else { return Ok(()) };
        let ((high, low), (reached, tail)) = (self.stepper.vector(), bridge.stepper.vector());
        let missed: Vec<f64> = (0..high.len()).map(|k| (high[k] - reached[k]) + (low[k] - tail[k])).collect();
        let size = (end - start.high) - start.low;
        let mut from = 0.0;
        for (index, piece) in self.pieces.iter_mut().enumerate() {
            let to = from + piece.size() / size;
            piece.tilt(from, to, &missed);
            from = to;
            if self.met.is_none() {
                let layout = motion.equations.layout();
                self.met = motion.approach.search(layout, piece, index, patience)?;
            }
        }
        Ok(())
    }

    /// Verner 9(8) at a tight tolerance from the last step's start to a time, or to where bodies meet before that.
    fn cross(&mut self, motion: &Motion, end: f64, patience: &mut Patience) -> Result<()> {
        let (start, high, low) = self.stepper.last();
        let bridge = match &mut self.bridge {
            Some(bridge) => bridge,
            None => {
                let tolerance = Tolerance::new(BRIDGE_TOLERANCE, BRIDGE_TOLERANCE)?;
                let stepper = Stepper::new(&VERNER98, tolerance, start.value(), high.to_vec(), low.to_vec());
                self.bridge.insert(Bridge { motion: motion.again(patience)?, stepper })
            }
        };
        let size = (end - start.high) - start.low;
        bridge.motion.equations.copy_rules(&motion.equations, patience)?;
        // One piece is enough for most steps, and its error shortens the others.
        bridge.stepper.restart(start, high, low, size);
        let evaluations = bridge.stepper.statistics().evaluations;
        let layout = motion.equations.layout();
        self.pieces.clear();
        self.met = None;
        while bridge.stepper.time() != end && self.met.is_none() {
            let index = self.pieces.len();
            if index == MOST_PIECES {
                return Err(Error::NotConverged {
                    what: format!(
                        "the motion within a step of size {:e} at time {}",
                        end - start.value(),
                        start.value()
                    ),
                    detail: format!(
                        "it takes more than {MOST_PIECES} steps of Verner 9(8); use a shorter step"
                    ),
                });
            }
            bridge.stepper.step(&mut bridge.motion, end, patience)?;
            let piece = match bridge.stepper.segment(&mut bridge.motion, patience) {
                Ok(piece) => piece.clone(),
                Err(Error::StepSizeTooSmall { reason, .. }) => {
                    bridge.stepper.shorten(&reason)?;
                    continue;
                }
                Err(error) => return Err(error),
            };
            self.met = bridge.motion.approach.search(layout, &piece, index, patience)?;
            self.pieces.push(piece);
        }
        self.stepper.count(bridge.stepper.statistics().evaluations - evaluations);
        Ok(())
    }
}
