//! Attitudes: unit quaternions `[w, x, y, z]`, rotation matrices and the paper's Tait-Bryan angles.
//!
//! An attitude turns body-frame vectors into the inertial frame. The angles (phi, theta, psi) mean
//! R = Rz(psi) Ry(theta) Rx(phi), the paper's `eq:RotationMatrix`.

use super::{Mat3, Vec3};
use nalgebra::{Quaternion, UnitQuaternion};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Returns the rotation matrix of a quaternion `[w, x, y, z]` of any non-zero length.
#[inline]
pub fn matrix(q: [f64; 4]) -> Mat3 {
    let [w, x, y, z] = q;
    let s = 2.0 / (w * w + x * x + y * y + z * z);
    let (xs, ys, zs) = (x * s, y * s, z * s);
    let (wx, wy, wz) = (w * xs, w * ys, w * zs);
    let (xx, xy, xz) = (x * xs, x * ys, x * zs);
    let (yy, yz, zz) = (y * ys, y * zs, z * zs);
    Mat3::new(
        1.0 - (yy + zz),
        xy - wz,
        xz + wy,
        xy + wz,
        1.0 - (xx + zz),
        yz - wx,
        xz - wy,
        yz + wx,
        1.0 - (xx + yy),
    )
}

/// Returns the product of a matrix and a vector. It is inlined, unlike the generic product of `nalgebra`.
#[inline(always)]
pub fn rotate(m: &Mat3, v: &Vec3) -> Vec3 {
    let row = |i: usize| m[(i, 0)] * v.x + m[(i, 1)] * v.y + m[(i, 2)] * v.z;
    Vec3::new(row(0), row(1), row(2))
}

/// Returns the product of the transposed matrix and a vector: the inverse rotation.
#[inline(always)]
pub fn rotate_back(m: &Mat3, v: &Vec3) -> Vec3 {
    let column = |i: usize| m[(0, i)] * v.x + m[(1, i)] * v.y + m[(2, i)] * v.z;
    Vec3::new(column(0), column(1), column(2))
}

/// Returns the unit quaternion of a rotation vector.
pub fn exponential(v: &Vec3) -> [f64; 4] {
    let half = 0.5 * v.norm();
    // For so small an angle sin(half)/half equals one to round-off.
    let factor = if half > 1e-9 { 0.5 * half.sin() / half } else { 0.5 };
    [half.cos(), factor * v.x, factor * v.y, factor * v.z]
}

/// Returns Hamilton's product p q: the rotation `q` followed by the rotation `p`.
#[inline]
pub fn product(p: [f64; 4], q: [f64; 4]) -> [f64; 4] {
    [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3],
        p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1],
    ]
}

/// Returns the quaternion scaled to length one.
pub fn normalised(q: [f64; 4]) -> [f64; 4] {
    let unit = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]));
    [unit.w, unit.i, unit.j, unit.k]
}

/// Returns the rate of the attitude for a spin in the body frame: dq/dt = q (0, spin) / 2.
#[inline]
pub fn quaternion_rate(q: [f64; 4], spin: Vec3) -> [f64; 4] {
    let [w, x, y, z] = q;
    let (a, b, c) = (0.5 * spin.x, 0.5 * spin.y, 0.5 * spin.z);
    [-x * a - y * b - z * c, w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a]
}

/// Returns the unit quaternion of the Tait-Bryan angles (phi, theta, psi).
pub fn from_tait_bryan(angles: [f64; 3]) -> [f64; 4] {
    let unit = UnitQuaternion::from_euler_angles(angles[0], angles[1], angles[2]);
    [unit.w, unit.i, unit.j, unit.k]
}

/// Returns the Tait-Bryan angles of a quaternion: phi and psi in (-pi, pi], theta in [-pi/2, pi/2].
///
/// They are formed from the sum and the difference of phi and psi, so that they represent the attitude to
/// round-off even near the poles theta = +-pi/2.
pub fn to_tait_bryan(q: [f64; 4]) -> [f64; 3] {
    let [w, x, y, z] = q;
    // With C = cos(theta/2) and S = sin(theta/2), these pairs are (C - S) (cos, sin)((phi + psi)/2) and
    // (C + S) (cos, sin)((phi - psi)/2).
    let (sum_cos, sum_sin, difference_cos, difference_sin) = (w - y, x + z, w + y, x - z);
    let (minus, plus) = (sum_cos.hypot(sum_sin), difference_cos.hypot(difference_sin));
    let theta = 2.0 * plus.atan2(minus) - FRAC_PI_2;
    let (half_sum, half_difference) = (sum_sin.atan2(sum_cos), difference_sin.atan2(difference_cos));
    // At a pole only the sum or the difference is defined: phi is set to zero.
    if minus < 1e-15 * plus {
        [0.0, theta, principal(-2.0 * half_difference)]
    } else if plus < 1e-15 * minus {
        [0.0, theta, principal(2.0 * half_sum)]
    } else {
        [principal(half_sum + half_difference), theta, principal(half_sum - half_difference)]
    }
}

/// Returns an angle of (-2 pi, 2 pi] reduced to (-pi, pi].
fn principal(angle: f64) -> f64 {
    if angle > PI {
        angle - TAU
    } else if angle <= -PI {
        angle + TAU
    } else {
        angle
    }
}

/// Returns the rotation matrix of the Tait-Bryan angles, the paper's `eq:RotationMatrix`.
#[inline]
pub fn tait_bryan_matrix(angles: [f64; 3]) -> Mat3 {
    // The letters f, t and p stand for phi, theta and psi.
    let ((sf, cf), (st, ct), (sp, cp)) = (angles[0].sin_cos(), angles[1].sin_cos(), angles[2].sin_cos());
    Mat3::new(
        cp * ct,
        cp * st * sf - sp * cf,
        cp * st * cf + sp * sf,
        sp * ct,
        sp * st * sf + cp * cf,
        sp * st * cf - cp * sf,
        -st,
        ct * sf,
        ct * cf,
    )
}

/// Returns the rates of the Tait-Bryan angles for a spin in the body frame, the paper's `eq:DiffEq_phi`,
/// `eq:DiffEq_theta` and `eq:DiffEq_psi`; singular where cos(theta) = 0.
#[inline]
pub fn tait_bryan_rate(angles: [f64; 3], spin: Vec3) -> [f64; 3] {
    let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (angles[0].sin_cos(), angles[1].sin_cos());
    let along = spin.y * sin_phi + spin.z * cos_phi;
    [spin.x + along * sin_theta / cos_theta, spin.y * cos_phi - spin.z * sin_phi, along / cos_theta]
}
