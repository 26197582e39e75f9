//! Rules that represent a body by a finite set of points, and the number of points that a tolerance requires.
//!
//! Takes the order (n, m) of a rule; gives nodes and weights on the unit sphere or disc, independent of body
//! and state. The surface rule represents the surface elements n dS and n x r dS of the paper's
//! `eq:Force_element` and `eq:Torq_element`. The focal rule follows from Maclaurin's theorem on confocal
//! ellipsoids in the limit of the flattest one.

mod cells;
mod convergence;
mod nodes;

#[doc(hidden)]
pub use cells::{Cell, Cells, Demand, Division};
pub use convergence::Order;
#[doc(hidden)]
pub use convergence::{Degrees, closest_confocal, focal_distance, focal_vectors, guess_degree, layer_degree};
#[doc(hidden)]
pub use nodes::{NodeRange, Nodes};
