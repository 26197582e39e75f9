//! Attitudes: unit quaternions `[w, x, y, z]`, rotation matrices and the paper's Tait-Bryan angles.
//!
//! An attitude turns body-frame vectors into the inertial frame. The angles (phi, theta, psi) mean
//! R = Rz(psi) Ry(theta) Rx(phi), the paper's `eq:RotationMatrix`.

use super::{Mat3, Vec3};
use nalgebra::{Quaternion, UnitQuaternion};

/// Rotation matrix of a quaternion `[w, x, y, z]` of any non-zero length.
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

/// The quaternion scaled to length one.
pub fn normalised(q: [f64; 4]) -> [f64; 4] {
    let unit = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]));
    [unit.w, unit.i, unit.j, unit.k]
}

/// Rate of the attitude for a spin in the body frame: dq/dt = q (0, spin) / 2.
#[inline]
pub fn quaternion_rate(q: [f64; 4], spin: Vec3) -> [f64; 4] {
    let [w, x, y, z] = q;
    let (a, b, c) = (0.5 * spin.x, 0.5 * spin.y, 0.5 * spin.z);
    [-x * a - y * b - z * c, w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a]
}

/// The unit quaternion of the Tait-Bryan angles (phi, theta, psi).
pub fn from_tait_bryan(angles: [f64; 3]) -> [f64; 4] {
    let unit = UnitQuaternion::from_euler_angles(angles[0], angles[1], angles[2]);
    [unit.w, unit.i, unit.j, unit.k]
}

/// The Tait-Bryan angles of a quaternion: phi and psi in (-pi, pi], theta in [-pi/2, pi/2].
pub fn to_tait_bryan(q: [f64; 4]) -> [f64; 3] {
    let r = matrix(q);
    let cos_theta = r[(0, 0)].hypot(r[(1, 0)]);
    let theta = (-r[(2, 0)]).atan2(cos_theta);
    if cos_theta > 1e-12 {
        [r[(2, 1)].atan2(r[(2, 2)]), theta, r[(1, 0)].atan2(r[(0, 0)])]
    } else {
        // At the pole only psi -/+ phi is defined; the whole turn goes to psi.
        [0.0, theta, (-r[(0, 1)]).atan2(r[(1, 1)])]
    }
}

/// Rotation matrix of the Tait-Bryan angles, the paper's `eq:RotationMatrix`.
#[inline]
pub fn tait_bryan_matrix(angles: [f64; 3]) -> Mat3 {
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

/// Rates of the Tait-Bryan angles for a spin in the body frame, the paper's `eq:DiffEq_phi`,
/// `eq:DiffEq_theta` and `eq:DiffEq_psi`; singular where cos(theta) = 0.
#[inline]
pub fn tait_bryan_rate(angles: [f64; 3], spin: Vec3) -> [f64; 3] {
    let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (angles[0].sin_cos(), angles[1].sin_cos());
    let along = spin.y * sin_phi + spin.z * cos_phi;
    [spin.x + along * sin_theta / cos_theta, spin.y * cos_phi - spin.z * sin_phi, along / cos_theta]
}
