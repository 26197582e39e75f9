//! The runs of a simulation: their steps until the end, and the hook in between.

use super::recorder::{Recorder, Run};
use super::{Output, Simulation, StopReason, Trajectory};
use crate::error::{Error, Result};
use crate::interrupt::{HOOK_INTERVAL, InterruptCheck, UNITS};
use std::ops::ControlFlow;
use web_time::Instant;

/// The units of work of evaluations after which the clock is read between steps.
const CLOCK_WORK: u64 = UNITS / 32;

/// The progress of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// The time at the start of the run.
    pub start: f64,
    /// The present time.
    pub time: f64,
    /// The time at the end of the run.
    pub end: f64,
}

impl Simulation {
    /// Integrates to `until`, forwards or backwards, and records into `record`.
    ///
    /// On an error the record keeps what was recorded before it, and the simulation stays at the end of the
    /// last step that is recorded completely, which is also the last sample; where two bodies touch, that is the
    /// last one before their contact.
    ///
    /// # Errors
    /// Returns [`Error::InvalidInput`] for a record of another number of bodies and for times that are not
    /// finite. Bodies that touch, steps that become too small and forces that fail have variants of their own,
    /// which carry the time.
    pub fn integrate(&mut self, until: f64, output: &Output, record: &mut Trajectory) -> Result<()> {
        self.run(until, Run::new(output), record, &mut |_, _| ControlFlow::Continue(()))
    }

    /// Integrates as [`Self::integrate`], with a hook, with events and with the continuous solution.
    ///
    /// The hook is called at the start, about every 50 ms, also within steps that take longer, and at the end.
    /// It stops the run by [`ControlFlow::Break`]. Between two steps it also receives the simulation, for an
    /// archive of it.
    ///
    /// A terminal event ends the run: its state becomes the last sample and the state of the simulation, and
    /// the record before it is the same as without it. A zero at a state that was set, by the caller or by a
    /// terminal event, is not an event, so that a run can continue from one.
    ///
    /// # Errors
    /// Returns the errors of [`Self::integrate`], the error of an event's function, and
    /// [`Error::Interrupted`].
    pub fn run(
        &mut self,
        until: f64,
        run: Run,
        record: &mut Trajectory,
        hook: &mut dyn FnMut(Option<&Self>, Progress) -> ControlFlow<()>,
    ) -> Result<()> {
        record.check(self.system().bodies().len())?;
        let start = self.time();
        let initial_switches = self.motion.equations.external_forces().switches();
        let outcome = self.follow(until, run, record, hook).and_then(|reason| {
            let time = self.time();
            let last = hook(Some(self), Progress { start, time, end: until });
            if last.is_break() { Err(Error::Interrupted { time }) } else { Ok(reason) }
        });
        let final_switches = self.motion.equations.external_forces().switches();
        record.switched_off.resize(final_switches.len(), None);
        for (count, switch) in
            record.switched_off.iter_mut().zip(initial_switches.iter().zip(&final_switches))
        {
            if let (Some(first), Some(last)) = switch {
                // A force that is off from the start on counts as switched off once.
                *count = Some(count.unwrap_or(u64::from(!first.on)) + last.times - first.times);
            }
        }
        record.stop_reason = match &outcome {
            Ok(reason) => *reason,
            Err(Error::Interrupted { .. }) => StopReason::Interrupted,
            Err(_) => StopReason::Unfinished,
        };
        outcome.map(drop)
    }

    /// Integrates to `until` and returns the reason for the end. The state at which an error ends the run is
    /// recorded too.
    fn follow(
        &mut self,
        until: f64,
        run: Run,
        record: &mut Trajectory,
        hook: &mut dyn FnMut(Option<&Self>, Progress) -> ControlFlow<()>,
    ) -> Result<StopReason> {
        let start = self.time();
        let closed_form = self.closed_form(until, &run);
        let mut recorder = Recorder::new(self, until, run, record)?;
        if hook(Some(self), Progress { start, time: start, end: until }).is_break() {
            return Err(Error::Interrupted { time: start });
        }
        let called = Instant::now();
        {
            let mut inside = || hook(None, Progress { start, time: start, end: until });
            let interrupt = &mut InterruptCheck::since(called, &mut inside);
            recorder.begin(self, interrupt)?;
            if let Some(rotation) = closed_form {
                return recorder.follow_closed_form(rotation, self, interrupt).map(|()| StopReason::End);
            }
        }
        let outcome = self.march(&mut recorder, called, hook);
        self.nominal = recorder.nominal(self);
        outcome.inspect_err(|_| recorder.record_last(self))
    }

    /// Takes the steps of a run, and reads the clock about every 50 ms; returns the reason for its end.
    fn march(
        &mut self,
        recorder: &mut Recorder,
        mut called: Instant,
        hook: &mut dyn FnMut(Option<&Self>, Progress) -> ControlFlow<()>,
    ) -> Result<StopReason> {
        let (start, until, mut work_since_check) = (self.time(), recorder.until, 0);
        while self.time() != until {
            let time = self.time();
            let mut inside = || hook(None, Progress { start, time, end: until });
            let stop = recorder.step(self, &mut InterruptCheck::since(called, &mut inside))?;
            if let Some(reason) = stop {
                return Ok(reason);
            }
            // The clock is read only after enough work, since steps may be quick.
            work_since_check += self.motion.equations.work() * self.motion.equations.parts() as u64;
            let check_clock = recorder.needs_interior || work_since_check >= CLOCK_WORK;
            work_since_check = if check_clock { 0 } else { work_since_check };
            if check_clock && called.elapsed() >= HOOK_INTERVAL {
                called = Instant::now();
                let time = self.time();
                if hook(Some(self), Progress { start, time, end: until }).is_break() {
                    return Err(Error::Interrupted { time });
                }
            }
        }
        Ok(StopReason::End)
    }
}
