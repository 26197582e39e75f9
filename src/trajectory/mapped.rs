//! Departures under the map of a step of fixed size: its own derivative, drift by drift and kick by kick.

use crate::dynamics::{Collocation, Dynamics, Parts, Splitting, Variations};
use crate::error::{Error, Result};
use crate::integrate::Flows;
use crate::patience::Patience;

/// Angle, in rad, that bodies turn or move by in a step of the equations of departures within a drift: a method of order ten then
/// keeps all digits.
const ANGLE: f64 = 0.1;

/// The step taken again, with departures.
pub(super) struct Mapped<'a> {
    pub equations: &'a mut Dynamics,
    /// That of the run as it was at the start of the step; and a copy that looks ahead within drifts.
    pub splitting: Splitting,
    pub variations: &'a mut Variations,
    pub collocation: &'a mut Collocation,
    pub columns: &'a mut [f64],
    /// Time of the step's start, and how much of it the drifts have covered.
    pub time: f64,
    pub covered: f64,
    /// Whether the present loads' derivatives are known.
    pub known: bool,
}

impl Mapped<'_> {
    fn failed(&self) -> Error {
        Error::NotConverged {
            what: format!("the derivative of a step at time {}", self.time),
            detail: "the discrete rotation has none; use a shorter step".to_owned(),
        }
    }
}

impl Flows for Mapped<'_> {
    fn prepare(&mut self, time: f64, y: &[f64], step: f64, patience: &mut Patience) -> Result<()> {
        (self.time, self.covered, self.known) = (time, 0.0, false);
        self.splitting.reset();
        self.splitting.begin(self.equations, time, y, step);
        self.equations.prepare_variations(time, patience)
    }

    fn drift(&mut self, size: f64, high: &mut [f64], low: &mut [f64], patience: &mut Patience) -> Result<()> {
        self.known = false;
        self.covered += size;
        if self.splitting.parts() == Parts::Free {
            let layout = self.equations.layout();
            let drifted = self.variations.drift_straight(layout, high, size, self.columns);
            drifted.ok_or_else(|| self.failed())?;
            return self.splitting.drift(self.equations, size, high, low, patience);
        }
        let pieces = (self.splitting.farthest(self.equations, high, size) / ANGLE).ceil().max(1.0);
        let mut ahead = self.splitting.clone();
        let (mut y, mut tail, mut end) = (high.to_vec(), low.to_vec(), high.to_vec());
        for piece in 0..pieces as u64 {
            let Self { equations, variations, collocation, columns, time, .. } = self;
            let mut at = |equations: &mut Dynamics, fraction: f64, y: &mut [f64], patience: &mut Patience| {
                y.copy_from_slice(high);
                tail.copy_from_slice(low);
                let part = (piece as f64 + fraction) / pieces;
                ahead.drift(equations, size * part, y, &mut tail, patience)
            };
            for node in 0..collocation.gauss().nodes.len() {
                at(equations, collocation.gauss().nodes[node], &mut y, patience)?;
                variations.look_at_drift(equations, &y);
                collocation.take(node, equations, variations, &y);
            }
            at(equations, 0.0, &mut y, patience)?;
            at(equations, 1.0, &mut end, patience)?;
            collocation.between(equations, variations, [&y, &end]);
            let size = size / pieces;
            if !collocation.solve(equations, [*time, size], columns, piece > 0, patience)? {
                return Err(self.failed());
            }
            columns.copy_from_slice(collocation.reached());
            collocation.remember(size);
        }
        self.splitting.drift(self.equations, size, high, low, patience)
    }

    fn kick(&mut self, size: f64, high: &mut [f64], low: &mut [f64], patience: &mut Patience) -> Result<u64> {
        if !self.known {
            patience.spend(self.variations.work(self.equations), self.time)?;
            let kepler = self.splitting.parts() == Parts::Kepler;
            self.variations.look_at_kick(self.equations, self.time + self.covered, high, kepler)?;
            self.known = true;
        }
        self.variations.kick(self.equations.system().arch(), size, self.columns);
        self.splitting.kick(self.equations, size, high, low, patience)
    }

    fn restore(&mut self, _high: &mut [f64], _low: &mut [f64]) {}
}
