//! External forces: their descriptions, and the functions that callers give.

use super::descriptions::from_python;
use crate::errors::Result;
use fullbody::forces::{Call, Force};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The address of a C function and of its data, its return value for success, and the object that keeps both
/// alive.
pub type Function = (usize, usize, i32, Py<PyAny>);

/// Returns the function as the core stores it; `None` for the address zero.
#[allow(unsafe_code)]
pub fn call((function, data, success, owner): &Function) -> Option<Call> {
    let owner = Python::attach(|py| owner.clone_ref(py));
    // SAFETY: the package takes addresses from ctypes, numba and scipy, and checks their signatures where
    // they carry them; for a bare address the caller is responsible. The object that owns the code is kept
    // with it.
    unsafe { Call::new(*function, *data, *success, Arc::new(owner)) }
}

/// Makes forces from their descriptions, with the functions by the names of the forces.
pub fn forces(described: &[Bound<'_, PyDict>], functions: &BTreeMap<String, Function>) -> Result<Vec<Force>> {
    let force = |described| {
        let mut force: Force = from_python(described)?;
        if let Force::Function(function) = &mut force {
            function.call = functions.get(&function.name).and_then(call);
        }
        Ok(force)
    };
    described.iter().map(force).collect()
}

/// Returns an error for the description of a force whose numbers are invalid in any system.
#[pyfunction]
pub fn check_force(described: &Bound<'_, PyDict>) -> Result<()> {
    let force: Force = from_python(described)?;
    Ok(force.check()?)
}
