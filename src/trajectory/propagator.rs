//! The propagator of a simulation: a Runge-Kutta pair or a composition of flows, with a common interface.

use super::approach::Contact;
use super::integrator::{Integrator, Steps};
use super::motion::{Motion, SplitMotion};
use crate::dynamics::Splitting;
use crate::error::{Error, Result, require_positive};
use crate::integrate::{
    FixedStepper, Memory, Segment, Statistics, Step, Stepper, Tableau, Tolerance, VERNER98,
};
use crate::interrupt::InterruptCheck;

/// The tolerance of the integration between the ends of a fixed step.
const IN_STEP_TOLERANCE: f64 = 1e-12;

/// The largest number of steps of the in-step integration; more would take gigabytes of memory.
const MOST_PIECES: usize = 4096;

/// The number of steps at the beginning that may be far too short, since each step is up to five times longer
/// than the one before.
const FIRST_STEPS: usize = 64;

#[derive(Debug, Clone)]
pub(super) enum Propagator {
    Adaptive(Box<Stepper>),
    Fixed(Box<FixedSteps>),
}

/// Steps of one size, and the polynomials between their ends.
#[derive(Debug, Clone)]
pub(super) struct FixedSteps {
    stepper: FixedStepper,
    splitting: Splitting,
    in_step: Option<InStepIntegration>,
    /// Whether `pieces` belong to the last step.
    formed: bool,
    pieces: Vec<Segment>,
    /// The contact with which the pieces end.
    contact: Option<Contact>,
    /// Whether the last step was not taken because bodies touch in it.
    blocked: bool,
}

/// The integration by Verner 9(8) from the start of the last fixed step to its end.
///
/// It works on a copy of the equations, so that computing the interior does not change the steps. It begins
/// with the rules that are in use in the step and keeps nothing else of earlier steps. The polynomials thus
/// depend on the step alone: they are the same however often they are computed, and after a restart.
#[derive(Debug, Clone)]
struct InStepIntegration {
    motion: Motion,
    stepper: Stepper,
}

