//! Tangent vectors of a run, integrated step by step.

use super::chaos::{INTEGRALS, TangentGrowth};
use super::events::StateDerivatives;
use super::motion::Motion;
use super::propagator::Propagator;
use super::record::Trajectory;
use super::tangent_interior::TangentInterior;
use super::tangent_map::StepTangentMap;
use super::tangent_step::{LARGEST, LastStep, SHORTEST, load_nodes, too_fast};
use crate::dynamics::{
    Collocation, DriftKind, Dynamics, NominalChange, Parameter, State, SteadyRotation, Variations,
};
use crate::error::{Error, Result};
use crate::forces::SwitchJump;
use crate::integrate::{Segment, VERNER98};
use crate::interrupt::InterruptCheck;

/// The largest growth of the logarithm of a tangent vector in one step, for its integrals. Beside free
/// motion, whose steps are not bounded, a tangent vector grows with time.
const LONGEST: f64 = 1.0;

/// The derivatives and chaos indicators that are computed beside a run.
///
/// ```
/// use fullbody::dynamics::Parameter;
/// use fullbody::trajectory::TangentOptions;
///
/// let transition = TangentOptions::derivatives(vec![]);
/// let with_masses = TangentOptions::derivatives(vec![Parameter::Mass(0), Parameter::Mass(1)]);
/// assert_ne!(transition, TangentOptions::default());
/// # assert_ne!(transition, with_masses);
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TangentOptions {
    /// The parameters whose sensitivities are computed in addition to the transition matrix; `None` where no
    /// derivatives are computed.
    pub derivatives: Option<Vec<Parameter>>,
    /// Whether the chaos indicators (MEGNO and Lyapunov exponents) are computed.
    pub chaos: bool,
}

impl TangentOptions {
    /// The options that ask for neither derivatives nor chaos indicators.
    pub(super) const NONE: Self = Self { derivatives: None, chaos: false };

    /// Makes the options that ask for the transition matrix and for the sensitivities to these parameters, if
    /// there are any.
    pub fn derivatives(parameters: Vec<Parameter>) -> Self {
        Self { derivatives: Some(parameters), chaos: false }
    }
}

/// All tangent vectors of a run.
#[derive(Debug, Clone)]
pub(super) struct Tangents(Vec<Tangent>);

/// A set of tangent vectors: the full matrix, or one vector whose growth is measured.
#[derive(Debug, Clone)]
struct Tangent {
    variations: Variations,
    growth_monitor: Option<TangentGrowth>,
    collocation: Collocation,
    /// The solution within the last step, for times before its end.
    interior: TangentInterior,
    /// The state at which the run began, and how the nominal barycentre changes with it.
    start: State,
    nominal: NominalChange,
    present: TangentState,
    /// Two vectors of the motion, used as buffers.
    y: [Vec<f64>; 2],
}

/// Tangent vectors at a time.
#[derive(Debug, Clone)]
struct TangentState {
    time: f64,
    columns: Vec<f64>,
    integrals: [f64; INTEGRALS],
}

impl Tangents {
    /// Starts the tangent vectors of a run.
    pub fn new(
        tangent_options: &TangentOptions,
        motion: &Motion,
        propagator: &Propagator,
        start: &State,
        nominal: Option<&NominalChange>,
    ) -> Result<Self> {
        let equations = &motion.equations;
        let mut all = Vec::new();
        if let Some(parameters) = &tangent_options.derivatives {
            let jacobi =
                propagator.fixed().is_some_and(|(_, splitting)| splitting.drift_kind() == DriftKind::Kepler);
            let masses = parameters.iter().any(|parameter| parameter.is_mass());
            if jacobi && masses && start.bodies() > 2 {
                let case = "by a mass, of three bodies and more in Jacobi's coordinates";
                let expected = "Verner98 for it, whose coordinates do not change with the masses";
                return Err(Error::invalid("derivatives", case, expected));
            }
            let variations = Variations::new(equations, parameters.clone())?;
            let columns = variations.start();
            let mut tangent = Tangent::new(variations, None, columns, propagator, start);
            if let Some(nominal) = nominal.filter(|nominal| nominal.time() == start.time) {
                tangent.nominal = nominal.clone();
            }
            all.push(tangent);
        }
        if tangent_options.chaos {
            let variations = Variations::single(equations)?;
            let growth_monitor = TangentGrowth::new(motion, &variations);
            let column = growth_monitor.start();
            all.push(Tangent::new(variations, Some(growth_monitor), column, propagator, start));
        }
        Ok(Self(all))
    }

