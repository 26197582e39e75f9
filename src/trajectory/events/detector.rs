//! The detection of events in the pieces of a step.

use super::condition::EvaluationPoint;
use super::{Condition, Event, Occurrence};
use crate::dynamics::Dynamics;
use crate::error::{Error, Result};
use crate::integrate::{SAMPLES, Segment, direction_matches, sample_fractions, zeros};
use crate::interrupt::InterruptCheck;
use crate::trajectory::approach::Contact;

/// A zero this close to a state that was set, as a fraction of the step, belongs to that state and is no event.
const NO_EVENT_WITHIN: f64 = 1e-9;

/// The units of work of searching a piece for one event.
const SCAN: u64 = 200;

/// The search for events along a run.
pub(crate) struct EventDetector {
    values: Vec<[f64; SAMPLES]>,
    /// Whether the last values are those at the start of the next piece.
    has_values: bool,
    /// Whether the next piece starts from a state that was set, and not from one that a step has reached.
    state_was_set: bool,
    y: Vec<f64>,
    /// The vector at the start of the piece after the present one.
    next: Vec<f64>,
    zeros: Vec<f64>,
    /// The fractions of the present piece at which events occur, with the indices of the events.
    event_zeros: Vec<(f64, usize)>,
}

impl EventDetector {
    /// Returns an error for events that the system cannot have. `state_was_set` says whether the run
    /// starts from a state that was set.
    pub fn new(equations: &Dynamics, events: &[Event], state_was_set: bool) -> Result<Self> {
        for event in events {
            event.condition.check(equations)?;
            let name = event.condition.name();
            let prescribed = event.condition.direction();
            let fits = match prescribed {
                Some(prescribed) => event.direction == 0 || event.direction == prescribed,
                None => (-1..=1).contains(&event.direction),
            };
            if !fits {
                let expected =
                    prescribed.map_or("-1, 0 or 1".to_owned(), |prescribed| format!("0 or {prescribed}"));
                return Err(Error::invalid(format!("direction of {name}"), event.direction, expected));
            }
        }
        let dimension = equations.layout().dimension();
        Ok(Self {
            values: vec![[0.0; SAMPLES]; events.len()],
            has_values: false,
            state_was_set,
            y: vec![0.0; dimension],
            next: vec![0.0; dimension],
            zeros: vec![0.0; dimension],
            event_zeros: Vec::new(),
        })
    }

