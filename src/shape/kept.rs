//! What polyhedra of one solid keep for each other.

use crate::error::Result;
use pulp::Arch;
use std::mem::Discriminant;
use std::sync::{Arc, Mutex};

/// Moments by degree, scale and instructions: with those of others results would depend, by rounding, on what was asked for before.
pub type Kept = Mutex<Vec<(Key, Arc<Vec<f64>>)>>;
pub type Key = (usize, u64, Option<Discriminant<Arch>>);

/// The most of them that are kept of a solid: sizes may be many.
const MOST_KEPT: usize = 16;

/// What was asked for before, or is made now; nothing is kept where another thread has panicked.
pub fn kept(kept: &Kept, key: Key, make: impl FnOnce() -> Result<Vec<f64>>) -> Result<Arc<Vec<f64>>> {
    let found = kept.lock().ok().and_then(|kept| kept.iter().find(|(other, _)| *other == key).cloned());
    if let Some((_, values)) = found {
        return Ok(values);
    }
    let values = Arc::new(make()?);
    if let Ok(mut kept) = kept.lock() {
        if kept.len() == MOST_KEPT {
            kept.remove(0);
        }
        kept.push((key, values.clone()));
    }
    Ok(values)
}
