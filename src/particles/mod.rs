//! Massless particles among moving bodies.
//!
//! Takes a run's continuous solution and particles; gives where they are at times and what becomes of them. The bodies
//! do not feel the particles: they move once, and particles are pushed along their course in blocks over lanes and threads, each
//! with its own steps and error control.

mod course;
mod fate;
mod flight;
mod ground;
mod outside;
mod pull;
mod push;
mod shadow;
mod stage;
mod surface;
mod watch;

pub use fate::{Contact, End, Escape, Fate, Particle, Rules};
pub use flight::{Flown, Plan};
pub use outside::{Radiation, visible_from};
pub use surface::Surface;
pub use watch::{Condition, Happened, ParticleFunction, Watch};
