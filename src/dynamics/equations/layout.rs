//! The layout of a state in the integrator's vector.
//!
//! | block | length | quantity |
//! |---|---|---|
//! | position | 3 N | relative to the barycentre, inertial axes |
//! | velocity | 3 N | relative to the barycentre, inertial axes |
//! | attitude | 4 N or 3 N | quaternion, or Tait-Bryan angles |
//! | spin | 3 N | body frames |
//! | barycentre offset | 6 or 0 | position and velocity of the barycentre relative to the nominal one, with
//! external forces |
//! | work and impulse | 7 per force | work, impulse and angular impulse of each external force |
//!
//! Without external forces the barycentre moves uniformly. This nominal motion is kept apart from the vector,
//! so that a system that travels loses no digits of its separations. Every number has a low part: a state
//! that is converted to a vector and back is the same state.

use super::state::State;
use crate::forces::{MotionSnapshot, WORK_AND_IMPULSE};
use crate::math::compensated::{Compensated, sum, two_sum};
use crate::math::{Mat3, Vec3, rotation};
use crate::names::Named;

/// The chart in which attitudes are integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum AttitudeChart {
    /// Unit quaternions, which have no singularity.
    #[default]
    Quaternion,
    /// The paper's angles (phi, theta, psi), singular at theta = 90 degrees.
    TaitBryan,
}

impl Named for AttitudeChart {
    const WHAT: &'static str = "attitude_chart";
    const NAMES: &'static [(&'static str, Self)] =
        &[("quaternion", Self::Quaternion), ("tait_bryan", Self::TaitBryan)];
}

impl AttitudeChart {
    /// Returns the number of values per body.
    pub fn width(self) -> usize {
        match self {
            Self::Quaternion => 4,
            Self::TaitBryan => 3,
        }
    }
}

/// The layout of the integrator's vector, which determines the offsets of its blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// The number of bodies.
    pub bodies: usize,
    /// The chart in which attitudes are stored.
    pub chart: AttitudeChart,
    /// The number of external forces.
    pub forces: usize,
}

impl Layout {
    /// Returns the length of the vector.
    pub fn dimension(self) -> usize {
        self.dimension_without_quadratures() + WORK_AND_IMPULSE * self.forces
    }

    /// Returns the index of the first of the six numbers of the barycentre offset, which equals the length of
    /// the blocks of the bodies.
    #[inline]
    pub fn barycentre_offset(self) -> usize {
        (9 + self.chart.width()) * self.bodies
    }

    /// Returns the number of values on which the rates of change depend: all but work and impulse.
    #[inline]
    pub fn dimension_without_quadratures(self) -> usize {
        self.barycentre_offset() + if self.forces > 0 { 6 } else { 0 }
    }

    /// Returns work, impulse and angular impulse of all forces.
    pub fn work_and_impulse(self, y: &[f64]) -> &[f64] {
        if self.forces == 0 { &[] } else { &y[self.work_and_impulse_index(0)..] }
    }

    /// Returns the index of the first of the seven numbers of a force.
    #[inline]
    pub fn work_and_impulse_index(self, force: usize) -> usize {
        self.dimension_without_quadratures() + WORK_AND_IMPULSE * force
    }

    /// Returns the index of the first position component of a body.
    #[inline]
    pub fn position(self, body: usize) -> usize {
        3 * body
    }

    /// Returns the index of the first velocity component of a body.
    #[inline]
    pub fn velocity(self, body: usize) -> usize {
        3 * (self.bodies + body)
    }

    /// Returns the index of the first attitude component of a body.
    #[inline]
    pub fn attitude(self, body: usize) -> usize {
        6 * self.bodies + self.chart.width() * body
    }

    /// Returns the index of the first spin component of a body.
    #[inline]
    pub fn spin(self, body: usize) -> usize {
        (6 + self.chart.width()) * self.bodies + 3 * body
    }

