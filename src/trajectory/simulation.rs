//! The stepping object: a system, where it is, and the integrator that moves it.

use super::approach::Contact;
use super::dense::{piece_at, state_within};
use super::events::Watch;
use super::motion::Motion;
use super::mover::Mover;
use super::output::Times;
use super::tangent::{Following, Tangents};
use super::{Dense, Event, Integrator, Output, StopReason, Trajectory};
use crate::dynamics::{BarycentricFrame, Dynamics, Invariants, State, System};
use crate::error::{Error, Result, require_finite};
use crate::integrate::{Equations, Statistics};
use crate::patience::{HOOK_INTERVAL, Patience, UNITS};
use std::ops::ControlFlow;
use std::time::Instant;

/// Units of work of evaluations between looks at the clock from step to step.
const LOOK: u64 = UNITS / 32;

/// Where a run is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Start of the run.
    pub start: f64,
    /// Present time.
    pub time: f64,
    /// End of the run.
    pub end: f64,
}

/// The options of a run.
pub struct Run<'a, 'f> {
    /// When samples are recorded.
    pub output: &'a Output,
    /// The events that are watched for.
    pub events: &'a mut [Event<'f>],
    /// Whether the continuous solution is kept.
    pub dense: bool,
    /// What is followed beside it.
    pub following: &'a Following,
}

/// A system at a state, ready to be moved.
#[derive(Debug, Clone)]
pub struct Simulation {
    pub(super) motion: Motion,
    pub(super) integrator: Integrator,
    pub(super) mover: Mover,
    /// Whether the present state was given, by the caller or as that of a terminal event, and not reached by a step.
    pub(super) given: bool,
    /// What a caller wants kept with the simulation and its archives, as text of any kind: names of units and the like. No number
    /// that the simulation works with belongs here.
    pub notes: String,
    /// The conserved quantities at the start.
    pub(super) start: Invariants,
}

impl Simulation {
    /// Checks the state against the system.
    pub fn new(system: &System, state: &State, integrator: Integrator) -> Result<Self> {
        Self::begin(system, state, integrator, &mut Patience::endless())
    }

    /// The same with a hook that may interrupt it: systems of very many bodies take seconds.
    pub fn begin(
        system: &System,
        state: &State,
        integrator: Integrator,
        patience: &mut Patience,
    ) -> Result<Self> {
        system.check(state, patience)?;
        let (frame, high, low) = BarycentricFrame::new(system.layout(), &system.masses(), state);
        let mut motion = Motion::new(system.dynamics(&frame, patience)?, &high);
        motion.equations.check_outside(state.time, state.time, &high)?;
        motion.prepare(state.time, &high, 0.0, patience)?;
        // Scales that overflow are refused here, since no step could be measured against them.
        let energy = motion.equations.energy(state.time, &high, &state.velocity, patience)?;
        system.check_range(&energy)?;
        let angular_momentum = motion.equations.angular_momentum(state.time, &high);
        let start = Invariants { time: state.time, energy, angular_momentum };
        let mover = Mover::new(integrator, &motion, state.time, high, low)?;
        Ok(Self { motion, integrator, mover, given: true, start, notes: String::new() })
    }

    /// The system.
    pub fn system(&self) -> &System {
        self.motion.equations.system()
    }

    /// The integrator.
    pub fn integrator(&self) -> Integrator {
        self.integrator
    }

    /// Present time.
    pub fn time(&self) -> f64 {
        self.mover.time()
    }

    /// Present state.
    pub fn state(&self) -> State {
        let (high, low) = self.mover.vector();
        self.frame().state(self.time(), high, low)
    }

    /// Starts anew from another state; counts start anew too.
    pub fn set_state(&mut self, state: &State, patience: &mut Patience) -> Result<()> {
        let fresh = Self::begin(self.system(), state, self.integrator, patience)?;
        *self = Self { notes: std::mem::take(&mut self.notes), ..fresh };
        Ok(())
    }

    /// The frame of the vectors.
    pub(super) fn frame(&self) -> &BarycentricFrame {
        self.motion.equations.frame()
    }

    /// The conserved quantities at the state that the simulation began with or was last set to.
    pub fn start(&self) -> Invariants {
        self.start
    }

    /// The conserved quantities at the present state.
    pub fn invariants(&mut self, patience: &mut Patience) -> Result<Invariants> {
        let state = self.state();
        let high = self.mover.vector().0.to_vec();
        self.invariants_of(&high, &state, patience)
    }

    /// Books of the forces from outside since then, seven numbers each: work, impulse, angular impulse.
    pub fn books(&self) -> &[f64] {
        self.frame().layout.books(self.mover.vector().0)
    }

    /// Counts since the start.
    pub fn statistics(&self) -> Statistics {
        self.mover.statistics()
    }

    /// The equations of motion with the rules in force.
    pub fn dynamics(&self) -> &Dynamics {
        &self.motion.equations
    }

