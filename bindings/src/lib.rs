//! The Python module `fullbody._core`: one file for each module of the crate, without mathematics. The
//! package `fullbody` wraps it with units, names and plots.

mod arrays;
mod bodies;
mod descriptions;
mod ensembles;
mod errors;
mod events;
mod forces;
mod gravity;
mod harmonics;
mod limbs;
mod listening;
mod orbits;
mod particles;
mod photometry;
mod polyhedra;
mod radar;
mod stokes;
mod rotations;
mod runs;
mod systems;

use pyo3::prelude::*;

#[pymodule]
mod _core {
    #[pymodule_export]
    use super::bodies::PyBody;
    #[pymodule_export]
    use super::ensembles::integrate_many;
    #[pymodule_export]
    use super::events::{PyCondition, PyViewpoint};
    #[pymodule_export]
    use super::forces::check_force;
    #[pymodule_export]
    use super::gravity::PyAttraction;
    #[pymodule_export]
    use super::harmonics::solid_harmonics;
    #[pymodule_export]
    use super::limbs::PyLimb;
    #[pymodule_export]
    use super::orbits::{cartesian_to_elements, elements_to_cartesian, period};
    #[pymodule_export]
    use super::particles::{fly, surface, visible};
    #[pymodule_export]
    const LARGEST_OF_PARTICLE: f64 = fullbody::particles::LARGEST;
    #[pymodule_export]
    use super::photometry::{PyPhotometer, recoil};
    #[pymodule_export]
    use super::polyhedra::PyPolyhedron;
    #[pymodule_export]
    use super::radar::PyRadar;
    #[pymodule_export]
    use super::rotations::{quaternion_of_tait_bryan, quaternion_product, rotation_matrices};
    #[pymodule_export]
    use super::runs::{PyDense, PySimulation, tolerance};
    #[pymodule_export]
    use super::stokes::PyStokesCoefficients;
    #[pymodule_export]
    use super::systems::{PyState, PySystem, vector_paths};
}
