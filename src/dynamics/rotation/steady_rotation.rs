//! The motion of a single body that rotates about a principal axis, in closed form over any length of time.
//!
//! With w the rate about the axis, phi the rotation angle and r the constant rate of change of w by a torque
//! along the spin,
//!
//!   w = w_0 + r t,   phi = (w_0 + r t/2) t.
//!
//! A small spin u across the axis obeys du/dphi = (k_1 u_2, k_2 u_1) with k_1 = (I_2 - I_3)/I_1 and k_2 =
//! (I_3 - I_1)/I_2, where the third moment is that of the axis. It is the wobble of a body that is not quite
//! relaxed; it stays small about the axes of the largest and of the smallest moment. Its small rotation theta
//! across the axis follows from the angular momentum: (I_3 w theta_2 + I_1 u_1, -I_3 w theta_1 + I_2 u_2) are
//! its components across the axis, which a torque along the spin changes in proportion to w. The amplitude of
//! u changes by the power (I_3/I_1 + I_3/I_2)/2 of w, up to errors of the relative size r/w^2.

use crate::dynamics::State;
use crate::math::rotation::{normalised, product};
use crate::math::{Vec3, rotation};

/// The largest spin across the axis, relative to that along it, for which the closed form is used. It is exact without
/// a spin across the axis.
const TILT: f64 = 1e-12;
/// The largest relative change of the spin in a rotation by one radian for which the closed form is used.
const CHANGE: f64 = 1e-6;

/// The numbers of a tangent vector of a body.
const SIZE: usize = 12;

/// The motion of a single body that rotates about a principal axis.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyRotation {
    start: State,
    /// The axes in cyclic order, with that of the rotation as the last, and their moments.
    axes: [usize; 3],
    inertia: [f64; 3],
    /// The constant rate of change of the spin along the axis.
    acceleration: f64,
    /// The numbers k_1 and k_2, and the root of -k_1 k_2.
    coupling: [f64; 2],
    wobble: f64,
}

impl SteadyRotation {
    /// Takes the moments of inertia, a state of one body, and the torque along its spin. Returns `None` for a
    /// body that does not rotate about a principal axis, or not stably, and for a torque that stops the
    /// rotation by a time, or changes it much within a revolution.
    pub fn new(inertia: Vec3, start: &State, torque: f64, until: f64) -> Option<Self> {
        let ([spin], true) = (start.spin.as_slice(), inertia.min() > 0.0) else { return None };
        let axis = spin.iamax();
        let axes = [(axis + 1) % 3, (axis + 2) % 3, axis];
        let [i1, i2, i3] = axes.map(|k| inertia[k]);
        let (rate, across) = (spin[axis], spin[axes[0]].hypot(spin[axes[1]]));
        let coupling = [(i2 - i3) / i1, (i3 - i1) / i2];
        let acceleration = (torque / i3).copysign(torque * rate);
        let end = rate + acceleration * (until - start.time);
        let slowest = rate.abs().min(end.abs());
        let steady = end * rate > 0.0 && acceleration.abs() <= CHANGE * slowest * slowest;
        // With one of the couplings zero the wobble grows in proportion to the angle.
        let stable = coupling[0] * coupling[1] < 0.0 || coupling == [0.0; 2];
        (steady
            && across <= TILT * rate.abs()
            && (stable || across == 0.0 && coupling[0] * coupling[1] == 0.0))
            .then(|| Self {
                start: start.clone(),
                axes,
                inertia: [i1, i2, i3],
                acceleration,
                coupling,
                wobble: (-coupling[0] * coupling[1]).sqrt(),
            })
    }

    /// Returns the rotation angle since the start, with its sign.
    pub fn angle(&self, time: f64) -> f64 {
        let elapsed = time - self.start.time;
        (self.rate() + 0.5 * self.acceleration * elapsed) * elapsed
    }

    /// Returns the state at the start.
    pub fn start(&self) -> &State {
        &self.start
    }

