//! The stepping object: a system, where it is, and the integrator that moves it.

use super::approach::Contact;
use super::events::Watch;
use super::motion::Motion;
use super::mover::Mover;
use super::output::Times;
use super::{Dense, Event, Integrator, Output, StopReason, Trajectory};
use crate::dynamics::{Dynamics, Inner, State, System};
use crate::error::{Error, Result, require_finite};
use crate::integrate::{Equations, Statistics};
use crate::patience::{HOOK_INTERVAL, Patience, UNITS};
use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Instant;

/// Units of work of looking for an event in a piece, and of evaluations between looks at the clock from step to step.
const SCAN: u64 = 200;
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

/// What is asked of a run.
pub struct Run<'a, 'f> {
    /// When samples are recorded.
    pub output: &'a Output,
    /// What is watched for.
    pub events: &'a mut [Event<'f>],
    /// Whether the continuous solution is kept.
    pub dense: bool,
}

/// A system at a state, ready to be moved.
#[derive(Debug, Clone)]
pub struct Simulation {
    pub(super) motion: Motion,
    pub(super) inner: Inner,
    pub(super) integrator: Integrator,
    pub(super) mover: Mover,
}

impl Simulation {
    /// Checks the state against the system.
    pub fn new(system: &System, state: &State, integrator: Integrator) -> Result<Self> {
        Self::begin(system, state, integrator, &mut Patience::endless())
    }

    /// The same for a caller who may not want to wait: systems of very many bodies take seconds.
    pub fn begin(
        system: &System,
        state: &State,
        integrator: Integrator,
        patience: &mut Patience,
    ) -> Result<Self> {
        system.check(state, patience)?;
        let inner = Inner::new(system.layout(), &system.masses(), state);
        let mut motion = Motion::new(system.dynamics(patience)?, &inner.high);
        motion.prepare(state.time, &inner.high, 0.0, patience)?;
        // What overflows is refused here: no step could be measured against it.
        let energy = motion.equations.energy(state.time, &inner.high, &state.velocity, patience)?;
        system.check_range(&energy)?;
        let mover = Mover::new(integrator, &motion, &inner, state.time)?;
        Ok(Self { motion, inner, integrator, mover })
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
        self.inner.state(self.time(), high, low)
    }

    /// Starts anew from another state; counts start anew too.
    pub fn set_state(&mut self, state: &State, patience: &mut Patience) -> Result<()> {
        *self = Self::begin(self.system(), state, self.integrator, patience)?;
        Ok(())
    }

    /// Counts since the start.
    pub fn statistics(&self) -> Statistics {
        self.mover.statistics()
    }

    /// The equations of motion with the rules in force.
    pub fn dynamics(&self) -> &Dynamics {
        &self.motion.equations
    }

    /// One accepted step towards `end`, never beyond it.
    pub fn step(&mut self, end: f64, patience: &mut Patience) -> Result<()> {
        match self.advance(end, |_| false, patience)? {
            None => Ok(()),
            Some(contact) => {
                self.mover.retreat();
                Err(contact.error(self.system()))
            }
        }
    }

    /// One step, and the first contact in it. `looked` tells of a step's end whether the step is to be
    /// looked into for other reasons as well.
    fn advance(
        &mut self,
        end: f64,
        looked: impl Fn(f64) -> bool,
        patience: &mut Patience,
    ) -> Result<Option<Contact>> {
        loop {
            self.mover.step(&mut self.motion, end, patience)?;
            let looked = looked(self.time());
            match self.mover.contact(&mut self.motion, looked, patience) {
                Ok(contact) => return Ok(contact),
                Err(error) => self.mover.shorten(error)?,
            }
        }
    }

