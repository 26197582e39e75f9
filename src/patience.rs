//! When a long computation asks its caller whether to go on.
//!
//! Takes the caller's hook and counts work; calls the hook about every 50 ms. A unit of work is about one node of a
//! quadrature, which takes some nanoseconds to some tens of them. The clock is read once in [`UNITS`] of them, so that
//! counting costs next to nothing. Whatever is done once for every pair of bodies counts, however little it is: a
//! thousand bodies make half a million pairs. One thing asks nobody: memory is given back at the end of a call or with a
//! simulation, in up to half a second for a thousand bodies.

use crate::error::{Error, Result};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// How long a hook is left alone; with what may be done between two looks at the clock it is called within 50 ms.
pub const HOOK_INTERVAL: Duration = Duration::from_millis(40);

/// Units of work between two looks at the clock: a few milliseconds.
pub const UNITS: u64 = 100_000;

/// The caller's leave to go on computing, which lasts until the hook breaks.
pub struct Patience<'a> {
    hook: Option<&'a mut dyn FnMut() -> ControlFlow<()>>,
    asked: Instant,
    left: u64,
    looks: u64,
}

impl<'a> Patience<'a> {
    /// From a hook that was last called now.
    pub fn new(hook: &'a mut dyn FnMut() -> ControlFlow<()>) -> Self {
        Self::since(Instant::now(), hook)
    }

    /// From a hook that was last called at some time.
    pub fn since(asked: Instant, hook: &'a mut dyn FnMut() -> ControlFlow<()>) -> Self {
        Self { hook: Some(hook), asked, left: UNITS, looks: 0 }
    }

    /// Without a hook: the caller waits for any length of time.
    pub fn endless() -> Self {
        Self { hook: None, asked: Instant::now(), left: UNITS, looks: 0 }
    }

    /// Counts `work` that is about to be done. An interruption names `time`, a time of the simulated motion.
    #[inline]
    pub fn spend(&mut self, work: u64, time: f64) -> Result<()> {
        match self.left.checked_sub(work) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => self.look(work, time),
        }
    }

    /// Counts the work if the clock need not be read for it. Otherwise returns `false`, and the caller spends it bit by
    /// bit.
    #[inline]
    pub fn affords(&mut self, work: u64) -> bool {
        let left = self.left.checked_sub(work);
        self.left = left.unwrap_or(self.left);
        left.is_some()
    }

    /// How often so much work was spent that it was time to look at the clock.
    pub fn looks(&self) -> u64 {
        self.looks
    }

    #[cold]
    fn look(&mut self, work: u64, time: f64) -> Result<()> {
        self.left = UNITS.saturating_sub(work);
        self.looks += 1;
        let Some(hook) = &mut self.hook else { return Ok(()) };
        if self.asked.elapsed() < HOOK_INTERVAL {
            return Ok(());
        }
        let answer = hook();
        self.asked = Instant::now();
        if answer.is_break() { Err(Error::Interrupted { time }) } else { Ok(()) }
    }
}
