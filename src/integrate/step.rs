//! A look at the last step.

use super::tableau::Tableau;
use crate::math::rows::{LargestChanges, stride};
use pulp::Arch;
use std::ops::Range;

/// An accepted step by its ends and stages.
#[derive(Debug, Clone, Copy)]
pub struct Step<'a> {
    pub(super) tableau: &'static Tableau,
    /// The vector at its start.
    pub start: &'a [f64],
    /// The vector at its end.
    pub end: &'a [f64],
    /// The time of its start.
    pub time: f64,
    /// Its size, negative for a run backwards.
    pub size: f64,
    pub(super) rates: &'a [f64],
}

impl Step<'_> {
    /// The rates of change at the step's start.
    pub fn first_rates(&self) -> &[f64] {
        &self.rates[..self.start.len()]
    }

    /// The tableau that it was made by.
    pub fn tableau(&self) -> &'static Tableau {
        self.tableau
    }

    /// By how much the rates of change of a range of numbers differ from the first ones at most, at the pair's own stages. `out` has
    /// the [`Self::stride`] as its length, and what it holds elsewhere means nothing.
    pub fn changes(&self, arch: Arch, range: Range<usize>, out: &mut [f64]) {
        let rows = &self.rates[..self.tableau.stages * self.stride()];
        arch.dispatch(LargestChanges { rows, range, out });
    }

    /// Length of the rows that the rates are kept in.
    pub fn stride(&self) -> usize {
        stride(self.start.len())
    }

    /// The tableau's [`Tableau::spread`].
    pub fn spread(&self) -> [f64; 2] {
        self.tableau.spread
    }
}
