//! The integrators behind one name.

use crate::integrate::{DORMAND_PRINCE54, Tableau, Tolerance, VERNER65, VERNER76, VERNER87, VERNER98};

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
}

impl Integrator {
    /// The Runge-Kutta pair and its tolerance.
    pub(super) fn pair(self) -> (&'static Tableau, Tolerance) {
        match self {
            Self::DormandPrince54(tolerance) => (&DORMAND_PRINCE54, tolerance),
            Self::Verner65(tolerance) => (&VERNER65, tolerance),
            Self::Verner76(tolerance) => (&VERNER76, tolerance),
            Self::Verner87(tolerance) => (&VERNER87, tolerance),
            Self::Verner98(tolerance) => (&VERNER98, tolerance),
        }
    }
}
