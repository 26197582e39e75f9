//! The size of the first step.

use super::Stepper;
use crate::error::{Error, Result};
use crate::integrate::control::Tolerance;
use crate::integrate::equations::{Equations, Incomplete, evaluate};
use crate::interrupt::InterruptCheck;
use crate::math::rows::stride;

impl Stepper {
    /// Returns the size of the first step by the method of Hairer, Norsett & Wanner, section II.4.
    pub(super) fn first_step(
        &mut self,
        equations: &mut impl Equations,
        direction: f64,
        end: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<f64> {
        let dimension = self.high.len();
        let remaining = (end - self.time()).abs();
        let time = self.time();
        equations.prepare(time, &self.high, 0.0, interrupt)?;
        let failed = |reason: &str| Error::StepSizeTooSmall { time, step: 0.0, reason: reason.to_owned() };
        let unit = Tolerance { relative: 1.0, absolute: 0.0 };
        let (first, later_stages) = self.stages.split_at_mut(stride(dimension));
        let first = &mut first[..dimension];
        evaluate(equations, time, &self.high, first, true, interrupt)
            .map_err(|unmade| unmade.error(failed))?;
        self.statistics.evaluations += 2;
        // In units of the scales all quantities are of order one, so that the norm of the rates is an inverse
        // time.
        let rate = equations.norm(&self.high, first, &unit);
        let guess = if rate > 0.0 { 0.01 / rate } else { remaining };
        let guess = guess.min(remaining);
        for (t, (y, k)) in self.trial.iter_mut().zip(self.high.iter().zip(first.iter())) {
            *t = y + direction * guess * k;
        }
        let second = &mut later_stages[..dimension];
        let (at, trial) = (time + direction * guess, &self.trial[..dimension]);
        let curvature = match evaluate(equations, at, trial, second, false, interrupt) {
            Err(Incomplete::Ended(error)) => return Err(error),
            // A trial that cannot be evaluated is too far: the solution changes within that time.
            Err(Incomplete::Refused(_)) => guess.powi(-2),
            Ok(()) => {
                second.iter_mut().zip(first.iter()).for_each(|(s, f)| *s = (*s - f) / guess);
                equations.norm(&self.high, second, &unit)
            }
        };
        self.fresh = true;
        let exponent = 1.0 / f64::from(self.tableau.error_order + 1);
        let tolerance = self.tolerance.relative + self.tolerance.absolute;
        let scale = (curvature.sqrt()).max(rate);
        let step = if scale > 0.0 { (0.01 * tolerance).powf(exponent) * 10.0 / scale } else { remaining };
        Ok(direction * step.min(100.0 * guess).min(remaining).max(f64::MIN_POSITIVE))
    }
}
