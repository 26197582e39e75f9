//! Integrators and runs, against closed forms and tight runs.
mod archive;
mod dense;
mod events;
mod order;
mod problems;
mod resume;
mod roundoff;
mod steps;
mod symplectic;
mod systems;
