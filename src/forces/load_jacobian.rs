//! The derivatives of forces and torques with respect to the poses of the bodies and to the rates of the
//! poses.

use crate::math::Mat3;
use crate::mutual::Jacobian;

/// Three rows or columns of a body. In rows, the translational block is the force (inertial) and the
/// rotational block is the torque (body frame). In columns, they are position and rotation vector (body
/// frame), or velocity and spin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BodyBlock(usize);

impl BodyBlock {
    /// Returns the translational block of a body.
    pub const fn translation(body: usize) -> Self {
        Self(6 * body)
    }

    /// Returns the rotational block of a body.
    pub const fn rotation(body: usize) -> Self {
        Self(6 * body + 3)
    }
}

/// The derivatives of the loads: 6 N rows of 6 N numbers each.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadJacobian {
    size: usize,
    /// Derivatives with respect to positions and rotation vectors.
    pub by_pose: Vec<f64>,
    /// Derivatives with respect to velocities and spins; empty where no force depends on them.
    pub by_rate: Vec<f64>,
}

impl LoadJacobian {
    /// Returns derivatives of zero for this many bodies.
    pub fn new(bodies: usize, by_rate: bool) -> Self {
        let size = 6 * bodies;
        let count = size * size;
        Self { size, by_pose: vec![0.0; count], by_rate: vec![0.0; if by_rate { count } else { 0 }] }
    }

    /// Sets all derivatives to zero.
    pub fn clear(&mut self) {
        self.by_pose.fill(0.0);
        self.by_rate.fill(0.0);
    }

    /// Adds a block to the derivatives with respect to poses.
    #[inline(always)]
    pub fn add(&mut self, row: BodyBlock, column: BodyBlock, block: &Mat3, factor: f64) {
        add(&mut self.by_pose, self.size, row, column, block, factor);
    }

    /// Adds a block to the derivatives with respect to rates.
    #[inline(always)]
    pub fn add_by_rate(&mut self, row: BodyBlock, column: BodyBlock, block: &Mat3, factor: f64) {
        add(&mut self.by_rate, self.size, row, column, block, factor);
    }

    /// Adds the derivatives of the interaction of two bodies, multiplied by `strength`, which is G m_i m_j.
    pub fn add_pair(&mut self, jacobian: &Jacobian, [i, j]: [usize; 2], strength: f64) {
        let force = &jacobian.force_by_separation;
        for (row, sign) in [(i, strength), (j, -strength)] {
            self.add(BodyBlock::translation(row), BodyBlock::translation(j), force, sign);
            self.add(BodyBlock::translation(row), BodyBlock::translation(i), force, -sign);
        }
        for (k, body) in [i, j].into_iter().enumerate() {
            let torque = &jacobian.torque_by_separation[k];
            self.add(BodyBlock::rotation(body), BodyBlock::translation(j), torque, strength);
            self.add(BodyBlock::rotation(body), BodyBlock::translation(i), torque, -strength);
            let force = torque.transpose();
            self.add(BodyBlock::translation(i), BodyBlock::rotation(body), &force, -strength);
            self.add(BodyBlock::translation(j), BodyBlock::rotation(body), &force, strength);
            self.add(
                BodyBlock::rotation(body),
                BodyBlock::rotation(body),
                &jacobian.torque_by_rotation[k],
                strength,
            );
        }
        let crossed = &jacobian.torque_first_by_second;
        self.add(BodyBlock::rotation(i), BodyBlock::rotation(j), crossed, strength);
        self.add(BodyBlock::rotation(j), BodyBlock::rotation(i), &crossed.transpose(), strength);
    }
}

#[inline(always)]
fn add(
    all: &mut [f64],
    size: usize,
    BodyBlock(row): BodyBlock,
    BodyBlock(column): BodyBlock,
    block: &Mat3,
    factor: f64,
) {
    for r in 0..3 {
        let line = &mut all[(row + r) * size + column..][..3];
        for c in 0..3 {
            line[c] += factor * block[(r, c)];
        }
    }
}
