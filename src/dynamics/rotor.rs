//! A rigid body that turns freely: exactly, and by the discrete law of the Lie group variational integrator.
//!
//! Takes moments of inertia, attitude, spin and a time; gives the changes of attitude and spin, so that a caller who keeps low
//! parts loses nothing of them.

use crate::math::rotation::product;
use crate::math::{Mat3, Vec3};

type Quaternion = [f64; 4];

/// The unit quaternion of a rotation vector, less one.
fn turn_less_one(turn: Vec3) -> Quaternion {
    let angle = turn.norm();
    let half = (0.25 * angle).sin();
    let scale = if angle > 0.0 { (0.5 * angle).sin() / angle } else { 0.5 };
    [-2.0 * half * half, scale * turn.x, scale * turn.y, scale * turn.z]
}

/// Farthest that a body with three different moments is turned at once, in rad: some 160 times round.
pub const FARTHEST: f64 = 1024.0;

/// Up to this angle, in rad, a loose bound of it costs little.
const FEW: f64 = 64.0;

/// Changes of attitude and spin over a time without torque.
///
/// A body with two equal moments: two rotations. Any other: its Taylor series to round-off, in pieces short enough for it;
/// `None` where it turns farther than [`FARTHEST`].
pub fn free_rotation(inertia: Vec3, q: Quaternion, spin: Vec3, time: f64) -> Option<(Quaternion, Vec3)> {
    let axis = (0..3).find(|&k| inertia[(k + 1) % 3] == inertia[(k + 2) % 3]);
    match axis {
        Some(axis) => Some(symmetric(inertia, axis, q, spin, time)),
        None => triaxial(inertia, q, spin, time),
    }
}

/// An angle that a freely rotating body with three different moments does not turn beyond in a time.
///
/// The spin stays below |L| over the smallest moment. For a needle that tumbles end over end that is too large by the ratio of its
/// moments, and beyond [`FEW`] a second bound is taken where it is smaller: every component of the spin stays below its value where
/// L^2 and the energy T, both conserved, leave nothing to one of the others. With I_1 < I_2 < I_3,
/// L^2 - 2 T I_1 = I_2 (I_2 - I_1) w_2^2 + I_3 (I_3 - I_1) w_3^2 and 2 T I_3 - L^2 = I_1 (I_3 - I_1) w_1^2 + I_2 (I_3 - I_2) w_2^2.
pub fn farthest_turn(inertia: Vec3, spin: Vec3, time: f64) -> f64 {
    let by_momentum = inertia.component_mul(&spin).norm() / inertia.min() * time.abs();
    if by_momentum <= FEW {
        return by_momentum;
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&j, &k| inertia[j].total_cmp(&inertia[k]));
    let [i1, i2, i3] = order.map(|k| inertia[k]);
    let [s1, s2, s3] = order.map(|k| spin[k] * spin[k]);
    let (first, third) = (i1 * (i3 - i1), i3 * (i3 - i1));
    let (second_by_first, second_by_third) = (i2 * (i3 - i2), i2 * (i2 - i1));
    let largest1 = s1 + second_by_first / first * s2;
    let largest2 = s2 + (first / second_by_first * s1).min(third / second_by_third * s3);
    let largest3 = s3 + second_by_third / third * s2;
    by_momentum.min((largest1 + largest2 + largest3).sqrt() * time.abs())
}

/// About the angular momentum at |L|/I, then about the symmetry axis.
fn symmetric(inertia: Vec3, axis: usize, q: Quaternion, spin: Vec3, time: f64) -> (Quaternion, Vec3) {
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    // A point has no inertia and turns on as a sphere would.
    let ratio = if inertia[j] > 0.0 { inertia[axis] / inertia[j] } else { 1.0 };
    let rate = (1.0 - ratio) * spin[axis];
    let mut about_momentum = spin;
    about_momentum[axis] *= ratio;
    let mut about_axis = Vec3::zeros();
    about_axis[axis] = rate;
    let (first, second) = (turn_less_one(about_momentum * time), turn_less_one(about_axis * time));
    let both = product(first, second);
    let turn = [0, 1, 2, 3].map(|c| first[c] + second[c] + both[c]);
    // The spin's other two components turn the other way.
    let half = (0.5 * rate * time).sin();
    let (less, sine) = (-2.0 * half * half, (rate * time).sin());
    let mut change = Vec3::zeros();
    change[j] = less * spin[j] + sine * spin[k];
    change[k] = less * spin[k] - sine * spin[j];
    (product(q, turn), change)
}