    /// Advances by the step that the run has taken. On an error all tangent vectors stay at the start of the
    /// step.
    pub fn advance(
        &mut self,
        motion: &mut Motion,
        propagator: &Propagator,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let previous: Vec<TangentState> = self.0.iter().map(|tangent| tangent.present.clone()).collect();
        let advanced =
            self.0.iter_mut().try_for_each(|tangent| tangent.advance(motion, propagator, interrupt));
        advanced.inspect_err(|_| {
            for (tangent, present) in self.0.iter_mut().zip(previous) {
                tangent.present = present;
                tangent.forget();
            }
        })
    }

    /// Prepares the derivatives of a run in closed form, at its start.
    pub fn begin_closed_form(
        &mut self,
        equations: &mut Dynamics,
        rotation: &SteadyRotation,
        y: &[f64],
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        for tangent in &mut self.0 {
            let time = rotation.start().time;
            equations.prepare_variations(&tangent.variations, time, y, interrupt)?;
            tangent.variations.evaluate(equations, time, y, interrupt)?;
        }
        Ok(())
    }

    /// Records the derivatives of a state of a run in closed form.
    pub fn record_closed_form(&self, rotation: &SteadyRotation, time: f64, record: &mut Trajectory) {
        for tangent in &self.0 {
            record.transition.extend(rotation.transition(time));
            for rate in tangent.variations.spin_rates(0) {
                record.sensitivity.extend(rotation.sensitivity(time, rate));
            }
        }
    }

    /// Maps the tangent vectors across a switch of a force, whose function has the rate `rate` before it.
    pub fn jump(&mut self, equations: &Dynamics, jump: &SwitchJump, rate: f64) {
        for tangent in &mut self.0 {
            let g = equations.system().gravitational_constant();
            tangent.variations.jump(jump, rate, g, &mut tangent.present.columns);
            tangent.forget();
        }
    }

    /// Moves to a time within the last step.
    pub fn move_to(&mut self, step: &mut LastStep, time: f64) -> Result<()> {
        self.0.iter_mut().try_for_each(|tangent| tangent.move_to(step, time))
    }

    /// Returns the derivatives of a state in the last step, at whose start the tangent vectors are; `None` where
    /// the run is not differentiated.
    pub fn at(&mut self, step: &mut LastStep, state: &State) -> Result<Option<StateDerivatives>> {
        let Some(tangent) = self.0.iter_mut().find(|tangent| tangent.growth_monitor.is_none()) else {
            return Ok(None);
        };
        let (transition, sensitivity) = tangent.derivatives(step, state)?;
        let flow = tangent.flow(step, state)?;
        Ok(Some(StateDerivatives { transition, sensitivity, flow }))
    }

    /// Returns how the nominal barycentre changes with the state at which the tangent vectors are; `None` where
    /// the run is not differentiated.
    pub fn nominal(&self, state: &State) -> Option<NominalChange> {
        let tangent = self.0.iter().find(|tangent| tangent.growth_monitor.is_none())?;
        let Tangent { variations, present, start, nominal, .. } = tangent;
        if present.time != state.time {
            return None;
        }
        nominal.propagated(state.time, &variations.expand(&present.columns, [start, state], nominal).0)
    }

    /// Records the derivatives or indicators at a state of the run, which is where the tangent vectors are or
    /// in the last step.
    pub fn record(&mut self, step: &mut LastStep, state: &State, record: &mut Trajectory) -> Result<()> {
        self.0.iter_mut().try_for_each(|tangent| tangent.record(step, state, record))
    }
}