    /// Appends the events within a step that ends with the time and vector `end`, in the order of the run, up
    /// to and including the first terminal one, whose index and time are returned. The step consists of the
    /// first list of pieces; the second one is all that is known of the continuous solution.
    ///
    /// At the ends of the pieces the functions are evaluated at the vectors through which the steps
    /// themselves pass. The values there are the same for the piece before and the piece after, and for a run
    /// that begins there: no zero is found twice, and none is lost. Where bodies touch the step ends, and
    /// their contact is an event at exactly that time.
    #[allow(clippy::too_many_arguments)]
    pub fn scan(
        &mut self,
        equations: &Dynamics,
        (pieces, known_pieces): (&[Segment], &[Segment]),
        end: (f64, &[f64]),
        contact: Option<Contact>,
        events: &mut [Event],
        out: &mut Vec<Occurrence>,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<(usize, f64)>> {
        for (k, piece) in pieces.iter().enumerate() {
            let work: u64 = events.iter().map(|event| SCAN * event.condition.weight()).sum();
            interrupt.charge(work, piece.start())?;
            let mut next = std::mem::take(&mut self.next);
            next.resize(end.1.len(), 0.0);
            let touch = contact.filter(|contact| contact.piece == k);
            let piece_end = match (touch, pieces.get(k + 1)) {
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
            let piece = (piece, known_pieces);
            let stop = self.scan_piece(equations, piece, piece_end, touch, events, out, interrupt)?;
            self.next = next;
            if stop.is_some() || touch.is_some() {
                return Ok(stop);
            }
        }
        Ok(None)
    }

    /// Appends the events within one piece; see [`Self::scan`].
    #[allow(clippy::too_many_arguments)]
    fn scan_piece(
        &mut self,
        equations: &Dynamics,
        (piece, known_pieces): (&Segment, &[Segment]),
        piece_end: (f64, &[f64]),
        contact: Option<Contact>,
        events: &mut [Event],
        out: &mut Vec<Occurrence>,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<(usize, f64)>> {
        let fractions = sample_fractions(contact.map_or(1.0, |contact| contact.theta));
        self.sample(equations, (piece, known_pieces), &fractions, piece_end, events, interrupt)?;
        self.find_zeros(equations, (piece, known_pieces), &fractions, contact, events, interrupt)?;
        (self.has_values, self.state_was_set) = (true, false);
        for &(theta, index) in &self.event_zeros {
            piece.at(theta, &mut self.y);
            let time = piece.time_at(theta);
            out.push(Occurrence {
                event: index,
                time,
                state: equations.frame().state(time, &self.y, &self.zeros),
                derivatives: None,
            });
            if events[index].terminal {
                return Ok(Some((index, time)));
            }
        }
        Ok(None)
    }

    /// Evaluates the functions at fractions of a piece; at the last fraction they are evaluated at the time
    /// and vector `piece_end`.
    fn sample(
        &mut self,
        equations: &Dynamics,
        (piece, pieces): (&Segment, &[Segment]),
        fractions: &[f64; SAMPLES],
        piece_end: (f64, &[f64]),
        events: &mut [Event],
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        for values in &mut self.values {
            values[0] = values[SAMPLES - 1];
        }
        for k in usize::from(self.has_values)..SAMPLES {
            let (time, y) = if k == SAMPLES - 1 {
                piece_end
            } else {
                piece.at(fractions[k], &mut self.y);
                (piece.time_at(fractions[k]), self.y.as_slice())
            };
            let point = EvaluationPoint { equations, time, y, zeros: &self.zeros, pieces };
            for (event, values) in events.iter_mut().zip(&mut self.values) {
                values[k] = checked(event, &point, interrupt)?;
            }
        }
        Ok(())
    }

    /// Finds the zeros that count between the samples of a piece, in the order of the run.
    fn find_zeros(
        &mut self,
        equations: &Dynamics,
        (piece, pieces): (&Segment, &[Segment]),
        fractions: &[f64; SAMPLES],
        contact: Option<Contact>,
        events: &mut [Event],
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let Self { values, state_was_set, y, zeros: low, event_zeros, .. } = self;
        let (end, forward) = (fractions[SAMPLES - 1], piece.size() > 0.0);
        event_zeros.clear();
        let mut take = |theta: f64, index: usize| {
            if !*state_was_set || theta > NO_EVENT_WITHIN {
                event_zeros.push((theta, index));
            }
        };
        for (index, (event, values)) in events.iter_mut().zip(values).enumerate() {
            let direction = event.condition.direction().unwrap_or(event.direction);
            if let (Condition::Contact { first, second }, Some(contact)) = (&event.condition, &contact)
                && contact.is_of(*first, *second)
            {
                // The function of a contact falls along the run.
                if direction_matches(direction, !forward) {
                    take(end, index);
                }
                continue;
            }
            let steepness = event.condition.steepness(equations, piece);
            let f = |theta: f64| {
                piece.at(theta, y);
                let time = piece.time_at(theta);
                checked(event, &EvaluationPoint { equations, time, y, zeros: low, pieces }, interrupt)
            };
            let accepts = |rises: bool| direction_matches(direction, rises == forward);
            zeros(fractions, values, steepness, f, accepts, |theta, _| take(theta, index))?;
        }
        self.event_zeros.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(())
    }

    /// Returns the vector of the last event found.
    pub fn vector(&self) -> &[f64] {
        &self.y
    }
}

/// Evaluates the function of an event, or returns an error for a value that is not a number.
fn checked(event: &mut Event, point: &EvaluationPoint, interrupt: &mut InterruptCheck) -> Result<f64> {
    let value = event.condition.value(point, interrupt)?;
    if value.is_finite() {
        return Ok(value);
    }
    // The growth of two points is infinite, since they never touch; it counts as a large number.
    if value == f64::INFINITY {
        return Ok(f64::MAX);
    }
    Err(Error::invalid(
        format!("{} at time {}", event.condition.name(), point.time),
        value,
        "a finite number",
    ))
}