fn triaxial(inertia: Vec3, q: Quaternion, spin: Vec3, time: f64) -> Option<(Quaternion, Vec3)> {
    /// Angle turned within one piece: the series then gains two bits a term and more.
    const PIECE: f64 = 0.25;
    const TERMS: usize = 40;
    let angle = farthest_turn(inertia, spin, time);
    if angle.is_nan() || angle > FARTHEST {
        return None;
    }
    let pieces = (angle / PIECE).ceil().max(1.0);
    let h = time / pieces;
    let rate = Vec3::from([0, 1, 2].map(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        (inertia[j] - inertia[k]) / inertia[i]
    }));
    let mut turned = [0.0; 4];
    let mut change = Vec3::zeros();
    let (mut w, mut p) = ([Vec3::zeros(); TERMS], [[0.0; 4]; TERMS]);
    for _ in 0..pieces as u64 {
        w[0] = spin + change;
        p[0] = [0, 1, 2, 3].map(|c| q[c] + turned[c]);
        let size = w[0].norm() * h.abs();
        let mut last = 0;
        for n in 0..TERMS - 1 {
            // Euler's equations and dq/dt = q (0, spin) / 2, coefficient by coefficient, in units of h.
            let (mut cross, mut sum) = (Vec3::zeros(), [0.0; 4]);
            for m in 0..=n {
                let (a, b) = (w[m], w[n - m]);
                cross += Vec3::new(a.y * b.z, a.z * b.x, a.x * b.y);
                let term = product(p[m], [0.0, b.x, b.y, b.z]);
                (0..4).for_each(|c| sum[c] += term[c]);
            }
            let scale = h / (n + 1) as f64;
            w[n + 1] = scale * rate.component_mul(&cross);
            p[n + 1] = sum.map(|x| 0.5 * scale * x);
            last = n + 1;
            let term =
                p[last].iter().fold(w[last].norm() * h.abs() / size.max(1e-300), |s, x| s.max(x.abs()));
            if n > 2 && term < 1e-18 {
                break;
            }
        }
        for n in (1..=last).rev() {
            change += w[n];
            (0..4).for_each(|c| turned[c] += p[n][c]);
        }
    }
    Some((turned, change))
}

/// Changes of attitude and spin in one step of the discrete free rotation: Lee, Leok & McClamroch (2007), Comput. Methods Appl.
/// Mech. Engrg. 196, 2907.
///
/// F J_d - J_d F^T = h S(J spin) is solved for F by Newton's method. For F of the unit quaternion (sqrt(1 - |p|^2), p) it reads
/// p_0 J p + p x J p = h J spin / 2. `None` where the step is too long for a solution.
pub fn variational_rotation(
    inertia: Vec3,
    q: Quaternion,
    spin: Vec3,
    time: f64,
) -> Option<(Quaternion, Vec3)> {
    if inertia.min() <= 0.0 {
        return free_rotation(inertia, q, spin, time);
    }
    let p = half_turn(inertia, spin, time)?;
    let scalar = (1.0 - p.norm_squared()).sqrt();
    let turn = [-p.norm_squared() / (1.0 + scalar), p.x, p.y, p.z];
    // F^T (J spin) - J spin.
    let across = p.cross(&inertia.component_mul(&spin));
    let change = 2.0 * (p.cross(&across) - scalar * across);
    scalar.is_finite().then(|| (product(q, turn), change.component_div(&inertia)))
}

/// The vector part p of the discrete rotation's quaternion.
fn half_turn(inertia: Vec3, spin: Vec3, time: f64) -> Option<Vec3> {
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
        let step = slope_of_half_turn(inertia, &p).lu().solve(&residual)?;
        p -= step;
        let size = step.norm();
        // To round-off: on until the steps no longer shrink.
        if size == 0.0 || (size >= 0.5 * last && size < 1e-12) {
            return Some(p);
        }
        last = size;
    }
    None
}

/// The derivative of p_0 J p + p x J p with p.
fn slope_of_half_turn(inertia: Vec3, p: &Vec3) -> Mat3 {
    let scalar = (1.0 - p.norm_squared()).sqrt();
    let jp = inertia.component_mul(p);
    Mat3::from_diagonal(&inertia) * scalar - jp * p.transpose() / scalar
        + p.cross_matrix() * Mat3::from_diagonal(&inertia)
        - jp.cross_matrix()
}

/// The derivative of the discrete rotation: theta' = F^T theta + xi, with xi and the change of the new spin linear in that of the old
/// one and in that of the moments.
#[derive(Debug, Clone, Copy)]
pub struct RotationSlopes {
    /// F^T.
    pub back: Mat3,
    /// xi with the spin, and with the moments.
    pub turn: [Mat3; 2],
    /// The new spin with these.
    pub spin: [Mat3; 2],
}

impl RotationSlopes {
    /// Of a step of [`variational_rotation`]; `None` where that is.
    pub fn new(inertia: Vec3, spin: Vec3, time: f64) -> Option<Self> {
        if inertia.min() <= 0.0 {
            let zero = Mat3::zeros();
            let keep = [Mat3::identity(), zero];
            return Some(Self { back: Mat3::identity(), turn: [Mat3::identity() * time, zero], spin: keep });
        }
        let p = half_turn(inertia, spin, time)?;
        let scalar = (1.0 - p.norm_squared()).sqrt();
        let slope = slope_of_half_turn(inertia, &p).try_inverse()?;
        let (moments, across) = (Mat3::from_diagonal(&inertia), p.cross_matrix());
        let by_spin = slope * moments * (0.5 * time);
        let by_moments = slope
            * (Mat3::from_diagonal(&spin) * (0.5 * time)
                - (Mat3::identity() * scalar + across) * Mat3::from_diagonal(&p));
        let xi = 2.0 * (Mat3::identity() * scalar + p * p.transpose() / scalar - across);
        let turn = [xi * by_spin, xi * by_moments];
        let back = Mat3::identity() + 2.0 * across * across - 2.0 * scalar * across;
        let momentum = back * inertia.component_mul(&spin);
        let new_spin = momentum.component_div(&inertia);
        let inverse = Mat3::from_diagonal(&inertia.map(|i| 1.0 / i));
        let moved = momentum.cross_matrix();
        let spins = [
            inverse * (back * moments + moved * turn[0]),
            inverse * (back * Mat3::from_diagonal(&spin) + moved * turn[1] - Mat3::from_diagonal(&new_spin)),
        ];
        Some(Self { back, turn, spin: spins })
    }
}
