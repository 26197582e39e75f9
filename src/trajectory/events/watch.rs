//! Finding events in the pieces of a step.

use super::condition::Place;
use super::{Condition, Event, Occurrence};
use crate::dynamics::Dynamics;
use crate::error::{Error, Result};
use crate::integrate::{Segment, extremum, root};
use crate::patience::Patience;
use crate::trajectory::approach::Contact;

/// Equal intervals of a step at whose ends the functions are sampled. Between three samples of which the middle one is nearest to
/// zero the extremum is sought, so that two zeros in one interval are not lost; only a function with more extrema than
/// that in an interval can hide some.
pub const SAMPLES: usize = 8;

/// Beside the ends of the intervals, two places near the ends of the step show which way the functions go there.
const POINTS: usize = SAMPLES + 3;
const NEAR: f64 = 1e-3;

/// A zero this near to a state that was given, in steps, is that state itself and no event.
const AT_GIVEN: f64 = 1e-9;

/// Units of work of looking for an event in a piece.
const SCAN: u64 = 200;

/// Watches events along a run.
pub(crate) struct Watch {
    values: Vec<[f64; POINTS]>,
    /// Whether the last of the values are those at the start of the next piece.
    begun: bool,
    /// Whether the next piece starts from a state that was given, not from one that a step has reached.
    given: bool,
    y: Vec<f64>,
    /// The vector with which the piece after the present one begins.
    next: Vec<f64>,
    zeros: Vec<f64>,
    found: Vec<(f64, usize)>,
}

impl Watch {
    /// Refuses events that the system cannot have. `given` says whether the run starts from a state that was given.
    pub fn new(equations: &Dynamics, events: &[Event], given: bool) -> Result<Self> {
        for event in events {
            event.condition.check(equations)?;
            let name = event.condition.name();
            let own = event.condition.direction();
            let fits = match own {
                Some(own) => event.direction == 0 || event.direction == own,
                None => (-1..=1).contains(&event.direction),
            };
            if !fits {
                let expected = own.map_or("-1, 0 or 1".to_owned(), |own| format!("0 or {own}"));
                return Err(Error::invalid(format!("direction of {name}"), event.direction, expected));
            }
        }
        let dimension = equations.layout().dimension();
        Ok(Self {
            values: vec![[0.0; POINTS]; events.len()],
            begun: false,
            given,
            y: vec![0.0; dimension],
            next: vec![0.0; dimension],
            zeros: vec![0.0; dimension],
            found: Vec::new(),
        })
    }

    /// The events within a step that ends with the time and vector `end`, in the order of the run, up to and with the first
    /// terminal one, whose place in the list and time are given back.
    ///
    /// At the ends of the pieces the functions are evaluated at the vectors that the steps themselves go through. The values
    /// there are the same for the piece before and the piece after, and for a run that begins there: no zero is found twice,
    /// none is lost. Where bodies meet the step ends, and their contact is an event at that very place.
    #[allow(clippy::too_many_arguments)]
    pub fn scan(
        &mut self,
        equations: &Dynamics,
        pieces: &[Segment],
        end: (f64, &[f64]),
        met: Option<Contact>,
        events: &mut [Event],
        out: &mut Vec<Occurrence>,
        patience: &mut Patience,
    ) -> Result<Option<(usize, f64)>> {
        for (k, piece) in pieces.iter().enumerate() {
            patience.spend(SCAN * events.len() as u64, piece.start())?;
            let mut next = std::mem::take(&mut self.next);
            next.resize(end.1.len(), 0.0);
            let here = met.filter(|contact| contact.piece == k);
            let after = match (here, pieces.get(k + 1)) {
                (Some(contact), _) => {
                    piece.at(contact.theta, &mut next);
                    (contact.time, next.as_slice())
                }
                (None, Some(piece)) => {
                    piece.at(0.0, &mut next);
                    (piece.start(), next.as_slice())
                }
                (None, None) => end,
            };
            let stop = self.scan_piece(equations, piece, after, here, events, out)?;
            self.next = next;
            if stop.is_some() || here.is_some() {
                return Ok(stop);
            }
        }
        Ok(None)
    }

