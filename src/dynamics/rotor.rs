//! A rigid body that turns freely.
//!
//! Takes moments of inertia, attitude, spin and a time; gives the changes of attitude and spin, so that a caller who keeps low
//! parts loses nothing of them.

use crate::math::Vec3;
use crate::math::rotation::product;
use crate::math::stumpff::{REACH, stumpff};

pub(super) type Quaternion = [f64; 4];

/// cos a - 1 and sin a / a of a^2.
#[inline(always)]
fn less_one(square: f64) -> (f64, f64) {
    if square <= REACH {
        let [c2, c3] = stumpff(square);
        (-square * c2, 1.0 - square * c3)
    } else {
        let angle = square.sqrt();
        let (sine, cosine) = (0.5 * angle).sin_cos();
        (-2.0 * sine * sine, 2.0 * sine * cosine / angle)
    }
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
    #[inline(always)]
    pub fn turn(&self, q: Quaternion, spin: Vec3, time: f64) -> Option<(Quaternion, Vec3)> {
        match &self.kind {
            Kind::Symmetric(axis, ratio) => Some(symmetric(*axis, *ratio, q, spin, time)),
            Kind::Triaxial(top) => top.turn(q, spin, time, self.inertia),
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
#[inline(always)]
fn symmetric(axis: usize, ratio: f64, q: Quaternion, spin: Vec3, time: f64) -> (Quaternion, Vec3) {
    let [along, j, k] = from_axis(axis, spin.into());
    let half = 0.5 * time;
    let (x, y, z) = (ratio * along * half, j * half, k * half);
    let (less, scale) = less_one(x * x + y * y + z * z);
    let (x, y, z) = (scale * x, scale * y, scale * z);
    let own = (1.0 - ratio) * along * half;
    let (own_less, scale) = less_one(own * own);
    let own_sine = scale * own;
    let turned = [
        less + own_less + (less * own_less - x * own_sine),
        x + own_sine + (x * own_less + less * own_sine),
        y + (y * own_less + z * own_sine),
        z + (z * own_less - y * own_sine),
    ];
    // The spin's other two components turn the other way, by twice the half angle of that quaternion.
    let (less, sine) = (-2.0 * own_sine * own_sine, 2.0 * own_sine * (1.0 + own_less));
    (onto(axis, q, turned), Vec3::from(from_axis(3 - axis, [0.0, less * j + sine * k, less * k - sine * j])))
}

/// The change of an attitude by a turn, less one, that is given from an axis on.
#[inline(always)]
fn onto(axis: usize, q: Quaternion, [less, x, y, z]: Quaternion) -> Quaternion {
    let [x, y, z] = from_axis(3 - axis, [x, y, z]);
    product(q, [less, x, y, z])
}

/// Components from an axis on.
#[inline(always)]
fn from_axis(axis: usize, [x, y, z]: [f64; 3]) -> [f64; 3] {
    match axis {
        1 => [y, z, x],
        2 => [z, x, y],
        _ => [x, y, z],
    }
}

/// Euler's top in closed form, from the middle of its way.
///
/// From the axis of the intermediate moment on, the spin is w = (a_1 sn, a_2 cn, a_3 dn) of Jacobi's functions. Half the time is the
/// unit here, s = sn(l)/l, c = cn(l) and d = dn(l) those of half the way, with
///
///   x = l^2 = -r_1 r_2 a_3^2,  z = l^2 k^2 = -r_1 r_3 a_2^2,  a_j^2 = w_j^2 - r_j/r_1 w_1^2,  r_i = (I_j - I_k)/I_i.
///
/// The addition theorem gives the spin u in the middle, and the change of spin as a product:
///
///   u f = (w_1 c d + r_1 w_2 w_3 s, w_2 c + r_2 w_3 w_1 s d, w_3 d + r_3 w_1 w_2 s c),  f = 1 - r_2 r_3 w_1^2 s^2,
///   w' - w = 2 s (r_1 u_2 u_3, r_2 u_3 u_1 d, r_3 u_1 u_2 c) f^2 / g,  g = f^2 - r_2 r_3 (u_1 f)^2 s^2.
///
/// The quaternion of the turn is that of a discrete top (see [`super::variational_rotation`]) whose moments depend on the energy T, the
/// angular momentum L and the time alone: Hairer & Vilmart (2006), J. Phys. A 39, 13225. So it suffices to know its angle where
/// u_1 = 0. With N = I_1^2 r_1^2 a_2^2 a_3^2 / L^2 half of that is
///
///   phi = 2 T/L - (1 - 2 T I_1/L^2) (J - 1) L/I_1,   J = int_0^s dy / ((1 - N y^2) ((1 - x y^2) (1 - z y^2))^(1/2)),
///
/// Legendre's third integral (van Zon & Schofield 2007, J. Comput. Phys. 225, 145). Neither it nor s, c and d know how fast the
/// body turns, but only how fast its spin moves in its own frame: their series are short.
#[derive(Debug, Clone)]
struct Triaxial {
    /// The axis of the intermediate moment.
    axis: usize,
    /// The moments from it on, in units of the largest one.
    inertia: [f64; 3],
    /// The r_i.
    rate: [f64; 3],
    /// r_2 r_3, -r_1 r_2 and -r_1 r_3, which are above zero.
    product: [f64; 3],
    /// I_1^2/(r_2 r_3), and 1/I_1.
    scale: f64,
    inverse: f64,
    /// The square of the largest moment over the smallest one.
    spread: f64,
}

/// The largest x + z. The first terms that the series leave out are then below 1e-17 of their sums.
const SHORT: f64 = 0.004;

/// The spin, and what stays while a body turns freely. Half the time is the unit.
#[derive(Clone, Copy)]
struct Turning {
    spin: [f64; 3],
    /// x and z.
    fast: [f64; 2],
    /// L^2.
    square: f64,
}

impl Triaxial {
    fn new(inertia: Vec3) -> Self {
        let middle = inertia.sum() - inertia.min() - inertia.max();
        let distance = |k: &usize| (inertia[*k] - middle).abs();
        let axis = (0..3).min_by(|j, k| distance(j).total_cmp(&distance(k))).unwrap_or(0);
        let [i1, i2, i3] = from_axis(axis, inertia.into());
        // Of the moments as they are: their differences may be small.
        let [r1, r2, r3] = [(i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3];
        let [i1, i2, i3] = [i1, i2, i3].map(|moment| moment / inertia.max());
        Self {
            axis,
            inertia: [i1, i2, i3],
            rate: [r1, r2, r3],
            product: [r2 * r3, -r1 * r2, -r1 * r3],
            scale: i1 * i1 / (r2 * r3),
            inverse: 1.0 / i1,
            spread: (inertia.max() / inertia.min()).powi(2),
        }
    }

    /// `inertia` are the moments as they were given.
    #[inline(always)]
    fn turn(&self, q: Quaternion, spin: Vec3, time: f64, inertia: Vec3) -> Option<(Quaternion, Vec3)> {
        let half = 0.5 * time;
        let w = from_axis(self.axis, (spin * half).into());
        let squares = w.map(|w| w * w);
        let first = self.product[0] * squares[0];
        let fast = [first + self.product[1] * squares[2], first + self.product[2] * squares[1]];
        let mut square = 0.0;
        (0..3).for_each(|i| square += self.inertia[i] * self.inertia[i] * squares[i]);
        // What is too large for it may be so by a loose bound.
        if 4.0 * square * self.spread > FEW * FEW || square.is_nan() {
            let angle = farthest_turn(inertia, spin, time);
            if angle.is_nan() || angle > FARTHEST {
                return None;
            }
        }
        let whole = Turning { spin: w, fast, square };
        let (turned, change) =
            if fast[0] + fast[1] <= SHORT { self.piece(whole) } else { self.pieces(whole) };
        let inverse = if half == 0.0 { 0.0 } else { 1.0 / half };
        Some((onto(self.axis, q, turned), Vec3::from(from_axis(3 - self.axis, change)) * inverse))
    }

    /// The turn, less one, and the change of the spin, in pieces.
    #[inline(never)]
    fn pieces(&self, whole: Turning) -> (Quaternion, [f64; 3]) {
        let count = ((whole.fast[0] + whole.fast[1]) / SHORT).sqrt().ceil();
        let share = 1.0 / count;
        let (fast, square) = (whole.fast.map(|fast| fast * share * share), whole.square * share * share);
        let (mut turned, mut change) = ([0.0; 4], [0.0; 3]);
        for _ in 0..count as u64 {
            let spin = [0, 1, 2].map(|i| (whole.spin[i] + change[i]) * share);
            let (turn, changed) = self.piece(Turning { spin, fast, square });
            turned = product_less_one(turned, turn);
            (0..3).for_each(|i| change[i] += changed[i] * count);
        }
        (turned, change)
    }

    /// The same at once.
    #[inline(always)]
    fn piece(&self, whole: Turning) -> (Quaternion, [f64; 3]) {
        let ([i1, i2, i3], [r1, r2, r3]) = (self.inertia, self.rate);
        let Turning { spin: w, fast: [x, z], square } = whole;
        // Without a spin the turn is then none.
        let square = square.max(f64::MIN_POSITIVE / f64::EPSILON);
        let (sum, product) = (x + z, x * z);
        let s = sine(sum, product);
        let s2 = s * s;
        let (c, d) = ((1.0 - x * s2).sqrt(), (1.0 - z * s2).sqrt());
        let cd = c * d;
        let [w11, w22, w33] = w.map(|w| w * w);
        let r23 = self.product[0] * s2;
        let facing = 1.0 - r23 * w11;
        let u = [
            w[0] * cd + r1 * s * (w[1] * w[2]),
            w[1] * c + r2 * s * d * (w[2] * w[0]),
            w[2] * d + r3 * s * c * (w[0] * w[1]),
        ];
        let by_square = 1.0 / square;
        let by_momentum = square.sqrt() * by_square;
        let n = self.scale * product * by_square * s2;
        let along = 1.0 - n;
        // One division for three: by g, by g (1 - n) and by c d.
        let g = facing * facing - r23 * (u[0] * u[0]);
        let both = g * along;
        let inverse = 1.0 / (both * cd);
        let (by_both, by_cd) = (inverse * cd, inverse * both);
        let twice = 2.0 * s * (by_both * along);
        let change =
            [twice * r1 * (u[1] * u[2]), twice * r2 * d * (u[2] * u[0]), twice * r3 * c * (u[0] * u[1])];
        let energy = i1 * w11 + i2 * w22 + i3 * w33;
        // L^2 - 2 T I_1 without its cancellation.
        let off = i2 * i3 * (r2 * w33 - r3 * w22);
        let phi =
            (energy - off * self.inverse * (n * s * third(n, sum * s2, product * s2 * s2))) * by_momentum;
        let (less, sine) = less_one(phi * phi);
        let cosine = 1.0 + less;
        let (sine, slope) = (phi * sine * by_momentum, cosine * s * by_cd);
        let mean = energy * by_square - n * self.inverse;
        let root = by_both.sqrt();
        let p = [
            root * cd * u[0] * (i1 * sine + slope * (off * by_square)),
            root * c * u[1] * (i2 * sine + slope * (along - i2 * mean)),
            root * d * u[2] * (i3 * sine + slope * (along - i3 * mean)),
        ];
        let whole = cosine * along * facing * root;
        let way = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        let less = if whole > 0.0 { -way / (1.0 + whole) } else { whole - 1.0 };
        ([less, p[0], p[1], p[2]], change)
    }
}

/// s of x + z and x z: Maclaurin's series of sn, DLMF 22.10(i).
#[inline(always)]
fn sine(p: f64, q: f64) -> f64 {
    let (pp, qq) = (p * p, q * q);
    let low = 1.0 - p * (1.0 / 6.0) + (pp + 12.0 * q) * (1.0 / 120.0) - p * (pp + 132.0 * q) * (1.0 / 5040.0);
    let high = pp * (pp + 1224.0 * q) + 3024.0 * qq;
    let highest = p * (pp * (pp + 11_064.0 * q) + 132_624.0 * qq);
    low + (high * (1.0 / 362_880.0) - highest * (1.0 / 39_916_800.0))
}

/// (J - 1)/(N s^3) of N s^2, (x + z) s^2 and x z s^4, by powers of s: the integrand's are those of (1 - (x + z) y + x z y^2)^(-1/2),
/// summed up with N.
#[inline(always)]
fn third(n: f64, p: f64, q: f64) -> f64 {
    let b1 = 0.5 * p;
    let b2 = 0.75 * (p * b1) - 0.5 * q;
    let b3 = (5.0 / 6.0) * (p * b2) - (2.0 / 3.0) * (q * b1);
    let b4 = 0.875 * (p * b3) - 0.75 * (q * b2);
    let b5 = 0.9 * (p * b4) - 0.8 * (q * b3);
    let c1 = b1 + n;
    let c2 = b2 + n * c1;
    let c3 = b3 + n * c2;
    let c4 = b4 + n * c3;
    let c5 = b5 + n * c4;
    (1.0 / 3.0 + c1 * (1.0 / 5.0))
        + (c2 * (1.0 / 7.0) + c3 * (1.0 / 9.0))
        + (c4 * (1.0 / 11.0) + c5 * (1.0 / 13.0))
}
