//! The interface between an integrator and its equations, and one evaluation of them.

use super::control::Tolerance;
use crate::error::{Error, Refusal, Result};
use crate::interrupt::InterruptCheck;
use pulp::Arch;

/// The equations that an integrator solves.
pub trait Equations {
    /// Returns the SIMD instruction set with which stages are summed.
    fn arch(&self) -> Arch {
        Arch::default()
    }

    /// Returns the number of parts in which the rates of change are evaluated, so that interrupts can be
    /// checked between them.
    fn parts(&self) -> usize {
        1
    }

    /// Returns the units of work of one part, for [`InterruptCheck`].
    fn work(&self) -> u64 {
        1
    }

    /// Prepares a step of size `step` from an accepted vector. It may allocate, and is called between steps
    /// only.
    fn prepare(&mut self, time: f64, y: &[f64], step: f64, interrupt: &mut InterruptCheck) -> Result<()>;

    /// Evaluates one part of the rates of change at a trial vector; the last part leaves the rates in `rate`.
    /// An error carries the reason, and whether a shorter step may help.
    fn derivative(
        &mut self,
        part: usize,
        time: f64,
        y: &[f64],
        rate: &mut [f64],
    ) -> std::result::Result<(), Refusal>;

    /// Returns the number of values on which the rates of change depend. They come first in the vector; the
    /// others are quadratures.
    fn dimension_without_quadratures(&self, dimension: usize) -> usize {
        dimension
    }

    /// Writes the rates of the quadratures at the time and the vector of the last evaluation into `rate`. It
    /// is called only for stages whose rates have a weight.
    fn quadratures(&mut self, _time: f64, _y: &[f64], _rate: &mut [f64]) {}

    /// Returns the size of a difference `v` at `y` in units of the tolerance.
    fn norm(&mut self, y: &[f64], v: &[f64], tolerance: &Tolerance) -> f64;

    /// Projects an accepted vector back onto its constraints.
    fn restore(&mut self, high: &mut [f64], low: &mut [f64]);
}

/// The reason why an evaluation or an attempt was not completed.
pub(super) enum Incomplete {
    /// The equations cannot be evaluated there; a shorter step may help.
    Refused(&'static str),
    /// The caller has interrupted the run, or the equations failed for good.
    Ended(Error),
}

impl From<Refusal> for Incomplete {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Shorter(reason) => Self::Refused(reason),
            Refusal::Failed(error) => Self::Ended(*error),
        }
    }
}

impl Incomplete {
    /// Returns the error that ends the integration; `of` makes it from the reason of a refusal.
    pub fn error(self, of: impl FnOnce(&str) -> Error) -> Error {
        match self {
            Self::Refused(reason) => of(reason),
            Self::Ended(error) => error,
        }
    }
}

/// Evaluates the rates of change at a trial vector, and those of the quadratures if the stage is `weighted`.
pub(super) fn evaluate(
    equations: &mut impl Equations,
    time: f64,
    y: &[f64],
    rate: &mut [f64],
    weighted: bool,
    interrupt: &mut InterruptCheck,
) -> std::result::Result<(), Incomplete> {
    for part in 0..equations.parts() {
        interrupt.charge(equations.work(), time).map_err(Incomplete::Ended)?;
        equations.derivative(part, time, y, rate)?;
    }
    if weighted {
        equations.quadratures(time, y, rate);
    }
    Ok(())
}
