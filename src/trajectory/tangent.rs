//! Departures that follow a run, step by step.

use super::chaos::{INTEGRALS, Parting};
use super::dense::piece_at;
use super::mapped::Mapped;
use super::motion::Motion;
use super::mover::Mover;
use super::record::Trajectory;
use crate::dynamics::{Dynamics, Parameter, Parts, State, Variations};
use crate::error::{Error, Result};
use crate::integrate::{Linear, Segment, VERNER98};
use crate::patience::Patience;

/// What is followed beside a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Following {
    /// The parameters by which the run is differentiated beside its start, where it is.
    pub derivatives: Option<Vec<Parameter>>,
    /// Whether its chaos is measured.
    pub chaos: bool,
}

/// All that follows a run.
#[derive(Debug, Clone)]
pub(super) struct Tangents(Vec<Tangent>);

/// Departures from a run: all of them, or one whose growth is measured.
#[derive(Debug, Clone)]
struct Tangent {
    variations: Variations,
    parting: Option<Parting>,
    linear: Linear,
    /// The state at which the run began.
    start: State,
    /// Where the departures are.
    time: f64,
    y: Vec<f64>,
}

impl Tangents {
    /// At the start of a run.
    pub fn new(following: &Following, motion: &Motion, mover: &Mover, start: &State) -> Result<Self> {
        let equations = &motion.equations;
        let mut all = Vec::new();
        if let Some(parameters) = &following.derivatives {
            let jacobi = mover.fixed().is_some_and(|(_, splitting)| splitting.parts() == Parts::Kepler);
            let masses = parameters.iter().any(|parameter| parameter.is_mass());
            if jacobi && masses && start.bodies() > 2 {
                let found = "by a mass, of three bodies and more in Jacobi's coordinates";
                let expected = "Verner98 for it, whose coordinates do not change with the masses";
                return Err(Error::invalid("derivatives", found, expected));
            }
            let variations = Variations::new(equations, parameters.clone())?;
            let columns = variations.start();
            all.push(Tangent::new(variations, None, columns, motion, mover, start));
        }
        if following.chaos {
            let variations = Variations::of_one(equations)?;
            let parting = Parting::new(motion, &variations);
            let column = parting.start();
            all.push(Tangent::new(variations, Some(parting), column, motion, mover, start));
        }
        Ok(Self(all))
    }

    /// Takes the step that the run has taken from where the departures are.
    pub fn advance(&mut self, motion: &mut Motion, mover: &Mover, patience: &mut Patience) -> Result<()> {
        self.0.iter_mut().try_for_each(|tangent| tangent.advance(motion, mover, patience))
    }

    /// Moves to a time within the last step, along its pieces.
    pub fn place(
        &mut self,
        motion: &mut Motion,
        pieces: &[Segment],
        time: f64,
        patience: &mut Patience,
    ) -> Result<()> {
        self.0.iter_mut().try_for_each(|tangent| tangent.place(&mut motion.equations, pieces, time, patience))
    }

    /// Records what belongs to a state of the run: where the departures are, or in the step that follows, of these pieces.
    pub fn record(
        &mut self,
        motion: &mut Motion,
        pieces: &[Segment],
        state: &State,
        record: &mut Trajectory,
        patience: &mut Patience,
    ) -> Result<()> {
        for tangent in &mut self.0 {
            tangent.record(&mut motion.equations, pieces, state, record, patience)?;
        }
        Ok(())
    }
}

impl Tangent {
    fn new(
        variations: Variations,
        parting: Option<Parting>,
        vector: Vec<f64>,
        motion: &Motion,
        mover: &Mover,
        start: &State,
    ) -> Self {
        let arch = motion.equations.system().arch();
        Self {
            linear: Linear::new(mover.tableau().unwrap_or(&VERNER98), arch, vector),
            variations,
            parting,
            time: start.time,
            start: start.clone(),
            y: vec![0.0; motion.equations.layout().dimension()],
        }
    }

