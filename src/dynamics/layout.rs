//! How a state lies in the integrator's vector.
//!
//! | block | length | quantity |
//! |---|---|---|
//! | position | 3 N | from the barycentre, inertial axes |
//! | velocity | 3 N | relative to the barycentre, inertial axes |
//! | attitude | 4 N or 3 N | quaternion, or Tait-Bryan angles |
//! | spin | 3 N | body frames |
//! | departure | 6 or 0 | position and velocity of the barycentre from the nominal one, where there are forces from outside |
//! | books | 7 a force | work, impulse and angular impulse |
//!
//! Without forces from outside the barycentre moves uniformly. This nominal motion is kept apart from the vector, so that a system
//! that travels loses no digits of its separations. Every number has a low part: a state that is converted to a vector and back is
//! the same state.

use super::State;
use crate::environment::{BOOK, Scene};
use crate::math::compensated::{Compensated, sum, two_sum};
use crate::math::{Mat3, Vec3, rotation};
use crate::names::Named;

/// How attitudes are integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AttitudeChart {
    /// Unit quaternions: no singularity.
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
    /// Numbers per body.
    pub fn width(self) -> usize {
        match self {
            Self::Quaternion => 4,
            Self::TaitBryan => 3,
        }
    }
}

/// Offsets of the blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Number of bodies.
    pub bodies: usize,
    /// How attitudes are stored.
    pub chart: AttitudeChart,
    /// Number of forces from outside.
    pub forces: usize,
}

impl Layout {
    /// Length of the vector.
    pub fn dimension(self) -> usize {
        self.dependent() + BOOK * self.forces
    }

    /// Index of the first of the six numbers of the barycentre's departure: the number of all that the bodies have.
    #[inline]
    pub fn departure(self) -> usize {
        (9 + self.chart.width()) * self.bodies
    }

    /// Number of numbers that the rates of change depend on: all but the books.
    #[inline]
    pub fn dependent(self) -> usize {
        self.departure() + if self.forces > 0 { 6 } else { 0 }
    }

    /// The books of all forces.
    pub fn books(self, y: &[f64]) -> &[f64] {
        if self.forces == 0 { &[] } else { &y[self.book(0)..] }
    }

    /// Index of the first number in the books of a force.
    #[inline]
    pub fn book(self, force: usize) -> usize {
        self.dependent() + BOOK * force
    }

    /// Index of the first position component of a body.
    #[inline]
    pub fn position(self, body: usize) -> usize {
        3 * body
    }

    /// Index of the first velocity component of a body.
    #[inline]
    pub fn velocity(self, body: usize) -> usize {
        3 * (self.bodies + body)
    }

    /// Index of the first attitude component of a body.
    #[inline]
    pub fn attitude(self, body: usize) -> usize {
        6 * self.bodies + self.chart.width() * body
    }

    /// Index of the first spin component of a body.
    #[inline]
    pub fn spin(self, body: usize) -> usize {
        (6 + self.chart.width()) * self.bodies + 3 * body
    }
}

/// The numbers of the bodies in a vector with quaternions.
pub(super) struct Blocks<'a> {
    pub position: &'a mut [[f64; 3]],
    pub velocity: &'a mut [[f64; 3]],
    pub attitude: &'a mut [[f64; 4]],
    pub spin: &'a mut [[f64; 3]],
}

impl<'a> Blocks<'a> {
    /// Of so many bodies.
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

/// The frame in which the integrator's vectors are: inertial axes at the barycentre, and where that nominally is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarycentricFrame {
    /// Where the blocks of a vector are.
    pub layout: Layout,
    /// Time at which the barycentre was at `barycentre`.
    pub epoch: f64,
    /// Position of the barycentre at `epoch`.
    pub barycentre: [f64; 3],
    /// Velocity of the nominal barycentre.
    pub barycentre_velocity: [f64; 3],
}

impl BarycentricFrame {
    /// The frame of a state; the state in it, as a vector; and what rounding dropped of the vector. Tait-Bryan angles start in
    /// their principal range.
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

    /// The nominal barycentre at a time.
    pub fn nominal_at(&self, time: f64) -> Vec3 {
        Vec3::from(self.barycentre) + Vec3::from(self.barycentre_velocity) * (time - self.epoch)
    }

    /// The barycentre's departure from the nominal one, and the rate of that.
    #[inline(always)]
    pub fn departure(&self, y: &[f64]) -> (Vec3, Vec3) {
        let at = self.layout.departure();
        if self.layout.forces == 0 {
            return Default::default();
        }
        let y: &[f64; 6] = &y[at..].as_chunks().0[0];
        (vector(y, 0), vector(y, 3))
    }

    /// The barycentre at a time, of a vector.
    pub fn barycentre_at(&self, time: f64, y: &[f64]) -> Vec3 {
        self.nominal_at(time) + self.departure(y).0
    }

    /// The attitude of a body in a vector, as a unit quaternion.
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

    /// The bodies of a vector at a time, with their rotation matrices and, where forces want them, their attitudes.
    #[inline(always)]
    pub fn scene<'a>(
        &self,
        time: f64,
        y: &'a [f64],
        rotation: &'a [Mat3],
        attitude: &'a [[f64; 4]],
    ) -> Scene<'a> {
        let layout = self.layout;
        let block = |start: usize| &y[start..].as_chunks().0[..layout.bodies];
        let (departed, departing) = self.departure(y);
        Scene {
            time,
            position: block(layout.position(0)),
            velocity: block(layout.velocity(0)),
            spin: block(layout.spin(0)),
            rotation: &rotation[..layout.bodies],
            attitude,
            departure: [departed, departing],
            nominal: [self.nominal_at(time), Vec3::from(self.barycentre_velocity)],
        }
    }

    /// The state that a vector `high` + `low` stands for at a time.
    pub fn state(&self, time: f64, high: &[f64], low: &[f64]) -> State {
        let layout = self.layout;
        let elapsed = time - self.epoch;
        let travelled = self.barycentre_velocity.map(|v| v * elapsed);
        let (departed, departing) = self.departure(high);
        let (departed_low, departing_low) = self.departure(low);
        let placed = |index: usize, nominal: [f64; 3], travelled: [f64; 3], departed: Vec3, tail: Vec3| {
            Vec3::from([0, 1, 2].map(|c| {
                let (partial, first) = two_sum(nominal[c], travelled[c]);
                let (barycentre, second) = two_sum(partial, departed[c]);
                let (total, third) = two_sum(barycentre, high[index + c]);
                total + (first + second + third + low[index + c] + tail[c])
            }))
        };
        let each = |f: &dyn Fn(usize) -> Vec3| (0..layout.bodies).map(f).collect::<Vec<_>>();
        State {
            time,
            position: each(&|b| {
                placed(layout.position(b), self.barycentre, travelled, departed, departed_low)
            }),
            velocity: each(&|b| {
                placed(layout.velocity(b), self.barycentre_velocity, [0.0; 3], departing, departing_low)
            }),
            attitude: (0..layout.bodies).map(|b| self.attitude(b, high)).collect(),
            spin: each(&|b| vector(high, layout.spin(b))),
        }
    }
}

/// The three numbers of a vector from an index on.
#[inline]
pub(super) fn vector(y: &[f64], index: usize) -> Vec3 {
    Vec3::new(y[index], y[index + 1], y[index + 2])
}