    /// Returns the unit vector of the spin, inertial frame, without the wobble.
    pub fn direction(&self) -> Vec3 {
        let mut along = Vec3::zeros();
        along[self.axes[2]] = 1f64.copysign(self.rate());
        rotation::rotate(&rotation::matrix(self.start.attitude[0]), &along)
    }

    /// Returns the state at a time.
    pub fn state(&self, time: f64) -> State {
        let elapsed = time - self.start.time;
        let spin = self.start.spin[0];
        let [i, j, k] = self.axes;
        let [u1, u2, theta1, theta2] = self.across(time, [spin[i], spin[j], 0.0, 0.0]);
        let (sine, cosine) = (0.5 * self.angle(time)).sin_cos();
        let (mut axial_rotation, mut transverse_rotation) = ([cosine, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]);
        axial_rotation[1 + k] = sine;
        (transverse_rotation[1 + i], transverse_rotation[1 + j]) = (0.5 * theta1, 0.5 * theta2);
        let mut state = self.start.clone();
        state.time = time;
        state.position[0] += state.velocity[0] * elapsed;
        state.attitude[0] =
            normalised(product(product(state.attitude[0], axial_rotation), transverse_rotation));
        state.spin[0][i] = u1;
        state.spin[0][j] = u2;
        state.spin[0][k] += self.acceleration * elapsed;
        state
    }

    /// Returns the transition matrix (12, 12) from the start to a time.
    pub fn transition(&self, time: f64) -> Vec<f64> {
        let elapsed = time - self.start.time;
        let mut transition = vec![0.0; SIZE * SIZE];
        (0..SIZE).for_each(|c| transition[c * SIZE + c] = 1.0);
        (0..3).for_each(|c| transition[c * SIZE + 3 + c] = elapsed);
        let [i, j, k] = self.axes;
        transition[(6 + k) * SIZE + 9 + k] = elapsed;
        let rows = [9 + i, 9 + j, 6 + i, 6 + j];
        for (c, column) in rows.into_iter().enumerate() {
            let mut unit = [0.0; 4];
            unit[c] = 1.0;
            for (row, value) in rows.into_iter().zip(self.across(time, unit)) {
                transition[row * SIZE + column] = value;
            }
        }
        transition
    }

    /// Returns the derivatives (12) of the state at a time with respect to a parameter, from that of the rate
    /// of change of the spin, body frame.
    pub fn sensitivity(&self, time: f64, by_acceleration: &Vec3) -> [f64; SIZE] {
        let (elapsed, axis) = (time - self.start.time, self.axes[2]);
        let mut sensitivity = [0.0; SIZE];
        sensitivity[6 + axis] = 0.5 * elapsed * elapsed * by_acceleration[axis];
        sensitivity[9 + axis] = elapsed * by_acceleration[axis];
        sensitivity
    }

    fn rate(&self) -> f64 {
        self.start.spin[0][self.axes[2]]
    }

    /// Returns the spin across the axis and the small rotation across it at a time, from those at the start.
    fn across(&self, time: f64, [x, y, theta1, theta2]: [f64; 4]) -> [f64; 4] {
        let ([i1, i2, i3], [k1, k2]) = (self.inertia, self.coupling);
        let (first, angle) = (self.rate(), self.angle(time));
        let rate = first + self.acceleration * (time - self.start.time);
        let growth = (rate / first).powf(0.5 * (i3 / i1 + i3 / i2));
        let (sine, cosine) = (self.wobble * angle).sin_cos();
        let sine = if self.wobble > 0.0 { sine / self.wobble } else { angle };
        let u = [growth * (cosine * x + k1 * sine * y), growth * (cosine * y + k2 * sine * x)];
        let momentum = [i3 * first * theta2 + i1 * x, -i3 * first * theta1 + i2 * y];
        let (sine, cosine) = angle.sin_cos();
        let share = rate / first;
        let v = [
            share * (cosine * momentum[0] + sine * momentum[1]),
            share * (cosine * momentum[1] - sine * momentum[0]),
        ];
        let scale = 1.0 / (i3 * rate);
        [u[0], u[1], (i2 * u[1] - v[1]) * scale, (v[0] - i1 * u[0]) * scale]
    }
}
