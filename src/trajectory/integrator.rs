//! The integrators by name.

use crate::dynamics::DriftKind;
use crate::integrate::{
    Composition, DORMAND_PRINCE54, KICK_DRIFT_KICK, Scheme, Tableau, Tolerance, VERNER65, VERNER76, VERNER87,
    VERNER96, VERNER98,
};
use serde::{Deserialize, Serialize};

/// An integrator with its settings. Archives and the Python package use this description.
///
/// ```
/// use fullbody::integrate::{Scheme, Tolerance};
/// use fullbody::trajectory::Integrator;
///
/// let default = Integrator::Verner98(Tolerance::new(1e-13, 1e-13)?);
/// let symplectic = Integrator::SymplecticSplitting { step: 0.1, scheme: Scheme::Aba864 };
/// assert_ne!(default, symplectic);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "name", deny_unknown_fields)]
#[non_exhaustive]
pub enum Integrator {
    /// The pair of Dormand and Prince of orders 5 and 4, with an interpolant of order 4 without further
    /// evaluations.
    DormandPrince54(Tolerance),
    /// Verner's pair of orders 6 and 5, with an interpolant of order 6 by 6 further evaluations in steps that
    /// need it.
    Verner65(Tolerance),
    /// Verner's pair of orders 7 and 6, with an interpolant of order 7 by 11 further evaluations.
    Verner76(Tolerance),
    /// Verner's pair of orders 8 and 7, with an interpolant of order 8 by 16 further evaluations.
    Verner87(Tolerance),
    /// Verner's pair of orders 9 and 8, with an interpolant of order 9 by 10 further evaluations.
    Verner98(Tolerance),
    /// The pair of `Verner98` with steps so short that truncation errors are below the random effect of
    /// rounding.
    Verner98ToRoundoff,
    /// The Lie group variational integrator of Lee, Leok & McClamroch (2007): second order, symplectic, one
    /// evaluation a step.
    LieGroupVariational {
        /// The size of the steps.
        step: f64,
    },
    /// The splitting into Kepler motion and free rotation, solved exactly, and kicks by the remaining forces.
    /// It is symplectic. N bodies are in Jacobi's coordinates, so that the first two should be the closest
    /// pair.
    SymplecticSplitting {
        /// The size of the steps.
        step: f64,
        /// The scheme of drifts and kicks.
        #[serde(with = "crate::names")]
        scheme: Scheme,
    },
}

/// The kind of an integrator's steps.
pub(super) enum Steps {
    /// Steps of a Runge-Kutta pair, whose size a tolerance controls.
    Controlled(&'static Tableau, Tolerance),
    /// Steps of one size, by a composition of the flows of two parts.
    Fixed(&'static Composition, DriftKind, f64),
}

impl Integrator {
    /// Returns the pair and its tolerance for an integrator with step control.
    pub fn pair(self) -> Option<(&'static Tableau, Tolerance)> {
        match self.steps() {
            Steps::Controlled(tableau, tolerance) => Some((tableau, tolerance)),
            Steps::Fixed(..) => None,
        }
    }

    pub(super) fn steps(self) -> Steps {
        match self {
            Self::DormandPrince54(tolerance) => Steps::Controlled(&DORMAND_PRINCE54, tolerance),
            Self::Verner65(tolerance) => Steps::Controlled(&VERNER65, tolerance),
            Self::Verner76(tolerance) => Steps::Controlled(&VERNER76, tolerance),
            Self::Verner87(tolerance) => Steps::Controlled(&VERNER87, tolerance),
            Self::Verner98(tolerance) => Steps::Controlled(&VERNER98, tolerance),
            Self::Verner98ToRoundoff => Steps::Controlled(&VERNER96, Tolerance::TO_ROUNDOFF),
            Self::LieGroupVariational { step } => Steps::Fixed(&KICK_DRIFT_KICK, DriftKind::Free, step),
            Self::SymplecticSplitting { step, scheme } => {
                Steps::Fixed(scheme.composition(), DriftKind::Kepler, step)
            }
        }
    }
}
