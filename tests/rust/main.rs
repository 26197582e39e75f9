//! The Rust tests, one binary. Expected values come from elsewhere than the code.
mod gravity;
mod integrators;
mod mutual;
mod orbit;
mod support;
