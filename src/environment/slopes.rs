//! The derivatives of forces and torques with respect to where the bodies are and how they move.

use crate::math::Mat3;
use crate::mutual::Jacobian;

/// Which three numbers of a body: rows are `CENTRE` for the force, inertial, and `TURN` for the torque, in its
/// frame. Columns are position or velocity, and a rotation vector in the body frame or the spin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Triple(usize);

impl Triple {
    /// Of the centre of a body.
    pub const fn centre(body: usize) -> Self {
        Self(6 * body)
    }

    /// Of the turn of a body.
    pub const fn turn(body: usize) -> Self {
        Self(6 * body + 3)
    }
}

/// The derivatives, 6 N rows of 6 N numbers each.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadSlopes {
    size: usize,
    /// With positions and rotation vectors.
    pub by_place: Vec<f64>,
    /// With velocities and spins, where a force depends on them.
    pub by_motion: Vec<f64>,
}

impl LoadSlopes {
    /// Of so many bodies, of which nothing acts on any.
    pub fn new(bodies: usize, by_motion: bool) -> Self {
        let size = 6 * bodies;
        let count = size * size;
        Self { size, by_place: vec![0.0; count], by_motion: vec![0.0; if by_motion { count } else { 0 }] }
    }

    /// Of nothing again.
    pub fn clear(&mut self) {
        self.by_place.fill(0.0);
        self.by_motion.fill(0.0);
    }

    /// Adds a block to those with places.
    #[inline(always)]
    pub fn add(&mut self, row: Triple, column: Triple, block: &Mat3, factor: f64) {
        add(&mut self.by_place, self.size, row, column, block, factor);
    }

    /// Adds a block to those with motions.
    #[inline(always)]
    pub fn add_by_motion(&mut self, row: Triple, column: Triple, block: &Mat3, factor: f64) {
        add(&mut self.by_motion, self.size, row, column, block, factor);
    }

    /// Adds what two bodies do to each other, times G m m.
    pub fn add_pair(&mut self, jacobian: &Jacobian, [i, j]: [usize; 2], strength: f64) {
        let force = &jacobian.force_by_separation;
        for (row, sign) in [(i, strength), (j, -strength)] {
            self.add(Triple::centre(row), Triple::centre(j), force, sign);
            self.add(Triple::centre(row), Triple::centre(i), force, -sign);
        }
        for (k, body) in [i, j].into_iter().enumerate() {
            let torque = &jacobian.torque_by_separation[k];
            self.add(Triple::turn(body), Triple::centre(j), torque, strength);
            self.add(Triple::turn(body), Triple::centre(i), torque, -strength);
            let force = torque.transpose();
            self.add(Triple::centre(i), Triple::turn(body), &force, -strength);
            self.add(Triple::centre(j), Triple::turn(body), &force, strength);
            self.add(Triple::turn(body), Triple::turn(body), &jacobian.torque_by_rotation[k], strength);
        }
        let crossed = &jacobian.torque_first_by_second;
        self.add(Triple::turn(i), Triple::turn(j), crossed, strength);
        self.add(Triple::turn(j), Triple::turn(i), &crossed.transpose(), strength);
    }
}

#[inline(always)]
fn add(all: &mut [f64], size: usize, Triple(row): Triple, Triple(column): Triple, block: &Mat3, factor: f64) {
    for r in 0..3 {
        let line = &mut all[(row + r) * size + column..][..3];
        for c in 0..3 {
            line[c] += factor * block[(r, c)];
        }
    }
}
