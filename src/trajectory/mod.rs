//! Simulations: they advance a system and record its motion.
//!
//! Takes a system, a state and an integrator; gives a [`Trajectory`]: samples with energies and angular
//! momenta, events, and the continuous solution. This is the only module in which physics and integrator
//! meet.

mod approach;
#[cfg(feature = "archives")]
mod archive;
mod chaos;
mod checkpoint;
mod closed_form;
mod dense;
mod encounter;
mod events;
mod integrator;
mod tangent_map;
mod tangent_step;
mod motion;
mod propagator;
mod output;
mod record;
mod recorder;
mod run;
mod simulation;
mod switching;
mod tangent;
mod tangent_interior;

#[cfg(feature = "archives")]
#[doc(hidden)]
pub use archive::{ARCHIVE_FORMAT, SimulationDescription};
#[doc(hidden)]
pub use chaos::INDICATORS;
pub use dense::Dense;
pub use events::{Condition, Event, Occurrence, StateDerivatives, StateFunction, Viewpoint};
#[doc(hidden)]
pub use events::{ConditionDerivatives, Crossings};
pub use integrator::Integrator;
pub use output::Output;
pub use record::{StopReason, Trajectory};
pub use recorder::Run;
pub use run::Progress;
pub use simulation::Simulation;
pub use tangent::TangentOptions;
