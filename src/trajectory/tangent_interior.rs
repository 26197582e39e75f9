//! Tangent vectors at times within a step of the motion, as polynomials that all times in the step share.

use super::tangent_step::{LARGEST, LastStep, SHORTEST, load_nodes, too_fast};
use crate::dynamics::{Collocation, Variations};
use crate::error::Result;

/// The shortest part of a step that is divided until the tangent vectors in it are polynomials up to rounding.
const SHORTEST_RESOLVED: f64 = 1.0 / 16.0;

/// The solution of the variational equations over a part of the motion's last step.
#[derive(Debug, Clone)]
pub(super) struct TangentInterior {
    collocation: Collocation,
    /// The part that is solved.
    part: Option<Part>,
    /// The length of a part, as a fraction of a piece, at which polynomials suffice.
    length: f64,
    /// The tangent vectors at the time that was asked for last.
    columns: Vec<f64>,
    y: [Vec<f64>; 2],
}

/// A part of a piece of the motion's step: the index of the piece, the fractions of it at the start and at the
/// end of the part, and the time at the end.
#[derive(Debug, Clone, Copy)]
struct Part {
    piece: usize,
    from: f64,
    to: f64,
    end: f64,
}

impl TangentInterior {
    /// Prepares solutions that have at least the given order.
    pub fn new(variations: &Variations, order: u32) -> Self {
        let collocation = Collocation::interior(variations, order);
        Self {
            columns: collocation.end_columns().to_vec(),
            collocation,
            part: None,
            length: 1.0,
            y: Default::default(),
        }
    }

    /// Forgets the part that is solved, because the tangent vectors at the start of the step have changed.
    pub fn forget(&mut self) {
        self.part = None;
        self.collocation.forget();
    }

    /// Returns the tangent vectors at a time in the last step, at whose start they are `start` at a time. Numbers
    /// are not finite where they leave the range of doubles.
    pub fn at(
        &mut self,
        variations: &mut Variations,
        step: &mut LastStep,
        start: (f64, &[f64]),
        time: f64,
    ) -> Result<&[f64]> {
        let before = |part: &Part| step.pieces[part.piece].fraction(time) < part.from;
        if self.part.as_ref().is_some_and(before) {
            self.forget();
        }
        loop {
            if let Some(part) = self.part {
                let piece = &step.pieces[part.piece];
                let fraction = piece.fraction(time);
                if time == part.end || fraction <= part.to {
                    let y = &mut self.y[0];
                    piece.at(fraction, y);
                    let within = (fraction - part.from) / (part.to - part.from);
                    let size = (part.to - part.from) * piece.size();
                    self.collocation.within(step.equations, (within, size), y, &mut self.columns);
                    return Ok(&self.columns);
                }
            }
            if !self.solve_next(variations, step, start)? {
                self.columns.fill(f64::NAN);
                return Ok(&self.columns);
            }
        }
    }

    /// Solves the part that follows the present one, or the first one. Returns whether the numbers are in the
    /// range of doubles.
    fn solve_next(
        &mut self,
        variations: &mut Variations,
        step: &mut LastStep,
        (begin, start): (f64, &[f64]),
    ) -> Result<bool> {
        let LastStep { equations, pieces, interrupt } = step;
        let Self { collocation, part, length, columns, y: [y, end] } = self;
        y.resize(equations.layout().dimension(), 0.0);
        end.resize(equations.layout().dimension(), 0.0);
        let (index, from) = match part {
            Some(part) if part.to < 1.0 => (part.piece, part.to),
            Some(part) => (part.piece + 1, 0.0),
            None => {
                let fraction = |index: usize| pieces[index].fraction(begin).max(0.0);
                let index =
                    (0..pieces.len()).find(|&index| fraction(index) < 1.0).unwrap_or(pieces.len() - 1);
                pieces[index].at(fraction(index), y);
                equations.prepare_variations(variations, begin, y, interrupt)?;
                (index, fraction(index))
            }
        };
        match part {
            Some(part) => {
                collocation.remember((part.to - part.from) * pieces[part.piece].size());
                columns.copy_from_slice(collocation.end_columns());
            }
            None => {
                *length = (2.0 * *length).min(1.0);
                columns.copy_from_slice(start);
            }
        }
        let piece = &pieces[index];
        loop {
            let to = if from + 1.5 * *length < 1.0 { from + *length } else { 1.0 };
            let ends = [from, to];
            let (time, size) = (piece.time_at(from), (to - from) * piece.size());
            load_nodes(collocation, variations, equations, (piece, ends), [y, end], interrupt)?;
            let solved = collocation.solve(equations, [time, size], columns, part.is_some(), interrupt)?;
            let half = 0.5 * (to - from);
            if solved && (half < SHORTEST_RESOLVED || collocation.is_resolved(size)) {
                *part = Some(Part { piece: index, from, to, end: piece.time_at(to) });
                return Ok(true);
            }
            if columns.iter().any(|number| number.is_nan() || number.abs() > LARGEST) {
                return Ok(false);
            }
            if half < SHORTEST {
                return Err(too_fast(time, half * piece.size()));
            }
            *length = half;
        }
    }
}
