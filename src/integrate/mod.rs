//! Integrators of ordinary differential equations: tableaux, step control, dense output, compositions, roots.
//!
//! Takes anything that is [`Equations`] or [`Flows`]; gives steps. Knows no physics.

mod composition;
mod control;
mod dormand_prince54;
mod fixed;
mod roots;
mod segment;
mod stepper;
mod tableau;
mod verner65;
mod verner76;
mod verner87;
mod verner98;

pub use composition::{Composition, Flows, KICK_DRIFT_KICK, Scheme};
pub use control::{Controller, Tolerance};
pub use dormand_prince54::DORMAND_PRINCE54;
pub use fixed::FixedStepper;
pub use roots::{extremum, root};
pub use segment::{MAX_TERMS, Segment};
pub use stepper::{Equations, Memory, Statistics, Step, Stepper};
pub use tableau::{Interpolant, Tableau};
pub use verner65::VERNER65;
pub use verner76::VERNER76;
pub use verner87::VERNER87;
pub use verner98::{VERNER96, VERNER98};
