//! The world around a system: forces and torques that its bodies do not have from each other.
//!
//! Takes where the bodies are at a time; gives each force's loads on every body. A [`Force`] describes one, for archives and the
//! Python package; an [`Environment`] has them ready for computing.
//!
//! Places are seen from the system's *nominal* barycentre: where its barycentre would be without these forces, moving uniformly
//! in the coordinates of the states. A third body's position is given from there, and the coordinates fall with the nominal
//! barycentre in the third body's gravity. What a third body does in them is thus the difference of its pulls on a body and on
//! the nominal barycentre.

mod force;
mod function;
mod point;
mod radiation;
mod scene;
mod slopes;
mod terms;
mod third_body;
mod tide;

pub use force::Force;
pub use function::{Call, ForceFunction, Function};
pub use point::PointPull;
pub use radiation::{Byorp, Yorp};
pub use scene::{Load, Scene, Switch, TakeLoads};
pub use slopes::{LoadSlopes, Triple};
pub use terms::{BOOK, Environment};
pub use third_body::{Path, ThirdBody, WhoseOrbit};
pub use tide::Tide;
