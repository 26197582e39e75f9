//! Events: zeros of functions of the state, found on the continuous solution.

mod condition;
mod crossings;
mod derivatives;
mod detector;
mod sighting;

pub use condition::{Condition, StateFunction, Viewpoint};
pub use crossings::Crossings;
pub use derivatives::ConditionDerivatives;
pub(super) use detector::EventDetector;

use crate::dynamics::State;

/// An event for which a run is searched.
///
/// ```
/// use fullbody::dynamics::{Settings, State, System};
/// use fullbody::integrate::Tolerance;
/// use fullbody::math::Vec3;
/// use fullbody::shape::{Body, Shape};
/// use fullbody::trajectory::{Condition, Event, Integrator, Output, Run, Simulation, Trajectory};
/// use std::ops::ControlFlow;
///
/// // Two points, half a revolution from their apoapsis to their periapsis.
/// let point = |name| Body::with_mass(name, Shape::Point, 0.5);
/// let system = System::new(vec![point("One")?, point("Two")?], 1.0, Settings::default())?;
/// let two = |vector: Vec3| vec![-vector, vector];
/// let (rest, upright) = (vec![Vec3::zeros(); 2], vec![[1.0, 0.0, 0.0, 0.0]; 2]);
/// let state = State::new(0.0, two(0.75 * Vec3::x()), two(Vec3::y() / 12.0_f64.sqrt()), upright, rest)?;
/// let integrator = Integrator::Verner98(Tolerance::new(1e-13, 1e-13)?);
/// let mut simulation = Simulation::new(&system, &state, integrator)?;
/// let mut record = Trajectory::new(2);
/// let periapsis = Condition::Periapsis { first: 0, second: 1 };
/// let mut events = [Event::new(periapsis).terminal()];
/// let run = Run { events: &mut events, ..Run::new(&Output::Ends) };
/// simulation.run(10.0, run, &mut record, &mut |_, _| ControlFlow::Continue(()))?;
/// assert!((simulation.time() - std::f64::consts::PI).abs() < 1e-11);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug)]
pub struct Event<'a> {
    /// The condition.
    pub condition: Condition<'a>,
    /// Which zeros count: 1 where the condition's function rises as time grows, -1 where it falls, 0 for
    /// both. The same zeros count whichever way the run goes.
    pub direction: i8,
    /// Whether the run ends at the event.
    pub terminal: bool,
}

impl<'a> Event<'a> {
    /// Makes an event of every zero, after which the run goes on.
    pub fn new(condition: Condition<'a>) -> Self {
        Self { condition, direction: 0, terminal: false }
    }

    /// Restricts the event to one direction.
    #[must_use]
    pub fn directed(self, direction: i8) -> Self {
        Self { direction, ..self }
    }

    /// Makes the event end the run.
    #[must_use]
    pub fn terminal(self) -> Self {
        Self { terminal: true, ..self }
    }
}

/// An event that has happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Occurrence {
    /// The index in the list of events.
    pub event: usize,
    /// The time of the event.
    pub time: f64,
    /// The state at that time.
    pub state: State,
    /// The derivatives of the state at that time, where the run is differentiated.
    pub derivatives: Option<StateDerivatives>,
}

/// The derivatives of a state at a fixed time with respect to the state at the start of a run and to
/// parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct StateDerivatives {
    /// The transition matrix (12 N, 12 N).
    pub transition: Vec<f64>,
    /// Sensitivities (P, 12 N) to the parameters.
    pub sensitivity: Vec<f64>,
    /// The rates of change of the state (12 N): velocity, acceleration, spin and its rate for each body.
    pub flow: Vec<f64>,
}
