//! The continuous solution of a run.

use crate::dynamics::{BarycentricFrame, State, SteadyRotation};
use crate::error::{Error, Result};
use crate::integrate::{MAX_TERMS, Segment};
use crate::interrupt::InterruptCheck;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// The largest rotation angle in one of the polynomials of a closed form, in rad, for which they keep all
/// digits.
const PIECE: f64 = 2.0;

/// The solution at any time of a run.
///
/// It keeps one polynomial for each step: 8 (terms + 2) bytes for every number of the integrator's vector (13
/// for a body), where there are as many terms as the interpolant's order. For two bodies under Verner 9(8)
/// that is 2.3 kB for a step. Where the motion has a closed form, that is stored instead, and polynomials are
/// computed when they are requested.
///
/// ```
/// use fullbody::dynamics::{Settings, State, System};
/// use fullbody::integrate::Tolerance;
/// use fullbody::math::Vec3;
/// use fullbody::shape::{Body, Shape};
/// use fullbody::trajectory::{Integrator, Output, Run, Simulation, Trajectory};
/// use std::ops::ControlFlow;
///
/// // Two points, half a revolution from their apoapsis to their periapsis.
/// let point = |name| Body::with_mass(name, Shape::Point, 0.5);
/// let system = System::new(vec![point("One")?, point("Two")?], 1.0, Settings::default())?;
/// let two = |vector: Vec3| vec![-vector, vector];
/// let (rest, upright) = (vec![Vec3::zeros(); 2], vec![[1.0, 0.0, 0.0, 0.0]; 2]);
/// let state = State::new(0.0, two(0.75 * Vec3::x()), two(Vec3::y() / 12.0_f64.sqrt()), upright, rest)?;
/// let integrator = Integrator::Verner98(Tolerance::new(1e-13, 1e-13)?);
/// let mut simulation = Simulation::new(&system, &state, integrator)?;
/// let mut record = Trajectory::new(2);
/// let run = Run { dense: true, ..Run::new(&Output::Ends) };
/// simulation.run(10.0, run, &mut record, &mut |_, _| ControlFlow::Continue(()))?;
/// let at = record.dense.expect("it was asked for").state(std::f64::consts::PI)?;
/// assert!((at.position()[1] + 0.25 * Vec3::x()).norm() < 1e-11);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Dense {
    frame: BarycentricFrame,
    segments: Vec<Segment>,
    closed_form: Option<SteadyRotation>,
    /// The polynomials of the closed form, once they have been requested.
    closed_form_pieces: OnceLock<Vec<Segment>>,
    start: f64,
    end: f64,
    /// The state at the end.
    last: State,
}

impl Dense {
    /// Starts with a solution of no length, at a state.
    pub(super) fn new(frame: &BarycentricFrame, state: State) -> Self {
        Self {
            frame: *frame,
            segments: Vec::new(),
            closed_form: None,
            closed_form_pieces: OnceLock::new(),
            start: state.time,
            end: state.time,
            last: state,
        }
    }

    /// Makes this the solution in closed form that ends in a state.
    pub(super) fn set_closed_form(&mut self, rotation: SteadyRotation, last: State) {
        self.end = last.time;
        self.last = last;
        self.closed_form = Some(rotation);
    }

    /// Appends a step, or the part of it before a terminal event, which ends in a state.
    pub(super) fn extend(&mut self, pieces: &[Segment], last: State) {
        let within = pieces.iter().filter(|piece| (piece.start() < last.time) == (self.start < last.time));
        self.segments.extend(within.cloned());
        self.end = last.time;
        self.last = last;
    }

    /// Returns the first and the last time, in the direction of the run.
    pub fn range(&self) -> (f64, f64) {
        (self.start, self.end)
    }

    /// Returns the polynomials, one after the other in the direction of the run.
    #[doc(hidden)]
    pub fn pieces(&self) -> &[Segment] {
        match &self.closed_form {
            Some(rotation) => self.closed_form_pieces.get_or_init(|| self.polynomials(rotation)),
            None => &self.segments,
        }
    }

