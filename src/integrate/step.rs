//! The last step of a stepper, borrowed: its ends and stages.

use super::tableau::Tableau;
use crate::math::rows::{LargestChanges, stride};
use pulp::Arch;
use std::ops::Range;

/// An accepted step with its ends and stages.
#[derive(Debug, Clone, Copy)]
pub struct Step<'a> {
    pub(super) tableau: &'static Tableau,
    /// The vector at the start of the step.
    pub start: &'a [f64],
    /// The vector at the end of the step.
    pub end: &'a [f64],
    /// The time of the start of the step.
    pub time: f64,
    /// The size of the step, negative for a run backwards.
    pub size: f64,
    pub(super) rates: &'a [f64],
}

impl Step<'_> {
    /// Returns the rates of change at the step's start.
    pub fn first_rates(&self) -> &[f64] {
        &self.rates[..self.start.len()]
    }

    /// Returns the tableau with which the step was made.
    pub fn tableau(&self) -> &'static Tableau {
        self.tableau
    }

    /// Writes, for a range of numbers, the largest difference of their rates of change at the pair's own
    /// stages from those at the start. `out` has the length [`Self::stride`]; its other numbers are
    /// unspecified.
    pub fn changes(&self, arch: Arch, range: Range<usize>, out: &mut [f64]) {
        let rows = &self.rates[..self.tableau.stages * self.stride()];
        arch.dispatch(LargestChanges { rows, range, out });
    }

    /// Returns the length of the rows in which the rates are kept.
    pub fn stride(&self) -> usize {
        stride(self.start.len())
    }

    /// Returns the tableau's [`Tableau::spread`].
    pub fn spread(&self) -> [f64; 2] {
        self.tableau.spread
    }
}
