//! The scales of an integrator's vector, and its projection onto the constraints.

use super::Dynamics;
use super::layout::{AttitudeChart, vector};
use crate::math::compensated::{two_product, two_sum};
use pulp::{Simd, WithSimd};

impl Dynamics {
    /// Computes the natural sizes against which the errors of each body are measured: (position, velocity,
    /// spin).
    ///
    /// Positions are measured against the nearest separation, velocities against their own size or that of a
    /// circular orbit there, spins against their own size or that orbit's rate. Attitudes are measured
    /// against one.
    pub fn scales(&self, y: &[f64], out: &mut [[f64; 3]]) {
        let bodies = self.system.bodies();
        for (body, scale) in bodies.iter().zip(out.iter_mut()) {
            *scale = [f64::INFINITY, 0.0, 0.0];
            if bodies.len() == 1 {
                *scale = [body.circumradius().max(f64::MIN_POSITIVE), 0.0, 0.0];
            }
        }
        for (i, j) in self.system.pairs() {
            let distance = (vector(y, self.layout.position(j)) - vector(y, self.layout.position(i))).norm();
            let mu = self.system.gravitational_constant * (bodies[i].mass + bodies[j].mass);
            let rate = (mu / (distance * distance * distance)).sqrt();
            for body in [i, j] {
                let [l, v, n] = &mut out[body];
                *l = l.min(distance);
                *v = v.max(rate * distance);
                *n = n.max(rate);
            }
        }
        for body in 0..self.layout.bodies {
            let speed = vector(y, self.layout.velocity(body)).norm();
            let spin = vector(y, self.layout.spin(body)).norm();
            let [l, v, n] = &mut out[body];
            *v = v.max(speed);
            *n = n.max(spin);
            // A body without any motion or attraction has no error either, but its scale must not be zero.
            *v = if *v > 0.0 { *v } else { *l };
            *n = if *n > 0.0 { *n } else { 1.0 };
        }
    }

    /// Scales quaternions back to unit length, in twice the working precision so that nothing of the state's
    /// low part is lost. This is a projection onto an invariant, which preserves the order of the method.
    pub fn restore(&self, high: &mut [f64], low: &mut [f64]) {
        if self.layout.chart == AttitudeChart::Quaternion {
            let attitudes = self.layout.attitude(0)..self.layout.spin(0);
            let (high, low) = (&mut high[attitudes.clone()], &mut low[attitudes]);
            self.system.arch().dispatch(Normalise(high.as_chunks_mut().0, low.as_chunks_mut().0));
        }
    }
}

/// Scales quaternions in two parts to unit length.
struct Normalise<'a>(&'a mut [[f64; 4]], &'a mut [[f64; 4]]);

impl WithSimd for Normalise<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (high, low) in self.0.iter_mut().zip(self.1) {
            let (mut sum, mut tail) = (-1.0, 0.0);
            for c in 0..4 {
                let (square, error) = two_product(high[c], high[c]);
                let (total, carry) = two_sum(sum, square);
                sum = total;
                tail += carry + error + 2.0 * high[c] * low[c];
            }
            let correction = -0.5 * (sum + tail);
            for c in 0..4 {
                (high[c], low[c]) = two_sum(high[c], low[c] + correction * high[c]);
            }
        }
    }
}