impl Tangent {
    fn new(
        variations: Variations,
        growth_monitor: Option<TangentGrowth>,
        columns: Vec<f64>,
        propagator: &Propagator,
        start: &State,
    ) -> Self {
        let tableau = propagator.tableau().unwrap_or(&VERNER98);
        Self {
            collocation: Collocation::new(&variations, tableau.order),
            interior: TangentInterior::new(&variations, tableau.order),
            nominal: variations.nominal_at_start(start.time),
            variations,
            growth_monitor,
            present: TangentState { time: start.time, columns, integrals: [0.0; INTEGRALS] },
            start: start.clone(),
            y: Default::default(),
        }
    }

    fn advance(
        &mut self,
        motion: &mut Motion,
        propagator: &Propagator,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        if propagator.fixed().is_some() {
            return self.map(motion, propagator, interrupt);
        }
        let equations = &mut motion.equations;
        let mut step = LastStep { equations, pieces: propagator.pieces(), interrupt };
        self.move_to(&mut step, propagator.time())
    }

    /// Applies the derivative of the map of a step of fixed size.
    fn map(
        &mut self,
        motion: &mut Motion,
        propagator: &Propagator,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let Some((stepper, splitting)) = propagator.fixed() else { return Ok(()) };
        let Self { variations, growth_monitor, collocation, present, start, .. } = self;
        let previous = growth_monitor.as_ref().map(|growth_monitor| growth_monitor.growth(&present.columns));
        let mut mapped = StepTangentMap {
            equations: &mut motion.equations,
            splitting: splitting.clone(),
            variations,
            collocation,
            columns: &mut present.columns,
            time: present.time,
            covered: 0.0,
            has_derivatives: false,
        };
        stepper.again(&mut mapped, interrupt)?;
        let now = propagator.time();
        if let (Some(growth_monitor), Some(previous)) = (growth_monitor, previous) {
            let times = [present.time - start.time, now - start.time];
            let growths = [previous, growth_monitor.growth(&present.columns)];
            growth_monitor.integrate_between(times, growths, &mut present.integrals);
        }
        self.settle(now);
        Ok(())
    }

    fn move_to(&mut self, step: &mut LastStep, time: f64) -> Result<()> {
        self.present = self.follow(step, time, true)?;
        self.settle(time);
        Ok(())
    }

    /// Returns the tangent vectors at a time in the last step. `is_final` says that the next step will begin at that
    /// time.
    fn follow(&mut self, step: &mut LastStep, until: f64, is_final: bool) -> Result<TangentState> {
        let LastStep { equations, pieces, interrupt } = step;
        let mut advanced = self.present.clone();
        let mut prepared = false;
        for piece in *pieces {
            let from =
                if advanced.time == piece.start() { 0.0 } else { piece.fraction(advanced.time).max(0.0) };
            let to = if until == piece.end() { 1.0 } else { piece.fraction(until).min(1.0) };
            if from < to {
                if !prepared {
                    let y = &mut self.y[0];
                    y.resize(equations.layout().dimension(), 0.0);
                    piece.at(from, y);
                    equations.prepare_variations(&self.variations, advanced.time, y, interrupt)?;
                    prepared = true;
                }
                self.step(equations, piece, [from, to], is_final, &mut advanced, interrupt)?;
                advanced.time = if to < 1.0 { until } else { piece.end() };
            }
        }
        advanced.time = until;
        Ok(advanced)
    }

