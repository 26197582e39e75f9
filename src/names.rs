//! Choices by name: what scripts, files and archives call them.

use crate::error::{Error, Result};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serializer};

/// A type of a few values, each with a name. A field of a description is written by that name with
/// `#[serde(with = "crate::names")]`.
pub trait Named: Copy + PartialEq + 'static {
    /// What the choice is about, for errors.
    const WHAT: &'static str;
    /// All values with their names.
    const NAMES: &'static [(&'static str, Self)];

    /// Its name.
    fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, choice)| *choice == self).map_or("", |(name, _)| name)
    }

    /// The choice of this name, or an error that lists the names.
    fn named(text: &str) -> Result<Self> {
        let found = Self::NAMES.iter().find(|(name, _)| *name == text).map(|(_, choice)| *choice);
        found.ok_or_else(|| {
            let names: Vec<String> = Self::NAMES.iter().map(|(name, _)| format!("{name:?}")).collect();
            Error::invalid(Self::WHAT, format!("{text:?}"), format!("one of {}", names.join(", ")))
        })
    }
}

/// Writes the name.
pub fn serialize<T: Named, S: Serializer>(choice: &T, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.serialize_str(choice.name())
}

/// Reads the name.
pub fn deserialize<'de, T: Named, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<T, D::Error> {
    T::named(&String::deserialize(deserializer)?).map_err(D::Error::custom)
}
