//! The stepping object: a system, where it is, and the integrator that moves it.

use super::dense::{piece_at, state_within};
use super::events::Watch;
use super::motion::Motion;
use super::mover::Mover;
use super::output::Times;
use super::{Dense, Event, Integrator, Output, StopReason, Trajectory};
use crate::dynamics::{BarycentricFrame, Dynamics, State, System};
use crate::error::{Error, Result, require_finite};
use crate::integrate::{Equations, Statistics};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// How often the hook is called, at most.
const HOOK_INTERVAL: Duration = Duration::from_millis(50);

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
    pub(super) frame: BarycentricFrame,
    pub(super) integrator: Integrator,
    pub(super) mover: Mover,
    /// Whether the present state was given, by the caller or as that of a terminal event, and not reached by a step.
    pub(super) given: bool,
    /// What a caller wants kept with the simulation and its archives, as text of any kind: names of units and the like. No number
    /// that the simulation works with belongs here.
    pub notes: String,
}

impl Simulation {
    /// Checks the state against the system.
    pub fn new(system: &System, state: &State, integrator: Integrator) -> Result<Self> {
        system.check(state)?;
        let (frame, high, low) = BarycentricFrame::new(system.layout(), &system.masses(), state);
        let mut motion = Motion::new(system.dynamics(), &high);
        motion.prepare(state.time, &high, 0.0)?;
        // What overflows is refused here: no step could be measured against it.
        system.check_range(&motion.equations.energy(&high, &state.velocity))?;
        let mover = Mover::new(integrator, &motion, state.time, high, low)?;
        Ok(Self { motion, frame, integrator, mover, given: true, notes: String::new() })
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
        self.frame.state(self.time(), high, low)
    }

    /// Starts anew from another state; counts start anew too.
    pub fn set_state(&mut self, state: &State) -> Result<()> {
        let fresh = Self::new(self.system(), state, self.integrator)?;
        *self = Self { notes: std::mem::take(&mut self.notes), ..fresh };
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
    pub fn step(&mut self, end: f64) -> Result<()> {
        self.mover.step(&mut self.motion, end)?;
        self.given = false;
        Ok(())
    }

    /// Moves to `until`, forwards or backwards, and records into `record`.
    ///
    /// On an error the record keeps what there was up to it, and the simulation stays at the end of the last step that is
    /// recorded whole. The hook is called between steps, at most every 50 ms, and stops the run by [`ControlFlow::Break`].
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
    /// before is as without it. A zero at a state that was given, by the caller or by a terminal event, is not an event, so
    /// that a run goes on from one. The hook also sees the simulation between two steps, for an archive of it.
    pub fn run(
        &mut self,
        until: f64,
        run: Run,
        record: &mut Trajectory,
        hook: &mut dyn FnMut(&Self, Progress) -> ControlFlow<()>,
    ) -> Result<()> {
        require_finite("until", &[until])?;
        self.mover.check_reach(until)?;
        let Run { output, events, dense } = run;
        let start = self.time();
        let mut times = Times::new(start, until, output)?;
        let mut watch = Watch::new(self.system(), &self.frame, events, self.given)?;
        let mut sample = vec![0.0; self.frame.layout.dimension()];
        record.stop_reason = StopReason::Unfinished;
        if dense {
            record.dense = Some(Dense::new(&self.frame, self.state()));
        }
        if times.due(start) {
            self.record_present(record);
        }
        let mut called = Instant::now();
        while self.time() != until {
            let mut stop = None;
            if dense || !events.is_empty() {
                let (before, known) = (self.checkpoint(), record.events.len());
                self.step(until)?;
                stop = match self.look_inside(&mut watch, events, record) {
                    Ok(stop) => stop,
                    Err(error) => {
                        // The step is taken back with all that was found in it: a run that goes on misses nothing.
                        record.events.truncate(known);
                        self.go_back(&before)?;
                        return Err(error);
                    }
                };
            } else {
                self.step(until)?;
            }
            let now = self.time();
            let reached = stop.map_or(now, |(_, time)| time);
            while let Some(time) = times.before(reached) {
                let pieces = self.mover.pieces(&mut self.motion)?;
                let state =
                    state_within(&self.frame, piece_at(pieces, time, until >= start), time, &mut sample);
                self.record_state(record, &sample, &state);
            }
            if let Some((event, time)) = stop {
                self.mover.place(time, watch.vector());
                self.given = true;
                self.record_present(record);
                record.stop_reason = StopReason::Event(event);
                return Ok(());
            }
            if times.due(now) {
                self.record_present(record);
            }
            if called.elapsed() >= HOOK_INTERVAL {
                called = Instant::now();
                if hook(self, Progress { start, time: now, end: until }).is_break() {
                    record.stop_reason = StopReason::Interrupted;
                    return Err(Error::Interrupted { time: now });
                }
            }
        }
        record.stop_reason = StopReason::End;
        Ok(())
    }

    /// The events and the continuous solution in the last step, up to the first terminal event: its place in the list and its
    /// time.
    fn look_inside(
        &mut self,
        watch: &mut Watch,
        events: &mut [Event],
        record: &mut Trajectory,
    ) -> Result<Option<(usize, f64)>> {
        let present = record.dense.is_some().then(|| self.state());
        let (now, vector) = (self.time(), self.mover.vector().0.to_vec());
        let pieces = self.mover.pieces(&mut self.motion)?;
        let mut stop = None;
        if !events.is_empty() {
            let system = self.motion.equations.system();
            stop = watch.scan(system, &self.frame, pieces, (now, &vector), events, &mut record.events)?;
        }
        if let (Some(solution), Some(present)) = (&mut record.dense, present) {
            let last = record.events.last().filter(|_| stop.is_some());
            solution.extend(pieces, last.map_or(present, |last| last.state.clone()));
        }
        Ok(stop)
    }

    fn record_present(&mut self, record: &mut Trajectory) {
        let state = self.state();
        let high = self.mover.vector().0.to_vec();
        self.record_state(record, &high, &state);
    }

    fn record_state(&mut self, record: &mut Trajectory, y: &[f64], state: &State) {
        let energy = self.motion.equations.energy(y, &state.velocity);
        let momentum = self.motion.equations.angular_momentum(&self.frame, y);
        record.push(state, &energy, &momentum);
    }
}
