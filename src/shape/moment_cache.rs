//! A cache of moments, which copies of one polyhedron share.

use crate::error::Result;
use pulp::Arch;
use std::mem::Discriminant;
use std::sync::{Arc, Mutex};

/// Moments with their degree, scale and vector instructions as the key. Without scale and instructions in the
/// key, the rounding of a result would depend on earlier requests.
pub type MomentCache = Mutex<Vec<(MomentKey, Arc<Vec<f64>>)>>;
pub type MomentKey = (usize, u64, Option<Discriminant<Arch>>);

/// The largest number of entries for one solid, since sizes may be many.
const MOST_CACHED: usize = 16;

/// Returns the cached moments, or computes and caches them. Nothing is cached where another thread has
/// panicked.
pub fn cached_moments(
    cache: &MomentCache,
    key: MomentKey,
    make: impl FnOnce() -> Result<Vec<f64>>,
) -> Result<Arc<Vec<f64>>> {
    let cached = cache.lock().ok().and_then(|cache| cache.iter().find(|(other, _)| *other == key).cloned());
    if let Some((_, values)) = cached {
        return Ok(values);
    }
    let values = Arc::new(make()?);
    if let Ok(mut cache) = cache.lock() {
        if cache.len() == MOST_CACHED {
            cache.remove(0);
        }
        cache.push((key, values.clone()));
    }
    Ok(values)
}