    /// One accepted step towards `end`, never beyond it, nor beyond the times for which the forces from outside are given.
    pub fn step(&mut self, end: f64, patience: &mut Patience) -> Result<()> {
        let time = self.time();
        let reach = self.motion.equations.outside().reach(time, end);
        if reach == time && end != time {
            self.motion.equations.check_outside(time, end, self.mover.vector().0)?;
        }
        match self.advance(reach, false, |_| false, patience)? {
            None => Ok(()),
            Some(contact) => {
                self.mover.retreat();
                Err(contact.error(self.system()))
            }
        }
    }

    /// One step, and the first contact in it. `looked` tells of a step's end whether the step is to be
    /// looked into for other reasons as well, and `followed` whether something follows the motion.
    fn advance(
        &mut self,
        end: f64,
        followed: bool,
        looked: impl Fn(f64) -> bool,
        patience: &mut Patience,
    ) -> Result<Option<Contact>> {
        loop {
            self.mover.step(&mut self.motion, end, patience)?;
            let looked = looked(self.time());
            let mut contact = self.mover.contact(&mut self.motion, looked, patience);
            if followed && contact.is_ok() {
                contact = self.mover.form(&mut self.motion, patience).and(contact);
            }
            match contact {
                Ok(contact) => {
                    self.given &= contact.is_some();
                    return Ok(contact);
                }
                Err(error) => self.mover.shorten(error)?,
            }
        }
    }

