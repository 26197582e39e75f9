//! A simulation: a system with its present state and the integrator that advances it.

use super::Integrator;
use super::approach::Contact;
use super::motion::Motion;
use super::propagator::Propagator;
use super::tangent_step::LastStep;
use crate::dynamics::{BarycentricFrame, Dynamics, Invariants, NominalChange, State, System};
use crate::error::{Error, Result};
use crate::integrate::{Equations, Statistics};
use crate::interrupt::InterruptCheck;

/// A system at a state, with an integrator.
///
/// ```
/// use fullbody::dynamics::{Settings, State, System};
/// use fullbody::integrate::Tolerance;
/// use fullbody::math::Vec3;
/// use fullbody::shape::{Body, Shape};
/// use fullbody::trajectory::{Integrator, Output, Simulation, Trajectory};
/// use std::f64::consts::PI;
/// use std::ops::ControlFlow;
///
/// let ball = |name| Body::with_mass(name, Shape::ellipsoid([0.1, 0.1, 0.1])?, 0.5);
/// let system = System::new(vec![ball("One")?, ball("Two")?], 1.0, Settings::default())?;
/// let (rest, upright) = (vec![Vec3::zeros(); 2], vec![[1.0, 0.0, 0.0, 0.0]; 2]);
/// let vectors = |x: f64, y: f64| vec![Vec3::new(-x, -y, 0.0), Vec3::new(x, y, 0.0)];
/// let state = State::new(0.0, vectors(0.5, 0.0), vectors(0.0, 0.5), upright, rest)?;
///
/// // Half a revolution on a circle of radius one about each other.
/// let integrator = Integrator::Verner98(Tolerance::new(1e-13, 1e-13)?);
/// let mut simulation = Simulation::new(&system, &state, integrator)?;
/// let mut run = Trajectory::new(2);
/// simulation.integrate(PI, &Output::Spacing(PI), &mut run)?;
/// assert!((simulation.state().position()[1].x + 0.5).abs() < 1e-12);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Simulation {
    pub(super) motion: Motion,
    pub(super) integrator: Integrator,
    pub(super) propagator: Propagator,
    /// Whether the present state was set, by the caller or as that of a terminal event, rather than reached by a step.
    pub(super) state_was_set: bool,
    /// How the nominal barycentre changes with the state at the end of the last run, if it was
    /// differentiated.
    pub(super) nominal: Option<NominalChange>,
    /// Text that the caller keeps with the simulation and its archives, such as names of units. No number
    /// that the simulation works with belongs here.
    pub notes: String,
    /// The conserved quantities at the start.
    pub(super) start: Invariants,
}

impl Simulation {
    /// Makes a simulation that starts at a state, after checking the state against the system.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] if the state does not belong to the system or the integrator does not accept
    /// its forces, [`Error::BodiesOverlap`] if two bodies overlap, [`Error::NotConverged`] if a quadrature
    /// reaches its limit, and [`Error::ForceFailed`] if an external force fails.
    pub fn new(system: &System, state: &State, integrator: Integrator) -> Result<Self> {
        Self::begin(system, state, integrator, &mut InterruptCheck::never())
    }

    /// Makes a simulation as [`Self::new`], with an interrupt check: systems of very many bodies take
    /// seconds.
    ///
    /// # Errors
    /// Returns the errors of [`Self::new`], and [`Error::Interrupted`].
    pub fn begin(
        system: &System,
        state: &State,
        integrator: Integrator,
        interrupt: &mut InterruptCheck,
    ) -> Result<Self> {
        system.check(state, interrupt)?;
        let (frame, high, low) = BarycentricFrame::new(system.layout(), &system.masses(), state);
        let mut motion = Motion::new(system.dynamics(&frame, interrupt)?, &high);
        motion.equations.check_external_forces(state.time, state.time, &high)?;
        motion.prepare(state.time, &high, 0.0, interrupt)?;
        // Scales that overflow are refused here, since no error of a step could be measured against them.
        let energy = motion.equations.energy(state.time, &high, &state.velocity, interrupt)?;
        system.check_range(&energy)?;
        let angular_momentum = motion.equations.angular_momentum(state.time, &high);
        let start = Invariants { time: state.time, energy, angular_momentum };
        let propagator = Propagator::new(integrator, &motion, state.time, high, low)?;
        Ok(Self {
            motion,
            integrator,
            propagator,
            state_was_set: true,
            start,
            nominal: None,
            notes: String::new(),
        })
    }

    /// Returns the system.
    pub fn system(&self) -> &System {
        self.motion.equations.system()
    }

    /// Returns the integrator.
    pub fn integrator(&self) -> Integrator {
        self.integrator
    }

    /// Returns the present time.
    pub fn time(&self) -> f64 {
        self.propagator.time()
    }

    /// Returns the present state.
    pub fn state(&self) -> State {
        let (high, low) = self.propagator.vector();
        self.frame().state(self.time(), high, low)
    }