impl Propagator {
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
                Self::Fixed(Box::new(FixedSteps {
                    stepper: FixedStepper::new(composition, size, time, high, low),
                    splitting: Splitting::new(&motion.equations, parts)?,
                    in_step: None,
                    formed: false,
                    pieces: Vec::new(),
                    contact: None,
                    blocked: false,
                }))
            }
        })
    }

    /// Returns an error for a run of more fixed steps than a double can count, which would not end.
    pub fn check_step_count(&self, until: f64) -> Result<()> {
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

    /// Takes one step towards `end`. A step that cannot be taken because bodies touch in it is left to
    /// [`Self::contact`].
    pub fn step(&mut self, motion: &mut Motion, end: f64, interrupt: &mut InterruptCheck) -> Result<()> {
        match self {
            Self::Adaptive(stepper) => stepper.step(motion, end, interrupt),
            Self::Fixed(fixed) => {
                (fixed.formed, fixed.blocked, fixed.contact) = (false, false, None);
                let mut flows =
                    SplitMotion { equations: &mut motion.equations, splitting: &mut fixed.splitting };
                let Err(error) = fixed.stepper.step(&mut flows, end, interrupt) else { return Ok(()) };
                fixed.splitting.reset();
                if !matches!(error, Error::NotConverged { .. }) {
                    return Err(error);
                }
                let (start, ..) = fixed.stepper.last();
                match fixed.cross(motion, start.value() + fixed.stepper.last_size(), interrupt) {
                    // A caller's function may fail because the caller interrupts it.
                    Err(ended @ (Error::Interrupted { .. } | Error::ForceFailed { .. })) => Err(ended),
                    Ok(()) if fixed.contact.is_some() => {
                        (fixed.formed, fixed.blocked) = (true, true);
                        Ok(())
                    }
                    _ => Err(error),
                }
            }
        }
    }

    /// Returns the first contact in the last step. `needs_pieces` says that the step's polynomials are needed
    /// for other reasons as well.
    pub fn contact(
        &mut self,
        motion: &mut Motion,
        needs_pieces: bool,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<Contact>> {
        let layout = motion.equations.layout();
        match self {
            Self::Adaptive(stepper) => {
                let arch = motion.equations.system().arch();
                if !needs_pieces && motion.approach.excludes(arch, layout, &stepper.last(), interrupt)? {
                    return Ok(None);
                }
                let piece = stepper.segment(motion, interrupt)?;
                motion.approach.search(layout, piece, 0, interrupt)
            }
            Self::Fixed(fixed) => {
                if !fixed.formed && (needs_pieces || !fixed.excludes(motion, interrupt)?) {
                    fixed.form(motion, interrupt)?;
                }
                Ok(fixed.contact)
            }
        }
    }

    /// Forms the polynomial of the last step of a Runge-Kutta pair. The polynomials of a fixed step are
    /// formed by [`Self::contact`] alone.
    pub fn form(&mut self, motion: &mut Motion, interrupt: &mut InterruptCheck) -> Result<()> {
        match self {
            Self::Adaptive(stepper) => stepper.segment(motion, interrupt).map(drop),
            Self::Fixed(_) => Ok(()),
        }
    }

    /// Returns the last step as polynomials, one after the other, up to the one in which bodies touch. They
    /// must have been formed.
    pub fn pieces(&self) -> &[Segment] {
        match self {
            Self::Adaptive(stepper) => std::slice::from_ref(stepper.piece()),
            Self::Fixed(fixed) => &fixed.pieces,
        }
    }

    /// Returns the last step with its stages, for a Runge-Kutta pair.
    pub fn last(&self) -> Option<Step<'_>> {
        match self {
            Self::Adaptive(stepper) => Some(stepper.last()),
            Self::Fixed(_) => None,
        }
    }

    /// Returns the stepper of fixed steps and its flows.
    pub fn fixed(&self) -> Option<(&FixedStepper, &Splitting)> {
        match self {
            Self::Adaptive(_) => None,
            Self::Fixed(fixed) => Some((&fixed.stepper, &fixed.splitting)),
        }
    }

    /// Returns the tableau of a Runge-Kutta pair.
    pub fn tableau(&self) -> Option<&'static Tableau> {
        self.last().map(|step| step.tableau())
    }

    /// Undoes the last step.
    pub fn undo(&mut self) {
        match self {
            Self::Adaptive(stepper) => stepper.undo(),
            Self::Fixed(fixed) => {
                fixed.splitting.reset();
                if !fixed.blocked {
                    fixed.stepper.undo();
                }
            }
        }
    }

    /// Undoes a step whose interior cannot be computed because of this error, and shortens the next one. Returns the
    /// error where that does not help.
    pub fn shorten(&mut self, error: Error) -> Result<()> {
        match (self, error) {
            (Self::Adaptive(stepper), Error::StepSizeTooSmall { reason, .. }) => stepper.shorten(&reason),
            (propagator, error) => {
                propagator.undo();
                Err(error)
            }
        }
    }

    /// Moves the simulation to a time and a vector within the last step.
    pub fn move_to(&mut self, time: f64, y: &[f64]) {
        match self {
            Self::Adaptive(stepper) => stepper.move_to(time, y),
            Self::Fixed(fixed) => {
                fixed.splitting.reset();
                fixed.stepper.move_to(time, y);
            }
        }
    }

    /// Moves the simulation to a time and a vector that are the end of a single step in closed form.
    pub fn leap(&mut self, time: f64, y: &[f64]) {
        self.move_to(time, y);
        if let Self::Adaptive(stepper) = self {
            stepper.count_step();
        }
    }

    /// Returns the data that determine the continuation of the run: the stepper's memory, and the loads at the present
    /// vector where they are stored.
    pub fn memory(&self) -> (Memory, Option<Vec<[f64; 6]>>) {
        match self {
            Self::Adaptive(stepper) => (stepper.memory(), None),
            Self::Fixed(fixed) => (fixed.stepper.memory(), fixed.splitting.loads()),
        }
    }

    /// Restores the data that [`Self::memory`] returned.
    pub fn restore_memory(&mut self, memory: &Memory, loads: Option<&[[f64; 6]]>) {
        match self {
            Self::Adaptive(stepper) => stepper.restore_memory(memory),
            Self::Fixed(fixed) => {
                fixed.stepper.restore_memory(memory);
                match loads {
                    Some(loads) => fixed.splitting.set_loads(loads),
                    None => fixed.splitting.reset(),
                }
            }
        }
    }
}

