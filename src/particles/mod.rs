//! Massless particles among moving bodies.
//!
//! Takes a run's continuous solution and particles; gives the particles' positions at the requested times and
//! their fates. Particles do not act on the bodies: the bodies' motion is integrated once, and particles are
//! integrated along the body ephemeris in blocks over lanes and threads, each with its own steps and error
//! control.

mod body_ephemeris;
mod fate;
mod flight;
mod contacts;
mod external_forces;
mod attraction;
mod batch;
mod shadow;
mod stage;
mod surface;
mod events;

pub use events::{ParticleCondition, ParticleEvent, ParticleFunction, ParticleOccurrence};
pub use external_forces::Radiation;
#[doc(hidden)]
pub use external_forces::visible_from;
#[doc(hidden)]
pub use fate::LARGEST;
pub use fate::{ContactResponse, End, Escape, Fate, Particle, Rules};
pub use flight::{FlightPlan, FlightRecord};
#[doc(hidden)]
pub use surface::BodySurface;
