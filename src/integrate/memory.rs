//! The state of an integration that an archive keeps.

use serde::{Deserialize, Serialize};

/// The counts of an integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Statistics {
    /// The number of accepted steps.
    pub steps: u64,
    /// The number of attempts that were rejected.
    pub rejected: u64,
    /// The number of evaluations of the rates of change.
    pub evaluations: u64,
}

/// The data that determine how an integration continues. Their layout belongs to the version of the archive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// The time and its low part.
    pub time: [f64; 2],
    /// The vector.
    pub high: Vec<f64>,
    /// The low part of the vector.
    pub low: Vec<f64>,
    /// The size planned for the next step; zero before the first.
    pub next: f64,
    /// The error of the last accepted step.
    pub previous_error: f64,
    /// Whether the last attempt failed.
    pub after_rejection: bool,
    /// The counts of the integration.
    pub statistics: Statistics,
}
