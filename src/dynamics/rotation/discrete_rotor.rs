//! The discrete free rotation of the Lie group variational integrator, and its derivative.
//!
//! Takes moments of inertia, attitude, spin and a time; gives the changes of attitude and spin.

use super::free_rotors::Quaternion;
use super::{Numbers, RotorKind, Symmetric};
use crate::math::matrix::inverse;
use crate::math::rotation::product;
use crate::math::{Mat3, Vec3};
use pulp::Scalar;

/// Returns the changes of attitude and spin in one step of the discrete free rotation: Lee, Leok & McClamroch
/// (2007), Comput. Methods Appl. Mech. Engrg. 196, 2907.
///
/// The equation F J_d - J_d F^T = h S(J spin) is solved for F by Newton's method. For the rotation F of the
/// unit quaternion (sqrt(1 - |p|^2), p) it reads p_0 J p + p x J p = h J spin / 2. Returns `None` where the
/// step is too long for a solution.
pub fn variational_rotation(
    inertia: Vec3,
    q: Quaternion,
    spin: Vec3,
    time: f64,
) -> Option<(Quaternion, Vec3)> {
    if inertia.min() <= 0.0 {
        // A point keeps rotating as a sphere would.
        let number = |value: f64| Numbers::splat(Scalar, value);
        let spin = [spin.x, spin.y, spin.z].map(number);
        let (rotation, _) = Symmetric::rotate(Scalar, [number(1.0)], q.map(number), spin, 0.5 * time);
        return Some((rotation.map(Numbers::first), Vec3::zeros()));
    }
    let p = vector_part(inertia, spin, time)?;
    let scalar = (1.0 - p.norm_squared()).sqrt();
    let rotation = [-p.norm_squared() / (1.0 + scalar), p.x, p.y, p.z];
    // The change of the spin is the change of the body-frame angular momentum, F^T (J spin) - J spin, over J.
    let across = p.cross(&inertia.component_mul(&spin));
    let change = 2.0 * (p.cross(&across) - scalar * across);
    scalar.is_finite().then(|| (product(q, rotation), change.component_div(&inertia)))
}

/// Returns the vector part p of the discrete rotation's quaternion.
fn vector_part(inertia: Vec3, spin: Vec3, time: f64) -> Option<Vec3> {
    let target = 0.5 * time * inertia.component_mul(&spin);
    let mut p = 0.5 * time * spin;
    if p.norm() >= 1.0 {
        return None;
    }
    let mut last = f64::INFINITY;
    for _ in 0..50 {
        if p.norm_squared() >= 1.0 {
            return None;
        }
        let scalar = (1.0 - p.norm_squared()).sqrt();
        let jp = inertia.component_mul(&p);
        let residual = scalar * jp + p.cross(&jp) - target;
        let step = vector_part_jacobian(inertia, &p).lu().solve(&residual)?;
        p -= step;
        let size = step.norm();
        // Newton's steps continue until round-off keeps them from shrinking.
        if size == 0.0 || (size >= 0.5 * last && size < 1e-12) {
            return Some(p);
        }
        last = size;
    }
    None
}

/// Returns the derivative of p_0 J p + p x J p with respect to p.
fn vector_part_jacobian(inertia: Vec3, p: &Vec3) -> Mat3 {
    let scalar = (1.0 - p.norm_squared()).sqrt();
    let jp = inertia.component_mul(p);
    Mat3::from_diagonal(&inertia) * scalar - jp * p.transpose() / scalar
        + p.cross_matrix() * Mat3::from_diagonal(&inertia)
        - jp.cross_matrix()
}

/// The derivative of the discrete rotation: theta' = F^T theta + xi, where xi and the change of the new spin
/// are linear in the changes of the old spin and of the moments of inertia.
#[derive(Debug, Clone, Copy)]
pub struct RotationDerivatives {
    /// The transposed rotation F^T.
    pub transposed: Mat3,
    /// The derivatives of xi with respect to the spin and to the moments of inertia.
    pub rotation: [Mat3; 2],
    /// The derivatives of the new spin with respect to the old spin and to the moments of inertia.
    pub spin: [Mat3; 2],
}

impl RotationDerivatives {
    /// Differentiates a step of [`variational_rotation`]; `None` where that step has no solution.
    pub fn new(inertia: Vec3, spin: Vec3, time: f64) -> Option<Self> {
        if inertia.min() <= 0.0 {
            return Some(Self::uniform_rotation(spin, time));
        }
        let p = vector_part(inertia, spin, time)?;
        let scalar = (1.0 - p.norm_squared()).sqrt();
        let inverse_jacobian = inverse(&vector_part_jacobian(inertia, &p))?;
        let (moments, across) = (Mat3::from_diagonal(&inertia), p.cross_matrix());
        let by_spin = inverse_jacobian * moments * (0.5 * time);
        let by_moments = inverse_jacobian
            * (Mat3::from_diagonal(&spin) * (0.5 * time)
                - (Mat3::identity() * scalar + across) * Mat3::from_diagonal(&p));
        let xi = 2.0 * (Mat3::identity() * scalar + p * p.transpose() / scalar - across);
        let rotation = [xi * by_spin, xi * by_moments];
        let transposed = Mat3::identity() + 2.0 * across * across - 2.0 * scalar * across;
        let momentum = transposed * inertia.component_mul(&spin);
        let new_spin = momentum.component_div(&inertia);
        let inverse = Mat3::from_diagonal(&inertia.map(|i| 1.0 / i));
        let momentum_cross = momentum.cross_matrix();
        let spins = [
            inverse * (transposed * moments + momentum_cross * rotation[0]),
            inverse
                * (transposed * Mat3::from_diagonal(&spin) + momentum_cross * rotation[1]
                    - Mat3::from_diagonal(&new_spin)),
        ];
        Some(Self { transposed, rotation, spin: spins })
    }

    /// Differentiates a uniform rotation by exp(X) with X = [h spin]: F^T = exp(-X), and xi is h (1 -
    /// exp(-X))/X times the change of the spin.
    fn uniform_rotation(spin: Vec3, time: f64) -> Self {
        let rotation_vector = spin * time;
        let (angle, axis) =
            (rotation_vector.norm(), rotation_vector.try_normalize(0.0).unwrap_or_default().cross_matrix());
        let (sine, versine) = (angle.sin(), 2.0 * (0.5 * angle).sin().powi(2));
        let squared = axis * axis;
        let (versine_factor, sine_factor) =
            if angle == 0.0 { (0.0, 0.0) } else { (1.0 - sine / angle, versine / angle) };
        Self {
            transposed: Mat3::identity() - axis * sine + squared * versine,
            rotation: [
                (Mat3::identity() - axis * sine_factor + squared * versine_factor) * time,
                Mat3::zeros(),
            ],
            spin: [Mat3::identity(), Mat3::zeros()],
        }
    }
}