    /// Moves to `until`, forwards or backwards, and records into `record`.
    ///
    /// On an error the record keeps what there was up to it, and the simulation stays at the end of the last step that is
    /// recorded whole; where two bodies meet, that is the last one before their contact. The hook is called at the start, about every
    /// 50 ms, also within steps that take longer, and at the end, and stops the run by [`ControlFlow::Break`].
    pub fn integrate(
        &mut self,
        until: f64,
        output: &Output,
        record: &mut Trajectory,
        hook: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<()> {
        let run = Run { output, events: &mut [], dense: false, following: &Following::default() };
        self.run(until, run, record, &mut |_, progress| hook(progress))
    }

    /// The same with events and the continuous solution.
    ///
    /// A terminal event ends the run: its state becomes the last sample and the state of the simulation, and what was recorded
    /// before is as without it. A zero at a state that was given, by the caller or by a terminal event, is not an event, so
    /// that a run goes on from one. Between two steps the hook also sees the simulation, for an archive of it.
    pub fn run(
        &mut self,
        until: f64,
        run: Run,
        record: &mut Trajectory,
        hook: &mut dyn FnMut(Option<&Self>, Progress) -> ControlFlow<()>,
    ) -> Result<()> {
        let start = self.time();
        let before = self.motion.equations.outside().switches();
        let outcome = self.follow(until, run, record, hook).and_then(|reason| {
            let time = self.time();
            let last = hook(Some(self), Progress { start, time, end: until });
            if last.is_break() { Err(Error::Interrupted { time }) } else { Ok(reason) }
        });
        let after = self.motion.equations.outside().switches();
        record.switched_off.resize(after.len(), None);
        for (count, switch) in record.switched_off.iter_mut().zip(before.iter().zip(&after)) {
            if let (Some(before), Some(after)) = switch {
                // One that is off from the start on has been switched off too.
                *count = Some(count.unwrap_or(u64::from(!before.on)) + after.times - before.times);
            }
        }
        record.stop_reason = match &outcome {
            Ok(reason) => *reason,
            Err(Error::Interrupted { .. }) => StopReason::Interrupted,
            Err(_) => StopReason::Unfinished,
        };
        outcome.map(drop)
    }

    fn follow(
        &mut self,
        until: f64,
        run: Run,
        record: &mut Trajectory,
        hook: &mut dyn FnMut(Option<&Self>, Progress) -> ControlFlow<()>,
    ) -> Result<StopReason> {
        require_finite("until", &[until])?;
        self.mover.check_reach(until)?;
        let from = self.time();
        self.motion.equations.check_outside(from, until, self.mover.vector().0)?;
        let Run { output, events, dense, following } = run;
        let followed = *following != Following::default();
        let start = self.time();
        let mut times = Times::new(start, until, output)?;
        let mut watch = Watch::new(&self.motion.equations, events, self.given)?;
        let mut sample = vec![0.0; self.frame().layout.dimension()];
        let mut tangents = Tangents::new(following, &self.motion, &self.mover, &self.state())?;
        if dense {
            record.dense = Some(Dense::new(self.frame(), self.state()));
        }
        if hook(Some(self), Progress { start, time: start, end: until }).is_break() {
            return Err(Error::Interrupted { time: start });
        }
        let (mut called, mut unseen) = (Instant::now(), 0);
        {
            let mut inside = || hook(None, Progress { start, time: start, end: until });
            let patience = &mut Patience::since(called, &mut inside);
            let conserved = self.invariants(patience)?;
            record.start.get_or_insert(conserved);
            let books = || self.frame().layout.books(self.mover.vector().0).to_vec();
            record.start_books.get_or_insert_with(books);
            if times.due(start) {
                self.record_present(record, &mut tangents, patience)?;
            }
        }
        while self.time() != until {
            let time = self.time();
            let mut inside = || hook(None, Progress { start, time, end: until });
            let patience = &mut Patience::since(called, &mut inside);
            let watched = dense || !events.is_empty();
            let (stop, contact);
            if watched {
                let (before, known) = (self.checkpoint(), record.events.len());
                contact = self.advance(until, followed, |_| true, patience)?;
                stop = match self.look_inside(contact, &mut watch, events, record, patience) {
                    Ok(stop) => stop,
                    Err(error) => {
                        // The step is taken back with all that was found in it: a run that goes on misses nothing.
                        record.events.truncate(known);
                        self.go_back(&before, &mut Patience::endless())?;
                        return Err(error);
                    }
                };
            } else {
                stop = None;
                contact = self.advance(until, followed, |now| times.pending(now).is_some(), patience)?;
            }
            let now = self.time();
            let met = contact.map_or(now, |contact| contact.time);
            let reached = stop.map_or(met, |(_, time)| time);
            while let Some(time) = times.before(reached) {
                let piece = piece_at(self.mover.pieces(), time, until >= start);
                let state = state_within(self.frame(), piece, time, &mut sample);
                self.record_state(record, &sample, &state, &mut tangents, patience)?;
            }
            if let Some((event, time)) = stop {
                tangents.place(&mut self.motion, self.mover.pieces(), time, patience)?;
                self.mover.place(time, watch.vector());
                self.given = true;
                self.record_present(record, &mut tangents, patience)?;
                return Ok(StopReason::Event(event));
            }
            if let Some(contact) = contact {
                self.mover.retreat();
                return Err(contact.error(self.system()));
            }
            let followed = tangents.advance(&mut self.motion, &self.mover, patience);
            followed.inspect_err(|_| self.mover.retreat())?;
            if times.due(now) {
                self.record_present(record, &mut tangents, patience)?;
            }
            // The clock is read after many quick steps.
            unseen += self.motion.equations.work() * self.motion.equations.parts() as u64;
            let look = watched || unseen >= LOOK;
            unseen = if look { 0 } else { unseen };
            if look && called.elapsed() >= HOOK_INTERVAL {
                called = Instant::now();
                if hook(Some(self), Progress { start, time: now, end: until }).is_break() {
                    return Err(Error::Interrupted { time: now });
                }
            }
        }
        Ok(StopReason::End)
    }

    /// The events and the continuous solution in the last step, up to the first terminal event, whose place in the list and time
    /// are given, or to where bodies meet.
    fn look_inside(
        &mut self,
        contact: Option<Contact>,
        watch: &mut Watch,
        events: &mut [Event],
        record: &mut Trajectory,
        patience: &mut Patience,
    ) -> Result<Option<(usize, f64)>> {
        let present = record.dense.is_some().then(|| self.state());
        let (now, vector) = (self.time(), self.mover.vector().0.to_vec());
        let pieces = self.mover.pieces();
        let mut stop = None;
        if !events.is_empty() {
            let (end, found) = ((now, vector.as_slice()), &mut record.events);
            stop = watch.scan(&self.motion.equations, pieces, end, contact, events, found, patience)?;
        }
        if let (Some(solution), Some(present)) = (&mut record.dense, present) {
            let last = match (record.events.last().filter(|_| stop.is_some()), contact) {
                (Some(last), _) => last.state.clone(),
                (None, Some(met)) => {
                    let mut y = vec![0.0; vector.len()];
                    state_within(self.frame(), &pieces[met.piece], met.time, &mut y)
                }
                (None, None) => present,
            };
            solution.extend(pieces, last);
        }
        Ok(stop)
    }

    fn record_present(
        &mut self,
        record: &mut Trajectory,
        tangents: &mut Tangents,
        patience: &mut Patience,
    ) -> Result<()> {
        let state = self.state();
        let high = self.mover.vector().0.to_vec();
        self.record_state(record, &high, &state, tangents, patience)
    }

    fn record_state(
        &mut self,
        record: &mut Trajectory,
        y: &[f64],
        state: &State,
        tangents: &mut Tangents,
        patience: &mut Patience,
    ) -> Result<()> {
        let conserved = self.invariants_of(y, state, patience)?;
        tangents.record(&mut self.motion, self.mover.pieces(), state, record, patience)?;
        record.push(state, &conserved, self.frame().layout.books(y));
        Ok(())
    }

    fn invariants_of(&mut self, y: &[f64], state: &State, patience: &mut Patience) -> Result<Invariants> {
        let energy = self.motion.equations.energy(state.time, y, &state.velocity, patience)?;
        let angular_momentum = self.motion.equations.angular_momentum(state.time, y);
        Ok(Invariants { time: state.time, energy, angular_momentum })
    }
}
