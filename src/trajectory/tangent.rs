//! Departures that follow a run, step by step.

use super::chaos::{INTEGRALS, Parting};
use super::mapped::Mapped;
use super::motion::Motion;
use super::mover::Mover;
use super::record::Trajectory;
use crate::dynamics::{Collocation, Dynamics, Parameter, Parts, State, Variations};
use crate::error::{Error, Result};
use crate::integrate::{Segment, VERNER98};
use crate::patience::Patience;

/// The shortest step of departures, as a fraction of the motion's.
const SHORTEST: f64 = 1e-6;

/// The most by which the logarithm of a departure may grow in one step, for the integrals of it. Beside free motion, whose steps have no
/// bound, a departure grows with the time.
const LONGEST: f64 = 1.0;

/// Numbers that are larger have left the range in which a step can be solved.
const LARGEST: f64 = 1e280;

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
    collocation: Collocation,
    /// The state at which the run began.
    start: State,
    present: Departed,
    /// Vectors of the motion.
    y: [Vec<f64>; 2],
}

/// How far departures have come.
#[derive(Debug, Clone)]
struct Departed {
    time: f64,
    columns: Vec<f64>,
    integrals: [f64; INTEGRALS],
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
            all.push(Tangent::new(variations, None, columns, mover, start));
        }
        if following.chaos {
            let variations = Variations::of_one(equations)?;
            let parting = Parting::new(motion, &variations);
            let column = parting.start();
            all.push(Tangent::new(variations, Some(parting), column, mover, start));
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
        columns: Vec<f64>,
        mover: &Mover,
        start: &State,
    ) -> Self {
        let tableau = mover.tableau().unwrap_or(&VERNER98);
        Self {
            collocation: Collocation::new(&variations, tableau.order),
            variations,
            parting,
            present: Departed { time: start.time, columns, integrals: [0.0; INTEGRALS] },
            start: start.clone(),
            y: Default::default(),
        }
    }

    fn advance(&mut self, motion: &mut Motion, mover: &Mover, patience: &mut Patience) -> Result<()> {
        if mover.fixed().is_some() {
            return self.map(motion, mover, patience);
        }
        self.place(&mut motion.equations, mover.pieces(), mover.time(), patience)
    }

    /// The derivative of the map of a step of fixed size.
    fn map(&mut self, motion: &mut Motion, mover: &Mover, patience: &mut Patience) -> Result<()> {
        let Some((stepper, splitting)) = mover.fixed() else { return Ok(()) };
        let Self { variations, parting, collocation, present, start, .. } = self;
        let before = parting.as_ref().map(|parting| parting.growth(&present.columns));
        let mut mapped = Mapped {
            equations: &mut motion.equations,
            splitting: splitting.clone(),
            variations,
            collocation,
            columns: &mut present.columns,
            time: present.time,
            covered: 0.0,
            known: false,
        };
        stepper.again(&mut mapped, patience)?;
        let now = mover.time();
        if let (Some(parting), Some(before)) = (parting, before) {
            let times = [present.time - start.time, now - start.time];
            let growths = [before, parting.growth(&present.columns)];
            parting.integrate_between(times, growths, &mut present.integrals);
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
        self.present = self.follow(equations, pieces, time, true, patience)?;
        self.settle(time);
        Ok(())
    }

    /// The departures at a time, along these pieces. `keep` says that the next step will begin there.
    fn follow(
        &mut self,
        equations: &mut Dynamics,
        pieces: &[Segment],
        until: f64,
        keep: bool,
        patience: &mut Patience,
    ) -> Result<Departed> {
        equations.prepare_variations(self.present.time, patience)?;
        let mut departed = self.present.clone();
        for piece in pieces {
            let from =
                if departed.time == piece.start() { 0.0 } else { piece.fraction(departed.time).max(0.0) };
            let to = if until == piece.end() { 1.0 } else { piece.fraction(until).min(1.0) };
            if from < to {
                self.step(equations, piece, [from, to], keep, &mut departed, patience)?;
                departed.time = if to < 1.0 { until } else { piece.end() };
            }
        }
        departed.time = until;
        Ok(departed)
    }

    /// Moves departures from a fraction of a piece to another; in shorter steps where the equations of the whole are not solved.
    fn step(
        &mut self,
        equations: &mut Dynamics,
        piece: &Segment,
        [from, to]: [f64; 2],
        keep: bool,
        departed: &mut Departed,
        patience: &mut Patience,
    ) -> Result<()> {
        let Self { variations, parting, collocation, start, y: [y, end], .. } = self;
        y.resize(equations.layout().dimension(), 0.0);
        end.resize(equations.layout().dimension(), 0.0);
        let (first, mut from, mut length) = (from, from, to - from);
        while from < to {
            let next = if from + 1.5 * length < to { from + length } else { to };
            let (time, size) = (piece.time_at(from), (next - from) * piece.size());
            for node in 0..collocation.gauss().nodes.len() {
                let fraction = from + collocation.gauss().nodes[node] * (next - from);
                piece.at(fraction, y);
                patience.spend(variations.work(equations), time)?;
                variations.look(equations, piece.time_at(fraction), y)?;
                collocation.take(node, equations, variations, y);
            }
            piece.at(from, y);
            piece.at(next, end);
            collocation.between(equations, variations, [y, end]);
            let follows = keep || from == first;
            if !collocation.solve(equations, [time, size], &departed.columns, follows, patience)? {
                if departed.columns.iter().any(|number| number.is_nan() || number.abs() > LARGEST) {
                    departed.columns.fill(f64::NAN);
                    return Ok(());
                }
                length = 0.5 * (next - from);
                if length < SHORTEST {
                    return Err(Error::NotConverged {
                        what: format!("the equations of departures at time {time}"),
                        detail: format!(
                            "they change too fast even for a step of {:e}",
                            length * piece.size()
                        ),
                    });
                }
                continue;
            }
            if let Some(parting) = parting {
                let growth = |node| parting.growth(collocation.at_node(node));
                let ends = [&departed.columns, collocation.reached()].map(|columns| parting.growth(columns));
                if (ends[1] - ends[0]).abs() > LONGEST && 0.5 * (next - from) >= SHORTEST {
                    length = 0.5 * (next - from);
                    continue;
                }
                let step = [time - start.time, size];
                parting.integrate(collocation.gauss(), step, growth, &mut departed.integrals);
                length *= 2.0;
            }
            departed.columns.copy_from_slice(collocation.reached());
            if keep {
                collocation.remember(size);
            }
            from = next;
        }
        Ok(())
    }

    fn settle(&mut self, time: f64) {
        self.present.time = time;
        if let Some(parting) = &mut self.parting
            && parting.settle(&mut self.present.columns)
        {
            self.collocation.forget();
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
        let Departed { columns, integrals, .. } = if state.time == self.present.time {
            self.present.clone()
        } else {
            self.follow(equations, pieces, state.time, false, patience)?
        };
        if let Some(parting) = &self.parting {
            record.chaos.extend(parting.indicators(state.time - self.start.time, &columns, integrals));
            return Ok(());
        }
        if !columns.iter().all(|number| number.is_finite()) {
            return Err(Error::NotConverged {
                what: format!("the transition matrix at time {}", state.time),
                detail:
                    "its numbers leave the range of doubles; ask for chaos alone, or begin anew on the way"
                        .to_owned(),
            });
        }
        let (transition, sensitivity) = self.variations.expand(&columns, &self.start, state);
        record.transition.extend(transition);
        record.sensitivity.extend(sensitivity);
        Ok(())
    }
}