    /// Writes attitude and spin of a body alone into a vector with quaternions.
    pub fn write_rotation(self, state: &State, y: &mut [f64]) {
        y[self.attitude(0)..][..4].copy_from_slice(&state.attitude[0]);
        y[self.spin(0)..][..3].copy_from_slice(state.spin[0].as_slice());
    }
}

/// The blocks of the bodies in a vector with quaternions.
pub(super) struct BodyBlocks<'a> {
    pub position: &'a mut [[f64; 3]],
    pub velocity: &'a mut [[f64; 3]],
    pub attitude: &'a mut [[f64; 4]],
    pub spin: &'a mut [[f64; 3]],
}

impl<'a> BodyBlocks<'a> {
    /// Splits a vector of this many bodies.
    #[inline(always)]
    pub fn new(bodies: usize, y: &'a mut [f64]) -> Self {
        let (position, y) = y.split_at_mut(3 * bodies);
        let (velocity, y) = y.split_at_mut(3 * bodies);
        let (attitude, y) = y.split_at_mut(4 * bodies);
        Self {
            position: &mut position.as_chunks_mut().0[..bodies],
            velocity: &mut velocity.as_chunks_mut().0[..bodies],
            attitude: &mut attitude.as_chunks_mut().0[..bodies],
            spin: &mut y.as_chunks_mut().0[..bodies],
        }
    }
}

/// The frame of the integrator's vectors: inertial axes at the barycentre, with the motion of the nominal
/// barycentre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarycentricFrame {
    /// The layout of the vectors.
    pub layout: Layout,
    /// The time at which the barycentre was at `barycentre`.
    pub epoch: f64,
    /// The position of the barycentre at `epoch`.
    pub barycentre: [f64; 3],
    /// The velocity of the nominal barycentre.
    pub barycentre_velocity: [f64; 3],
}

impl BarycentricFrame {
    /// Returns the frame of a state, and the state in it as a vector with its low part. Tait-Bryan angles
    /// start in their principal range.
    pub fn new(layout: Layout, masses: &[f64], state: &State) -> (Self, Vec<f64>, Vec<f64>) {
        let total = sum(masses.iter().copied());
        let mean = |vectors: &[Vec3]| {
            [0, 1, 2].map(|c| sum(vectors.iter().zip(masses).map(|(v, m)| v[c] * (m / total))))
        };
        let (barycentre, barycentre_velocity) = (mean(&state.position), mean(&state.velocity));
        let mut high = vec![0.0; layout.dimension()];
        let mut low = high.clone();
        let parts = |value: Compensated| (value.high, value.low);
        for body in 0..layout.bodies {
            let (p, v) = (layout.position(body), layout.velocity(body));
            for c in 0..3 {
                (high[p + c], low[p + c]) =
                    parts(Compensated::difference(state.position[body][c], barycentre[c]));
                (high[v + c], low[v + c]) =
                    parts(Compensated::difference(state.velocity[body][c], barycentre_velocity[c]));
            }
            let (a, s) = (layout.attitude(body), layout.spin(body));
            match layout.chart {
                AttitudeChart::Quaternion => high[a..a + 4].copy_from_slice(&state.attitude[body]),
                AttitudeChart::TaitBryan => {
                    high[a..a + 3].copy_from_slice(&rotation::to_tait_bryan(state.attitude[body]));
                }
            }
            high[s..s + 3].copy_from_slice(state.spin[body].as_slice());
        }
        (Self { layout, epoch: state.time, barycentre, barycentre_velocity }, high, low)
    }

    /// Returns the nominal barycentre at a time.
    pub fn nominal_at(&self, time: f64) -> Vec3 {
        Vec3::from(self.barycentre) + Vec3::from(self.barycentre_velocity) * (time - self.epoch)
    }