    /// Restarts the simulation and its counts from another state.
    ///
    /// # Errors
    /// Returns the errors of [`Self::begin`]; the simulation is then unchanged.
    pub fn set_state(&mut self, state: &State, interrupt: &mut InterruptCheck) -> Result<()> {
        let fresh = Self::begin(self.system(), state, self.integrator, interrupt)?;
        *self = Self { notes: std::mem::take(&mut self.notes), ..fresh };
        Ok(())
    }

    /// Returns the frame of the vectors.
    pub(super) fn frame(&self) -> &BarycentricFrame {
        self.motion.equations.frame()
    }

    /// Returns the conserved quantities at the state with which the simulation began or that was set last.
    pub fn start(&self) -> Invariants {
        self.start
    }

    /// Returns the conserved quantities at the present state.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] if the energy is too large for a double, and [`Error::Interrupted`].
    pub fn invariants(&mut self, interrupt: &mut InterruptCheck) -> Result<Invariants> {
        let state = self.state();
        let high = self.propagator.vector().0.to_vec();
        self.invariants_of(&high, &state, interrupt)
    }

    /// Returns work, impulse and angular impulse of the external forces since [`Self::start`], seven numbers
    /// for each force.
    pub fn work_and_impulse(&self) -> &[f64] {
        self.frame().layout.work_and_impulse(self.propagator.vector().0)
    }

    /// Returns the counts since the start.
    pub fn statistics(&self) -> Statistics {
        self.propagator.statistics()
    }

    /// Returns the equations of motion with the rules in use.
    #[doc(hidden)]
    pub fn dynamics(&self) -> &Dynamics {
        &self.motion.equations
    }

    /// Takes one accepted step towards `end`, never beyond it, nor beyond the times for which the external
    /// forces are defined.
    ///
    /// # Errors
    /// Returns the errors of [`Self::integrate`]; after an error the simulation is at the start of the step.
    pub fn step(&mut self, end: f64) -> Result<()> {
        self.step_with(end, &mut InterruptCheck::never())
    }

    /// Takes one step as [`Self::step`], with interrupt checks.
    ///
    /// # Errors
    /// Returns the errors of [`Self::step`], and [`Error::Interrupted`].
    pub fn step_with(&mut self, end: f64, interrupt: &mut InterruptCheck) -> Result<()> {
        if end.is_nan() {
            return Err(Error::invalid("end of a step", end, "a time, which may be infinite"));
        }
        let time = self.time();
        let defined_end = self.motion.equations.external_forces().reach(time, end);
        if defined_end == time && end != time {
            self.motion.equations.check_external_forces(time, end, self.propagator.vector().0)?;
        }
        self.switch_overdue(None)?;
        let (contact, switched) = self.advance(defined_end, false, |_| false, interrupt)?;
        let ended = match (contact, switched) {
            (Some(contact), _) => Err(contact.error(self.system())),
            (None, Some(force)) => self.switch(force, None),
            (None, None) => Ok(()),
        };
        ended.inspect_err(|_| self.propagator.undo())
    }

    /// Takes one step and returns the first contact in it, or the force with whose switch it ends.
    /// `needs_pieces` decides from a step's end whether the step's polynomials are needed for other reasons
    /// as well, and `with_tangents` says whether tangent vectors are integrated.
    pub(super) fn advance(
        &mut self,
        end: f64,
        with_tangents: bool,
        needs_pieces: impl Fn(f64) -> bool,
        interrupt: &mut InterruptCheck,
    ) -> Result<(Option<Contact>, Option<usize>)> {
        let (mut end, mut repetitions) = (end, 0);
        loop {
            self.propagator.step(&mut self.motion, end, interrupt)?;
            let needs_pieces = needs_pieces(self.time());
            let mut contact = self.propagator.contact(&mut self.motion, needs_pieces, interrupt);
            if with_tangents && contact.is_ok() {
                contact = self.propagator.form(&mut self.motion, interrupt).and(contact);
            }
            let interruption =
                contact.and_then(|contact| Ok((contact, self.next_switch(contact, repetitions, interrupt)?)));
            match interruption {
                Ok((_, Some((_, time)))) if time != self.time() => {
                    self.propagator.undo();
                    (end, repetitions) = (time, repetitions + 1);
                }
                Ok((contact, switch)) => {
                    self.state_was_set &= contact.is_some();
                    return Ok((contact, switch.map(|(force, _)| force)));
                }
                Err(error) => self.propagator.shorten(error)?,
            }
        }
    }

    /// Returns the last step, along which tangent vectors are integrated.
    pub(super) fn last_step<'a, 'i>(&'a mut self, interrupt: &'a mut InterruptCheck<'i>) -> LastStep<'a, 'i> {
        let pieces = self.propagator.pieces();
        LastStep { equations: &mut self.motion.equations, pieces, interrupt }
    }

    pub(super) fn invariants_of(
        &mut self,
        y: &[f64],
        state: &State,
        interrupt: &mut InterruptCheck,
    ) -> Result<Invariants> {
        let energy = self.motion.equations.energy(state.time, y, &state.velocity, interrupt)?;
        let angular_momentum = self.motion.equations.angular_momentum(state.time, y);
        Ok(Invariants { time: state.time, energy, angular_momentum })
    }
}
