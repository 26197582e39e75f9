//! The equations of motion as the integrators see them.

use crate::dynamics::{Dynamics, Splitting};
use crate::error::Result;
use crate::integrate::{Equations, Flows, Tolerance};
use pulp::Arch;

/// The equations, and what errors are measured against.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    pub equations: Dynamics,
    /// Scales at the start, per body: position, velocity, spin.
    pub initial: Vec<[f64; 3]>,
    present: Vec<[f64; 3]>,
}

impl Motion {
    pub fn new(equations: Dynamics, y: &[f64]) -> Self {
        let mut initial = vec![[0.0; 3]; equations.layout().bodies];
        equations.scales(y, &mut initial);
        Self { equations, present: initial.clone(), initial }
    }
}

impl Equations for Motion {
    fn arch(&self) -> Arch {
        self.equations.system().arch()
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

    /// The length of the difference in units of the tolerance: the largest over all bodies and kinds of quantity. As lengths
    /// of vectors they are the same in every frame.
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

/// The equations as two flows, for a composition.
pub(super) struct SplitMotion<'a> {
    pub equations: &'a mut Dynamics,
    pub splitting: &'a mut Splitting,
}

impl Flows for SplitMotion<'_> {
    fn prepare(&mut self, time: f64, y: &[f64], step: f64) -> Result<()> {
        self.equations.prepare(time, y, step)
    }

    fn drift(
        &mut self,
        size: f64,
        high: &mut [f64],
        low: &mut [f64],
    ) -> std::result::Result<(), &'static str> {
        self.splitting.drift(self.equations, size, high, low)
    }

    fn kick(
        &mut self,
        size: f64,
        high: &mut [f64],
        low: &mut [f64],
    ) -> std::result::Result<u64, &'static str> {
        self.splitting.kick(self.equations, size, high, low)
    }

    fn restore(&mut self, high: &mut [f64], low: &mut [f64]) {
        self.equations.restore(high, low);
    }
}