    fn advance(&mut self, motion: &mut Motion, mover: &Mover, patience: &mut Patience) -> Result<()> {
        let Some(step) = mover.last() else { return self.map(motion, mover, patience) };
        self.step(&mut motion.equations, step.size, true, patience, |stage, _, y| step.stage(stage, y))?;
        self.settle(mover.time());
        Ok(())
    }

    /// The derivative of the map of a step of fixed size.
    fn map(&mut self, motion: &mut Motion, mover: &Mover, patience: &mut Patience) -> Result<()> {
        let Some((stepper, splitting)) = mover.fixed() else { return Ok(()) };
        let Self { variations, parting, linear, .. } = self;
        let count = linear.vector().len() - if parting.is_some() { INTEGRALS } else { 0 };
        let before = linear.vector().to_vec();
        let mut mapped = Mapped {
            equations: &mut motion.equations,
            splitting: splitting.clone(),
            variations,
            linear,
            count,
            time: self.time,
            covered: 0.0,
            known: false,
            scratch: vec![0.0; count],
        };
        stepper.again(&mut mapped, patience)?;
        let now = mover.time();
        if let Some(parting) = parting {
            let times = [self.time - self.start.time, now - self.start.time];
            parting.integrate(times, &before, linear.vector_mut());
        }
        self.settle(now);
        Ok(())
    }

    fn place(
        &mut self,
        equations: &mut Dynamics,
        pieces: &[Segment],
        time: f64,
        patience: &mut Patience,
    ) -> Result<()> {
        let forward = time >= self.time;
        self.step(equations, time - self.time, true, patience, |_, at, y| within(pieces, at, forward, y))?;
        self.settle(time);
        Ok(())
    }

    /// A step from where the departures are, with the vectors of the motion at its stages; the last one reached.
    fn step(
        &mut self,
        equations: &mut Dynamics,
        size: f64,
        keep: bool,
        patience: &mut Patience,
        motion: impl Fn(usize, f64, &mut [f64]),
    ) -> Result<&[f64]> {
        let Self { variations, parting, linear, start, time, y } = self;
        let (time, since) = (*time, *time - start.time);
        equations.prepare_variations(time, patience)?;
        let arch = equations.system().arch();
        linear.step(size, keep, |stage, fraction, columns, rates| {
            patience.spend(variations.work(equations), time)?;
            let at = time + fraction * size;
            motion(stage, at, y);
            variations.look(equations, at, y)?;
            let count = columns.len() - if parting.is_some() { INTEGRALS } else { 0 };
            variations.rates(arch, &columns[..count], &mut rates[..count]);
            if let Some(parting) = parting {
                parting.integrals(since + fraction * size, columns, rates);
            }
            Ok(())
        })
    }

    fn settle(&mut self, time: f64) {
        self.time = time;
        if let Some(parting) = &mut self.parting {
            parting.settle(self.linear.vector_mut());
        }
    }

    fn record(
        &mut self,
        equations: &mut Dynamics,
        pieces: &[Segment],
        state: &State,
        record: &mut Trajectory,
        patience: &mut Patience,
    ) -> Result<()> {
        let vector = if state.time == self.time {
            self.linear.vector().to_vec()
        } else {
            let (size, forward) = (state.time - self.time, state.time >= self.time);
            self.step(equations, size, false, patience, |_, at, y| within(pieces, at, forward, y))?.to_vec()
        };
        if let Some(parting) = &self.parting {
            record.chaos.extend(parting.indicators(state.time - self.start.time, &vector));
            return Ok(());
        }
        if !vector.iter().all(|number| number.is_finite()) {
            return Err(Error::NotConverged {
                what: format!("the transition matrix at time {}", state.time),
                detail:
                    "its numbers leave the range of doubles; ask for chaos alone, or begin anew on the way"
                        .to_owned(),
            });
        }
        let (transition, sensitivity) = self.variations.expand(&vector, &self.start, state);
        record.transition.extend(transition);
        record.sensitivity.extend(sensitivity);
        Ok(())
    }
}

/// The motion at a time within pieces.
fn within(pieces: &[Segment], at: f64, forward: bool, y: &mut [f64]) {
    let piece = piece_at(pieces, at, forward);
    piece.at(piece.fraction(at), y);
}
