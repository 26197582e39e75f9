//! `fullbody`: rigid ellipsoids moving and turning in each other's exact gravity.
//!
//! The rooms, in the direction in which data flows; each uses only those above it.

pub mod error;
pub mod math;
pub mod shape;
pub mod gravity;
pub mod quadrature;
pub mod mutual;
pub mod orbit;
pub mod dynamics;
pub mod integrate;
pub mod trajectory;
#[cfg(feature = "python")]
mod py;
