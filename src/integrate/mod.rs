//! Integrators of ordinary differential equations: tableaux, step control, dense output, compositions, event
//! detection.
//!
//! Takes `Equations` or `Flows`; gives steps. The integrators contain no physics.

mod composition;
mod control;
mod equations;
mod event_detection;
mod fixed;
mod memory;
mod pairs;
mod roots;
mod segment;
mod step;
mod stepper;
mod tableau;

pub use composition::Scheme;
#[doc(hidden)]
pub use composition::{Composition, Flows, KICK_DRIFT_KICK};
#[doc(hidden)]
pub use control::Controller;
pub use control::Tolerance;
#[doc(hidden)]
pub use equations::Equations;
#[doc(hidden)]
pub use event_detection::{SAMPLES, direction_matches, sample_fractions, zeros};
#[doc(hidden)]
pub use fixed::FixedStepper;
#[doc(hidden)]
pub use memory::Memory;
pub use memory::Statistics;
#[doc(hidden)]
pub use pairs::{DORMAND_PRINCE54, VERNER65, VERNER76, VERNER87, VERNER96, VERNER98};
#[doc(hidden)]
pub use roots::{first_fall_below_zero, minimum, polynomial_roots, root};
#[doc(hidden)]
pub use segment::{MAX_TERMS, Segment};
#[doc(hidden)]
pub use step::Step;
#[doc(hidden)]
pub use stepper::Stepper;
#[doc(hidden)]
pub use tableau::{Interpolant, Tableau};
