//! How fast neighbouring runs part: MEGNO, the fast Lyapunov indicator and the largest Lyapunov exponent.
//!
//! Of one departure delta, measured in the natural sizes of its numbers at the start, with L = ln |delta| / |delta_0| at the time
//! s since the start,
//!
//!   Y = 2/t int_0^t s dL = 2 (L - z/t),   z = int_0^t L ds,   and its mean 1/t int_0^t Y ds:
//!
//! Cincotta & Simo (2000), Astron. Astrophys. Suppl. 147, 205. The mean tends to 2 for regular motion and to t/2 times the
//! largest Lyapunov exponent for chaotic motion. L/t tends to that exponent, and the largest L so far is the fast Lyapunov
//! indicator of Froeschle, Lega & Gonczi (1997), Celest. Mech. Dyn. Astron. 67, 41. Both integrals are two more numbers of the
//! equations; the departure is brought back to its first length when it has grown long.

use super::motion::Motion;
use crate::dynamics::Variations;

/// Numbers recorded of a sample: the mean of MEGNO, the exponent, the indicator.
pub const INDICATORS: usize = 3;

/// The integrals z and that of Y, behind the departure.
pub(super) const INTEGRALS: usize = 2;

/// Length at which a departure is brought back.
const LONG: f64 = 1e60;

/// What is known of a departure beside its numbers.
#[derive(Debug, Clone)]
pub(super) struct Parting {
    /// One over the natural size of each number.
    inverse: Vec<f64>,
    /// ln of the factors by which it was brought back.
    shortened: f64,
    /// The largest L so far.
    largest: f64,
}

impl Parting {
    /// With the sizes at the start of a run.
    pub fn new(motion: &Motion, variations: &Variations) -> Self {
        Self { inverse: variations.inverse_sizes(&motion.initial), shortened: 0.0, largest: 0.0 }
    }

    /// A departure of length one in all directions at once, by no random numbers, and zero integrals.
    pub fn start(&self) -> Vec<f64> {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let share = |k: usize| (GOLDEN * (k + 1) as f64).fract() - 0.5;
        let count = self.inverse.len();
        let length = (0..count).map(|k| share(k) * share(k)).sum::<f64>().sqrt();
        let numbers = (0..count).map(|k| share(k) / length / self.inverse[k]);
        numbers.chain([0.0; INTEGRALS]).collect()
    }

    /// L of a vector.
    fn growth(&self, vector: &[f64]) -> f64 {
        let squares = vector.iter().zip(&self.inverse).map(|(x, inverse)| (x * inverse).powi(2));
        0.5 * squares.sum::<f64>().ln() + self.shortened
    }

    /// Rates of the integrals at a vector, a time after the start.
    pub fn integrals(&self, elapsed: f64, vector: &[f64], rates: &mut [f64]) {
        let count = self.inverse.len();
        let growth = self.growth(vector);
        rates[count] = growth;
        rates[count + 1] = if elapsed == 0.0 { 0.0 } else { 2.0 * (growth - vector[count] / elapsed) };
    }

    /// The integrals over a step of fixed size, between whose ends nothing is known: by the trapezoidal rule.
    pub fn integrate(&self, [from, to]: [f64; 2], before: &[f64], after: &mut [f64]) {
        let (count, half) = (self.inverse.len(), 0.5 * (to - from));
        for k in 0..INTEGRALS {
            // The second takes the first at the end.
            let (mut first, mut last) = (vec![0.0; before.len()], vec![0.0; before.len()]);
            self.integrals(from, before, &mut first);
            self.integrals(to, after, &mut last);
            after[count + k] = before[count + k] + half * (first[count + k] + last[count + k]);
        }
    }

    /// Notes a vector at the end of a step, and brings a long one back.
    pub fn settle(&mut self, vector: &mut [f64]) {
        let growth = self.growth(vector);
        self.largest = self.largest.max(growth);
        if growth - self.shortened > LONG.ln() {
            let factor = (self.shortened - growth).exp();
            vector[..self.inverse.len()].iter_mut().for_each(|x| *x *= factor);
            self.shortened = growth;
        }
    }

    /// The indicators of a vector, a time after the start.
    pub fn indicators(&self, elapsed: f64, vector: &[f64]) -> [f64; INDICATORS] {
        if elapsed == 0.0 {
            return [0.0; INDICATORS];
        }
        let growth = self.growth(vector);
        [vector[self.inverse.len() + 1] / elapsed, growth / elapsed.abs(), self.largest.max(growth)]
    }
}
