//! One step as a polynomial in time.

use crate::math::compensated::Compensated;

/// Most coefficients of a segment's polynomial.
pub const MAX_TERMS: usize = 12;

/// The solution over one step: y(t + theta h) = y + theta h sum_k c_k T_k(2 theta - 1).
///
/// Takes 8 (terms + 2) bytes for every number of the vector: 96 at most.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Where the step begins.
    pub(super) time: Compensated,
    /// Its size, negative for a run backwards.
    pub(super) size: f64,
    pub(super) high: Vec<f64>,
    pub(super) low: Vec<f64>,
    /// c_0 of the whole vector, then c_1, ...
    pub(super) coefficients: Vec<f64>,
}

impl Segment {
    /// Room for a vector of this length and a polynomial of that many coefficients.
    pub(super) fn new(dimension: usize, terms: usize) -> Self {
        Self {
            time: Compensated::default(),
            size: 0.0,
            high: vec![0.0; dimension],
            low: vec![0.0; dimension],
            coefficients: vec![0.0; terms.min(MAX_TERMS) * dimension],
        }
    }

    /// Time at which the step begins.
    pub fn start(&self) -> f64 {
        self.time.value()
    }

    /// Time at which it ends.
    pub fn end(&self) -> f64 {
        self.time_at(1.0)
    }

    /// The vector at which it begins, and what rounding dropped of it.
    pub fn start_vector(&self) -> (&[f64], &[f64]) {
        (&self.high, &self.low)
    }

    /// Its size, negative for a run backwards.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Memory that its numbers take.
    pub fn bytes(&self) -> usize {
        8 * (self.high.len() + self.low.len() + self.coefficients.len())
    }

    /// The time at a fraction of the step.
    pub fn time_at(&self, theta: f64) -> f64 {
        let mut time = self.time;
        time.add(theta * self.size);
        time.value()
    }

    /// The fraction of the step at a time.
    pub fn fraction(&self, time: f64) -> f64 {
        ((time - self.time.high) - self.time.low) / self.size
    }

    /// The vector at a fraction of the step. Allocates nothing.
    pub fn at(&self, theta: f64, out: &mut [f64]) {
        let dimension = self.high.len();
        let terms = self.coefficients.len() / dimension.max(1);
        let mut basis = [0.0; MAX_TERMS];
        let x = 2.0 * theta - 1.0;
        let (mut previous, mut present) = (x, 1.0);
        for value in &mut basis[..terms] {
            *value = theta * self.size * present;
            (previous, present) = (present, 2.0 * x * present - previous);
        }
        out.fill(0.0);
        // The small terms first.
        for (value, row) in basis[..terms].iter().zip(self.coefficients.chunks_exact(dimension)).rev() {
            out.iter_mut().zip(row).for_each(|(o, c)| *o += value * c);
        }
        for (o, (high, low)) in out.iter_mut().zip(self.high.iter().zip(&self.low)) {
            *o = high + (low + *o);
        }
    }

    /// Moves the end by a difference and what is before it by its share, linear in time.
    pub fn tilt(&mut self, from: f64, to: f64, difference: &[f64]) {
        for (index, difference) in difference.iter().enumerate() {
            self.low[index] += from * difference;
            self.coefficients[index] += (to - from) * difference / self.size;
        }
    }
}
