//! Motion along a Kepler orbit of any kind by universal variables.
//!
//! Takes position, velocity, mu and a time; gives the changes of position and velocity rather than new values, so that a
//! caller who carries them in twice the working precision adds the changes without loss.
//! Functions G_k and the solution as in Rein & Tamayo (2015), MNRAS 452, 376.

use crate::math::Vec3;
use crate::math::stumpff::{REACH, stumpff};
use std::f64::consts::TAU;

/// Changes of position and velocity over a time on the orbit through them; `None` where doubles overflow or the iteration
/// does not end.
#[inline(always)]
pub fn kepler_change(position: &Vec3, velocity: &Vec3, mu: f64, time: f64) -> Option<(Vec3, Vec3)> {
    if mu == 0.0 || time == 0.0 {
        return Some((velocity * time, Vec3::zeros()));
    }
    let r0 = position.norm();
    let inverse = 1.0 / r0;
    let eta = position.dot(velocity);
    let beta = 2.0 * mu * inverse - velocity.norm_squared();
    let time = if beta > 0.0 {
        let period = TAU * mu / (beta * beta.sqrt());
        if time.abs() > period { time % period } else { time }
    } else {
        time
    };
    // r0 s + eta0 G2 + zeta0 G3 = t rises with s, since its derivative is the distance.
    let zeta = mu - beta * r0;
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let slope = time * inverse;
    // The first three terms of its inverse.
    let (a, b) = (0.5 * eta * inverse * slope, zeta * inverse * slope * slope / 6.0);
    let mut s = slope * (1.0 - a + (2.0 * a * a - b)).clamp(0.5, 1.5);
    let mut last_change = f64::INFINITY;
    for _ in 0..200 {
        let g = functions(beta, s);
        let residual = (r0 * s - time) + eta * g[2] + zeta * g[3];
        let r = r0 + eta * g[1] + zeta * g[2];
        if residual > 0.0 {
            high = high.min(s)
        } else {
            low = low.max(s)
        }
        // Danby's step of fourth order, by the derivatives of the distance.
        let (second, third) = (eta * g[0] + zeta * g[1], zeta * g[0] - beta * eta * g[1]);
        let newton = -residual / r;
        let halley = -residual / (r + 0.5 * newton * second);
        let step = -residual / (r + halley * (0.5 * second + halley * third / 6.0));
        let danby = s + step;
        let inside = danby > low && danby < high && danby.is_finite();
        let next = if inside {
            danby
        } else if residual == 0.0 {
            s
        } else if low.is_finite() && high.is_finite() {
            0.5 * (low + high)
        } else {
            s + 2.0 * slope.abs().copysign(-residual)
        };
        let change = (next - s).abs();
        s = next;
        // What a small step of fourth order leaves is below round-off, and so is what a very small one leaves of third order.
        let small = inside && change <= 1e-5 * s.abs() && change * second.abs() <= 1e-4 * r;
        if small || change <= f64::EPSILON * s.abs() || (change >= last_change && change <= 1e-12 * s.abs()) {
            let g = if inside && change <= 2e-6 * s.abs() {
                let half = 0.5 * step;
                [g[0], g[1] + step * (g[0] - half * beta * g[1]), g[2] + step * (g[1] + half * g[0]), g[3]]
            } else {
                functions(beta, s)
            };
            let r = r0 + eta * g[1] + zeta * g[2];
            let there = mu / r;
            let (f, fdot) = (-mu * inverse * g[2], -there * inverse * g[1]);
            let (g_time, gdot) = (r0 * g[1] + eta * g[2], -there * g[2]);
            let position_change = f * position + g_time * velocity;
            let velocity_change = fdot * position + gdot * velocity;
            let finite = position_change.iter().chain(&velocity_change).all(|x| x.is_finite());
            return finite.then_some((position_change, velocity_change));
        }
        last_change = change;
    }
    None
}

/// G_0 to G_3 = s^k c_k(beta s^2), c_k Stumpff's functions: series at a reduced argument, then doublings.
#[inline(always)]
fn functions(beta: f64, s: f64) -> [f64; 4] {
    let mut z = beta * s * s;
    let mut doublings = 0;
    while z.abs() > REACH && doublings < 60 {
        z *= 0.25;
        doublings += 1;
    }
    let [mut c2, mut c3] = stumpff(z);
    let (mut c0, mut c1) = (1.0 - z * c2, 1.0 - z * c3);
    for _ in 0..doublings {
        (c2, c3) = (0.5 * c1 * c1, 0.25 * (c2 + c0 * c3));
        z *= 4.0;
        (c0, c1) = (1.0 - z * c2, 1.0 - z * c3);
    }
    [c0, s * c1, s * s * c2, s * s * s * c3]
}
