//! The state of an integration that an archive keeps.

use serde::{Deserialize, Serialize};

/// Counts of an integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: u64,
    /// Attempts that were rejected.
    pub rejected: u64,
    /// Evaluations of the rates of change.
    pub evaluations: u64,
}

/// Everything that decides how an integration goes on. Its layout belongs to the version of the archive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Time and what rounding dropped of it.
    pub time: [f64; 2],
    /// Vector.
    pub high: Vec<f64>,
    /// What rounding dropped of it.
    pub low: Vec<f64>,
    /// Size planned for the next step; zero before the first.
    pub next: f64,
    /// Error of the last accepted step.
    pub previous_error: f64,
    /// Whether the last attempt failed.
    pub after_rejection: bool,
    /// Counts.
    pub statistics: Statistics,
}
