//! Running a system and recording it.
//!
//! Takes a system, a state and an integrator; gives a [`Trajectory`]: samples with energies and angular momenta. The one
//! room where physics and integrator meet.

mod integrator;
mod record;
mod simulation;

pub use integrator::Integrator;
pub use record::Trajectory;
pub use simulation::{Output, Progress, Simulation};
