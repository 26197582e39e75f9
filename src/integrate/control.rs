//! Proportional-integral control of the step size, after Gustafsson (1991), ACM Trans. Math. Softw. 17, 533,
//! with the limits of Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, section II.4.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// The error allowed in a step: `relative` times the present scale plus `absolute` times the scale at the
/// start.
///
/// ```
/// use fullbody::integrate::Tolerance;
///
/// assert!(Tolerance::new(1e-13, 1e-13).is_ok());
/// assert!(Tolerance::new(0.0, 0.0).is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct Tolerance {
    /// The tolerance relative to the present scale of each quantity.
    #[serde(rename = "rtol")]
    pub(crate) relative: f64,
    /// The tolerance relative to the scale at the start.
    #[serde(rename = "atol")]
    pub(crate) absolute: f64,
}

impl Tolerance {
    /// The smallest sum of both tolerances. Below it the error estimate of a step is its own round-off, and
    /// shorter steps only add more. At this tolerance the truncation errors are smaller than the random
    /// rounding errors over some 1e5 steps.
    pub const FLOOR: f64 = 6e-16;

    /// The tolerance of `VERNER96` at which truncation errors are below round-off: in exact
    /// arithmetic the energy of Kepler orbits of any eccentricity would drift by 2e-21 a step. Rounding makes
    /// the energy walk by 5e-18 times the root of the number of steps and, from some 1e5 steps on, drift by
    /// up to 4e-20 a step.
    pub const TO_ROUNDOFF: Self = Self { relative: 2e-13, absolute: 0.0 };

    /// Checks that both numbers lie between 0 and 1 and that not both are zero. Where their sum is below
    /// [`Self::FLOOR`] the relative part is raised to reach it.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a number out of this range, and for two zeros.
    pub fn new(relative: f64, absolute: f64) -> Result<Self> {
        for (name, value) in [("rtol", relative), ("atol", absolute)] {
            if !(0.0..1.0).contains(&value) {
                return Err(Error::invalid(name, format!("{value:?}"), "a number from 0 to below 1"));
            }
        }
        if relative + absolute == 0.0 {
            return Err(Error::invalid("the larger of rtol and atol", "0", "a number above zero"));
        }
        let mut raised = relative.max(Self::FLOOR - absolute);
        if raised + absolute < Self::FLOOR {
            // The sum is rounded up, so that a tolerance that has been raised once is not raised again.
            raised = raised.next_up();
        }
        Ok(Self { relative: raised, absolute })
    }

    /// Returns the tolerance relative to the present scale of each quantity.
    pub fn relative(&self) -> f64 {
        self.relative
    }

    /// Returns the tolerance relative to the scale of each quantity at the start.
    pub fn absolute(&self) -> f64 {
        self.absolute
    }
}

/// A tolerance as it is serialised, not yet checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    rtol: f64,
    atol: f64,
}

impl TryFrom<Unchecked> for Tolerance {
    type Error = Error;

    fn try_from(unchecked: Unchecked) -> Result<Self> {
        Self::new(unchecked.rtol, unchecked.atol)
    }
}

/// The memory of the step-size controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    /// The error of the last accepted step, in units of the tolerance.
    pub previous: f64,
    /// Whether the last attempt failed.
    pub after_rejection: bool,
}

/// The factor that aims at an error somewhat below the tolerance.
const SAFETY: f64 = 0.9;
/// The exponent of the inverse error of a step in the step-size factor, times one plus the order of the error.
const PROPORTIONAL: f64 = 0.7;
/// The exponent of the error of the step before, likewise.
const INTEGRAL: f64 = 0.4;
/// The smallest step-size factor.
const SHRINK: f64 = 0.2;
/// The largest step-size factor.
const GROW: f64 = 5.0;

impl Default for Controller {
    fn default() -> Self {
        Self::new()
    }
}

impl Controller {
    /// Returns the controller before the first step.
    pub fn new() -> Self {
        Self { previous: 1.0, after_rejection: false }
    }

    /// Returns the factor from an accepted step with this error to the next step, and remembers the error.
    pub fn accepted(&mut self, error: f64, error_order: u32) -> f64 {
        let exponent = 1.0 / f64::from(error_order + 1);
        // An error of exactly zero (free motion) does not tell how long the next step may be.
        let error = error.max(1e-10);
        let factor = SAFETY * error.powf(-PROPORTIONAL * exponent) * self.previous.powf(INTEGRAL * exponent);
        let limit = if self.after_rejection { 1.0 } else { GROW };
        self.previous = error;
        self.after_rejection = false;
        factor.clamp(SHRINK, limit)
    }

    /// Returns the factor from a rejected attempt with this error to the next attempt.
    pub fn rejected(&mut self, error: f64, error_order: u32) -> f64 {
        self.after_rejection = true;
        let exponent = 1.0 / f64::from(error_order + 1);
        if error.is_finite() { (SAFETY * error.powf(-exponent)).clamp(SHRINK, SAFETY) } else { SHRINK }
    }
}