    #[allow(clippy::too_many_arguments)]
    fn scan_piece(
        &mut self,
        equations: &Dynamics,
        piece: &Segment,
        after: (f64, &[f64]),
        met: Option<Contact>,
        events: &mut [Event],
        out: &mut Vec<Occurrence>,
    ) -> Result<Option<(usize, f64)>> {
        let end = met.map_or(1.0, |contact| contact.theta);
        let places: [f64; POINTS] = std::array::from_fn(|k| match k {
            0 => 0.0,
            1 => NEAR * end,
            k if k == POINTS - 2 => (1.0 - NEAR) * end,
            k if k == POINTS - 1 => end,
            k => (k - 1) as f64 / SAMPLES as f64 * end,
        });
        for values in &mut self.values {
            values[0] = values[POINTS - 1];
        }
        let first = usize::from(self.begun);
        for k in first..POINTS {
            let (time, y) = if k == POINTS - 1 {
                after
            } else {
                piece.at(places[k], &mut self.y);
                (piece.time_at(places[k]), self.y.as_slice())
            };
            let place = Place { equations, time, y, zeros: &self.zeros };
            for (event, values) in events.iter_mut().zip(&mut self.values) {
                values[k] = checked(event, &place)?;
            }
        }
        self.found.clear();
        let y = &mut self.y;
        for (index, (event, values)) in events.iter_mut().zip(&self.values).enumerate() {
            let wanted = event.condition.direction().unwrap_or(event.direction);
            if let (Condition::Contact { first, second }, Some(contact)) = (&event.condition, &met)
                && contact.is_of(*first, *second)
            {
                // The function falls there, along the run.
                if (wanted == 0 || (wanted > 0) == (piece.size() < 0.0)) && (!self.given || end > AT_GIVEN) {
                    self.found.push((end, index));
                }
                continue;
            }
            let mut f = |theta: f64| {
                piece.at(theta, y);
                let time = piece.time_at(theta);
                checked(event, &Place { equations, time, y, zeros: &self.zeros })
            };
            let along = piece.size().signum();
            let mut take = |a: (f64, f64), b: (f64, f64), f: &mut dyn FnMut(f64) -> Result<f64>| {
                let rising = (b.1 - a.1) * along > 0.0;
                if wanted == 0 || (wanted > 0) == rising {
                    let theta = root(f, a, b)?;
                    if !self.given || theta > AT_GIVEN {
                        self.found.push((theta, index));
                    }
                }
                Ok::<(), Error>(())
            };
            for k in 1..POINTS {
                let (a, b) = ((places[k - 1], values[k - 1]), (places[k], values[k]));
                if a.1 * b.1 < 0.0 || (b.1 == 0.0 && a.1 != 0.0) {
                    take(a, b, &mut f)?;
                }
                if k + 1 == POINTS {
                    continue;
                }
                let c = (places[k + 1], values[k + 1]);
                let sign = b.1.signum();
                let same = a.1 * sign > 0.0 && c.1 * sign > 0.0;
                if same && b.1.abs() < a.1.abs() && b.1.abs() <= c.1.abs() {
                    let (theta, value) = extremum(|theta| f(theta).map(|v| v * sign), a.0, c.0)?;
                    if value < 0.0 {
                        let middle = (theta, value * sign);
                        take(a, middle, &mut f)?;
                        take(middle, c, &mut f)?;
                    }
                }
            }
        }
        (self.begun, self.given) = (true, false);
        self.found.sort_by(|a, b| a.0.total_cmp(&b.0));
        for &(theta, index) in &self.found {
            piece.at(theta, &mut self.y);
            let time = piece.time_at(theta);
            out.push(Occurrence {
                event: index,
                time,
                state: equations.frame().state(time, &self.y, &self.zeros),
            });
            if events[index].terminal {
                return Ok(Some((index, time)));
            }
        }
        Ok(None)
    }

    /// The vector of the last event found.
    pub fn vector(&self) -> &[f64] {
        &self.y
    }
}

fn checked(event: &mut Event, place: &Place) -> Result<f64> {
    let value = event.condition.value(place)?;
    if value.is_finite() {
        return Ok(value);
    }
    // Two points never touch: infinitely far is an answer there.
    if value == f64::INFINITY {
        return Ok(f64::MAX);
    }
    Err(Error::invalid(
        format!("{} at time {}", event.condition.name(), place.time),
        value,
        "a finite number",
    ))
}
