//! Lists of results that are computed on all cores, with interrupt checks between groups.

use crate::error::Result;
use crate::interrupt::InterruptCheck;
#[cfg(feature = "threads")]
use crate::interrupt::UNITS;
#[cfg(feature = "threads")]
use rayon::prelude::*;

/// Applies a function to shares of the items on all cores, and joins the lists in order. The clock is read after
/// `most` items of each core; an interruption names the time of an item.
///
/// # Errors
/// [`Error::Interrupted`](crate::error::Error::Interrupted), and those of the function.
#[cfg(feature = "threads")]
pub fn in_parallel<I: Sync, T: Send>(
    items: &[I],
    most: usize,
    time: &dyn Fn(&I) -> f64,
    interrupt: &mut InterruptCheck,
    some: impl Fn(&[I], &mut InterruptCheck) -> Result<Vec<T>> + Sync,
) -> Result<Vec<T>> {
    let threads = rayon::current_num_threads();
    if threads == 1 {
        return some(items, interrupt);
    }
    let mut all = Vec::new();
    for group in items.chunks(most * threads) {
        interrupt.charge(UNITS, time(&group[0]))?;
        let share = group.len().div_ceil(threads);
        let parts = group.par_chunks(share).map(|items| some(items, &mut InterruptCheck::never()));
        for part in parts.collect::<Vec<_>>() {
            all.extend(part?);
        }
    }
    Ok(all)
}

/// Applies a function to all items in one thread.
///
/// # Errors
/// Returns the errors of the function.
#[cfg(not(feature = "threads"))]
pub fn in_parallel<I, T>(
    items: &[I],
    _: usize,
    _: &dyn Fn(&I) -> f64,
    interrupt: &mut InterruptCheck,
    some: impl Fn(&[I], &mut InterruptCheck) -> Result<Vec<T>>,
) -> Result<Vec<T>> {
    some(items, interrupt)
}
