//! Kepler motion in Jacobi's coordinates, in which body i moves about the barycentre of those before it with
//! mu = G (m_0 + ... + m_i).
//!
//! Takes and gives numbers from the barycentre of all, three a body.

use crate::math::Vec3;
use crate::math::compensated::two_sum;
use crate::orbit::kepler_change;

/// What the motion takes of the masses, and its scratch.
#[derive(Debug, Clone)]
pub(super) struct Jacobi {
    mu: Vec<f64>,
    /// Share of body i in the mass of it and all before it.
    shares: Vec<f64>,
    position: Vec<Vec3>,
    velocity: Vec<Vec3>,
}

impl Jacobi {
    pub fn new(masses: &[f64], gravitational_constant: f64) -> Self {
        let mut total = 0.0;
        let within: Vec<f64> = masses
            .iter()
            .map(|mass| {
                total += mass;
                total
            })
            .collect();
        let zeros = vec![Vec3::zeros(); masses.len()];
        Self {
            mu: within.iter().map(|within| gravitational_constant * within).collect(),
            shares: masses.iter().zip(&within).map(|(mass, within)| mass / within).collect(),
            position: zeros.clone(),
            velocity: zeros,
        }
    }

    /// Changes of positions and velocities over a time, from the two parts of these; `None` where Kepler's equation has no solution
    /// in doubles.
    #[inline(always)]
    pub fn drift(&mut self, time: f64, [high, low]: [&[f64]; 2], change: &mut [f64]) -> Option<()> {
        let half = high.len() / 2;
        enter(&self.shares, [&high[..half], &low[..half]], &mut self.position);
        enter(&self.shares, [&high[half..], &low[half..]], &mut self.velocity);
        for body in 1..self.mu.len() {
            let (position, velocity) = (&mut self.position[body], &mut self.velocity[body]);
            (*position, *velocity) = kepler_change(position, velocity, self.mu[body], time)?;
        }
        leave(&self.shares, &self.position, &mut change[..half]);
        leave(&self.shares, &self.velocity, &mut change[half..]);
        Some(())
    }

    /// The accelerations of the motion, from the two parts of the positions.
    #[inline(always)]
    pub fn accelerations(&mut self, [high, low]: [&[f64]; 2], numbers: &mut [f64]) {
        enter(&self.shares, [high, low], &mut self.position);
        for body in 1..self.mu.len() {
            let position = &mut self.position[body];
            let distance = position.norm();
            *position *= -self.mu[body] / (distance * distance * distance);
        }
        leave(&self.shares, &self.position, numbers);
    }
}

/// Jacobi's vectors of numbers in two parts. The first would be that of the barycentre and is left alone.
#[inline(always)]
fn enter(shares: &[f64], [high, low]: [&[f64]; 2], vectors: &mut [Vec3]) {
    let (high, low) = (high.as_chunks::<3>().0, low.as_chunks::<3>().0);
    // The barycentre of the bodies before each, with its low part: for two bodies the difference is then exact.
    let (mut centre, mut tail) = (high[0], low[0]);
    for body in 1..vectors.len() {
        let (high, low) = (high[body], low[body]);
        for c in 0..3 {
            let (difference, error) = two_sum(high[c], -centre[c]);
            vectors[body][c] = difference + (error + (low[c] - tail[c]));
        }
        if body + 1 < vectors.len() {
            for c in 0..3 {
                let (sum, error) = two_sum(centre[c], shares[body] * vectors[body][c]);
                (centre[c], tail[c]) = (sum, tail[c] + error);
            }
        }
    }
}

/// Jacobi's vectors as numbers from the barycentre of all.
#[inline(always)]
fn leave(shares: &[f64], vectors: &[Vec3], numbers: &mut [f64]) {
    let numbers = numbers.as_chunks_mut::<3>().0;
    let mut centre = Vec3::zeros();
    for body in (1..vectors.len()).rev() {
        let jacobi = vectors[body];
        centre -= shares[body] * jacobi;
        numbers[body] = (centre + jacobi).into();
    }
    numbers[0] = centre.into();
}
