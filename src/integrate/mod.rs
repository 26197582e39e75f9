//! Integrators of ordinary differential equations: tableaux, step control, dense output.
//!
//! Takes anything that is [`Equations`]; gives steps. Knows no physics.

mod control;
mod stepper;
mod tableau;
mod verner98;

pub use control::Tolerance;
pub use stepper::{Equations, Statistics, Stepper};
pub use tableau::{Interpolant, Tableau};
pub use verner98::VERNER98;
