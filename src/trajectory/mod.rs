//! Running a system and recording it.
//!
//! Takes a system, a state and an integrator; gives a [`Trajectory`]: samples with energies and angular momenta. The one
//! room where physics and integrator meet.

mod record;
mod simulation;

pub use record::Trajectory;
pub use simulation::{Integrator, Output, Progress, Simulation};
