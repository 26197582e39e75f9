//! One step as a polynomial in time.

use crate::math::compensated::Compensated;

/// The largest number of coefficients of a segment's polynomial.
pub const MAX_TERMS: usize = 12;

/// The solution over one step: y(t + theta h) = y + theta h sum_k c_k T_k(2 theta - 1).
///
/// It takes 8 (terms + 2) bytes for every number of the vector: 112 at most.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// The time at which the step begins.
    pub(super) time: Compensated,
    /// The size of the step, negative for a run backwards.
    pub(super) size: f64,
    /// The vector at the start.
    pub(super) high: Vec<f64>,
    /// The low part of the vector at the start.
    pub(super) low: Vec<f64>,
    /// The coefficients: c_0 of the whole vector, then c_1, and so on.
    pub(super) coefficients: Vec<f64>,
}

impl Segment {
    /// Allocates for a vector of this length and a polynomial of `terms` coefficients.
    pub fn new(dimension: usize, terms: usize) -> Self {
        Self {
            time: Compensated::default(),
            size: 0.0,
            high: vec![0.0; dimension],
            low: vec![0.0; dimension],
            coefficients: vec![0.0; terms.min(MAX_TERMS) * dimension],
        }
    }

    /// Overwrites the segment with another step: its start and size, the vector there in two parts, and a
    /// function that returns a coefficient by its order and the index of the number.
    pub fn refill(
        &mut self,
        (time, size): (f64, f64),
        (high, low): (&[f64], &[f64]),
        coefficient: impl Fn(usize, usize) -> f64,
    ) {
        self.time = Compensated::new(time);
        self.size = size;
        self.high.copy_from_slice(high);
        self.low.copy_from_slice(low);
        let dimension = self.high.len();
        for (index, value) in self.coefficients.iter_mut().enumerate() {
            *value = coefficient(index / dimension, index % dimension);
        }
    }

    /// Returns the coefficients: c_0 of the whole vector, then c_1, and so on.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// Returns the time at which the step begins.
    pub fn start(&self) -> f64 {
        self.time.value()
    }

    /// Returns the time at which the step ends.
    pub fn end(&self) -> f64 {
        self.time_at(1.0)
    }

    /// Returns the vector at the start, and its low part.
    pub fn start_vector(&self) -> (&[f64], &[f64]) {
        (&self.high, &self.low)
    }

    /// Returns the size of the step, negative for a run backwards.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Returns the memory that the numbers take, in bytes.
    pub fn bytes(&self) -> usize {
        8 * (self.high.len() + self.low.len() + self.coefficients.len())
    }

    /// Returns the time at a fraction of the step.
    pub fn time_at(&self, theta: f64) -> f64 {
        let mut time = self.time;
        time.add(theta * self.size);
        time.value()
    }

    /// Returns the fraction of the step at a time.
    pub fn fraction(&self, time: f64) -> f64 {
        ((time - self.time.high) - self.time.low) / self.size
    }

    /// Writes the vector at a fraction of the step. Allocates nothing.
    pub fn at(&self, theta: f64, out: &mut [f64]) {
        let dimension = self.high.len();
        let basis = self.basis(theta);
        out.fill(0.0);
        // Small terms are added first.
        for (value, row) in basis.iter().zip(self.coefficients.chunks_exact(dimension)).rev() {
            out.iter_mut().zip(row).for_each(|(o, c)| *o += value * c);
        }
        for (o, (high, low)) in out.iter_mut().zip(self.high.iter().zip(&self.low)) {
            *o = high + (low + *o);
        }
    }

    /// Returns the factors of the coefficients at a fraction of the step.
    pub fn basis(&self, theta: f64) -> [f64; MAX_TERMS] {
        let mut basis = [0.0; MAX_TERMS];
        let x = 2.0 * theta - 1.0;
        let (mut previous, mut present) = (x, 1.0);
        for value in &mut basis[..self.terms()] {
            *value = theta * self.size * present;
            (previous, present) = (present, 2.0 * x * present - previous);
        }
        basis
    }

    /// Writes the rate of change of the vector at a fraction of the step. Allocates nothing.
    ///
    /// With x = 2 theta - 1 the derivative of theta T_k(x) is T_k(x) + 2 theta k U_(k-1)(x).
    pub fn rate(&self, theta: f64, out: &mut [f64]) {
        let x = 2.0 * theta - 1.0;
        let (mut previous, mut present) = (x, 1.0);
        // These hold U_(k-2) and U_(k-1).
        let (mut second_previous, mut second) = (-1.0, 0.0);
        out.fill(0.0);
        for (k, row) in self.coefficients.chunks_exact(self.high.len()).enumerate() {
            let value = present + 2.0 * theta * k as f64 * second;
            out.iter_mut().zip(row).for_each(|(o, c)| *o += value * c);
            (previous, present) = (present, 2.0 * x * present - previous);
            (second_previous, second) = (second, 2.0 * x * second - second_previous);
        }
    }

    /// Returns one number of the vector at the fraction for which the basis was computed, with the same bits
    /// as [`Self::at`].
    pub fn number(&self, basis: &[f64; MAX_TERMS], index: usize) -> f64 {
        let column = self.coefficients[index..].iter().step_by(self.high.len());
        let sum = basis[..self.terms()].iter().zip(column).rev().fold(0.0, |sum, (value, c)| sum + value * c);
        self.high[index] + (self.low[index] + sum)
    }

    /// Returns bounds, anywhere in the step, of the lengths of the first three derivatives with respect to
    /// the fraction of the step, for the `count` numbers from `index` on.
    ///
    /// The derivatives of theta T_k(2 theta - 1) are largest at the end: 1 + 2 k^2, 4 k^2 (k^2 + 2) / 3 and 4
    /// k^2 (k^2 - 1) (2 k^2 + 7) / 15.
    pub fn derivative_bounds(&self, index: usize, count: usize) -> [f64; 3] {
        let mut bounds = [0.0; 3];
        for (k, row) in self.coefficients.chunks_exact(self.high.len()).enumerate() {
            let length =
                row[index..index + count].iter().map(|c| c * c).sum::<f64>().sqrt() * self.size.abs();
            let q = (k * k) as f64;
            bounds[0] += length * (1.0 + 2.0 * q);
            bounds[1] += length * 4.0 / 3.0 * q * (q + 2.0);
            bounds[2] += length * 4.0 / 15.0 * q * (q - 1.0) * (2.0 * q + 7.0);
        }
        bounds
    }

    fn terms(&self) -> usize {
        self.coefficients.len() / self.high.len().max(1)
    }

    /// Adds a difference that grows linearly with time, from the fraction `from` of it at the start to the
    /// fraction `to` at the end.
    pub fn tilt(&mut self, from: f64, to: f64, difference: &[f64]) {
        for (index, difference) in difference.iter().enumerate() {
            self.low[index] += from * difference;
            self.coefficients[index] += (to - from) * difference / self.size;
        }
    }
}
