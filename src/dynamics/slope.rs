//! The derivatives of a system's forces and torques with its state.

use super::system::{NEW_PAIR, pose};
use super::{State, System};
use crate::error::{Error, Result};
use crate::math::Mat3;
use crate::patience::Patience;

/// A Jacobian takes about this many times the work of an interaction.
const JACOBIAN: u64 = 4;

impl System {
    /// Derivatives (6 N, 6 N) of the forces and torques of the bodies' gravity with their places and turns, in C order.
    ///
    /// Rows per body: force (inertial), torque (body frame); columns per body: position (inertial) and a rotation vector v in the body
    /// frame, R -> R exp(v).
    pub fn jacobian(&self, state: &State, patience: &mut Patience) -> Result<Vec<f64>> {
        self.check(state, patience)?;
        self.moments(patience).map_err(|error| error.at(state.time))?;
        let size = 6 * self.bodies.len();
        let mut rows = vec![0.0; size * size];
        let mut add = |row: usize, column: usize, block: &Mat3, factor: f64| {
            for r in 0..3 {
                for c in 0..3 {
                    rows[(row + r) * size + column + c] += factor * block[(r, c)];
                }
            }
        };
        for (i, j) in self.pairs() {
            let pose = pose(state, i, j);
            let strength = self.strength(i, j);
            for mut link in self.links(i, j) {
                patience.spend(NEW_PAIR, state.time)?;
                link.prepare(&pose, None, patience).map_err(|error| error.at(state.time))?;
                link.prepare_jacobian(patience).map_err(|error| error.at(state.time))?;
                patience.spend(JACOBIAN * link.pair.work(), state.time)?;
                let slopes = link.jacobian(&pose);
                let torques = &slopes.torque_by_separation;
                let turns = &slopes.torque_by_rotation;
                let other = slopes.torque_first_by_second;
                for (body, sign) in [(i, strength), (j, -strength)] {
                    add(6 * body, 6 * i, &slopes.force_by_separation, -sign);
                    add(6 * body, 6 * j, &slopes.force_by_separation, sign);
                    add(6 * body, 6 * i + 3, &torques[0].transpose(), -sign);
                    add(6 * body, 6 * j + 3, &torques[1].transpose(), -sign);
                }
                for (k, body) in [i, j].into_iter().enumerate() {
                    add(6 * body + 3, 6 * i, &torques[k], -strength);
                    add(6 * body + 3, 6 * j, &torques[k], strength);
                    add(6 * body + 3, 6 * body + 3, &turns[k], strength);
                }
                add(6 * i + 3, 6 * j + 3, &other, strength);
                add(6 * j + 3, 6 * i + 3, &other.transpose(), strength);
            }
        }
        match rows.iter().find(|value| !value.is_finite()) {
            None => Ok(rows),
            Some(value) => Err(Error::invalid(
                "derivatives of the forces",
                value,
                "finite numbers; choose units that keep the numbers in range",
            )),
        }
    }
}
