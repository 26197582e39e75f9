//! A rigid body that turns freely: exactly, and by the discrete law of the Lie group variational integrator.
//!
//! Takes moments of inertia, attitude, spin and a time; gives the changes of attitude and spin, so that a caller who keeps low
//! parts loses nothing of them.

use crate::math::rotation::product;
use crate::math::{Mat3, Vec3};

type Quaternion = [f64; 4];

/// The unit quaternion of the turn by an angle about a unit vector, less one.
fn turn_less_one(axis: Vec3, angle: f64) -> Quaternion {
    let (sine, cosine) = (0.25 * angle).sin_cos();
    let scale = 2.0 * sine * cosine;
    [-2.0 * sine * sine, scale * axis.x, scale * axis.y, scale * axis.z]
}

/// The product of two quaternions, each of them given less one and so the result.
fn product_less_one(first: Quaternion, second: Quaternion) -> Quaternion {
    let both = product(first, second);
    [0, 1, 2, 3].map(|c| first[c] + second[c] + both[c])
}

/// Farthest that a body with three different moments is turned at once, in rad: some 160 times round.
pub const FARTHEST: f64 = 1024.0;

/// Up to this angle, in rad, a loose bound of it costs little.
const FEW: f64 = 64.0;

/// Changes of attitude and spin over a time without torque.
///
/// A body with two equal moments: two rotations. Any other: see [`triaxial`]; `None` where it turns farther than [`FARTHEST`].
#[inline]
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
    let mut about_momentum = spin;
    about_momentum[axis] *= ratio;
    let fast = about_momentum.norm();
    let first = if fast > 0.0 { turn_less_one(about_momentum / fast, fast * time) } else { [0.0; 4] };
    let mut figure = Vec3::zeros();
    figure[axis] = 1.0;
    let second = turn_less_one(figure, (1.0 - ratio) * spin[axis] * time);
    // The spin's other two components turn the other way, by twice the half angle of that quaternion.
    let (half_sine, half_cosine) = (second[axis + 1], 1.0 + second[0]);
    let (less, sine) = (-2.0 * half_sine * half_sine, 2.0 * half_sine * half_cosine);
    let mut change = Vec3::zeros();
    change[j] = less * spin[j] + sine * spin[k];
    change[k] = less * spin[k] - sine * spin[j];
    (product(q, product_less_one(first, second)), change)
}

/// Euler's top by the series of its spin alone; its attitude follows from the angular momentum, which stays.
///
/// In the body's frame the direction m of the angular momentum moves, by dm/dt = m x w, and in space it rests. The turn from the
/// frame at the start is the shortest one that takes m back to its first direction m_0, and then one about m_0 by the angle
///
///   phi = 2 T t / L - int (m_0 x m) . dm/dt / (1 + m_0 . m) dt,
///
/// T the energy: the way of m off its shortest turn encloses the integral, which is of third order in the way. Gauss's rule takes
/// it. The spin changes in the frame of the body more slowly than the body turns, the more so the rounder it is: series and rule
/// are short. (Montgomery 1991, Am. J. Phys. 59, 394; van Zon & Schofield 2007, J. Comput. Phys. 225, 145.)
fn triaxial(inertia: Vec3, q: Quaternion, spin: Vec3, time: f64) -> Option<(Quaternion, Vec3)> {
    let angle = farthest_turn(inertia, spin, time);
    if angle.is_nan() || angle > FARTHEST {
        return None;
    }
    let rate = Vec3::from([0, 1, 2].map(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        (inertia[j] - inertia[k]) / inertia[i]
    }));
    // |dw/dt| <= max |rate| |w|^2 / 3^(1/2): the n-th term of the series is below that of a geometric one of this ratio.
    let ratio = rate.amax() * angle / 3.0_f64.sqrt();
    let pieces = (ratio / LONGEST).ceil().max(1.0);
    let scaled = inertia / inertia.max();
    let h = time / pieces;
    let (mut turned, mut change) = ([0.0; 4], Vec3::zeros());
    for _ in 0..pieces as u64 {
        let (turn, changed) = piece(scaled, rate, (spin + change) * h, ratio / pieces);
        turned = product_less_one(turned, turn);
        // Of no time nothing changes.
        if h != 0.0 {
            change += changed / h;
        }
    }
    Some((product(q, turned), change))
}

/// Ratio of the longest series.
const LONGEST: f64 = 0.125;

/// Up to this ratio three points of Gauss are enough, beyond it five: on an interval whose nearest singularity is 1 / ratio lengths
/// away the rule of n points errs by (ratio / 4)^(2 n) of an integrand that is of the size of the ratio's square.
const SHORT: f64 = 0.016;

