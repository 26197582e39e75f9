//! Interrupt checks: a long computation asks its caller at intervals whether to go on.
//!
//! A check takes the caller's hook, counts work, and calls the hook about every 50 ms. A unit of work is
//! about one node of a quadrature, which takes from a few to some tens of nanoseconds. The clock is read once
//! in [`UNITS`] of them, so that counting costs next to nothing. Everything that is done for each pair of
//! bodies counts, however little it is: a thousand bodies make half a million pairs. One operation is not
//! checked: freeing memory at the end of a call or with a simulation, which takes up to half a second for a
//! thousand bodies.

use crate::error::{Error, Result};
use std::fmt;
use std::ops::ControlFlow;
use std::time::Duration;
use web_time::Instant;

/// The shortest time between two calls of a hook. With the work that may be done between two readings of the
/// clock, a hook is called every 50 ms.
pub const HOOK_INTERVAL: Duration = Duration::from_millis(40);

/// The units of work between two readings of the clock: a few milliseconds.
pub const UNITS: u64 = 100_000;

/// Counts work and calls the caller's hook at intervals. Once the hook breaks, the computation ends with
/// [`Error::Interrupted`].
///
/// ```
/// use fullbody::error::Error;
/// use fullbody::interrupt::{InterruptCheck, UNITS};
/// use std::ops::ControlFlow;
///
/// // A program that is asked to stop stops within 50 ms.
/// let mut hook = || ControlFlow::Break(());
/// let mut interrupt = InterruptCheck::new(&mut hook);
/// let stopped = loop {
///     if let Err(error) = interrupt.charge(UNITS, 0.0) {
///         break error;
///     }
/// };
/// assert!(matches!(stopped, Error::Interrupted { .. }));
/// ```
pub struct InterruptCheck<'a> {
    hook: Option<&'a mut dyn FnMut() -> ControlFlow<()>>,
    last_call: Instant,
    left: u64,
    polls: u64,
}

impl fmt::Debug for InterruptCheck<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("InterruptCheck").field("polls", &self.polls).finish_non_exhaustive()
    }
}

impl<'a> InterruptCheck<'a> {
    /// Starts with a hook that was last called now.
    pub fn new(hook: &'a mut dyn FnMut() -> ControlFlow<()>) -> Self {
        Self::since(Instant::now(), hook)
    }

    /// Starts with a hook that was last called at `last_call`.
    pub fn since(last_call: Instant, hook: &'a mut dyn FnMut() -> ControlFlow<()>) -> Self {
        Self { hook: Some(hook), last_call, left: UNITS, polls: 0 }
    }

    /// A check without a hook, which never interrupts.
    pub fn never() -> Self {
        Self { hook: None, last_call: Instant::now(), left: UNITS, polls: 0 }
    }

    /// Counts `work` that is about to be done, and calls the hook where it is due. An interruption names
    /// `time`, a time of the simulated motion.
    ///
    /// # Errors
    /// [`Error::Interrupted`] if the hook asks to stop.
    #[inline]
    pub fn charge(&mut self, work: u64, time: f64) -> Result<()> {
        match self.left.checked_sub(work) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => self.poll(work, time),
        }
    }

    /// Counts the work if the clock need not be read for it. Otherwise returns `false` and counts nothing;
    /// the caller then charges the work piece by piece.
    #[inline]
    pub fn try_charge(&mut self, work: u64) -> bool {
        let left = self.left.checked_sub(work);
        self.left = left.unwrap_or(self.left);
        left.is_some()
    }

    /// Returns how often enough work was charged to read the clock.
    pub fn polls(&self) -> u64 {
        self.polls
    }

    #[cold]
    fn poll(&mut self, work: u64, time: f64) -> Result<()> {
        self.left = UNITS.saturating_sub(work);
        self.polls += 1;
        let Some(hook) = &mut self.hook else { return Ok(()) };
        if self.last_call.elapsed() < HOOK_INTERVAL {
            return Ok(());
        }
        let answer = hook();
        self.last_call = Instant::now();
        if answer.is_break() { Err(Error::Interrupted { time }) } else { Ok(()) }
    }
}
