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
    /// The mutual expansion to a total degree (even, 2 to 16).
    Multipole(usize),
    /// Point masses, which exert no torque.
    Point,
}

impl Method {
    /// The highest total degree of the mutual expansion.
    pub const MAX_DEGREE: usize = 16;
    /// The degree to which the truncation error of the highest degree is estimated.
    pub(super) const BEYOND: usize = Self::MAX_DEGREE + 2;
    const EXPECTED: &str = "\"surface\", \"focal\", \"multipole:N\" with N even from 2 to 16, or \"point\"";
}

impl FromStr for Method {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let degree = |n: &str| {
            n.parse().ok().filter(|n| n % 2 == 0 && (2..=Self::MAX_DEGREE).contains(n)).map(Self::Multipole)
        };
        let method = match text {
            "surface" => Some(Self::Surface),
            "focal" => Some(Self::Focal),
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
            Self::Multipole(n) => write!(f, "multipole:{n}"),
            Self::Point => f.write_str("point"),
        }
    }
}
