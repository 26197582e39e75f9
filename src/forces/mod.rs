//! External forces: forces and torques on the bodies of a system other than their mutual gravity.
//!
//! Takes the state of the bodies at a time; gives the loads of each force on every body. A [`Force`]
//! describes a force, for archives and the Python package; a `ForceModel` holds the forces prepared for
//! evaluation.
//!
//! Positions are relative to the system's *nominal* barycentre: where its barycentre would be without these
//! forces, moving uniformly in the coordinates of the states. A third body's position is given relative to
//! it, and the coordinates fall with the nominal barycentre in the third body's gravity. In these coordinates
//! the effect of a third body is thus the difference of its attractions on a body and on the nominal
//! barycentre.

mod binary_yarkovsky;
mod byorp;
mod evaluator;
mod force;
mod function;
mod lock;
mod parameter;
mod point;
mod snapshot;
mod load_jacobian;
mod load_sum;
mod force_model;
mod force_parameter;
mod third_body;
mod tide;
mod yorp;

pub use binary_yarkovsky::BinaryYarkovsky;
pub use byorp::Byorp;
pub use force::Force;
#[doc(hidden)]
pub use force_model::{ForceModel, SwitchJump, WORK_AND_IMPULSE};
pub use force_parameter::ForceParameter;
pub use function::{Call, ForceFunction, Function, Motion};
#[doc(hidden)]
pub use load_jacobian::{BodyBlock, LoadJacobian};
#[doc(hidden)]
pub use load_sum::LoadSum;
#[doc(hidden)]
pub use lock::MarginGradient;
#[doc(hidden)]
pub use point::PointAttraction;
pub use snapshot::{Load, MotionSnapshot};
#[doc(hidden)]
pub use snapshot::{LoadSink, Switch};
pub use third_body::{Path, ThirdBody, WhoseOrbit};
pub use tide::Tide;
pub use yorp::Yorp;
