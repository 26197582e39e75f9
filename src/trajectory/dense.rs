//! A run as a function of time.

use crate::dynamics::{Inner, State};
use crate::error::{Error, Result};
use crate::integrate::Segment;
use crate::patience::Patience;

/// The solution at any time of a run.
///
/// Keeps one polynomial a step: 8 (terms + 2) bytes for every number of the integrator's vector (13 a body), where the terms
/// are as many as the interpolant's order. For two bodies under Verner 9(8) that is 2.3 kB a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Dense {
    inner: Inner,
    first: State,
    segments: Vec<Segment>,
    start: f64,
    end: f64,
}

impl Dense {
    pub(super) fn new(inner: &Inner, first: State, start: f64) -> Self {
        Self { inner: inner.clone(), first, segments: Vec::new(), start, end: start }
    }

    pub(super) fn push(&mut self, segment: &Segment, end: f64) {
        self.segments.push(segment.clone());
        self.end = end;
    }

    /// First and last time, in the direction of the run.
    pub fn range(&self) -> (f64, f64) {
        (self.start, self.end)
    }

    /// Number of polynomials.
    pub fn segments(&self) -> usize {
        self.segments.len()
    }

    /// Memory that the polynomials take.
    pub fn bytes(&self) -> usize {
        self.segments.iter().map(Segment::bytes).sum()
    }

    /// The state at a time of the run.
    pub fn state(&self, time: f64) -> Result<State> {
        let (low, high) = (self.start.min(self.end), self.start.max(self.end));
        if !(low..=high).contains(&time) {
            return Err(Error::invalid(
                "time",
                time,
                format!("one from {low} to {high}, which the run covers"),
            ));
        }
        if self.segments.is_empty() {
            return Ok(self.first.clone());
        }
        let forward = self.end >= self.start;
        let after =
            self.segments.partition_point(|s| if forward { s.start() <= time } else { s.start() >= time });
        let segment = &self.segments[after.saturating_sub(1)];
        let mut y = vec![0.0; self.inner.high.len()];
        segment.at(segment.fraction(time), &mut y);
        Ok(self.inner.state(time, &y, &vec![0.0; y.len()]))
    }

    /// The states at many times, in any order.
    pub fn states(&self, times: &[f64], patience: &mut Patience) -> Result<Vec<State>> {
        let state = |&time: &f64| {
            patience.spend(self.inner.high.len() as u64, time)?;
            self.state(time)
        };
        times.iter().map(state).collect()
    }
}
