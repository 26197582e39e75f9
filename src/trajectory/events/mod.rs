//! Events: zeros of functions of the state, found on the continuous solution.

mod condition;
mod slopes;
mod watch;

pub use condition::{Condition, StateFunction};
pub use slopes::ConditionSlopes;
pub use watch::SAMPLES;
pub(super) use watch::Watch;

use crate::dynamics::State;

/// Something to watch for.
pub struct Event<'a> {
    /// When it happens.
    pub condition: Condition<'a>,
    /// Which zeros count: 1 where the condition's function rises as time grows, -1 where it falls, 0 both. The same
    /// zeros count whichever way the run goes.
    pub direction: i8,
    /// Whether the run stops there.
    pub terminal: bool,
}

impl<'a> Event<'a> {
    /// Every zero, and the run goes on.
    pub fn new(condition: Condition<'a>) -> Self {
        Self { condition, direction: 0, terminal: false }
    }

    /// The event in one direction only.
    pub fn directed(self, direction: i8) -> Self {
        Self { direction, ..self }
    }

    /// The event as one that ends the run.
    pub fn terminal(self) -> Self {
        Self { terminal: true, ..self }
    }
}

/// An event that happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Occurrence {
    /// Its place in the list of events.
    pub event: usize,
    /// When.
    pub time: f64,
    /// The state then.
    pub state: State,
}
