#![doc = include_str!("README.md")]
//!
//! # Rooms
//!
//! In the direction in which data flows; each uses only those above it:
//!
//! - [`error`]: what can go wrong, with body, time and value.
//! - [`names`]: choices by name.
//! - [`patience`]: when a long computation asks whether to go on.
//! - [`math`]: Carlson's integrals, rotations, exact sums, solid harmonics, lanes.
//! - [`shape`]: ellipsoids, polyhedra and points, bodies of them: volume, inertia, overlap.
//! - [`gravity`]: potential and field of one body.
//! - [`quadrature`]: surface and focal rule, faces and layers, and how many nodes reach a tolerance.
//! - [`mutual`]: force, torques and energy of a pair, by method.
//! - [`orbit`]: Kepler elements to and from Cartesian.
//! - [`environment`]: third bodies, tides, radiation, a caller's own forces.
//! - [`dynamics`]: state, equations of motion, invariants.
//! - [`integrate`]: integrators of ordinary differential equations; no physics.
//! - [`trajectory`]: a system on its way: stepping, events, archive, record.
//! - [`particles`]: massless particles among moving bodies: flight, impacts, fates.
//! - [`ensemble`]: many simulations over cores.
//! - `py`: the Python bindings, no mathematics.

#![deny(unsafe_code)]

pub mod error;
pub mod names;
pub mod patience;
pub mod math;
pub mod shape;
pub mod gravity;
pub mod quadrature;
pub mod mutual;
pub mod orbit;
pub mod environment;
pub mod dynamics;
pub mod integrate;
pub mod trajectory;
pub mod particles;
pub mod ensemble;
#[cfg(feature = "python")]
mod py;
