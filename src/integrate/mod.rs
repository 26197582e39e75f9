//! Integrators of ordinary differential equations: tableaux, step control, dense output, compositions, roots.
//!
//! Takes anything that is [`Equations`] or [`Flows`]; gives steps. Knows no physics.

mod composition;
mod control;
mod dormand_prince54;
mod equations;
mod fixed;
mod memory;
mod roots;
mod segment;
mod step;
mod stepper;
mod tableau;
mod verner65;
mod verner76;
mod verner87;
mod verner98;

pub use composition::{Composition, Flows, KICK_DRIFT_KICK, Scheme};
pub use control::{Controller, Tolerance};
pub use dormand_prince54::DORMAND_PRINCE54;
pub use equations::Equations;
pub use fixed::FixedStepper;
pub use memory::{Memory, Statistics};
pub use roots::{extremum, root};
pub use segment::{MAX_TERMS, Segment};
pub use step::Step;
pub use stepper::Stepper;
pub use tableau::{Interpolant, Tableau};
pub use verner65::VERNER65;
pub use verner76::VERNER76;
pub use verner87::VERNER87;
pub use verner98::{VERNER96, VERNER98};
