//! The Rust tests, one binary. Expected values come from elsewhere than the code.
mod gravity;
mod math;
mod mutual;
mod mutual_values;
mod orbit;
mod quadrature;
mod shape;
mod support;