    /// Moves to `until`, forwards or backwards, and records into `record`.
    ///
    /// On an error the record keeps what there was up to it, and the simulation stays at the last accepted step; where two bodies
    /// meet, that is the last one before their contact. The hook is called about every 50 ms, also within steps that take longer,
    /// and stops the run by [`ControlFlow::Break`].
    pub fn integrate(
        &mut self,
        until: f64,
        output: &Output,
        record: &mut Trajectory,
        hook: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<()> {
        let run = Run { output, events: &mut [], dense: false };
        self.run(until, run, record, &mut |_, progress| hook(progress))
    }

    /// The same with events and the continuous solution.
    ///
    /// A terminal event ends the run: its state becomes the last sample and the state of the simulation, and what was recorded
    /// before is as without it. A zero at the very start of a run is not an event, so that a run goes on from one. Between two
    /// steps the hook also sees the simulation, for an archive of it.
    pub fn run(
        &mut self,
        until: f64,
        run: Run,
        record: &mut Trajectory,
        hook: &mut dyn FnMut(Option<&Self>, Progress) -> ControlFlow<()>,
    ) -> Result<()> {
        let outcome = self.follow(until, run, record, hook);
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
        let Run { output, events, dense } = run;
        let start = self.time();
        let mut times = Times::new(start, until, output)?;
        let mut watch = Watch::new(self.system(), &self.inner, events)?;
        let zeros = vec![0.0; self.inner.high.len()];
        let mut sample = zeros.clone();
        if dense {
            record.dense = Some(Dense::new(&self.inner, self.state(), start));
        }
        let (mut called, mut unseen) = (Instant::now(), 0);
        if times.due(start) {
            let mut hook = || hook(None, Progress { start, time: start, end: until });
            self.record_present(record, &mut Patience::since(called, &mut hook))?;
        }
        while self.time() != until {
            let before = self.time();
            let mut inside = || hook(None, Progress { start, time: before, end: until });
            let patience = &mut Patience::since(called, &mut inside);
            let watched = dense || !events.is_empty();
            let contact = self.advance(until, |now| watched || times.pending(now).is_some(), patience)?;
            let now = self.time();
            let mut stop = None;
            if watched {
                for (index, piece) in self.mover.pieces().iter().enumerate() {
                    patience.spend(SCAN * events.len() as u64, piece.start())?;
                    let met = contact.filter(|contact| contact.piece == index);
                    let system = self.motion.equations.system();
                    let stopped = !events.is_empty()
                        && watch.scan(system, &self.inner, piece, met, events, &mut record.events)?;
                    stop = record.events.last().filter(|_| stopped).map(|last| (last.event, last.time));
                    if let Some(solution) = &mut record.dense {
                        let met = met.map_or(piece.end(), |contact| contact.time);
                        solution.push(piece, stop.map_or(met, |(_, time)| time));
                    }
                    if stop.is_some() || met.is_some() {
                        break;
                    }
                }
            }
            let met = contact.map_or(now, |contact| contact.time);
            let reached = stop.map_or(met, |(_, time)| time);
            while let Some(time) = times.before(reached) {
                let forward = until >= start;
                let pieces = self.mover.pieces();
                let after =
                    pieces.partition_point(|p| if forward { p.start() <= time } else { p.start() >= time });
                let piece = &pieces[after.saturating_sub(1)];
                piece.at(piece.fraction(time), &mut sample);
                let state = self.inner.state(time, &sample, &zeros);
                self.record_state(record, &sample, &state, patience)?;
            }
            if let Some((event, time)) = stop {
                self.mover.place(time, watch.vector());
                self.record_present(record, patience)?;
                return Ok(StopReason::Event(event));
            }
            if let Some(contact) = contact {
                self.mover.retreat();
                return Err(contact.error(self.system()));
            }
            if times.due(now) {
                self.record_present(record, patience)?;
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

    /// Shortest time of an evaluation of the rates of change at the present state, seconds; for benchmarks.
    pub fn time_evaluation(&mut self, number: usize, repeats: usize) -> Result<f64> {
        let high = self.mover.vector().0.to_vec();
        let mut rate = vec![0.0; high.len()];
        self.motion.prepare(self.time(), &high, 0.0, &mut Patience::endless())?;
        let equations = &mut self.motion.equations;
        Ok(shortest(number, repeats, || {
            for part in 0..equations.parts() {
                let _ = black_box(equations.derivative(part, black_box(&high), &mut rate));
            }
        }))
    }

    /// Shortest time of an interaction of the first pair at the present state, seconds; for benchmarks.
    pub fn time_interaction(&self, number: usize, repeats: usize) -> f64 {
        let high = self.mover.vector().0;
        let Some((_, _, pair)) = self.motion.equations.pairs().next() else { return 0.0 };
        let pose = self.motion.equations.first_pose(high);
        shortest(number, repeats, || {
            black_box(pair.interaction(black_box(&pose)));
        })
    }

    fn record_present(&mut self, record: &mut Trajectory, patience: &mut Patience) -> Result<()> {
        let state = self.state();
        let high = self.mover.vector().0.to_vec();
        self.record_state(record, &high, &state, patience)
    }

    fn record_state(
        &mut self,
        record: &mut Trajectory,
        y: &[f64],
        state: &State,
        patience: &mut Patience,
    ) -> Result<()> {
        let energy = self.motion.equations.energy(state.time, y, &state.velocity, patience)?;
        let momentum = self.motion.equations.angular_momentum(&self.inner, y);
        record.push(state, &energy, &momentum);
        Ok(())
    }
}

fn shortest(number: usize, repeats: usize, mut call: impl FnMut()) -> f64 {
    let time = |_| {
        let started = Instant::now();
        (0..number).for_each(|_| call());
        started.elapsed().as_secs_f64() / number.max(1) as f64
    };
    (0..repeats).map(time).fold(f64::INFINITY, f64::min)
}
