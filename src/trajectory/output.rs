//! The times at which a run is recorded.

use crate::error::{Error, Result, require_finite};
use std::cmp::Ordering;

/// The times at which a run is recorded.
///
/// ```
/// use fullbody::trajectory::Output;
///
/// assert_eq!(Output::Spacing(1.0).times(0.0, 2.5)?, [0.0, 1.0, 2.0, 2.5]);
/// assert!(Output::Times(vec![3.0]).times(0.0, 2.5).is_err());
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Output {
    /// Samples at every accepted step.
    Steps,
    /// Samples at the start and the end.
    Ends,
    /// Samples at a constant spacing, with the start and the end.
    Spacing(f64),
    /// Samples at exactly these times, in the direction of the run.
    Times(Vec<f64>),
}

impl Output {
    /// Returns the times of a run, where they do not depend on its steps.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a spacing that is zero, not finite or too small for the span, and for
    /// times that are not in order or not within it.
    pub fn times(&self, start: f64, until: f64) -> Result<Vec<f64>> {
        let mut times = Times::new(start, until, self)?;
        let next = || {
            let time = times.next();
            times.skip();
            time
        };
        Ok(std::iter::from_fn(next).collect())
    }
}

/// The times that remain to be recorded.
pub(super) enum Times<'a> {
    Steps,
    /// The multiples of a spacing that are well before the end, and the end.
    Spaced {
        start: f64,
        step: f64,
        end: f64,
        next: u64,
        count: u64,
    },
    List {
        times: &'a [f64],
        next: usize,
        forward: bool,
    },
}

impl<'a> Times<'a> {
    pub fn new(start: f64, until: f64, output: &'a Output) -> Result<Self> {
        let forward = until >= start;
        match output {
            Output::Steps => Ok(Self::Steps),
            Output::Ends => {
                let (step, count) = (until - start, u64::from(until != start));
                Ok(Self::Spaced { start, step, end: until, next: 0, count })
            }
            Output::Spacing(spacing) => {
                if !(spacing.is_finite() && *spacing != 0.0) {
                    return Err(Error::invalid("output", spacing, "a finite spacing above zero, or times"));
                }
                let count = (until - start).abs() / spacing.abs();
                if count > 1e9 {
                    return Err(Error::invalid("output", spacing, "a spacing with fewer than 1e9 samples"));
                }
                // Times are multiples of the step rather than sums, and the end is recorded rather than a
                // time very near to it.
                let step = spacing.abs().copysign(until - start);
                let mut count = count as u64 + 1;
                while count > 0 && (until - (start + (count - 1) as f64 * step)).abs() <= 1e-9 * spacing.abs()
                {
                    count -= 1;
                }
                Ok(Self::Spaced { start, step, end: until, next: 0, count })
            }
            Output::Times(times) => {
                require_finite("output", times)?;
                let (low, high) = (start.min(until), start.max(until));
                if let Some(t) = times.iter().find(|t| !(low..=high).contains(*t)) {
                    return Err(Error::invalid("a time in output", t, format!("times from {low} to {high}")));
                }
                if let Some(w) = times.windows(2).find(|w| if forward { w[1] <= w[0] } else { w[1] >= w[0] })
                {
                    return Err(Error::invalid(
                        "output",
                        format!("{} followed by {}", w[0], w[1]),
                        "times in the direction of the run, none twice",
                    ));
                }
                Ok(Self::List { times, next: 0, forward })
            }
        }
    }

    /// Returns the next time, if it lies before `now`.
    pub fn pending(&self, now: f64) -> Option<f64> {
        let time = self.next()?;
        let forward = match self {
            Self::Spaced { step, .. } => *step >= 0.0,
            Self::List { forward, .. } => *forward,
            Self::Steps => return None,
        };
        (if forward { time < now } else { time > now }).then_some(time)
    }

    /// Takes the next time off the list and returns it, if it lies before `now`.
    pub fn take_before(&mut self, now: f64) -> Option<f64> {
        let time = self.pending(now)?;
        self.skip();
        Some(time)
    }

    /// Returns whether `now` itself is to be recorded, and takes it off the list.
    pub fn due(&mut self, now: f64) -> bool {
        let due = matches!(self, Self::Steps) || self.next() == Some(now);
        if due {
            self.skip();
        }
        due
    }

    fn next(&self) -> Option<f64> {
        match self {
            Self::Steps => None,
            Self::Spaced { start, step, end, next, count } => match next.cmp(count) {
                Ordering::Less => Some(start + *next as f64 * step),
                Ordering::Equal => Some(*end),
                Ordering::Greater => None,
            },
            Self::List { times, next, .. } => times.get(*next).copied(),
        }
    }

    fn skip(&mut self) {
        match self {
            Self::Steps => {}
            Self::Spaced { next, .. } => *next += 1,
            Self::List { next, .. } => *next += 1,
        }
    }
}
