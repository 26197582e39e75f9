//! The methods of mutual gravity, by name.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// The method by which the interaction of a pair is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
#[non_exhaustive]
pub enum Method {
    /// The paper's surface integrals.
    Surface,
    /// The focal rule, which gives the same numbers from a quarter of the nodes.
    Focal,
    /// The harmonic series, exact to the tolerance outside the circumscribed spheres.
    Harmonic,
    /// The mutual expansion to a total degree (2 to 60).
    Multipole(usize),
    /// Point masses, which exert no torque.
    Point,
}

impl Method {
    /// The highest total degree of the mutual expansion.
    pub const MAX_DEGREE: usize = 60;
    const EXPECTED: &str =
        "\"surface\", \"focal\", \"harmonic\", \"multipole:N\" with N from 2 to 60, or \"point\"";
}

impl FromStr for Method {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let degree =
            |n: &str| n.parse().ok().filter(|n| (2..=Self::MAX_DEGREE).contains(n)).map(Self::Multipole);
        let method = match text {
            "surface" => Some(Self::Surface),
            "focal" => Some(Self::Focal),
            "harmonic" => Some(Self::Harmonic),
            "point" => Some(Self::Point),
            _ => text.strip_prefix("multipole:").and_then(degree),
        };
        method.ok_or_else(|| Error::invalid("gravity", format!("{text:?}"), Self::EXPECTED))
    }
}

impl TryFrom<String> for Method {
    type Error = Error;

    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<Method> for String {
    fn from(method: Method) -> Self {
        method.to_string()
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Surface => f.write_str("surface"),
            Self::Focal => f.write_str("focal"),
            Self::Harmonic => f.write_str("harmonic"),
            Self::Multipole(n) => write!(f, "multipole:{n}"),
            Self::Point => f.write_str("point"),
        }
    }
}
