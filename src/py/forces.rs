//! Forces from outside: their descriptions, and the functions that callers give.

use super::descriptions::from_python;
use crate::environment::{Call, Force};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Addresses of a function in C and of its data, its answer where all is well, and the object that keeps both.
pub type Function = (usize, usize, i32, Py<PyAny>);

/// The function as the core has it; none at the address zero.
#[allow(unsafe_code)]
pub fn call((function, data, success, owner): &Function) -> Option<Call> {
    let owner = Python::attach(|py| owner.clone_ref(py));
    // SAFETY: the package takes addresses from ctypes, numba and scipy, after a look at their signatures where they tell them;
    // for a bare address the caller answers. The object that owns the code is kept with it.
    unsafe { Call::new(*function, *data, *success, Arc::new(owner)) }
}

/// Forces from their descriptions, with the functions by the names of their forces.
pub fn forces(
    described: &[Bound<'_, PyDict>],
    functions: &BTreeMap<String, Function>,
) -> PyResult<Vec<Force>> {
    let force = |described| {
        let mut force: Force = from_python(described)?;
        if let Force::Function(function) = &mut force {
            function.call = functions.get(&function.name).and_then(call);
        }
        Ok(force)
    };
    described.iter().map(force).collect()
}
