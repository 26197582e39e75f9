//! Tangent vectors under the map of a step of fixed size: the exact derivative of the map, drift with respect
//! to drift and kick by kick.

use crate::dynamics::{Collocation, DriftKind, Dynamics, Splitting, Variations};
use crate::error::{Error, Result};
use crate::integrate::Flows;
use crate::interrupt::InterruptCheck;

/// The angle, in rad, by which bodies rotate or move along their orbits in one step of the variational
/// equations within a drift: a method of order ten then keeps all digits.
const ANGLE: f64 = 0.1;

/// A fixed step that is repeated with tangent vectors.
pub(super) struct StepTangentMap<'a> {
    pub equations: &'a mut Dynamics,
    /// The splitting of the run as it was at the start of the step.
    pub splitting: Splitting,
    pub variations: &'a mut Variations,
    pub collocation: &'a mut Collocation,
    pub columns: &'a mut [f64],
    /// The time of the step's start, and the part of the step that the drifts have covered.
    pub time: f64,
    pub covered: f64,
    /// Whether the derivatives of the present loads are known.
    pub has_derivatives: bool,
}

impl StepTangentMap<'_> {
    fn failed(&self) -> Error {
        Error::NotConverged {
            what: format!("the derivative of a step at time {}", self.time),
            detail: "the discrete rotation has none; use a shorter step".to_owned(),
        }
    }
}

impl Flows for StepTangentMap<'_> {
    fn prepare(&mut self, time: f64, y: &[f64], step: f64, interrupt: &mut InterruptCheck) -> Result<()> {
        (self.time, self.covered, self.has_derivatives) = (time, 0.0, false);
        self.splitting.reset();
        self.splitting.begin(self.equations, time, y, step);
        self.equations.prepare_variations(self.variations, time, y, interrupt)
    }

    fn drift(
        &mut self,
        size: f64,
        [high, low]: [&mut [f64]; 2],
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        self.has_derivatives = false;
        self.covered += size;
        if self.splitting.drift_kind() == DriftKind::Free {
            let layout = self.equations.layout();
            let drifted = self.variations.drift_straight(layout, high, size, self.columns);
            drifted.ok_or_else(|| self.failed())?;
            return self.splitting.drift(self.equations, size, [high, low], interrupt);
        }
        let pieces = (self.splitting.farthest(self.equations, high, size) / ANGLE).ceil().max(1.0);
        let mut splitting_within = self.splitting.clone();
        let (mut y, mut tail, mut end) = (high.to_vec(), low.to_vec(), high.to_vec());
        for piece in 0..pieces as u64 {
            let Self { equations, variations, collocation, columns, time, .. } = self;
            let mut at =
                |equations: &mut Dynamics, fraction: f64, y: &mut [f64], interrupt: &mut InterruptCheck| {
                    y.copy_from_slice(high);
                    tail.copy_from_slice(low);
                    let part = (piece as f64 + fraction) / pieces;
                    splitting_within.drift(equations, size * part, [y, &mut tail], interrupt)
                };
            for node in 0..collocation.gauss().nodes.len() {
                at(equations, collocation.gauss().nodes[node], &mut y, interrupt)?;
                variations.evaluate_drift(equations, &y);
                collocation.load(node, equations, variations, &y);
            }
            at(equations, 0.0, &mut y, interrupt)?;
            at(equations, 1.0, &mut end, interrupt)?;
            collocation.load_ends(equations, variations, [&y, &end]);
            let size = size / pieces;
            if !collocation.solve(equations, [*time, size], columns, piece > 0, interrupt)? {
                return Err(self.failed());
            }
            columns.copy_from_slice(collocation.end_columns());
            collocation.remember(size);
        }
        self.splitting.drift(self.equations, size, [high, low], interrupt)
    }

    fn kick(
        &mut self,
        size: f64,
        [high, low]: [&mut [f64]; 2],
        interrupt: &mut InterruptCheck,
    ) -> Result<u64> {
        if !self.has_derivatives {
            interrupt.charge(self.variations.work(self.equations), self.time)?;
            let kepler = self.splitting.drift_kind() == DriftKind::Kepler;
            self.variations.evaluate_kick(
                self.equations,
                self.time + self.covered,
                high,
                kepler,
                interrupt,
            )?;
            self.has_derivatives = true;
        }
        self.variations.kick(self.equations.system().arch(), size, self.columns);
        self.splitting.kick(self.equations, size, [high, low], interrupt)
    }

    fn restore(&mut self, _high: &mut [f64], _low: &mut [f64]) {}
}
