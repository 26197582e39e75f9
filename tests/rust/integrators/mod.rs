//! Integrators and runs, against closed forms and tight runs.
mod archive;
mod bounds;
mod collisions;
mod dense;
mod events;
mod order;
mod interrupt;
mod problems;
mod resume;
mod roots;
mod roundoff;
mod steps;
mod symplectic;
pub mod systems;
mod tableaux;
