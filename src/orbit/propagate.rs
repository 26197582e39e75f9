//! Motion along a Kepler orbit of any kind, by universal variables.
//!
//! Takes position, velocity, mu and a time. Gives the changes of position and velocity rather than new
//! values, so that a caller who carries them in twice the working precision adds the changes without loss.
//! The functions G_k and the solution follow Rein & Tamayo (2015), MNRAS 452, 376.

use crate::math::Vec3;
use crate::math::lanes::Lanes;
use crate::math::stumpff::{SERIES_LIMIT, stumpff};
use pulp::Scalar;
use std::f64::consts::TAU;

/// The number of iterations after which every second one halves the bracket.
const QUICK: u32 = 16;

/// The changes of position and velocity along an orbit over a time.
#[derive(Debug, Clone, Copy)]
pub struct KeplerChange {
    /// The change of the position.
    pub position: Vec3,
    /// The change of the velocity.
    pub velocity: Vec3,
    /// The acceleration at the end.
    pub acceleration: Vec3,
}

/// Returns the changes of position and velocity over a time on the orbit through them; `None` where doubles
/// overflow or the iteration does not converge.
#[inline(always)]
pub fn kepler_change(position: &Vec3, velocity: &Vec3, mu: f64, time: f64) -> Option<KeplerChange> {
    if mu == 0.0 {
        let rest = Vec3::zeros();
        return Some(KeplerChange { position: velocity * time, velocity: rest, acceleration: rest });
    }
    let r0 = position.norm();
    let inverse = 1.0 / r0;
    let (square, attraction) = (velocity.norm_squared(), mu * inverse);
    let beta = 2.0 * attraction - square;
    let mut time = time;
    if beta > 0.0 && time.abs() * beta * beta.sqrt() > TAU * mu {
        time %= TAU * mu / (beta * beta.sqrt());
    }
    // Divided by the distance r0 at the start, Kepler's equation is s + eta G_2 + zeta G_3 = t/r0 with eta =
    // r.v/r0 and zeta = v^2 - mu/r0. The derivative of its left side by s is the distance r/r0 > 0, and s = 0 at
    // t = 0.
    let (eta0, zeta) = (position.dot(velocity), square - attraction);
    let eta = eta0 * inverse;
    let (mut low, mut high) = if time > 0.0 { (0.0, f64::INFINITY) } else { (f64::NEG_INFINITY, 0.0) };
    let slope = time * inverse;
    // The starting value consists of the first three terms of the inverse series.
    let (a, b) = (0.5 * eta * slope, zeta * (slope * slope) * (1.0 / 6.0));
    let mut s = slope * (1.0 - a + (2.0 * a * a - b)).clamp(0.5, 1.5);
    let mut last_change = f64::INFINITY;
    for trial in 0..200 {
        let g = g_functions(beta, s);
        let residual = (r0 * s - time) * inverse + (eta * g[2] + zeta * g[3]);
        let r = 1.0 + (eta * g[1] + zeta * g[2]);
        // Where the residual overflows, far out, it has the sign of s.
        let signed_residual = if residual.is_finite() { residual } else { s };
        if signed_residual > 0.0 {
            high = high.min(s)
        } else {
            low = low.max(s)
        }
        // This is Danby's step of fourth order, by the derivatives of the distance, with one division for
        // three quotients.
        let (second, third) = (eta * g[0] + zeta * g[1], zeta * g[0] - beta * eta * g[1]);
        let halley = r * r - residual * (0.5 * second);
        let halley_square = halley * halley;
        let further = (0.5 * second) * halley - residual * (r * third * (1.0 / 6.0));
        let reduced = halley_square - residual * further;
        let denominator = r * reduced;
        let step = -residual * halley_square / denominator;
        let danby = s + step;
        let within = |next: f64| next > low && next < high;
        // Where `halley` vanishes or doubles overflow, Danby's step vanishes beside Newton's, which is not a
        // sign of convergence.
        let reliable = 10.0 * halley_square >= reduced.abs() && denominator.is_finite();
        // Far out on a hyperbola, where the equation is exponential, halving the bracket is quicker than a
        // step of any order. A step that rounds to nothing ends at the root, which is an end of the bracket.
        let inside = (within(danby) || danby == s) && reliable && (trial < QUICK || trial % 2 == 0);
        let newton = s - residual / r;
        let next = if inside {
            danby
        } else if residual == 0.0 {
            s
        } else if trial < QUICK && within(newton) {
            newton
        } else if low.is_finite() && high.is_finite() {
            0.5 * (low + high)
        } else {
            s + 2.0 * slope.abs().copysign(-signed_residual)
        };
        let change = (next - s).abs();
        s = next;
        // After a small step of fourth order, or a very small one of third order, the remaining error is
        // below round-off.
        let small = inside && change <= 1e-5 * s.abs() && change * second.abs() <= 1e-4 * r;
        if small || change <= f64::EPSILON * s.abs() || (change >= last_change && change <= 1e-12 * s.abs()) {
            let g = if inside && change <= 2e-6 * s.abs() {
                let half = 0.5 * step;
                [g[0], g[1] + step * (g[0] - half * beta * g[1]), g[2] + step * (g[1] + half * g[0]), g[3]]
            } else {
                g_functions(beta, s)
            };
            // The ratio r0/r of the distances at the start and the end.
            let distance_ratio = 1.0 / (1.0 + (eta * g[1] + zeta * g[2]));
            let (f, g_time) = (-attraction * g[2], r0 * g[1] + eta0 * g[2]);
            let (fdot, gdot) = (-(attraction * inverse) * g[1] * distance_ratio, f * distance_ratio);
            let change = [f * position + g_time * velocity, fdot * position + gdot * velocity];
            let inverse_end = distance_ratio * inverse;
            let acceleration = (position + change[0]) * (-mu * inverse_end * inverse_end * inverse_end);
            let finite = (change[0].sum() + change[1].sum()).is_finite();
            return finite.then_some(KeplerChange { position: change[0], velocity: change[1], acceleration });
        }
        last_change = change;
    }
    None
}

/// Computes G_0 to G_3 = s^k c_k(beta s^2), with c_k Stumpff's functions: by series at a reduced argument,
/// followed by doublings.
#[inline(always)]
fn g_functions(beta: f64, s: f64) -> [f64; 4] {
    let mut z = beta * s * s;
    let mut doublings = 0;
    while z.abs() > SERIES_LIMIT && doublings < 60 {
        z *= 0.25;
        doublings += 1;
    }
    let [mut c2, mut c3] = stumpff(Lanes::<_, 1>::splat(Scalar, z)).map(Lanes::first);
    let (mut c0, mut c1) = (1.0 - z * c2, 1.0 - z * c3);
    for _ in 0..doublings {
        (c2, c3) = (0.5 * c1 * c1, 0.25 * (c2 + c0 * c3));
        z *= 4.0;
        (c0, c1) = (1.0 - z * c2, 1.0 - z * c3);
    }
    [c0, s * c1, s * s * c2, s * s * s * c3]
}
