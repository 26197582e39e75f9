//! Kepler orbits: conversion between elements and Cartesian coordinates, and the anomalies.
//!
//! Takes the position and velocity of one body relative to another and mu = G (m_1 + m_2), and gives six
//! elements, or the reverse. Bodies that are not points have osculating elements: those of the orbit on which
//! the pair would continue as points.

mod anomaly;
mod elements;
mod osculating;
mod path;
mod propagate;

pub use elements::KeplerElements;
pub use path::OrbitPath;
#[doc(hidden)]
pub use path::{OrbitCells, OrbitPosition};
#[doc(hidden)]
pub use propagate::{KeplerChange, kepler_change};
