//! The stepping object: a system, where it is, and the integrator that moves it.

use super::Trajectory;
use crate::dynamics::{Dynamics, Inner, State, System};
use crate::error::{Error, Result, require_finite};
use crate::integrate::{Equations, Statistics, Stepper, Tolerance, VERNER98};
use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// How often the hook is called, at most.
const HOOK_INTERVAL: Duration = Duration::from_millis(50);

/// An integrator with its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Integrator {
    /// Verner's pair of orders 9 and 8.
    Verner98(Tolerance),
}

/// At which times a run is recorded.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// At every accepted step.
    Steps,
    /// At a spacing, start and end included.
    Spacing(f64),
    /// At exactly these times, in the direction of the run.
    Times(Vec<f64>),
}

/// Where a run is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Start of the run.
    pub start: f64,
    /// Present time.
    pub time: f64,
    /// End of the run.
    pub end: f64,
}

/// A system at a state, ready to be moved.
#[derive(Debug, Clone)]
pub struct Simulation {
    dynamics: Motion,
    inner: Inner,
    stepper: Stepper,
}

impl Simulation {
    /// Checks the state against the system.
    pub fn new(system: &System, state: &State, integrator: Integrator) -> Result<Self> {
        system.check(state)?;
        let inner = Inner::new(system.layout(), &system.masses(), state);
        let dynamics = Motion::new(system.dynamics(), &inner.high);
        let Integrator::Verner98(tolerance) = integrator;
        let stepper = Stepper::new(&VERNER98, tolerance, state.time, inner.high.clone(), inner.low.clone());
        Ok(Self { dynamics, inner, stepper })
    }

    /// Present time.
    pub fn time(&self) -> f64 {
        self.stepper.time()
    }

    /// Present state.
    pub fn state(&self) -> State {
        let (high, low) = self.stepper.vector();
        self.inner.state(self.time(), high, low)
    }

    /// Counts since the start.
    pub fn statistics(&self) -> Statistics {
        self.stepper.statistics()
    }

    /// The equations of motion with the rules in force.
    pub fn dynamics(&self) -> &Dynamics {
        &self.dynamics.equations
    }

    /// One accepted step towards `end`, never beyond it.
    pub fn step(&mut self, end: f64) -> Result<()> {
        self.stepper.step(&mut self.dynamics, end)
    }

    /// Moves to `until`, forwards or backwards, and records into `record`.
    ///
    /// On an error the record keeps what there was up to it, and the simulation stays at the last accepted step. The hook is
    /// called between steps, at most every 50 ms, and stops the run by [`ControlFlow::Break`].
    pub fn integrate(
        &mut self,
        until: f64,
        output: &Output,
        record: &mut Trajectory,
        hook: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<()> {
        require_finite("until", &[until])?;
        let start = self.time();
        let mut times = Times::new(start, until, output)?;
        let mut sample = vec![0.0; self.inner.high.len()];
        let zeros = vec![0.0; self.inner.high.len()];
        let (high, _) = self.stepper.vector();
        self.dynamics.prepare(start, high, 0.0)?;
        if times.due(start) {
            self.record_present(record);
        }
        let mut called = Instant::now();
        while self.time() != until {
            self.stepper.step(&mut self.dynamics, until)?;
            let now = self.time();
            while let Some(time) = times.before(now) {
                self.stepper.interpolate(&mut self.dynamics, time, &mut sample)?;
                let state = self.inner.state(time, &sample, &zeros);
                self.record_state(record, &sample, &state);
            }
            if times.due(now) {
                self.record_present(record);
            }
            if called.elapsed() >= HOOK_INTERVAL {
                called = Instant::now();
                if hook(Progress { start, time: now, end: until }).is_break() {
                    return Err(Error::Interrupted { time: now });
                }
            }
        }
        Ok(())
    }

    /// Shortest time of an evaluation of the rates of change at the present state, seconds; for benchmarks.
    pub fn time_evaluation(&mut self, number: usize, repeats: usize) -> Result<f64> {
        let high = self.stepper.vector().0.to_vec();
        let mut rate = vec![0.0; high.len()];
        self.dynamics.prepare(self.time(), &high, 0.0)?;
        let equations = &mut self.dynamics.equations;
        Ok(shortest(number, repeats, || {
            let _ = black_box(equations.derivative(black_box(&high), &mut rate));
        }))
    }

    /// Shortest time of an interaction of the first pair at the present state, seconds; for benchmarks.
    pub fn time_interaction(&self, number: usize, repeats: usize) -> f64 {
        let high = self.stepper.vector().0;
        let Some((_, _, pair)) = self.dynamics.equations.pairs().next() else { return 0.0 };
        let pose = self.dynamics.equations.first_pose(high);
        shortest(number, repeats, || {
            black_box(pair.interaction(black_box(&pose)));
        })
    }

    fn record_present(&mut self, record: &mut Trajectory) {
        let state = self.state();
        let high = self.stepper.vector().0.to_vec();
        self.record_state(record, &high, &state);
    }

    fn record_state(&mut self, record: &mut Trajectory, y: &[f64], state: &State) {
        let energy = self.dynamics.equations.energy(y, &state.velocity);
        let momentum = self.dynamics.equations.angular_momentum(state);
        record.push(state, &energy, &momentum);
    }
}

fn shortest(number: usize, repeats: usize, mut call: impl FnMut()) -> f64 {
    let time = |_| {
        let started = Instant::now();
        (0..number).for_each(|_| call());
        started.elapsed().as_secs_f64() / number.max(1) as f64
    };
    (0..repeats).map(time).fold(f64::INFINITY, f64::min)
}

/// The times that are still to be recorded.
enum Times<'a> {
    Steps,
    List { times: std::borrow::Cow<'a, [f64]>, next: usize, forward: bool },
}

impl<'a> Times<'a> {
    fn new(start: f64, until: f64, output: &'a Output) -> Result<Self> {
        let forward = until >= start;
        let list = |times| Ok(Self::List { times, next: 0, forward });
        match output {
            Output::Steps => Ok(Self::Steps),
            Output::Spacing(spacing) => {
                if !(spacing.is_finite() && *spacing != 0.0) {
                    return Err(Error::invalid("output", spacing, "a finite spacing above zero, or times"));
                }
                let count = (until - start).abs() / spacing.abs();
                if count > 1e9 {
                    return Err(Error::invalid("output", spacing, "a spacing with fewer than 1e9 samples"));
                }
                // Multiples, not sums, and the end itself rather than something beside it.
                let step = spacing.abs().copysign(until - start);
                let inner = (0..=count as u64).map(|k| start + k as f64 * step);
                let mut times: Vec<f64> =
                    inner.filter(|t| (until - t).abs() > 1e-9 * spacing.abs()).collect();
                times.push(until);
                list(times.into())
            }
            Output::Times(times) => {
                require_finite("output", times)?;
                let (low, high) = (start.min(until), start.max(until));
                if let Some(t) = times.iter().find(|t| !(low..=high).contains(*t)) {
                    return Err(Error::invalid("a time in output", t, format!("times from {low} to {high}")));
                }
                if let Some(w) = times.windows(2).find(|w| if forward { w[1] <= w[0] } else { w[1] >= w[0] })
                {
                    return Err(Error::invalid(
                        "output",
                        format!("{} followed by {}", w[0], w[1]),
                        "times in the direction of the run, none twice",
                    ));
                }
                list(times.as_slice().into())
            }
        }
    }

