//! The change of the nominal barycentre with the state of a motion.
//!
//! Third bodies move relative to the nominal barycentre. A motion that begins at a state has its barycentre
//! there, so that a change of the state moves the paths of third bodies as well. Where a motion continues, its
//! nominal barycentre is that of an earlier state, and changes as that state changes: with T the transition
//! matrix since then and N the derivatives by the earlier state, the derivatives by the present state are N
//! T^-1. The transition matrices of consecutive runs then multiply to that of the whole.

use crate::math::Vec3;
use nalgebra::DMatrix;

/// The derivatives of position and velocity of the nominal barycentre with respect to the state at a time.
#[derive(Debug, Clone)]
pub struct NominalChange {
    time: f64,
    /// Six rows of as many numbers as a tangent vector of all bodies has.
    rows: DMatrix<f64>,
}

impl NominalChange {
    /// Makes the derivatives at a state that becomes the start of a motion, from the masses relative to the
    /// total mass. Each body has `size` numbers, first position and velocity.
    pub(super) fn at_start(time: f64, share: &[f64], size: usize) -> Self {
        let mut rows = DMatrix::zeros(6, size * share.len());
        for (body, share) in share.iter().enumerate() {
            (0..6).for_each(|c| rows[(c, size * body + c)] = *share);
        }
        Self { time, rows }
    }

    /// Returns the time of the state.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns the derivatives at a later state, from the transition matrix since the present one; `None` for
    /// a matrix without an inverse.
    pub fn propagated(&self, time: f64, transition: &[f64]) -> Option<Self> {
        let size = self.rows.ncols();
        let mut rows = self.rows.clone();
        for c in 0..3 {
            let propagated = rows.row(c) + rows.row(3 + c) * (time - self.time);
            rows.set_row(c, &propagated);
        }
        // The rows of the given matrix are the columns of its transpose.
        let transposed = DMatrix::from_column_slice(size, size, transition);
        let solved = transposed.lu().solve(&rows.transpose())?;
        solved.iter().all(|value| value.is_finite()).then(|| Self { time, rows: solved.transpose() })
    }

    /// Returns the change of position and velocity with one number of the state.
    pub(super) fn by(&self, number: usize) -> [Vec3; 2] {
        [0, 3].map(|row| self.rows.fixed_view::<3, 1>(row, number).into())
    }
}
