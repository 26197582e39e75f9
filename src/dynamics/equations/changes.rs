//! The changes of the parameters that lead from one system to another.

use super::parameter::Parameter;
use super::system::System;
use crate::error::{Error, Result};
use serde_json::{Value, json};

/// The largest relative change of a number that counts as rounding.
const ROUNDING: f64 = 1e-12;

/// The changes of parameters that lead from one system to another.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterChanges {
    /// The parameters that differ, with their changes.
    pub changes: Vec<(String, f64)>,
    /// The first number or text of the description that differs and that no parameter changes.
    pub unexplained: Option<String>,
}

impl System {
    /// Returns the parameters by which motions can be differentiated, with their values.
    pub fn parameter_values(&self) -> Vec<(String, f64)> {
        Parameter::all_of(self).into_iter().map(|(name, parameter)| (name, parameter.value(self))).collect()
    }

    /// Returns the changes of the parameters that lead from this system to another one, and the first difference that
    /// they do not explain. Settings are not compared.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for parameters that cannot be changed one after the other.
    pub fn parameter_changes(&self, other: &Self) -> Result<ParameterChanges> {
        let (mut changed, mut changes) = (self.clone(), Vec::new());
        let mut parameters = Parameter::all_of(self);
        if parameters.iter().map(|(name, _)| name).eq(Parameter::all_of(other).iter().map(|(name, _)| name)) {
            // The mass of a composite remains to be changed only where its parts do not explain it; a density
            // changes nothing else than a mass.
            parameters.sort_by_key(|(_, parameter)| !matches!(parameter, Parameter::Part(..)));
            parameters.retain(|(_, parameter)| !matches!(parameter, Parameter::Density(..)));
            for (name, parameter) in parameters {
                let by = parameter.change(&changed, other);
                if by.abs() > ROUNDING * parameter.value(other).abs().max(parameter.size(self)) {
                    changed = parameter.changed(&changed, by)?;
                    changes.push((name, by));
                }
            }
        }
        let unexplained = difference("", &changed.description()?, &other.description()?, 0.0);
        Ok(ParameterChanges { changes, unexplained })
    }

    fn description(&self) -> Result<Value> {
        let values = serde_json::to_value((self.gravitational_constant, &self.bodies, self.forces()));
        let mut values = values.map_err(|error| {
            Error::invalid("the description of a system", error.to_string(), "numbers and texts")
        })?;
        Ok(json!({ "G": values[0].take(), "bodies": values[1].take(), "forces": values[2].take() }))
    }
}

/// Returns the first place at which two descriptions differ by more than rounding. The coordinates of a
/// vector or of a table of vectors have one scale.
fn difference(path: &str, reference: &Value, other: &Value, scale: f64) -> Option<String> {
    match (reference, other) {
        (Value::Number(a), Value::Number(b)) if a.is_f64() && b.is_f64() => {
            let [a, b] = [a, b].map(|number| number.as_f64().unwrap_or(f64::NAN));
            let is_same = (a - b).abs() <= ROUNDING * scale.max(a.abs()).max(b.abs());
            (!is_same).then(|| path.to_owned())
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let scale = scale.max(largest(reference)).max(largest(other));
            let mut pairs = a.iter().zip(b).enumerate();
            pairs.find_map(|(k, (a, b))| difference(&format!("{path}[{k}]"), a, b, scale))
        }
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            let mut pairs = a.iter().zip(b.values());
            pairs.find_map(|((name, a), b)| difference(format!("{path} {name}").trim_start(), a, b, 0.0))
        }
        _ => (reference != other).then(|| path.to_owned()),
    }
}

/// Returns the largest magnitude in a table of numbers.
fn largest(value: &Value) -> f64 {
    match value {
        Value::Array(values) => values.iter().map(largest).fold(0.0, f64::max),
        _ => value.as_f64().map_or(0.0, f64::abs),
    }
}
