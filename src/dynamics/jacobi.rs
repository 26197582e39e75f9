//! Jacobi's coordinates: body i from the barycentre of those before it.

use crate::math::Vec3;
use crate::math::compensated::two_sum;

/// What they take of the masses.
#[derive(Debug, Clone)]
pub(super) struct Jacobi {
    /// Mass of body i and all before it.
    pub within: Vec<f64>,
    /// Share of body i in that.
    shares: Vec<f64>,
}

impl Jacobi {
    pub fn new(masses: &[f64]) -> Self {
        let mut total = 0.0;
        let within: Vec<f64> = masses
            .iter()
            .map(|mass| {
                total += mass;
                total
            })
            .collect();
        let shares = masses.iter().zip(&within).map(|(mass, within)| mass / within).collect();
        Self { within, shares }
    }

    /// Jacobi's vectors of bodies whose components are given in two parts. The first is zero, since the barycentre of all rests at
    /// the origin.
    #[inline]
    pub fn enter(&self, vectors: &mut [Vec3], number: impl Fn(usize, usize) -> (f64, f64)) {
        vectors[0] = Vec3::zeros();
        for c in 0..3 {
            // The barycentre of the bodies before i, with its low part: for two bodies the difference is then exact.
            let (mut centre, mut tail) = number(0, c);
            for body in 1..vectors.len() {
                let (high, low) = number(body, c);
                let (difference, error) = two_sum(high, -centre);
                let vector = difference + (error + (low - tail));
                vectors[body][c] = vector;
                if body + 1 < vectors.len() {
                    let (sum, error) = two_sum(centre, self.shares[body] * vector);
                    (centre, tail) = (sum, tail + error);
                }
            }
        }
    }

    /// Turns Jacobi's vectors into those from the barycentre of all.
    #[inline]
    pub fn leave(&self, vectors: &mut [Vec3]) {
        let mut centre = Vec3::zeros();
        for body in (1..vectors.len()).rev() {
            let jacobi = vectors[body];
            centre -= self.shares[body] * jacobi;
            vectors[body] = centre + jacobi;
        }
        vectors[0] = centre;
    }
}
