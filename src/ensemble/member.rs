//! One of many simulations.

use crate::dynamics::{State, System};
use crate::error::{Error, Result};
use crate::integrate::Statistics;
use crate::mutual::Store;
use crate::patience::Patience;
use crate::trajectory::{Event, Following, Integrator, Output, Progress, Run, Simulation, Trajectory};
use std::ops::ControlFlow;
use std::sync::Arc;

/// A simulation that is to be run.
pub struct Member {
    /// The system.
    pub system: System,
    /// Where it starts.
    pub state: State,
    /// The integrator.
    pub integrator: Integrator,
    /// The end of the run.
    pub until: f64,
    /// When samples are recorded.
    pub output: Output,
    /// The events that are watched for.
    pub events: Vec<Event<'static>>,
    /// Whether the continuous solution is kept.
    pub dense: bool,
    /// What is followed beside the run.
    pub following: Following,
}

/// A run that began.
#[derive(Debug)]
pub struct Ran {
    /// What was recorded.
    pub record: Trajectory,
    /// Counts.
    pub statistics: Statistics,
    /// The time that the simulation came to.
    pub time: f64,
    /// What cut it short.
    pub error: Option<Error>,
}

/// What became of a member: a run, or the error of a start that is none. `None` where it had not begun when the caller asked to
/// stop.
pub type Answer = Option<Result<Ran>>;

impl Member {
    /// Runs it. The hook is told the part of the run that is done, about every 50 ms.
    pub(super) fn run(mut self, store: &Arc<Store>, hook: &mut dyn FnMut(f64) -> ControlFlow<()>) -> Answer {
        if hook(0.0).is_break() {
            return None;
        }
        let system = self.system.sharing(store.clone());
        let begun = {
            let mut inside = || hook(0.0);
            Simulation::begin(&system, &self.state, self.integrator, &mut Patience::new(&mut inside))
        };
        let mut simulation = match begun {
            Ok(simulation) => simulation,
            Err(Error::Interrupted { .. }) => return None,
            Err(error) => return Some(Err(error)),
        };
        let mut record = Trajectory::new(system.bodies().len());
        let mut inside = |_: Option<&Simulation>, now: Progress| match part(now) {
            // What has come to its end is not interrupted.
            1.0 => ControlFlow::Continue(()),
            part => hook(part),
        };
        let run = Run {
            output: &self.output,
            events: &mut self.events,
            dense: self.dense,
            following: &self.following,
        };
        let error = simulation.run(self.until, run, &mut record, &mut inside).err();
        let (statistics, time) = (simulation.statistics(), simulation.time());
        Some(Ok(Ran { record, statistics, time, error }))
    }
}

/// How much of a run is done, from 0 to 1.
fn part(now: Progress) -> f64 {
    let part = (now.time - now.start) / (now.end - now.start);
    if now.time == now.end { 1.0 } else { part.clamp(0.0, 1.0 - f64::EPSILON) }
}