impl FixedSteps {
    /// Returns whether the ends of the last step alone prove that no two bodies touch in it.
    fn excludes(&self, motion: &mut Motion, interrupt: &mut InterruptCheck) -> Result<bool> {
        let ((time, start, _), (end, _)) = (self.stepper.last(), self.stepper.vector());
        let (layout, size) = (motion.equations.layout(), self.stepper.last_size());
        motion.approach.excludes_between(layout, time.value(), [start, end], size, interrupt)
    }

    /// Forms the pieces of the last step. The difference between their end and the step's end is spread over
    /// them in proportion to time, so that the error inside is that of the step itself. The pieces end where
    /// bodies touch.
    fn form(&mut self, motion: &mut Motion, interrupt: &mut InterruptCheck) -> Result<()> {
        let (start, ..) = self.stepper.last();
        let end = self.stepper.time();
        self.cross(motion, end, interrupt)?;
        self.formed = true;
        let (Some(in_step), None) = (&self.in_step, self.contact) else { return Ok(()) };
        let ((high, low), (end_high, end_low)) = (self.stepper.vector(), in_step.stepper.vector());
        let difference: Vec<f64> =
            (0..high.len()).map(|k| (high[k] - end_high[k]) + (low[k] - end_low[k])).collect();
        let size = (end - start.high) - start.low;
        let mut from = 0.0;
        for (index, piece) in self.pieces.iter_mut().enumerate() {
            let to = from + piece.size() / size;
            piece.tilt(from, to, &difference);
            from = to;
            if self.contact.is_none() {
                let layout = motion.equations.layout();
                self.contact = motion.approach.search(layout, piece, index, interrupt)?;
            }
        }
        Ok(())
    }

    /// Integrates by Verner 9(8) at a tight tolerance from the last step's start to a time, or to a contact
    /// before that.
    fn cross(&mut self, motion: &Motion, end: f64, interrupt: &mut InterruptCheck) -> Result<()> {
        let (start, high, low) = self.stepper.last();
        let in_step = match &mut self.in_step {
            Some(in_step) => in_step,
            None => {
                let tolerance = Tolerance::new(IN_STEP_TOLERANCE, IN_STEP_TOLERANCE)?;
                let stepper = Stepper::new(&VERNER98, tolerance, start.value(), high.to_vec(), low.to_vec());
                self.in_step
                    .insert(InStepIntegration { motion: motion.copy_without_rules(interrupt)?, stepper })
            }
        };
        let size = (end - start.high) - start.low;
        in_step.motion.equations.copy_rules(&motion.equations, interrupt)?;
        // One piece is enough for most steps; otherwise error control shortens the pieces.
        in_step.stepper.restart(start, high, low, size);
        let evaluations = in_step.stepper.statistics().evaluations;
        let layout = motion.equations.layout();
        self.pieces.clear();
        self.contact = None;
        while in_step.stepper.time() != end && self.contact.is_none() {
            let index = self.pieces.len();
            let covered = (in_step.stepper.time() - start.high) - start.low;
            // Even if each remaining piece were as long as all previous pieces together, the end would not be reached.
            let hopeless = index >= FIRST_STEPS && (covered * MOST_PIECES as f64).abs() < size.abs();
            if hopeless || index == MOST_PIECES {
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
            in_step.stepper.step(&mut in_step.motion, end, interrupt)?;
            let piece = match in_step.stepper.segment(&mut in_step.motion, interrupt) {
                Ok(piece) => piece.clone(),
                Err(Error::StepSizeTooSmall { reason, .. }) => {
                    in_step.stepper.shorten(&reason)?;
                    continue;
                }
                Err(error) => return Err(error),
            };
            self.contact = in_step.motion.approach.search(layout, &piece, index, interrupt)?;
            self.pieces.push(piece);
        }
        self.stepper.count(in_step.stepper.statistics().evaluations - evaluations);
        Ok(())
    }
}
