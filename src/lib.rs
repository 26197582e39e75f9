#![doc = include_str!("README.md")]
//!
//! # Modules
//!
//! The modules are listed in the direction of the dependencies; each uses only those above it:
//!
//! - [`error`]: the error type, whose variants carry body, time and value.
//! - [`names`]: enumerations whose values have names in scripts, files and archives.
//! - [`interrupt`]: the interrupt check of long computations.
//! - `workers`: a pool of threads for many jobs of one kind.
//! - [`math`]: Carlson's integrals, rotations, compensated sums, solid harmonics, lanes (SIMD).
//! - [`shape`]: ellipsoids, polyhedra and points, and bodies made of them: volume, inertia, overlap.
//! - [`gravity`]: potential and field of one body.
//! - [`quadrature`]: surface and focal rule, cells and layers, and the order that a tolerance needs.
//! - [`mutual`]: force, torques and energy of a pair, by method.
//! - [`orbit`]: Kepler elements to and from position and velocity.
//! - [`forces`]: external forces: third bodies, tides, radiation, functions of the user.
//! - [`dynamics`]: state, equations of motion, variational equations, conserved quantities.
//! - [`integrate`]: integrators of ordinary differential equations, without physics.
//! - [`trajectory`]: simulations: steps, events, archives, records.
//! - [`particles`]: massless particles among moving bodies: flight, contacts, fates.
//! - [`photometry`]: brightness of bodies in sunlight, with mutual occultations and eclipses.
//! - [`radar`]: radar echoes of bodies in bins of delay and Doppler frequency.
//! - [`ensemble`]: many simulations in parallel.

#![deny(unsafe_code)]

/// The linear algebra whose vectors and matrices stand in this crate's signatures.
pub use nalgebra;

/// The vector instructions: [`pulp::Arch`] is what [`dynamics::System::arch`] returns and [`gravity`] takes.
pub use pulp;

pub mod error;
pub mod names;
pub mod interrupt;
#[cfg(feature = "threads")]
#[doc(hidden)]
pub mod workers;
pub mod math;
pub mod shape;
pub mod gravity;
pub mod quadrature;
pub mod mutual;
pub mod orbit;
pub mod forces;
pub mod dynamics;
pub mod integrate;
pub mod trajectory;
#[cfg(feature = "threads")]
pub mod particles;
#[cfg(feature = "photometry")]
pub mod photometry;
#[cfg(feature = "photometry")]
pub mod radar;
#[cfg(feature = "threads")]
pub mod ensemble;
