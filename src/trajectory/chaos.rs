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
use crate::math::gauss::Gauss;

/// Numbers recorded of a sample: the mean of MEGNO, the exponent, the indicator.
pub const INDICATORS: usize = 3;

/// The integrals z and that of Y.
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
        let mut inverse = vec![1.0; 2 * variations.half()];
        variations.inverse_sizes(&motion.initial, &mut inverse);
        Self { inverse, shortened: 0.0, largest: 0.0 }
    }

    /// A departure of length one in all directions at once, by no random numbers.
    pub fn start(&self) -> Vec<f64> {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let share = |k: usize| (GOLDEN * (k + 1) as f64).fract() - 0.5;
        let count = self.inverse.len();
        let length = (0..count).map(|k| share(k) * share(k)).sum::<f64>().sqrt();
        (0..count).map(|k| share(k) / length / self.inverse[k]).collect()
    }

    /// L of a departure.
    pub fn growth<'a>(&self, departure: impl IntoIterator<Item = &'a f64>) -> f64 {
        let squares = departure.into_iter().zip(&self.inverse).map(|(x, inverse)| (x * inverse).powi(2));
        0.5 * squares.sum::<f64>().ln() + self.shortened
    }

    /// The integrals over a step from a time after the start on, with L at its nodes.
    pub fn integrate(
        &self,
        gauss: &Gauss,
        [from, size]: [f64; 2],
        growth: impl Fn(usize) -> f64,
        [first, second]: &mut [f64; INTEGRALS],
    ) {
        let growths: Vec<f64> = (0..gauss.nodes.len()).map(growth).collect();
        let sum = |factors: &[f64]| factors.iter().zip(&growths).map(|(b, l)| b * l).sum::<f64>();
        for (i, growth) in growths.iter().enumerate() {
            let inner = *first + size * sum(&gauss.integrals[i]);
            let rate = 2.0 * (growth - inner / (from + size * gauss.nodes[i]));
            *second += size * gauss.weights[i] * rate;
        }
        *first += size * sum(&gauss.weights);
    }

    /// The integrals over a step of fixed size, between whose ends nothing is known: by the trapezoidal rule.
    pub fn integrate_between(
        &self,
        [from, to]: [f64; 2],
        [before, after]: [f64; 2],
        [first, second]: &mut [f64; INTEGRALS],
    ) {
        let half = 0.5 * (to - from);
        let rate = |time: f64, growth: f64, inner: f64| {
            if time == 0.0 { 0.0 } else { 2.0 * (growth - inner / time) }
        };
        let start = rate(from, before, *first);
        *first += half * (before + after);
        *second += half * (start + rate(to, after, *first));
    }

    /// Notes a departure at the end of a step, and brings a long one back; whether it was long.
    pub fn settle(&mut self, departure: &mut [f64]) -> bool {
        let growth = self.growth(&*departure);
        self.largest = self.largest.max(growth);
        let long = growth - self.shortened > LONG.ln();
        if long {
            let factor = (self.shortened - growth).exp();
            departure.iter_mut().for_each(|x| *x *= factor);
            self.shortened = growth;
        }
        long
    }

    /// The indicators of a departure, a time after the start.
    pub fn indicators(
        &self,
        elapsed: f64,
        departure: &[f64],
        [_, second]: [f64; INTEGRALS],
    ) -> [f64; INDICATORS] {
        if elapsed == 0.0 {
            return [0.0; INDICATORS];
        }
        let growth = self.growth(departure);
        [second / elapsed, growth / elapsed.abs(), self.largest.max(growth)]
    }
}
