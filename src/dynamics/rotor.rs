//! A rigid body that turns freely: exactly, and by the discrete law of the Lie group variational integrator.
//!
//! Takes moments of inertia, attitude, spin and a time; gives the changes of attitude and spin, so that a caller who keeps low
//! parts loses nothing of them.

use crate::math::rotation::product;
use crate::math::stumpff::{REACH, stumpff};
use crate::math::{Mat3, Vec3};

type Quaternion = [f64; 4];

/// The unit quaternion of a rotation vector, less one.
#[inline]
fn turn_less_one(turn: Vec3) -> Quaternion {
    // Of the half angle.
    let square = 0.25 * turn.norm_squared();
    let (less, scale) = if square <= REACH {
        let [c2, c3] = stumpff(square);
        (-square * c2, 0.5 - 0.5 * square * c3)
    } else {
        let angle = 2.0 * square.sqrt();
        let (sine, cosine) = (0.25 * angle).sin_cos();
        (-2.0 * sine * sine, 2.0 * sine * cosine / angle)
    };
    [less, scale * turn.x, scale * turn.y, scale * turn.z]
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

/// A body that turns freely, by its principal moments of inertia.
#[derive(Debug, Clone)]
pub struct Top {
    inertia: Vec3,
    kind: Kind,
}

#[derive(Debug, Clone)]
enum Kind {
    /// Two equal moments: the axis of the third one, and its ratio to them.
    Symmetric(usize, f64),
    Triaxial(Triaxial),
}

impl Top {
    /// Of these moments; zeros for a point.
    pub fn new(inertia: Vec3) -> Self {
        let axis = (0..3).find(|&k| inertia[(k + 1) % 3] == inertia[(k + 2) % 3]);
        let kind = match axis {
            Some(axis) => {
                let across = inertia[(axis + 1) % 3];
                // A point has no inertia and turns on as a sphere would.
                Kind::Symmetric(axis, if across > 0.0 { inertia[axis] / across } else { 1.0 })
            }
            None => Kind::Triaxial(Triaxial::new(inertia)),
        };
        Self { inertia, kind }
    }

    /// Changes of attitude and spin over a time without torque.
    ///
    /// Two rotations for a body with two equal moments; for any other see `Triaxial`, and `None` where it turns farther than
    /// [`FARTHEST`].
    #[inline]
    pub fn turn(&self, q: Quaternion, spin: Vec3, time: f64) -> Option<(Quaternion, Vec3)> {
        match &self.kind {
            Kind::Symmetric(axis, ratio) => Some(symmetric(*axis, *ratio, q, spin, time)),
            Kind::Triaxial(top) => {
                let angle = self.inertia.component_mul(&spin).norm() * top.inverse_least * time.abs();
                // What is too large for it may be so by a loose bound.
                let angle = if angle <= FEW { angle } else { farthest_turn(self.inertia, spin, time) };
                top.turn(q, spin, time, angle)
            }
        }
    }
}

/// An angle that a freely rotating body with three different moments does not turn beyond in a time.
///
/// The spin stays below |L| over the smallest moment. For a needle that tumbles end over end that is too large by the ratio of its
/// moments, and beyond `FEW` a second bound is taken where it is smaller: every component of the spin stays below its value where
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
fn symmetric(axis: usize, ratio: f64, q: Quaternion, spin: Vec3, time: f64) -> (Quaternion, Vec3) {
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut about_momentum = spin;
    about_momentum[axis] *= ratio;
    let mut about_axis = Vec3::zeros();
    about_axis[axis] = (1.0 - ratio) * spin[axis];
    let (first, second) = (turn_less_one(about_momentum * time), turn_less_one(about_axis * time));
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
#[derive(Debug, Clone)]
struct Triaxial {
    /// In units of the largest one.
    inertia: Vec3,
    /// dw_i/dt = rate_i w_j w_k.
    rate: Vec3,
    /// |dw/dt| is below this times |w|^2: max |rate| / 3^(1/2). The terms of the series then fall at least as those of a geometric
    /// one of the ratio steepness |w| t.
    steepness: f64,
    /// 1 over the smallest moment.
    inverse_least: f64,
}

/// Ratio of the longest series.
const LONGEST: f64 = 0.125;

/// Gauss's points and weights on [0, 1], and the end, which has none.
type Rule<const N: usize> = [[f64; N]; 2];
const THREE: Rule<4> = [
    [0.112_701_665_379_258_311_5, 0.5, 0.887_298_334_620_741_688_5, 1.0],
    [0.277_777_777_777_777_777_8, 0.444_444_444_444_444_444_4, 0.277_777_777_777_777_777_8, 0.0],
];
const FIVE: Rule<6> = [
    [
        0.046_910_077_030_668_003_6,
        0.230_765_344_947_158_454_5,
        0.5,
        0.769_234_655_052_841_545_5,
        0.953_089_922_969_331_996_4,
        1.0,
    ],
    [
        0.118_463_442_528_094_543_8,
        0.239_314_335_249_683_234_0,
        0.284_444_444_444_444_444_4,
        0.239_314_335_249_683_234_0,
        0.118_463_442_528_094_543_8,
        0.0,
    ],
];

/// Coefficients of the series by the power before each.
macro_rules! terms {
    ($top:expr, $series:expr, $($before:literal)*) => { $( $top.term::<$before>(&mut $series); )* };
}

impl Triaxial {
    fn new(inertia: Vec3) -> Self {
        let rate = Vec3::from([0, 1, 2].map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            (inertia[j] - inertia[k]) / inertia[i]
        }));
        Self {
            inertia: inertia / inertia.max(),
            rate,
            steepness: rate.amax() / 3.0_f64.sqrt(),
            inverse_least: 1.0 / inertia.min(),
        }
    }

    /// `angle` is a bound of how far the body turns.
    fn turn(&self, q: Quaternion, spin: Vec3, time: f64, angle: f64) -> Option<(Quaternion, Vec3)> {
        if angle.is_nan() || angle > FARTHEST {
            return None;
        }
        let ratio = self.steepness * angle;
        if ratio <= LONGEST {
            let (turned, changed) = self.piece(spin * time, ratio);
            return Some((product(q, turned), if time == 0.0 { Vec3::zeros() } else { changed / time }));
        }
        let pieces = (ratio / LONGEST).ceil();
        let h = time / pieces;
        let (mut turned, mut change) = ([0.0; 4], Vec3::zeros());
        for _ in 0..pieces as u64 {
            let (turn, changed) = self.piece((spin + change) * h, ratio / pieces);
            turned = product_less_one(turned, turn);
            change += changed / h;
        }
        Some((product(q, turned), change))
    }

    /// The turn, less one, and the change of the spin in a unit of time.
    fn piece(&self, spin: Vec3, ratio: f64) -> (Quaternion, Vec3) {
        let mut w = [[0.0; 20]; 3];
        (0..3).for_each(|i| w[i][0] = spin[i]);
        let size = spin.amax();
        // Two terms may be small by chance, but then what follows them is smaller by the ratio and more.
        let short = |w: &Series, terms: usize| {
            let last = |n: usize| w[0][n].abs().max(w[1][n].abs()).max(w[2][n].abs());
            (last(terms - 1) + last(terms - 2)) * ratio <= 1e-18 * size
        };
        terms!(self, w, 0 1 2 3 4 5 6);
        // The rule of n points errs by (ratio / 4)^(2 n) of an integrand that is of the size of the square of m's way.
        let way = w[0][1].abs().max(w[1][1].abs()).max(w[2][1].abs());
        let few = way * way * (0.25 * ratio).powi(6) <= 1e-19 * size * size;
        if short(&w, 8) && few {
            return self.turned::<8, 4>(&w, &THREE, spin);
        }
        terms!(self, w, 7 8 9);
        if short(&w, 11) {
            return if few {
                self.turned::<11, 4>(&w, &THREE, spin)
            } else {
                self.turned::<11, 6>(&w, &FIVE, spin)
            };
        }
        terms!(self, w, 10 11 12 13 14 15 16 17 18);
        self.turned::<20, 6>(&w, &FIVE, spin)
    }

    /// By so many terms and a rule.
    #[inline(always)]
    fn turned<const TERMS: usize, const N: usize>(
        &self,
        w: &Series,
        rule: &Rule<N>,
        spin: Vec3,
    ) -> (Quaternion, Vec3) {
        let [points, weights] = rule;
        let changes = changes::<TERMS, N>(w, points);
        let momentum = self.inertia.component_mul(&spin);
        let square = momentum.norm_squared();
        let changed = Vec3::new(changes[0][N - 1], changes[1][N - 1], changes[2][N - 1]);
        if square < f64::MIN_POSITIVE / f64::EPSILON {
            // So small a turn is its rotation vector.
            return ([0.0, 0.5 * spin.x, 0.5 * spin.y, 0.5 * spin.z], changed);
        }
        // The integral of (L_0 x L) . dL/dt / (L^2 + L_0 . L).
        let mut swept = 0.0;
        for k in 0..N - 1 {
            let spun = Vec3::new(changes[0][k], changes[1][k], changes[2][k]);
            let moved = self.inertia.component_mul(&spun);
            let rate = (momentum + moved).cross(&(spin + spun));
            let facing = 2.0 * square - 0.5 * moved.norm_squared();
            swept += weights[k] * momentum.cross(&moved).dot(&rate) / facing;
        }
        let inverse = 1.0 / square.sqrt();
        let angle = (spin.dot(&momentum) - swept) * inverse;
        let (along, moved) = (momentum * inverse, self.inertia.component_mul(&changed) * inverse);
        let way = moved.norm_squared();
        let cosine = (1.0 - 0.25 * way).sqrt();
        let across = moved.cross(&along) * (0.5 / cosine);
        let shortest = [-0.25 * way / (1.0 + cosine), across.x, across.y, across.z];
        (product_less_one(turn_less_one(along * angle), shortest), changed)
    }

    /// The coefficient of the power N + 1 of the spin in time, by Euler's equations from those before it. Of constant length, so that
    /// no loop is left.
    #[inline(always)]
    fn term<const N: usize>(&self, w: &mut Series) {
        let mut sum = [0.0; 3];
        for m in 1..N {
            sum[0] += w[1][m] * w[2][N - m];
            sum[1] += w[2][m] * w[0][N - m];
            sum[2] += w[0][m] * w[1][N - m];
        }
        // What is newest comes last.
        sum[0] += w[1][0] * w[2][N];
        sum[1] += w[2][0] * w[0][N];
        sum[2] += w[0][0] * w[1][N];
        if N > 0 {
            sum[0] += w[1][N] * w[2][0];
            sum[1] += w[2][N] * w[0][0];
            sum[2] += w[0][N] * w[1][0];
        }
        let share = const { 1.0 / (N + 1) as f64 };
        for i in 0..3 {
            w[i][N + 1] = share * self.rate[i] * sum[i];
        }
    }
}

/// Coefficients of the spin's components in powers of time.
type Series = [[f64; 20]; 3];

/// Changes of the spin's components at several times, by so many terms.
#[inline(always)]
fn changes<const TERMS: usize, const N: usize>(w: &Series, times: &[f64; N]) -> [[f64; N]; 3] {
    let mut sums = [[0.0; N]; 3];
    for n in (1..TERMS).rev() {
        for i in 0..3 {
            for k in 0..N {
                sums[i][k] = (sums[i][k] + w[i][n]) * times[k];
            }
        }
    }
    sums
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
        return Top::new(inertia).turn(q, spin, time);
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