    /// Returns the position and velocity of the barycentre relative to the nominal one.
    #[inline(always)]
    pub fn barycentre_offset(&self, y: &[f64]) -> (Vec3, Vec3) {
        let at = self.layout.barycentre_offset();
        if self.layout.forces == 0 {
            return Default::default();
        }
        let y: &[f64; 6] = &y[at..].as_chunks().0[0];
        (vector(y, 0), vector(y, 3))
    }

    /// Returns the barycentre at a time, for a vector.
    pub fn barycentre_at(&self, time: f64, y: &[f64]) -> Vec3 {
        self.nominal_at(time) + self.barycentre_offset(y).0
    }

    /// Returns the attitude of a body in a vector, as a unit quaternion.
    pub fn attitude(&self, body: usize, y: &[f64]) -> [f64; 4] {
        let a = self.layout.attitude(body);
        match self.layout.chart {
            AttitudeChart::TaitBryan => rotation::from_tait_bryan([y[a], y[a + 1], y[a + 2]]),
            AttitudeChart::Quaternion => {
                let q = [y[a], y[a + 1], y[a + 2], y[a + 3]];
                let length = q.iter().map(|c| c * c).sum::<f64>();
                if (length - 1.0).abs() < 4.0 * f64::EPSILON { q } else { rotation::normalised(q) }
            }
        }
    }

    /// Returns the snapshot of a vector at a time, with the bodies' rotation matrices and, where forces need
    /// them, their attitudes.
    #[inline(always)]
    pub fn snapshot<'a>(
        &self,
        time: f64,
        y: &'a [f64],
        rotation: &'a [Mat3],
        attitude: &'a [[f64; 4]],
    ) -> MotionSnapshot<'a> {
        let layout = self.layout;
        let block = |start: usize| &y[start..].as_chunks().0[..layout.bodies];
        let (offset, offset_rate) = self.barycentre_offset(y);
        MotionSnapshot {
            time,
            position: block(layout.position(0)),
            velocity: block(layout.velocity(0)),
            spin: block(layout.spin(0)),
            rotation: &rotation[..layout.bodies],
            attitude,
            barycentre_offset: [offset, offset_rate],
            nominal: [self.nominal_at(time), Vec3::from(self.barycentre_velocity)],
        }
    }

    /// Returns the state for the vector `high` + `low` at a time.
    pub fn state(&self, time: f64, high: &[f64], low: &[f64]) -> State {
        let layout = self.layout;
        let elapsed = time - self.epoch;
        let displacement = self.barycentre_velocity.map(|v| v * elapsed);
        let (offset, offset_rate) = self.barycentre_offset(high);
        let (offset_low, offset_rate_low) = self.barycentre_offset(low);
        let absolute = |index: usize, nominal: [f64; 3], displacement: [f64; 3], offset: Vec3, tail: Vec3| {
            Vec3::from([0, 1, 2].map(|c| {
                let (partial, first) = two_sum(nominal[c], displacement[c]);
                let (barycentre, second) = two_sum(partial, offset[c]);
                let (total, third) = two_sum(barycentre, high[index + c]);
                total + (first + second + third + low[index + c] + tail[c])
            }))
        };
        let per_body = |f: &dyn Fn(usize) -> Vec3| (0..layout.bodies).map(f).collect::<Vec<_>>();
        State {
            time,
            position: per_body(&|b| {
                absolute(layout.position(b), self.barycentre, displacement, offset, offset_low)
            }),
            velocity: per_body(&|b| {
                absolute(layout.velocity(b), self.barycentre_velocity, [0.0; 3], offset_rate, offset_rate_low)
            }),
            attitude: (0..layout.bodies).map(|b| self.attitude(b, high)).collect(),
            spin: per_body(&|b| vector(high, layout.spin(b))),
        }
    }
}

/// Returns the three numbers from an index on as a vector.
#[inline]
pub(in crate::dynamics) fn vector(y: &[f64], index: usize) -> Vec3 {
    Vec3::new(y[index], y[index + 1], y[index + 2])
}
