//! The equations of motion in the form that the integrators take.

use super::approach::Approach;
use crate::dynamics::{Dynamics, Splitting};
use crate::error::{Refusal, Result};
use crate::integrate::{Equations, Flows, Tolerance};
use crate::interrupt::InterruptCheck;
use pulp::Arch;

/// The equations, the scales of their errors, and the check for contacts.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    pub equations: Dynamics,
    /// Scales at the start for each body: position, velocity, spin.
    pub initial: Vec<[f64; 3]>,
    present_scales: Vec<[f64; 3]>,
    pub approach: Approach,
}

impl Motion {
    pub fn new(equations: Dynamics, y: &[f64]) -> Self {
        let mut initial = vec![[0.0; 3]; equations.layout().bodies];
        equations.scales(y, &mut initial);
        let approach = Approach::new(equations.system());
        Self { equations, present_scales: initial.clone(), initial, approach }
    }

    /// Returns a copy without the quadrature rules, for a second integration. Making it can be interrupted.
    pub fn copy_without_rules(&self, interrupt: &mut InterruptCheck) -> Result<Self> {
        let system = self.equations.system();
        Ok(Self {
            equations: system.dynamics(self.equations.frame(), interrupt)?,
            initial: self.initial.clone(),
            present_scales: self.present_scales.clone(),
            approach: Approach::new(system),
        })
    }
}

impl Equations for Motion {
    fn arch(&self) -> Arch {
        self.equations.system().arch()
    }

    fn parts(&self) -> usize {
        self.equations.parts()
    }

    fn work(&self) -> u64 {
        self.equations.work()
    }

    fn prepare(&mut self, time: f64, y: &[f64], step: f64, interrupt: &mut InterruptCheck) -> Result<()> {
        self.equations.prepare(time, y, step, interrupt)
    }

    fn derivative(
        &mut self,
        part: usize,
        time: f64,
        y: &[f64],
        rate: &mut [f64],
    ) -> std::result::Result<(), Refusal> {
        Ok(self.equations.derivative(part, time, y, rate)?)
    }

    fn dimension_without_quadratures(&self, _dimension: usize) -> usize {
        self.equations.layout().dimension_without_quadratures()
    }

    fn quadratures(&mut self, time: f64, y: &[f64], rate: &mut [f64]) {
        self.equations.quadratures(time, y, rate);
    }

    /// Returns the size of a difference in units of the tolerance: the largest over all bodies and kinds of
    /// quantity. Lengths of vectors are compared, which are the same in every frame. Work and impulse of
    /// forces follow from the motion and are not measured.
    fn norm(&mut self, y: &[f64], v: &[f64], tolerance: &Tolerance) -> f64 {
        let layout = self.equations.layout();
        self.equations.scales(y, &mut self.present_scales);
        let length =
            |start: usize, count: usize| v[start..start + count].iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut largest: f64 = 0.0;
        let mut measure = |length: f64, present_scales: f64, initial: f64| {
            let ratio = length / (tolerance.relative * present_scales + tolerance.absolute * initial);
            // f64::max would hide a NaN.
            largest = if ratio > largest || ratio.is_nan() { ratio } else { largest };
        };
        for body in 0..layout.bodies {
            let ([l, u, n], [l0, u0, n0]) = (self.present_scales[body], self.initial[body]);
            measure(length(layout.position(body), 3), l, l0);
            measure(length(layout.velocity(body), 3), u, u0);
            measure(length(layout.attitude(body), layout.chart.width()), 1.0, 1.0);
            measure(length(layout.spin(body), 3), n, n0);
        }
        if layout.forces > 0 {
            // The barycentre offset is measured like the bodies, and against its own size.
            let (present_scales, initial) =
                (largest_scales(&self.present_scales), largest_scales(&self.initial));
            let at = layout.barycentre_offset();
            let length_of = |start: usize| y[start..start + 3].iter().map(|x| x * x).sum::<f64>().sqrt();
            measure(length(at, 3), present_scales[0].max(length_of(at)), initial[0]);
            measure(length(at + 3, 3), present_scales[1].max(length_of(at + 3)), initial[1]);
        }
        largest
    }

    fn restore(&mut self, high: &mut [f64], low: &mut [f64]) {
        self.equations.restore(high, low);
    }
}

/// Returns the largest scales of position and velocity of all bodies.
fn largest_scales(scales: &[[f64; 3]]) -> [f64; 2] {
    scales.iter().fold([0.0; 2], |w, s| [w[0].max(s[0]), w[1].max(s[1])])
}

/// The equations of motion as two flows, for a composition.
pub(super) struct SplitMotion<'a> {
    pub equations: &'a mut Dynamics,
    pub splitting: &'a mut Splitting,
}

impl Flows for SplitMotion<'_> {
    fn prepare(&mut self, time: f64, y: &[f64], step: f64, interrupt: &mut InterruptCheck) -> Result<()> {
        self.splitting.begin(self.equations, time, y, step);
        self.equations.prepare(time, y, step, interrupt)
    }

    fn drift(&mut self, size: f64, vector: [&mut [f64]; 2], interrupt: &mut InterruptCheck) -> Result<()> {
        self.splitting.drift(self.equations, size, vector, interrupt)
    }

    fn kick(&mut self, size: f64, vector: [&mut [f64]; 2], interrupt: &mut InterruptCheck) -> Result<u64> {
        self.splitting.kick(self.equations, size, vector, interrupt)
    }

    fn restore(&mut self, high: &mut [f64], low: &mut [f64]) {
        self.equations.restore(high, low);
    }
}
