//! How a run depends on its start and on parameters: departures that follow it.

use super::dense::piece_at;
use super::motion::Motion;
use super::mover::Mover;
use crate::dynamics::{Dynamics, Parameter, State, Variations};
use crate::error::Result;
use crate::integrate::{Linear, Segment, VERNER98};
use crate::patience::Patience;

/// Departures from a run, step by step.
#[derive(Debug, Clone)]
pub(super) struct Tangent {
    variations: Variations,
    linear: Linear,
    /// The state at which the run began.
    start: State,
    /// Where the departures are.
    time: f64,
    y: Vec<f64>,
}

impl Tangent {
    /// At the start of a run.
    pub fn new(motion: &Motion, mover: &Mover, parameters: &[Parameter], start: State) -> Self {
        let variations = Variations::new(&motion.equations, parameters.to_vec());
        let arch = motion.equations.system().arch();
        let tableau = mover.tableau().unwrap_or(&VERNER98);
        Self {
            linear: Linear::new(tableau, arch, variations.start()),
            variations,
            time: start.time,
            start,
            y: vec![0.0; motion.equations.layout().dimension()],
        }
    }

    /// Takes the step that the run has taken from where the departures are.
    pub fn advance(&mut self, motion: &mut Motion, mover: &Mover, patience: &mut Patience) -> Result<()> {
        match mover.last() {
            Some(step) => {
                let y = &mut self.y;
                let equations = &mut motion.equations;
                equations.prepare_variations(step.time, patience)?;
                let variations = &mut self.variations;
                let arch = equations.system().arch();
                self.linear.step(step.size, true, |stage, fraction, columns, rates| {
                    patience.spend(variations.work(equations), step.time)?;
                    step.stage(stage, y);
                    variations.look(equations, step.time + fraction * step.size, y)?;
                    variations.rates(arch, columns, rates);
                    Ok(())
                })?;
            }
            None => {
                self.along(&mut motion.equations, mover.pieces(), mover.time(), true, patience).map(drop)?
            }
        }
        self.time = mover.time();
        Ok(())
    }

    /// Moves to a time within the last step, along its pieces.
    pub fn place(
        &mut self,
        motion: &mut Motion,
        pieces: &[Segment],
        time: f64,
        patience: &mut Patience,
    ) -> Result<()> {
        self.along(&mut motion.equations, pieces, time, true, patience)?;
        self.time = time;
        Ok(())
    }

    /// Transition matrix and sensitivities at a state of the run: where the departures are, or in the step that follows, of these
    /// pieces.
    pub fn at(
        &mut self,
        motion: &mut Motion,
        pieces: &[Segment],
        state: &State,
        patience: &mut Patience,
    ) -> Result<(Vec<f64>, Vec<f64>)> {
        let columns = if state.time == self.time {
            self.linear.vector().to_vec()
        } else {
            self.along(&mut motion.equations, pieces, state.time, false, patience)?
        };
        Ok(self.variations.expand(&columns, &self.start, state))
    }

    fn along(
        &mut self,
        equations: &mut Dynamics,
        pieces: &[Segment],
        time: f64,
        keep: bool,
        patience: &mut Patience,
    ) -> Result<Vec<f64>> {
        let (start, size) = (self.time, time - self.time);
        equations.prepare_variations(start, patience)?;
        let (variations, y) = (&mut self.variations, &mut self.y);
        let arch = equations.system().arch();
        let reached = self.linear.step(size, keep, |_, fraction, columns, rates| {
            patience.spend(variations.work(equations), start)?;
            let at = start + fraction * size;
            let piece = piece_at(pieces, at, size >= 0.0);
            piece.at(piece.fraction(at), y);
            variations.look(equations, at, y)?;
            variations.rates(arch, columns, rates);
            Ok(())
        })?;
        Ok(reached.to_vec())
    }
}
