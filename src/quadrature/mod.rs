//! Rules that carry a body's attraction by a finite set of points, and how many points a tolerance takes.
//!
//! Takes the order (n, m) of a rule; gives nodes and weights on the unit sphere or disc, independent of body
//! and state. Surface rule: the surface elements n dS and n x r dS of the paper's `eq:Force_element` and
//! `eq:Torq_element`. Focal rule: Maclaurin's theorem on confocal ellipsoids in the limit of the flattest
//! one.

mod cells;
mod convergence;
mod nodes;

#[doc(hidden)]
pub use cells::{Cell, Cells, Demand, Division};
pub use convergence::Order;
#[doc(hidden)]
pub use convergence::{Degrees, closest_confocal, focal_distance, focal_vectors, guess_degree, layer_degree};
#[doc(hidden)]
pub use nodes::{Nodes, Stretch};
