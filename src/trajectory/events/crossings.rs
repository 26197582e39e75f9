//! Zeros of conditions along a continuous solution.

use super::condition::EvaluationPoint;
use super::{Condition, Event, EventDetector};
use crate::dynamics::System;
use crate::error::Result;
use crate::integrate::Segment;
use crate::interrupt::InterruptCheck;
use crate::trajectory::Dense;

/// The zeros of a condition's function along a part of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Crossings {
    /// The value of the function at the start of the piece of the run in which the span begins.
    pub at_start: f64,
    /// The times of the zeros in the order of the run; the function changes its sign at each.
    pub times: Vec<f64>,
}

impl Dense {
    /// Returns the zeros of the functions of conditions in the pieces of a run that contain a part of the
    /// span. They are found like the events of a run that is being integrated.
    ///
    /// # Errors
    /// The errors of the conditions' functions, and
    /// [`Error::Interrupted`](crate::error::Error::Interrupted).
    pub fn crossings(
        &self,
        system: &System,
        conditions: Vec<Condition>,
        span: [f64; 2],
        interrupt: &mut InterruptCheck,
    ) -> Result<Vec<Crossings>> {
        let equations = system.dynamics(self.frame(), interrupt)?;
        let mut events: Vec<Event> = conditions.into_iter().map(Event::new).collect();
        let mut detector = EventDetector::new(&equations, &events, false)?;
        let overlaps = |piece: &Segment| {
            let (start, end) = (piece.start(), piece.time_at(1.0));
            start.max(end) >= span[0] && start.min(end) <= span[1]
        };
        let all = self.pieces();
        let from = all.iter().position(overlaps).unwrap_or(all.len());
        let until = all.iter().rposition(overlaps).map_or(from, |last| last + 1);
        let pieces = &all[from..until];
        let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else {
            return Ok(events.iter().map(|_| Crossings { at_start: f64::MAX, times: Vec::new() }).collect());
        };
        let mut y = vec![0.0; equations.layout().dimension()];
        let zeros = y.clone();
        first.at(0.0, &mut y);
        let (time, y) = (first.start(), &y);
        let point = EvaluationPoint { equations: &equations, time, y, zeros: &zeros, pieces: all };
        let mut start = |event: &mut Event| {
            Ok(Crossings { at_start: event.condition.value(&point, interrupt)?, times: Vec::new() })
        };
        let mut crossings = events.iter_mut().map(&mut start).collect::<Result<Vec<_>>>()?;
        let mut occurrences = Vec::new();
        let mut y = zeros.clone();
        last.at(1.0, &mut y);
        let end = (last.time_at(1.0), y.as_slice());
        detector.scan(&equations, (pieces, all), end, None, &mut events, &mut occurrences, interrupt)?;
        // The last piece may go on beyond the event that ended the run.
        let (from, to) = self.range();
        let within = from.min(to)..=from.max(to);
        for occurrence in occurrences.iter().filter(|occurrence| within.contains(&occurrence.time)) {
            crossings[occurrence.event].times.push(occurrence.time);
        }
        Ok(crossings)
    }
}