    /// Advances tangent vectors from one fraction of a piece to another, in shorter steps where the equations
    /// over the whole interval are not solved.
    fn step(
        &mut self,
        equations: &mut Dynamics,
        piece: &Segment,
        [from, to]: [f64; 2],
        is_final: bool,
        advanced: &mut TangentState,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let Self { variations, growth_monitor, collocation, start, y: [y, end], .. } = self;
        y.resize(equations.layout().dimension(), 0.0);
        end.resize(equations.layout().dimension(), 0.0);
        let (first, mut from, mut length) = (from, from, to - from);
        while from < to {
            let next = if from + 1.5 * length < to { from + length } else { to };
            let (time, size) = (piece.time_at(from), (next - from) * piece.size());
            load_nodes(collocation, variations, equations, (piece, [from, next]), [y, end], interrupt)?;
            let follows = is_final || from == first;
            if !collocation.solve(equations, [time, size], &advanced.columns, follows, interrupt)? {
                if advanced.columns.iter().any(|number| number.is_nan() || number.abs() > LARGEST) {
                    advanced.columns.fill(f64::NAN);
                    return Ok(());
                }
                length = 0.5 * (next - from);
                if length < SHORTEST {
                    return Err(too_fast(time, length * piece.size()));
                }
                continue;
            }
            if let Some(growth_monitor) = growth_monitor {
                let growth = |node| growth_monitor.growth(collocation.at_node(node));
                let ends = [&advanced.columns, collocation.end_columns()]
                    .map(|columns| growth_monitor.growth(columns));
                if (ends[1] - ends[0]).abs() > LONGEST && 0.5 * (next - from) >= SHORTEST {
                    length = 0.5 * (next - from);
                    continue;
                }
                let step = [time - start.time, size];
                growth_monitor.integrate(collocation.gauss(), step, growth, &mut advanced.integrals);
                length *= 2.0;
            }
            advanced.columns.copy_from_slice(collocation.end_columns());
            if is_final {
                collocation.remember(size);
            }
            from = next;
        }
        Ok(())
    }

    /// Forgets everything about the last step.
    fn forget(&mut self) {
        self.collocation.forget();
        self.interior.forget();
    }

    /// Makes the present tangent vectors those at this time, and scales back a long one.
    fn settle(&mut self, time: f64) {
        self.present.time = time;
        self.interior.forget();
        if let Some(growth_monitor) = &mut self.growth_monitor
            && growth_monitor.rescale(&mut self.present.columns)
        {
            self.collocation.forget();
        }
    }

    fn record(&mut self, step: &mut LastStep, state: &State, record: &mut Trajectory) -> Result<()> {
        if self.growth_monitor.is_none() {
            let (transition, sensitivity) = self.derivatives(step, state)?;
            record.transition.extend(transition);
            record.sensitivity.extend(sensitivity);
            return Ok(());
        }
        let at_present = state.time == self.present.time;
        let TangentState { columns, integrals, .. } =
            if at_present { self.present.clone() } else { self.follow(step, state.time, false)? };
        if let Some(growth_monitor) = &self.growth_monitor {
            record.chaos.extend(growth_monitor.indicators(state.time - self.start.time, &columns, integrals));
        }
        Ok(())
    }

    /// Returns the transition matrix and the sensitivities at a state, which is where the tangent vectors are
    /// or in the last step.
    fn derivatives(&mut self, step: &mut LastStep, state: &State) -> Result<(Vec<f64>, Vec<f64>)> {
        let Self { variations, interior, present, .. } = self;
        let columns = if state.time == present.time {
            &present.columns
        } else {
            interior.at(variations, step, (present.time, &present.columns), state.time)?
        };
        if !columns.iter().all(|number| number.is_finite()) {
            return Err(Error::NotConverged {
                what: format!("the transition matrix at time {}", state.time),
                detail: "its numbers leave the range of doubles; compute chaos alone, or divide the run"
                    .to_owned(),
            });
        }
        Ok(self.variations.expand(columns, [&self.start, state], &self.nominal))
    }

    /// Returns the rates of change of the motion at a state in the last step.
    fn flow(&mut self, step: &mut LastStep, state: &State) -> Result<Vec<f64>> {
        let LastStep { equations, pieces, interrupt } = step;
        let y = &mut self.y[0];
        y.resize(equations.layout().dimension(), 0.0);
        let Some(piece) = pieces.iter().find(|piece| piece.fraction(state.time) <= 1.0).or(pieces.last())
        else {
            return Ok(Vec::new());
        };
        piece.at(piece.fraction(state.time).clamp(0.0, 1.0), y);
        equations.flow(state, y, interrupt)
    }
}