    /// The next time that lies before `now`.
    fn before(&mut self, now: f64) -> Option<f64> {
        let Self::List { times, next, forward } = self else { return None };
        let time = *times.get(*next)?;
        if if *forward { time < now } else { time > now } {
            *next += 1;
            Some(time)
        } else {
            None
        }
    }

    /// Whether `now` itself is to be recorded.
    fn due(&mut self, now: f64) -> bool {
        match self {
            Self::Steps => true,
            Self::List { times, next, .. } => {
                let due = times.get(*next) == Some(&now);
                *next += usize::from(due);
                due
            }
        }
    }
}

/// The equations of motion as the integrator sees them.
#[derive(Debug, Clone)]
struct Motion {
    equations: Dynamics,
    /// Scales at the start, per body: position, velocity, spin.
    initial: Vec<[f64; 3]>,
    present: Vec<[f64; 3]>,
}

impl Motion {
    fn new(equations: Dynamics, y: &[f64]) -> Self {
        let mut initial = vec![[0.0; 3]; equations.layout().bodies];
        equations.scales(y, &mut initial);
        Self { equations, present: initial.clone(), initial }
    }
}

impl Equations for Motion {
    fn dimension(&self) -> usize {
        self.equations.layout().dimension()
    }

    fn prepare(&mut self, time: f64, y: &[f64], step: f64) -> Result<()> {
        self.equations.prepare(time, y, step)
    }

    fn derivative(
        &mut self,
        _time: f64,
        y: &[f64],
        rate: &mut [f64],
    ) -> std::result::Result<(), &'static str> {
        self.equations.derivative(y, rate).map_err(|rejected| rejected.0)
    }

    /// Largest over bodies and kinds of quantity of the length of the difference, hence the same in every frame.
    fn norm(&mut self, y: &[f64], v: &[f64], tolerance: &Tolerance) -> f64 {
        let layout = self.equations.layout();
        self.equations.scales(y, &mut self.present);
        let length =
            |start: usize, count: usize| v[start..start + count].iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut largest: f64 = 0.0;
        let mut worst = |length: f64, present: f64, initial: f64| {
            let ratio = length / (tolerance.relative * present + tolerance.absolute * initial);
            // f64::max would hide a NaN.
            largest = if ratio > largest || ratio.is_nan() { ratio } else { largest };
        };
        for body in 0..layout.bodies {
            let ([l, u, n], [l0, u0, n0]) = (self.present[body], self.initial[body]);
            worst(length(layout.position(body), 3), l, l0);
            worst(length(layout.velocity(body), 3), u, u0);
            worst(length(layout.attitude(body), layout.chart.width()), 1.0, 1.0);
            worst(length(layout.spin(body), 3), n, n0);
        }
        largest
    }

    fn restore(&mut self, high: &mut [f64], low: &mut [f64]) {
        self.equations.restore(high, low);
    }
}
