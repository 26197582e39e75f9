//! The Rust tests, one binary. Expected values come from elsewhere than the code.
mod composite;
mod contact;
mod doors;
mod dynamics;
mod ensemble;
mod environment;
mod gravity;
mod integrators;
mod math;
mod jacobian;
mod mutual;
mod mutual_values;
mod orbit;
mod polyhedron;
mod quadrature;
mod shape;
mod support;
