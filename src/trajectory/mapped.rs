//! Departures under the map of a step of fixed size: its own derivative, drift by drift and kick by kick.

use crate::dynamics::{Dynamics, Parts, Splitting, Variations};
use crate::error::{Error, Result};
use crate::integrate::{Flows, Linear};
use crate::patience::Patience;

/// Angle, in rad, that bodies turn or move by in a step of the equations of departures within a drift: Verner's pair of order nine then
/// keeps all digits.
const ANGLE: f64 = 0.1;

/// The step taken again, with departures.
pub(super) struct Mapped<'a> {
    pub equations: &'a mut Dynamics,
    /// That of the run as it was at the start of the step; and a copy that looks ahead within drifts.
    pub splitting: Splitting,
    pub variations: &'a mut Variations,
    pub linear: &'a mut Linear,
    /// How many numbers of the vector of `linear` are departures.
    pub count: usize,
    /// Time of the step's start, and how much of it the drifts have covered.
    pub time: f64,
    pub covered: f64,
    /// Whether the present loads' derivatives are known.
    pub known: bool,
    pub scratch: Vec<f64>,
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
            let columns = &mut self.linear.vector_mut()[..self.count];
            let layout = self.equations.layout();
            let drifted = self.variations.drift_straight(layout, high, size, columns);
            drifted.ok_or_else(|| self.failed())?;
            return self.splitting.drift(self.equations, size, high, low, patience);
        }
        let pieces = (self.splitting.farthest(self.equations, high, size) / ANGLE).ceil().max(1.0);
        let (count, arch) = (self.count, self.equations.system().arch());
        let mut ahead = self.splitting.clone();
        let (mut y, mut tail) = (high.to_vec(), low.to_vec());
        for piece in 0..pieces as u64 {
            let Self { equations, variations, linear, .. } = self;
            linear.step(size / pieces, true, |_, fraction, columns, rates| {
                y.copy_from_slice(high);
                tail.copy_from_slice(low);
                let part = (piece as f64 + fraction) / pieces;
                ahead.drift(equations, size * part, &mut y, &mut tail, patience)?;
                variations.look_at_drift(equations, &y);
                variations.rates(arch, &columns[..count], &mut rates[..count]);
                rates[count..].fill(0.0);
                Ok(())
            })?;
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
        let arch = self.equations.system().arch();
        let columns = &mut self.linear.vector_mut()[..self.count];
        self.variations.kick(arch, size, columns, &mut self.scratch);
        self.splitting.kick(self.equations, size, high, low, patience)
    }

    fn restore(&mut self, _high: &mut [f64], _low: &mut [f64]) {}
}
