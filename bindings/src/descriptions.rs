//! Descriptions of settings, integrators and simulations as Python dicts. They pass through JSON, so that the
//! core's types alone define the names and values.

use crate::errors::{InvalidInput, Result};
use fullbody::error::require_finite;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Returns the value that a dict describes.
pub fn from_python<T: DeserializeOwned>(described: &Bound<'_, PyDict>) -> Result<T> {
    for (name, value) in described {
        // JSON cannot represent infinities and NaN, which are refused here.
        if let Ok(number) = value.extract::<f64>() {
            require_finite(&name.to_string(), &[number])?;
        }
    }
    let json = described.py().import("json")?;
    let text: String = json.call_method1("dumps", (described,))?.extract()?;
    // The text is parsed in two steps, so that errors do not name positions in a text that the caller never
    // sees.
    let value = serde_json::from_str::<serde_json::Value>(&text);
    let value_read = value.and_then(serde_json::from_value);
    Ok(value_read.map_err(|error| InvalidInput::new_err(error.to_string()))?)
}

/// Returns the dict that describes a value.
pub fn to_python<'py>(py: Python<'py>, value: &impl Serialize) -> Result<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(|error| InvalidInput::new_err(error.to_string()))?;
    Ok(py.import("json")?.call_method1("loads", (text,))?)
}
