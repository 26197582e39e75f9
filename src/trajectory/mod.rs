//! Running a system and recording it.
//!
//! Takes a system, a state and an integrator; gives a [`Trajectory`]: samples with energies and angular momenta, events, the
//! continuous solution. The one room where physics and integrator meet.

mod approach;
mod archive;
mod chaos;
mod checkpoint;
mod dense;
mod encounter;
mod events;
mod integrator;
mod mapped;
mod motion;
mod mover;
mod output;
mod record;
mod simulation;
mod tangent;

pub use archive::{ARCHIVE_VERSION, Setup};
pub use chaos::INDICATORS;
pub use dense::Dense;
pub use events::{Condition, ConditionSlopes, Event, Occurrence, SAMPLES, StateFunction};
pub use integrator::Integrator;
pub use output::Output;
pub use record::{StopReason, Trajectory};
pub use simulation::{Progress, Run, Simulation};
pub use tangent::Following;