/// Gauss's points and weights on [0, 1].
const THREE: [[f64; 2]; 3] = [
    [0.112_701_665_379_258_311_5, 0.277_777_777_777_777_777_8],
    [0.5, 0.444_444_444_444_444_444_4],
    [0.887_298_334_620_741_688_5, 0.277_777_777_777_777_777_8],
];
const FIVE: [[f64; 2]; 5] = [
    [0.046_910_077_030_668_003_6, 0.118_463_442_528_094_543_8],
    [0.230_765_344_947_158_454_5, 0.239_314_335_249_683_234_0],
    [0.5, 0.284_444_444_444_444_444_4],
    [0.769_234_655_052_841_545_5, 0.239_314_335_249_683_234_0],
    [0.953_089_922_969_331_996_4, 0.118_463_442_528_094_543_8],
];

/// The turn, less one, and the change of the spin in a unit of time.
fn piece(inertia: Vec3, rate: Vec3, spin: Vec3, ratio: f64) -> (Quaternion, Vec3) {
    const TERMS: usize = 24;
    /// 1/(n + 1).
    const SHARES: [f64; TERMS] = {
        let mut shares = [1.0; TERMS];
        let mut n = 1;
        while n < TERMS {
            shares[n] = 1.0 / (n + 1) as f64;
            n += 1;
        }
        shares
    };
    let negligible = 1e-18 * spin.amax();
    let mut w = [Vec3::zeros(); TERMS];
    w[0] = spin;
    let mut last = 0;
    while last + 1 < TERMS {
        let mut cross = Vec3::zeros();
        for m in 0..=last {
            let (a, b) = (w[m], w[last - m]);
            cross += Vec3::new(a.y * b.z, a.z * b.x, a.x * b.y);
        }
        w[last + 1] = SHARES[last] * rate.component_mul(&cross);
        last += 1;
        if last > 1 && w[last].amax() <= negligible && w[last - 1].amax() * ratio <= negligible {
            break;
        }
    }
    let change = |at: f64| {
        let mut sum = w[last];
        for n in (1..last).rev() {
            sum = sum * at + w[n];
        }
        sum * at
    };
    let momentum = inertia.component_mul(&spin);
    let square = momentum.norm_squared();
    let changed = change(1.0);
    if square < f64::MIN_POSITIVE / f64::EPSILON {
        // So small a turn is its rotation vector.
        return ([0.0, 0.5 * spin.x, 0.5 * spin.y, 0.5 * spin.z], changed);
    }
    // 1 + m_0 . m in units of L^2.
    let facing = |moved: &Vec3| 2.0 * square - 0.5 * moved.norm_squared();
    let swept = |[at, weight]: &[f64; 2]| {
        let spun = change(*at);
        let moved = inertia.component_mul(&spun);
        let rate = (momentum + moved).cross(&(spin + spun));
        weight * momentum.cross(&moved).dot(&rate) / facing(&moved)
    };
    let rule: &[[f64; 2]] = if ratio < SHORT { &THREE } else { &FIVE };
    let length = square.sqrt();
    let angle = (spin.dot(&momentum) - rule.iter().map(swept).sum::<f64>()) / length;
    let moved = inertia.component_mul(&changed);
    let cosine = (facing(&moved) / (2.0 * square)).sqrt();
    let across = moved.cross(&momentum) / (2.0 * cosine * square);
    let shortest = [-moved.norm_squared() / (4.0 * square * (1.0 + cosine)), across.x, across.y, across.z];
    (product_less_one(turn_less_one(momentum / length, angle), shortest), changed)
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
    let momentum = inertia.component_mul(&spin);
    let target = 0.5 * time * momentum;
    let mut p = 0.5 * time * spin;
    if p.norm() >= 1.0 {
        return None;
    }
    let mut last = f64::INFINITY;
    for _ in 0..50 {
        let square = 1.0 - p.norm_squared();
        if square <= 0.0 {
            return None;
        }
        let scalar = square.sqrt();
        let jp = inertia.component_mul(&p);
        let residual = scalar * jp + p.cross(&jp) - target;
        let jacobian = Mat3::from_diagonal(&inertia) * scalar - jp * p.transpose() / scalar
            + p.cross_matrix() * Mat3::from_diagonal(&inertia)
            - jp.cross_matrix();
        let step = jacobian.lu().solve(&residual)?;
        p -= step;
        let size = step.norm();
        // To round-off: on until the steps no longer shrink.
        if size == 0.0 || (size >= 0.5 * last && size < 1e-12) {
            let scalar = (1.0 - p.norm_squared()).sqrt();
            let turn = [-p.norm_squared() / (1.0 + scalar), p.x, p.y, p.z];
            // F^T (J spin) - J spin.
            let across = p.cross(&momentum);
            let change = 2.0 * (p.cross(&across) - scalar * across);
            return scalar.is_finite().then(|| (product(q, turn), change.component_div(&inertia)));
        }
        last = size;
    }
    None
}
