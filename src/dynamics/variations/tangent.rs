//! Conversion of tangent vectors from relative coordinates to those of the bodies.

use super::Variations;
use super::nominal::NominalChange;
use crate::dynamics::State;
use crate::math::Vec3;

/// The numbers of a tangent vector for each body: position, velocity, rotation vector and spin.
pub const TANGENT_SIZE: usize = 12;

impl Variations {
    /// Returns the transition matrix (12 N, 12 N) and the sensitivities (P, 12 N) to the parameters, from the
    /// matrix of tangent vectors in relative coordinates. The tangent vectors began at the state `start` and
    /// are now at the state `end`. For each body a tangent vector has position, velocity, rotation vector and
    /// spin. `nominal` says how the nominal barycentre changes with the state `start`.
    pub fn expand(
        &self,
        columns: &[f64],
        [start, end]: [&State; 2],
        nominal: &NominalChange,
    ) -> (Vec<f64>, Vec<f64>) {
        let (n, half) = (self.bodies, self.half());
        let size = TANGENT_SIZE * n;
        let mut transition = vec![0.0; size * size];
        let mut combination = Vec::new();
        for body in 0..n {
            for kind in 0..4 {
                for c in 0..3 {
                    combination.clear();
                    let column = TANGENT_SIZE * body + 3 * kind + c;
                    let mut barycentre_change = nominal.by(column);
                    let block = half * (kind % 2);
                    if kind >= 2 {
                        combination.push((block + self.rotation_row(body) + c, 1.0));
                    } else {
                        match self.position_row(body) {
                            Some(row) => combination.push((block + row + c, 1.0)),
                            None => {
                                combination.extend((1..n).map(|other| (block + 3 * (other - 1) + c, -1.0)))
                            }
                        }
                    }
                    // The barycentre moves with the body, and the rest of its change is that of its offset
                    // from the nominal one.
                    if let Some(row) = self.barycentre() {
                        let body_share = |part: usize, k: usize| {
                            if (part, k) == (kind, c) { self.share[body] } else { 0.0 }
                        };
                        let offsets = (0..6).map(|k| {
                            (
                                half * (k / 3) + row + k % 3,
                                body_share(k / 3, k % 3) - barycentre_change[k / 3][k % 3],
                            )
                        });
                        combination.extend(offsets.filter(|(_, offset)| *offset != 0.0));
                    }
                    barycentre_change[0] += barycentre_change[1] * (end.time - start.time);
                    self.spread(columns, &combination, barycentre_change, |row, value| {
                        transition[row * size + column] = value;
                    });
                }
            }
        }
        let mut sensitivity = vec![0.0; size * self.parameters.len()];
        for (k, out) in sensitivity.chunks_exact_mut(size).enumerate() {
            let nominal = self.nominal_by_masses(k, start);
            combination.clear();
            combination.push((2 * half + k, 1.0));
            // Where the barycentre has an equation of its own, its offset is relative to the nominal
            // barycentre, which changes with the masses.
            if let Some(row) = self.barycentre() {
                for (block, offset) in nominal.iter().enumerate() {
                    combination.extend((0..3).map(|c| (block * half + row + c, -offset[c])));
                }
            }
            let elapsed = end.time - start.time;
            let mut barycentre_change = [nominal[0] + nominal[1] * elapsed, nominal[1]];
            if !self.free {
                // The barycentre is then the mean of all bodies, weighted by fractions that depend on the
                // masses.
                let [position, velocity] = self.nominal_by_masses(k, end);
                barycentre_change[0] -= position;
                barycentre_change[1] -= velocity;
            }
            self.spread(columns, &combination, barycentre_change, |row, value| out[row] = value);
        }
        (transition, sensitivity)
    }

    /// Returns how the nominal barycentre changes with a state that becomes the start of a motion.
    pub fn nominal_at_start(&self, time: f64) -> NominalChange {
        NominalChange::at_start(time, &self.share, TANGENT_SIZE)
    }

    /// Returns the change of the mean position and velocity that follows from the change of the bodies' mass
    /// fractions by a parameter.
    fn nominal_by_masses(&self, parameter: usize, state: &State) -> [Vec3; 2] {
        let mean = |vectors: &[Vec3]| {
            (0..self.bodies).map(|body| self.share_by(parameter, body) * vectors[body]).sum::<Vec3>()
        };
        [mean(&state.position), mean(&state.velocity)]
    }

    /// Returns the derivative with respect to a parameter of a body's mass relative to the total mass.
    pub(super) fn share_by(&self, parameter: usize, body: usize) -> f64 {
        let total: f64 = self.masses.iter().sum();
        let by_mass = |body: usize| self.parameters[parameter].mass_derivative(body) / total;
        by_mass(body) - self.share[body] * (0..self.bodies).map(by_mass).sum::<f64>()
    }

    /// Converts a combination of columns to the bodies' own numbers; `moved` is added to the barycentre and
    /// its velocity.
    fn spread(
        &self,
        columns: &[f64],
        combination: &[(usize, f64)],
        barycentre_change: [Vec3; 2],
        mut out: impl FnMut(usize, f64),
    ) {
        let (n, width) = (self.bodies, self.width());
        let number =
            |row: usize| combination.iter().map(|(c, factor)| factor * columns[row * width + c]).sum::<f64>();
        for (block, barycentre_change) in barycentre_change.iter().enumerate() {
            let from = block * self.half();
            for c in 0..3 {
                let relative =
                    |body: usize| self.position_row(body).map_or(0.0, |row| number(from + row + c));
                let barycentre =
                    barycentre_change[c] + self.barycentre().map_or(0.0, |row| number(from + row + c));
                let first = barycentre - (1..n).map(|body| self.share[body] * relative(body)).sum::<f64>();
                for body in 0..n {
                    out(TANGENT_SIZE * body + 3 * block + c, first + relative(body));
                    out(TANGENT_SIZE * body + 6 + 3 * block + c, number(from + self.rotation_row(body) + c));
                }
            }
        }
    }
}
