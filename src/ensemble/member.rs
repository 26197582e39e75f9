//! A member of an ensemble: one of many simulations.

use crate::dynamics::{State, System};
use crate::error::{Error, Result};
use crate::integrate::Statistics;
use crate::interrupt::InterruptCheck;
use crate::mutual::Store;
use crate::trajectory::{Event, Integrator, Output, Progress, Run, Simulation, TangentOptions, Trajectory};
use std::ops::ControlFlow;
use std::sync::Arc;

/// A simulation that is to be run.
#[derive(Debug)]
pub struct Member {
    /// The system.
    pub system: System,
    /// The state at the start.
    pub state: State,
    /// The integrator.
    pub integrator: Integrator,
    /// The end of the run.
    pub until: f64,
    /// When samples are recorded.
    pub output: Output,
    /// The events that are searched for.
    pub events: Vec<Event<'static>>,
    /// Whether the continuous solution is kept.
    pub dense: bool,
    /// Which tangent vectors are integrated beside the run.
    pub tangent_options: TangentOptions,
}

/// The run of a member that has begun.
#[derive(Debug)]
pub struct MemberRun {
    /// The record of the run.
    pub record: Trajectory,
    /// Counts of steps and evaluations.
    pub statistics: Statistics,
    /// The time that the simulation has reached.
    pub time: f64,
    /// The error that cut the run short.
    pub error: Option<Error>,
}

/// The outcome of a member: its run, or the error for an invalid start. `None` where it had not begun when
/// the caller interrupted.
pub type MemberOutcome = Option<Result<MemberRun>>;

impl Member {
    /// Runs the member. The hook receives the part of the run that is done, about every 50 ms.
    pub(super) fn run(
        mut self,
        store: &Arc<Store>,
        hook: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> MemberOutcome {
        if hook(0.0).is_break() {
            return None;
        }
        let system = self.system.with_store(store.clone());
        let begun = {
            let mut inside = || hook(0.0);
            Simulation::begin(&system, &self.state, self.integrator, &mut InterruptCheck::new(&mut inside))
        };
        let mut simulation = match begun {
            Ok(simulation) => simulation,
            Err(Error::Interrupted { .. }) => return None,
            Err(error) => return Some(Err(error)),
        };
        let mut record = Trajectory::new(system.bodies().len());
        let mut inside = |_: Option<&Simulation>, now: Progress| match part(now) {
            // A run that has reached its end is not interrupted.
            1.0 => ControlFlow::Continue(()),
            part => hook(part),
        };
        let run = Run {
            output: &self.output,
            events: &mut self.events,
            dense: self.dense,
            tangent_options: &self.tangent_options,
        };
        let error = simulation.run(self.until, run, &mut record, &mut inside).err();
        let (statistics, time) = (simulation.statistics(), simulation.time());
        Some(Ok(MemberRun { record, statistics, time, error }))
    }
}

/// Returns the finished part of a run, from 0 to 1.
fn part(now: Progress) -> f64 {
    let part = (now.time - now.start) / (now.end - now.start);
    if now.time == now.end { 1.0 } else { part.clamp(0.0, 1.0 - f64::EPSILON) }
}
