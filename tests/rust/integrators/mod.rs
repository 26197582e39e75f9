//! Integrators and runs, against closed forms and tight runs.
mod order;
mod problems;