    /// Returns the polynomials through a closed form at Chebyshev nodes.
    fn polynomials(&self, rotation: &SteadyRotation) -> Vec<Segment> {
        let (layout, dimension) = (self.frame.layout, self.frame.layout.dimension());
        let count = (rotation.angle(self.end).abs() / PIECE).ceil().max(1.0);
        let at = |time: f64| {
            let mut y = vec![0.0; dimension];
            layout.write_rotation(&rotation.state(time), &mut y);
            y
        };
        let angles: Vec<f64> = (0..MAX_TERMS).map(|k| (k as f64 + 0.5) * PI / MAX_TERMS as f64).collect();
        let knot = |k: f64| self.start + (self.end - self.start) * (k / count);
        let piece = |k: u64| {
            let (start, size) = (knot(k as f64), knot(k as f64 + 1.0) - knot(k as f64));
            let first = at(start);
            let rates: Vec<Vec<f64>> = (angles.iter())
                .map(|angle| 0.5 * (1.0 + angle.cos()) * size)
                .map(|since| at(start + since).iter().zip(&first).map(|(y, y0)| (y - y0) / since).collect())
                .collect();
            let mut segment = Segment::new(dimension, MAX_TERMS);
            segment.refill((start, size), (&first, &vec![0.0; dimension]), |order, index| {
                let cosine = |angle: &f64| (order as f64 * angle).cos();
                let sum: f64 =
                    angles.iter().zip(&rates).map(|(angle, rate)| cosine(angle) * rate[index]).sum();
                sum * if order == 0 { 1.0 } else { 2.0 } / MAX_TERMS as f64
            });
            segment
        };
        (0..count as u64).map(piece).collect()
    }

    /// Returns the frame of the polynomials.
    #[doc(hidden)]
    pub fn frame(&self) -> &BarycentricFrame {
        &self.frame
    }

    /// Returns the number of polynomials.
    pub fn segments(&self) -> usize {
        self.pieces().len()
    }

    /// Returns the memory of the polynomials, in bytes.
    pub fn bytes(&self) -> usize {
        self.segments
            .iter()
            .chain(self.closed_form_pieces.get().into_iter().flatten())
            .map(Segment::bytes)
            .sum()
    }

    /// Returns the state at a time of the run.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a time that the run does not cover.
    pub fn state(&self, time: f64) -> Result<State> {
        let (low, high) = (self.start.min(self.end), self.start.max(self.end));
        if !(low..=high).contains(&time) {
            return Err(Error::invalid(
                "time",
                time,
                format!("one from {low} to {high}, which the run covers"),
            ));
        }
        if time == self.end {
            return Ok(self.last.clone());
        }
        if let Some(rotation) = &self.closed_form {
            return Ok(rotation.state(time));
        }
        let segment = piece_at(&self.segments, time, self.end > self.start);
        let mut y = vec![0.0; self.frame.layout.dimension()];
        Ok(state_within(&self.frame, segment, time, &mut y))
    }

    /// Returns the states at many times, in any order.
    ///
    /// # Errors
    /// Returns the errors of [`Self::state`], and [`Error::Interrupted`].
    pub fn states(&self, times: &[f64], interrupt: &mut InterruptCheck) -> Result<Vec<State>> {
        let state = |&time: &f64| {
            interrupt.charge(self.frame.layout.dimension() as u64, time)?;
            self.state(time)
        };
        times.iter().map(state).collect()
    }
}

/// Returns the polynomial that holds a time, from pieces that follow each other forwards or backwards.
pub(super) fn piece_at(pieces: &[Segment], time: f64, forward: bool) -> &Segment {
    let begun = pieces.partition_point(|p| if forward { p.start() <= time } else { p.start() >= time });
    &pieces[begun.saturating_sub(1)]
}

/// Returns the state at a time within a piece, and writes its vector into `y`. Where the piece begins, it is
/// the state of the step itself.
pub(super) fn state_within(frame: &BarycentricFrame, piece: &Segment, time: f64, y: &mut [f64]) -> State {
    piece.at(piece.fraction(time), y);
    if time == piece.start() {
        let (high, low) = piece.start_vector();
        return frame.state(time, high, low);
    }
    frame.state(time, y, &vec![0.0; y.len()])
}
