//! At which times a run is recorded.

use crate::error::{Error, Result, require_finite};

/// At which times a run is recorded.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// At every accepted step.
    Steps,
    /// At a spacing, start and end included.
    Spacing(f64),
    /// At exactly these times, in the direction of the run.
    Times(Vec<f64>),
}

/// The times that are still to be recorded.
pub(super) enum Times<'a> {
    Steps,
    List { times: std::borrow::Cow<'a, [f64]>, next: usize, forward: bool },
}

impl<'a> Times<'a> {
    pub fn new(start: f64, until: f64, output: &'a Output) -> Result<Self> {
        let forward = until >= start;
        let list = |times| Ok(Self::List { times, next: 0, forward });
        match output {
            Output::Steps => Ok(Self::Steps),
            Output::Spacing(spacing) => {
                if !(spacing.is_finite() && *spacing != 0.0) {
                    return Err(Error::invalid("output", spacing, "a finite spacing above zero, or times"));
                }
                let count = (until - start).abs() / spacing.abs();
                if count > 1e9 {
                    return Err(Error::invalid("output", spacing, "a spacing with fewer than 1e9 samples"));
                }
                // Multiples, not sums, and the end itself rather than something beside it.
                let step = spacing.abs().copysign(until - start);
                let inner = (0..=count as u64).map(|k| start + k as f64 * step);
                let mut times: Vec<f64> =
                    inner.filter(|t| (until - t).abs() > 1e-9 * spacing.abs()).collect();
                times.push(until);
                list(times.into())
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
                list(times.as_slice().into())
            }
        }
    }

    /// The next time that lies before `now`.
    pub fn before(&mut self, now: f64) -> Option<f64> {
        let Self::List { times, next, forward } = self else { return None };
        let time = *times.get(*next)?;
        if if *forward { time < now } else { time > now } {
            *next += 1;
            Some(time)
        } else {
            None
        }
    }

    /// Whether `now` itself is to be recorded.
    pub fn due(&mut self, now: f64) -> bool {
        match self {
            Self::Steps => true,
            Self::List { times, next, .. } => {
                let due = times.get(*next) == Some(&now);
                *next += usize::from(due);
                due
            }
        }
    }
}
