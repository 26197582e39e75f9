//! Enumerations whose values have names in scripts, files and archives.

use crate::error::{Error, Result};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serializer};

/// A type with a few values, each of which has a name. A serialized field is written as that name with
/// `#[serde(with = "crate::names")]`.
pub trait Named: Copy + PartialEq + 'static {
    /// The name of the choice in error messages.
    const WHAT: &'static str;
    /// All values with their names.
    const NAMES: &'static [(&'static str, Self)];

    /// Returns the name of the value.
    fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, choice)| *choice == self).map_or("", |(name, _)| name)
    }

    /// Returns the value with this name.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] lists all names.
    fn named(text: &str) -> Result<Self> {
        let choice = Self::NAMES.iter().find(|(name, _)| *name == text).map(|(_, choice)| *choice);
        choice.ok_or_else(|| {
            let names: Vec<String> = Self::NAMES.iter().map(|(name, _)| format!("{name:?}")).collect();
            Error::invalid(Self::WHAT, format!("{text:?}"), format!("one of {}", names.join(", ")))
        })
    }
}

/// Serializes a value as its name.
///
/// # Errors
/// Returns the errors of the serializer.
pub fn serialize<T: Named, S: Serializer>(choice: &T, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.serialize_str(choice.name())
}

/// Deserializes a value from its name.
///
/// # Errors
/// Returns the errors of the deserializer, and one for a name that does not exist.
pub fn deserialize<'de, T: Named, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<T, D::Error> {
    T::named(&String::deserialize(deserializer)?).map_err(D::Error::custom)
}
