//! The integrators behind one name.

use crate::error::{Error, Result, require_positive};
use crate::integrate::{
    DORMAND_PRINCE54, Scheme, Tableau, Tolerance, VERNER65, VERNER76, VERNER87, VERNER98,
};

/// An integrator with its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Integrator {
    /// The pair of Dormand and Prince of orders 5 and 4; interpolant of order 4 without further evaluations.
    DormandPrince54(Tolerance),
    /// Verner's pair of orders 6 and 5; interpolant of order 6 by 6 further evaluations in steps that need it.
    Verner65(Tolerance),
    /// Verner's pair of orders 7 and 6; interpolant of order 7 by 11 further evaluations.
    Verner76(Tolerance),
    /// Verner's pair of orders 8 and 7; interpolant of order 8 by 16 further evaluations.
    Verner87(Tolerance),
    /// Verner's pair of orders 9 and 8; interpolant of order 9 by 10 further evaluations.
    Verner98(Tolerance),
    /// The Lie group variational integrator of Lee, Leok & McClamroch (2007): second order, symplectic, one evaluation a step.
    LieGroupVariational {
        /// Size of the steps.
        step: f64,
    },
    /// Kepler motion and free rotation solved exactly, the rest as kicks. Symplectic; N bodies in Jacobi's coordinates, so
    /// that the first two are to be the closest pair.
    SymplecticSplitting {
        /// Size of the steps.
        step: f64,
        /// How drifts and kicks follow each other.
        scheme: Scheme,
    },
}

/// What is behind an integrator.
pub(super) enum Engine {
    Pair(&'static Tableau, Tolerance),
    Composition(Scheme, f64),
}

impl Integrator {
    /// The integrator of a name, with the tolerances (relative, absolute) or the step and scheme that it takes.
    pub fn named(name: &str, tolerances: (f64, f64), step: f64, scheme: &str) -> Result<Self> {
        let tolerance = || Tolerance::new(tolerances.0, tolerances.1);
        Ok(match name {
            "DormandPrince54" => Self::DormandPrince54(tolerance()?),
            "Verner65" => Self::Verner65(tolerance()?),
            "Verner76" => Self::Verner76(tolerance()?),
            "Verner87" => Self::Verner87(tolerance()?),
            "Verner98" => Self::Verner98(tolerance()?),
            "LieGroupVariational" => Self::LieGroupVariational { step },
            "SymplecticSplitting" => Self::SymplecticSplitting { step, scheme: scheme.parse()? },
            other => return Err(Error::invalid("integrator", format!("{other:?}"), "one of fullbody's")),
        })
    }

    pub(super) fn engine(self) -> Result<Engine> {
        Ok(match self {
            Self::DormandPrince54(tolerance) => Engine::Pair(&DORMAND_PRINCE54, tolerance),
            Self::Verner65(tolerance) => Engine::Pair(&VERNER65, tolerance),
            Self::Verner76(tolerance) => Engine::Pair(&VERNER76, tolerance),
            Self::Verner87(tolerance) => Engine::Pair(&VERNER87, tolerance),
            Self::Verner98(tolerance) => Engine::Pair(&VERNER98, tolerance),
            Self::LieGroupVariational { step } => {
                require_positive("step", step)?;
                Engine::Composition(Scheme::KickDriftKick, step)
            }
            Self::SymplecticSplitting { step, scheme } => {
                require_positive("step", step)?;
                Engine::Composition(scheme, step)
            }
        })
    }
}
