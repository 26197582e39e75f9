//! Indicators of chaos: MEGNO, the fast Lyapunov indicator and the largest Lyapunov exponent.
//!
//! For a tangent vector delta, measured in the natural sizes of its numbers at the start, let L = ln |delta|
//! / |delta_0| at the time s since the start. Then
//!
//!   Y = 2/t int_0^t s dL = 2 (L - z/t),   z = int_0^t L ds,   and its mean is 1/t int_0^t Y ds:
//!
//! Cincotta & Simo (2000), Astron. Astrophys. Suppl. 147, 205. The mean tends to 2 for regular motion and to
//! t/2 times the largest Lyapunov exponent for chaotic motion. L/t tends to that exponent, and the largest L
//! so far is the fast Lyapunov indicator of Froeschle, Lega & Gonczi (1997), Celest. Mech. Dyn. Astron. 67,
//! 41. Both integrals are two more numbers of the equations. The tangent vector is scaled back to its first
//! length when it has grown long.

use super::motion::Motion;
use crate::dynamics::Variations;
use crate::math::gauss::Gauss;

/// The numbers recorded for a sample: the mean of MEGNO, the Lyapunov exponent and the fast Lyapunov
/// indicator.
pub const INDICATORS: usize = 3;

/// The number of integrals of a tangent vector: z and the integral of Y.
pub(super) const INTEGRALS: usize = 2;

/// The length at which a tangent vector is scaled back.
const LONG: f64 = 1e60;

/// The growth of a tangent vector, from its length and the factors by which it was scaled back.
#[derive(Debug, Clone)]
pub(super) struct TangentGrowth {
    /// One over the natural size of each number.
    inverse: Vec<f64>,
    /// The logarithm of the product of the factors by which the vector was scaled back.
    log_scale: f64,
    /// The largest L so far.
    largest: f64,
}

impl TangentGrowth {
    /// Takes the natural sizes at the start of a run.
    pub fn new(motion: &Motion, variations: &Variations) -> Self {
        let mut inverse = vec![1.0; 2 * variations.half()];
        variations.inverse_sizes(&motion.initial, &mut inverse);
        Self { inverse, log_scale: 0.0, largest: 0.0 }
    }

    /// Returns a tangent vector of length one with components in all directions, made without random numbers.
    pub fn start(&self) -> Vec<f64> {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let share = |k: usize| (GOLDEN * (k + 1) as f64).fract() - 0.5;
        let count = self.inverse.len();
        let length = (0..count).map(|k| share(k) * share(k)).sum::<f64>().sqrt();
        (0..count).map(|k| share(k) / length / self.inverse[k]).collect()
    }

    /// Returns L of a tangent vector.
    pub fn growth<'a>(&self, tangent: impl IntoIterator<Item = &'a f64>) -> f64 {
        let squares = tangent.into_iter().zip(&self.inverse).map(|(x, inverse)| (x * inverse).powi(2));
        0.5 * squares.sum::<f64>().ln() + self.log_scale
    }

    /// Adds the integrals over a step, given by its start and size, with L at its nodes.
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

    /// Adds the integrals over a step of fixed size by the trapezoidal rule, since nothing is known between
    /// its ends.
    pub fn integrate_between(
        &self,
        [from, to]: [f64; 2],
        [growth_from, growth_to]: [f64; 2],
        [first, second]: &mut [f64; INTEGRALS],
    ) {
        let half = 0.5 * (to - from);
        let rate = |time: f64, growth: f64, inner: f64| {
            if time == 0.0 { 0.0 } else { 2.0 * (growth - inner / time) }
        };
        let start = rate(from, growth_from, *first);
        *first += half * (growth_from + growth_to);
        *second += half * (start + rate(to, growth_to, *first));
    }

    /// Records the growth at the end of a step, and scales a long vector back. Returns whether it was long.
    pub fn rescale(&mut self, tangent: &mut [f64]) -> bool {
        let growth = self.growth(&*tangent);
        self.largest = self.largest.max(growth);
        let long = growth - self.log_scale > LONG.ln();
        if long {
            let factor = (self.log_scale - growth).exp();
            tangent.iter_mut().for_each(|x| *x *= factor);
            self.log_scale = growth;
        }
        long
    }

    /// Returns the indicators for a tangent vector at this time after the start.
    pub fn indicators(
        &self,
        elapsed: f64,
        tangent: &[f64],
        [_, second]: [f64; INTEGRALS],
    ) -> [f64; INDICATORS] {
        if elapsed == 0.0 {
            return [0.0; INDICATORS];
        }
        let growth = self.growth(tangent);
        [second / elapsed, growth / elapsed.abs(), self.largest.max(growth)]
    }
}
