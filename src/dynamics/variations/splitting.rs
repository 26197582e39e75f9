//! The variational equations under the two flows of a splitting.
//!
//! The kicks change p by A q alone, where A contains the loads without the Kepler motion. A drift is either
//! the Kepler motion with the free rotation, whose variational equations are those of a motion without other
//! loads, or the straight motion with the discrete rotation, whose derivative has a closed form.

use super::Variations;
use super::products::KickProduct;
use crate::dynamics::equations::layout::vector;
use crate::dynamics::rotation::discrete_rotor::RotationDerivatives;
use crate::dynamics::{Dynamics, Layout, Parameter};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3};

impl Variations {
    /// Evaluates the coefficients of a kick as [`Self::evaluate`] does, but without the spins, and without
    /// the Kepler motion if that is the drift.
    pub fn evaluate_kick(
        &mut self,
        dynamics: &mut Dynamics,
        time: f64,
        y: &[f64],
        kepler: bool,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        self.evaluate_coefficients(dynamics, time, y, false, interrupt)?;
        if kepler {
            self.add_kepler(dynamics, y, -1.0);
        }
        Ok(())
    }

    /// Evaluates the coefficients of the drift of Kepler motion and free rotation as [`Self::evaluate`] does.
    pub fn evaluate_drift(&mut self, dynamics: &Dynamics, y: &[f64]) {
        self.clear(dynamics.layout(), y, true);
        self.by_pose.fill(0.0);
        self.by_rate.fill(0.0);
        self.force_by_inertia();
        self.add_kepler(dynamics, y, 1.0);
    }

    /// Adds the Kepler motion in Jacobi's coordinates, in which body i moves about the barycentre of those
    /// before it.
    fn add_kepler(&mut self, dynamics: &Dynamics, y: &[f64], sign: f64) {
        let (n, layout) = (self.bodies, dynamics.layout());
        let g = dynamics.system().gravitational_constant();
        // The rows hold derivatives of d; `forced` holds those of accelerations by G and by the masses.
        let mut rows = vec![vec![Mat3::zeros(); n]; n];
        let mut forced = vec![vec![Vec3::zeros(); self.parameters.len()]; n];
        let mut accelerations = vec![Vec3::zeros(); n];
        let origin = vector(y, layout.position(0));
        let mut cumulative_mass = self.masses[0];
        for i in 1..n {
            let mut r = vector(y, layout.position(i)) - origin;
            for k in 1..i {
                r -= (vector(y, layout.position(k)) - origin) * (self.masses[k] / cumulative_mass);
            }
            let (distance, inner_mass) = (r.norm(), cumulative_mass);
            cumulative_mass += self.masses[i];
            let u = r / distance;
            let attraction = u / (distance * distance);
            let slope =
                (3.0 * u * u.transpose() - Mat3::identity()) * (g * cumulative_mass / distance.powi(3));
            accelerations[i] -= attraction * (g * cumulative_mass);
            for j in 1..=i {
                let share = if j == i { 1.0 } else { -self.masses[j] / inner_mass };
                rows[i][j] += slope * share;
            }
            for (k, parameter) in self.parameters.iter().enumerate() {
                let mass: f64 = (0..=i).map(|body| parameter.mass_derivative(body)).sum();
                let mu = g * mass
                    + if *parameter == Parameter::GravitationalConstant { cumulative_mass } else { 0.0 };
                forced[i][k] -= attraction * mu;
            }
            for k in 1..i {
                let share = self.masses[k] / inner_mass;
                for j in 1..=k {
                    let block = rows[k][j];
                    rows[i][j] += block * share;
                }
                let acceleration = accelerations[k];
                accelerations[i] += acceleration * share;
                for p in 0..self.parameters.len() {
                    let value = forced[k][p];
                    forced[i][p] += value * share;
                }
            }
        }
        for (i, row) in rows.iter().enumerate().skip(1) {
            for (j, block) in row.iter().enumerate().skip(1) {
                for r in 0..3 {
                    for c in 0..3 {
                        self.by_pose[(3 * (i - 1) + r) * self.stride + 3 * (j - 1) + c] +=
                            sign * block[(r, c)];
                    }
                }
            }
        }
        // The Kepler motion does not move the barycentre, but a change of the masses changes the bodies'
        // shares in it.
        for p in 0..self.parameters.len() {
            let centre: Vec3 =
                (1..n).map(|i| self.share[i] * forced[i][p] + self.share_by(p, i) * accelerations[i]).sum();
            for body in 0..n {
                let relative_acceleration = if body == 0 { Vec3::zeros() } else { forced[body][p] };
                self.forcing[p * n + body][0] += (relative_acceleration - centre) * sign;
            }
        }
    }

    /// Applies the drift along straight lines with the discrete rotation, starting from a vector. Returns
    /// `None` where the rotation has no solution.
    pub fn drift_straight(&self, layout: Layout, y: &[f64], size: f64, columns: &mut [f64]) -> Option<()> {
        let (half, width) = (self.half(), self.width());
        let (q, p) = columns.split_at_mut(half * width);
        let centres =
            (0..3 * (self.bodies - 1)).chain(self.barycentre().into_iter().flat_map(|row| row..row + 3));
        for row in centres {
            let rates = &p[row * width..][..width];
            q[row * width..][..width].iter_mut().zip(rates).for_each(|(q, p)| *q += size * p);
        }
        for (body, inertia) in self.inertia.iter().enumerate() {
            let derivatives = RotationDerivatives::new(*inertia, vector(y, layout.spin(body)), size)?;
            let row = self.rotation_row(body);
            for column in 0..width {
                let at = |c: usize| (row + c) * width + column;
                let read = |from: &[f64]| Vec3::new(from[at(0)], from[at(1)], from[at(2)]);
                let (theta, spin) = (read(q), read(p));
                let moments =
                    column.checked_sub(self.initial).map_or(Vec3::zeros(), |k| self.by_inertia(k, body));
                let theta = derivatives.transposed * theta
                    + derivatives.rotation[0] * spin
                    + derivatives.rotation[1] * moments;
                let spin = derivatives.spin[0] * spin + derivatives.spin[1] * moments;
                (0..3).for_each(|c| (q[at(c)], p[at(c)]) = (theta[c], spin[c]));
            }
        }
        Some(())
    }

    /// Applies a kick with the coefficients of the last [`Self::evaluate_kick`].
    pub fn kick(&self, arch: pulp::Arch, size: f64, columns: &mut [f64]) {
        let shape @ [half, width] = [self.half(), self.width()];
        let (matrix, stride) = (&self.by_pose, self.stride);
        arch.dispatch(KickProduct { matrix, stride, size, shape, columns });
        self.force(|row, column, value| columns[(half + row) * width + column] += size * value);
    }

    /// Clears the coefficients, and stores the spins of a vector where they are needed.
    pub(super) fn clear(&mut self, layout: Layout, y: &[f64], with_spins: bool) {
        self.torque.fill(Vec3::zeros());
        self.forcing.fill([Vec3::zeros(); 2]);
        for body in 0..self.bodies {
            self.spin[body] = if with_spins { vector(y, layout.spin(body)) } else { Vec3::zeros() };
        }
    }
}
