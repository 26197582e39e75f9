//! Linear equations beside a motion: Runge-Kutta steps of the same tableau over the motion's own steps.
//!
//! With the motion's stages as they were, a step of dY/dt = A(t) Y is the exact derivative of the motion's step. It does not touch
//! the motion, which is integrated as without it.

use super::tableau::Tableau;
use crate::error::Result;
use crate::math::rows::{Combination, Term, stride};
use pulp::Arch;

/// A vector that follows a motion by linear equations.
#[derive(Debug, Clone)]
pub struct Linear {
    tableau: &'static Tableau,
    arch: Arch,
    /// The non-zero weights of every stage, and at the end those of the solution.
    terms: Vec<Vec<Term>>,
    /// The vector at the start of a step, padded.
    present: Vec<f64>,
    trial: Vec<f64>,
    rates: Vec<f64>,
    dimension: usize,
}

impl Linear {
    /// From a vector.
    pub fn new(tableau: &'static Tableau, arch: Arch, mut present: Vec<f64>) -> Self {
        let dimension = present.len();
        let width = stride(dimension);
        present.resize(width, 0.0);
        let terms = |weights: &[f64]| {
            let term = |(row, &weight): (usize, &f64)| Term { row, weight, low: 0.0 };
            weights.iter().enumerate().map(term).filter(|term| term.weight != 0.0).collect()
        };
        let stages = tableau.a[..tableau.stages].iter().map(|row| terms(row));
        Self {
            terms: stages.chain([terms(tableau.b)]).collect(),
            trial: vec![0.0; width],
            rates: vec![0.0; tableau.stages * width],
            tableau,
            arch,
            present,
            dimension,
        }
    }

    /// The present vector.
    pub fn vector(&self) -> &[f64] {
        &self.present[..self.dimension]
    }

    /// The present vector, to be changed.
    pub fn vector_mut(&mut self) -> &mut [f64] {
        &mut self.present[..self.dimension]
    }

    /// The step that a motion makes in `size`. `rate` is given the number of a stage, the fraction of the step at which it is, the
    /// vector there and where to leave its rate of change. The result replaces the present vector if `keep`, and is returned.
    pub fn step(
        &mut self,
        size: f64,
        keep: bool,
        mut rate: impl FnMut(usize, f64, &[f64], &mut [f64]) -> Result<()>,
    ) -> Result<&[f64]> {
        let width = self.present.len();
        for stage in 0..self.tableau.stages {
            self.combine(stage, size);
            let rates = &mut self.rates[stage * width..][..self.dimension];
            rate(stage, self.tableau.c[stage], &self.trial[..self.dimension], rates)?;
        }
        self.combine(self.tableau.stages, size);
        if keep {
            self.present.copy_from_slice(&self.trial);
        }
        Ok(&self.trial[..self.dimension])
    }

    fn combine(&mut self, row: usize, size: f64) {
        self.arch.dispatch(Combination {
            terms: &self.terms[row],
            rows: &self.rates,
            size,
            start: &self.present,
            out: &mut self.trial,
        });
    }
}
