//! Kepler motion in Jacobi's coordinates, in which body i moves about the barycentre of the bodies before it with
//! mu = G (m_0 + ... + m_i).
//!
//! Takes and gives vectors relative to the barycentre of all bodies, in two parts.

use super::layout::BodyBlocks;
use crate::math::Vec3;
use crate::math::compensated::{add_multiples, two_sum};
use crate::orbit::{KeplerChange, kepler_change};

/// The change before the first drift, filled with NaN.
const UNKNOWN: KeplerChange = {
    let unknown = Vec3::new(f64::NAN, f64::NAN, f64::NAN);
    KeplerChange { position: unknown, velocity: unknown, acceleration: unknown }
};

/// Jacobi's coordinates of a system: constants from the masses, and buffers.
#[derive(Debug, Clone)]
pub(super) struct Jacobi {
    mu: Vec<f64>,
    /// The share of body i in the total mass of bodies 0 to i.
    shares: Vec<f64>,
    /// The changes by the last drift, in Jacobi's coordinates. Entry 0, which would be that of the
    /// barycentre, is unused.
    changes: Vec<KeplerChange>,
}

impl Jacobi {
    pub fn new(masses: &[f64], gravitational_constant: f64) -> Self {
        let mut total = 0.0;
        let cumulative_mass: Vec<f64> = masses
            .iter()
            .map(|mass| {
                total += mass;
                total
            })
            .collect();
        Self {
            mu: cumulative_mass
                .iter()
                .map(|cumulative_mass| gravitational_constant * cumulative_mass)
                .collect(),
            shares: masses
                .iter()
                .zip(&cumulative_mass)
                .map(|(mass, cumulative_mass)| mass / cumulative_mass)
                .collect(),
            changes: vec![UNKNOWN; masses.len()],
        }
    }

    /// Moves the bodies over a time. The error is the index of a body for which Kepler's equation has no
    /// solution in doubles.
    #[inline(always)]
    pub fn drift(&mut self, time: f64, high: &mut BodyBlocks, low: &mut BodyBlocks) -> Result<(), usize> {
        let n = high.position.len();
        let (mu, shares, changes) = (&self.mu[..n], &self.shares[..n], &mut self.changes[..n]);
        let mut centre = Centre { high: high.position[0], low: low.position[0] };
        let mut centre_velocity = Centre { high: high.velocity[0], low: low.velocity[0] };
        for body in 1..n {
            let position = centre.vector_to(&high.position[body], &low.position[body]);
            let velocity = centre_velocity.vector_to(&high.velocity[body], &low.velocity[body]);
            let change = kepler_change(&position, &velocity, mu[body], time).ok_or(body)?;
            // The numbers are copied one by one, since a copy of the vector would wait until all are in memory.
            for c in 0..3 {
                changes[body].position[c] = change.position[c];
                changes[body].velocity[c] = change.velocity[c];
                changes[body].acceleration[c] = change.acceleration[c];
            }
            if body + 1 < n {
                centre.include(shares[body], &position);
                centre_velocity.include(shares[body], &velocity);
            }
        }
        let (mut centre, mut centre_velocity) = (Vec3::zeros(), Vec3::zeros());
        for body in (0..n).rev() {
            let position = barycentric_vector(body, shares[body], &changes[body].position, &mut centre);
            let velocity =
                barycentric_vector(body, shares[body], &changes[body].velocity, &mut centre_velocity);
            add_multiples(&mut high.position[body], &mut low.position[body], 1.0, &position.into());
            add_multiples(&mut high.velocity[body], &mut low.velocity[body], 1.0, &velocity.into());
        }
        Ok(())
    }

    /// Returns a body's acceleration by the Kepler motion at the end of the last drift. It must be called for
    /// the bodies from the last to the first, with a `centre` that begins as zero.
    #[inline(always)]
    pub fn acceleration(&self, body: usize, centre: &mut Vec3) -> Vec3 {
        barycentric_vector(body, self.shares[body], &self.changes[body].acceleration, centre)
    }

    /// Forgets the last drift: accelerations are NaN until the next one.
    pub fn reset(&mut self) {
        self.changes.fill(UNKNOWN);
    }
}

/// Returns a body's vector from the barycentre of all bodies, given its Jacobi vector. `centre` is the
/// barycentre of the bodies up to this one, and becomes that of the bodies before it.
#[inline(always)]
fn barycentric_vector(body: usize, share: f64, jacobi: &Vec3, centre: &mut Vec3) -> Vec3 {
    if body == 0 {
        return *centre;
    }
    *centre -= share * jacobi;
    *centre + jacobi
}

/// The barycentre of the bodies before a given one, in two parts: for two bodies the vector from it is then
/// exact.
struct Centre {
    high: [f64; 3],
    low: [f64; 3],
}

impl Centre {
    /// Returns the vector from this barycentre to the next body.
    #[inline(always)]
    fn vector_to(&self, high: &[f64; 3], low: &[f64; 3]) -> Vec3 {
        let mut vector = Vec3::zeros();
        for c in 0..3 {
            let (difference, error) = two_sum(high[c], -self.high[c]);
            vector[c] = difference + (error + (low[c] - self.low[c]));
        }
        vector
    }

    /// Includes the next body, given its mass relative to that of the bodies up to it.
    #[inline(always)]
    fn include(&mut self, share: f64, vector: &Vec3) {
        for c in 0..3 {
            let (sum, error) = two_sum(self.high[c], share * vector[c]);
            (self.high[c], self.low[c]) = (sum, self.low[c] + error);
        }
    }
}
