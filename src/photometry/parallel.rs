//! Computations of many results on all cores, with interrupt checks between groups of them.

use crate::error::Result;
use crate::interrupt::InterruptCheck;
#[cfg(feature = "threads")]
use crate::interrupt::UNITS;
#[cfg(feature = "threads")]
use rayon::prelude::*;

/// Applies a function to shares of the items on all cores, and joins the lists in order. Interrupts are checked after
/// every `group` items of each core; an interruption names the time of an item.
///
/// # Errors
/// [`Error::Interrupted`](crate::error::Error::Interrupted), and those of the function.
#[cfg(feature = "threads")]
pub fn in_parallel<I: Sync, T: Send>(
    items: &[I],
    group: usize,
    time: &dyn Fn(&I) -> f64,
    interrupt: &mut InterruptCheck,
    compute: impl Fn(&[I], &mut InterruptCheck) -> Result<Vec<T>> + Sync,
) -> Result<Vec<T>> {
    let threads = rayon::current_num_threads();
    if threads == 1 {
        return compute(items, interrupt);
    }
    let mut all = Vec::new();
    for items in items.chunks(group * threads) {
        interrupt.charge(UNITS, time(&items[0]))?;
        let share = items.len().div_ceil(threads);
        let parts = items.par_chunks(share).map(|items| compute(items, &mut InterruptCheck::never()));
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
    compute: impl Fn(&[I], &mut InterruptCheck) -> Result<Vec<T>>,
) -> Result<Vec<T>> {
    compute(items, interrupt)
}
