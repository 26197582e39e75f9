//! What an integrator asks of equations of motion, and an evaluation of them.

use super::control::Tolerance;
use crate::error::{Error, Refusal, Result};
use crate::patience::Patience;
use pulp::Arch;

/// What an integrator needs to know of its equations.
pub trait Equations {
    /// The instructions to sum stages with.
    fn arch(&self) -> Arch {
        Arch::default()
    }

    /// Parts in which the rates of change are evaluated, so that the caller can be asked between them.
    fn parts(&self) -> usize {
        1
    }

    /// Units of work of a part, for [`Patience`].
    fn work(&self) -> u64 {
        1
    }

    /// Called between steps, before a step of size `step` from an accepted vector. May allocate.
    fn prepare(&mut self, time: f64, y: &[f64], step: f64, patience: &mut Patience) -> Result<()>;

    /// A part of the evaluation of the rates of change at a trial vector; the last part leaves them in `rate`. `Err` says why
    /// they cannot be had there, and whether to try the step shorter.
    fn derivative(
        &mut self,
        part: usize,
        time: f64,
        y: &[f64],
        rate: &mut [f64],
    ) -> std::result::Result<(), Refusal>;

    /// How many numbers of the vector, its first ones, the rates of change depend on. The others are quadratures.
    fn dependent(&self, dimension: usize) -> usize {
        dimension
    }

    /// Leaves the rates of the quadratures at the time and the vector of the last evaluation in `rate`. Called only where they count.
    fn quadratures(&mut self, _time: f64, _y: &[f64], _rate: &mut [f64]) {}

    /// Size of a difference `v` at `y` in units of the tolerance.
    fn norm(&mut self, y: &[f64], v: &[f64], tolerance: &Tolerance) -> f64;

    /// Brings an accepted vector back onto its constraints.
    fn restore(&mut self, high: &mut [f64], low: &mut [f64]);
}

/// Why an evaluation or an attempt was not made to its end.
pub(super) enum Unmade {
    /// The equations refuse; a shorter step may do.
    Refused(&'static str),
    /// The caller does not want to go on, or the equations cannot.
    Ended(Error),
}

impl From<Refusal> for Unmade {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Shorter(reason) => Self::Refused(reason),
            Refusal::Failed(error) => Self::Ended(*error),
        }
    }
}

impl Unmade {
    /// The error that ends the integration, made from the reason of a refusal.
    pub fn error(self, of: impl FnOnce(&str) -> Error) -> Error {
        match self {
            Self::Refused(reason) => of(reason),
            Self::Ended(error) => error,
        }
    }
}

/// The rates of change at a trial vector, with those of the quadratures where the stage counts.
pub(super) fn evaluate(
    equations: &mut impl Equations,
    time: f64,
    y: &[f64],
    rate: &mut [f64],
    counts: bool,
    patience: &mut Patience,
) -> std::result::Result<(), Unmade> {
    for part in 0..equations.parts() {
        patience.spend(equations.work(), time).map_err(Unmade::Ended)?;
        equations.derivative(part, time, y, rate)?;
    }
    if counts {
        equations.quadratures(time, y, rate);
    }
    Ok(())
}
