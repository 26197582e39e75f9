//! The free rotation of a rigid body in closed form, for as many bodies of the same kind as a register has
//! lanes.
//!
//! Takes constants of the moments of inertia, attitudes, spins and a time; gives the changes of attitude and
//! spin, which a caller adds to numbers with low parts without loss. Components of vectors are in cyclic
//! order, beginning with the distinguished axis.

pub(super) mod discrete_rotor;
pub(super) mod free_rotors;
pub(super) mod steady_rotation;

use crate::math::Vec3;
use crate::math::lanes::{Lanes, WIDEST};
use crate::math::stumpff::{SERIES_LIMIT, stumpff};
use pulp::Simd;

/// One number for each of as many bodies as a register has lanes.
type Numbers<S> = Lanes<S, 1>;

/// Returns cos a - 1 and sin a / a, given a^2.
#[inline(always)]
fn cosine_minus_one<S: Simd>(simd: S, square: Numbers<S>) -> (Numbers<S>, Numbers<S>) {
    let [c2, c3] = stumpff(square);
    let series = (-(square * c2), -(square * c3) + 1.0);
    if square.reduce_max() <= SERIES_LIMIT {
        return series;
    }
    let (mut squares, mut less, mut scale) = ([0.0; WIDEST], [0.0; WIDEST], [0.0; WIDEST]);
    square.store(&mut squares, 0);
    series.0.store(&mut less, 0);
    series.1.store(&mut scale, 0);
    for lane in 0..S::F64_LANES {
        if squares[lane] > SERIES_LIMIT {
            let angle = squares[lane].sqrt();
            let (sine, cosine) = (0.5 * angle).sin_cos();
            (less[lane], scale[lane]) = (-2.0 * sine * sine, 2.0 * sine * cosine / angle);
        }
    }
    (Lanes::load(simd, &less, 0), Lanes::load(simd, &scale, 0))
}

/// Returns Hamilton's product.
#[inline(always)]
fn product<S: Simd>(p: [Numbers<S>; 4], q: [Numbers<S>; 4]) -> [Numbers<S>; 4] {
    [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3],
        p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1],
    ]
}

/// Returns the product of two quaternions, where both factors and the result are given minus one.
#[inline(always)]
fn product_minus_one<S: Simd>(first: [Numbers<S>; 4], second: [Numbers<S>; 4]) -> [Numbers<S>; 4] {
    let mut result = product(first, second);
    for c in 0..4 {
        result[c] = first[c] + second[c] + result[c];
    }
    result
}

/// A kind of rotors, with `K` constants for each of them.
trait RotorKind<const K: usize> {
    /// Returns the changes of the attitude and of the spin over twice the time `half`.
    fn rotate<S: Simd>(
        simd: S,
        constants: [Numbers<S>; K],
        q: [Numbers<S>; 4],
        spin: [Numbers<S>; 3],
        half: f64,
    ) -> ([Numbers<S>; 4], [Numbers<S>; 3]);
}

/// A rotor with two equal moments, with the symmetry axis first. It rotates about the angular momentum at the
/// rate |L|/I and then about the axis. The constant is the ratio of the third moment to the two equal ones.
struct Symmetric;

impl RotorKind<1> for Symmetric {
    #[inline(always)]
    fn rotate<S: Simd>(
        simd: S,
        [ratio]: [Numbers<S>; 1],
        q: [Numbers<S>; 4],
        [along, j, k]: [Numbers<S>; 3],
        half: f64,
    ) -> ([Numbers<S>; 4], [Numbers<S>; 3]) {
        let (x, y, z) = (ratio * along * half, j * half, k * half);
        let (less, scale) = cosine_minus_one(simd, x * x + y * y + z * z);
        let (x, y, z) = (scale * x, scale * y, scale * z);
        let axial = (-ratio + 1.0) * along * half;
        let (axial_less, scale) = cosine_minus_one(simd, axial * axial);
        let axial_sine = scale * axial;
        let rotation = [
            less + axial_less + (less * axial_less - x * axial_sine),
            x + axial_sine + (x * axial_less + less * axial_sine),
            y + (y * axial_less + z * axial_sine),
            z + (z * axial_less - y * axial_sine),
        ];
        // The other two components of the spin rotate in the opposite sense, by twice the half angle of that
        // quaternion.
        let (less, sine) = (axial_sine * axial_sine * -2.0, axial_sine * (axial_less + 1.0) * 2.0);
        (product(q, rotation), [along.constant(0.0), less * j + sine * k, less * k - sine * j])
    }
}

/// The closed-form free rotation of a body with three different moments, from the state in the middle of the
/// step.
///
/// Measured from the axis of the intermediate moment, the spin is w = (a_1 sn, a_2 cn, a_3 dn) with Jacobi's
/// elliptic functions. Half of the step is the unit of time here, and s = sn(l)/l, c = cn(l) and d = dn(l)
/// are the functions of half of the step, with
///
///   x = l^2 = -r_1 r_2 a_3^2,  z = l^2 k^2 = -r_1 r_3 a_2^2,
///   a_j^2 = w_j^2 - r_j/r_1 w_1^2,  r_i = (I_j - I_k)/I_i.
///
/// The addition theorem gives the spin u in the middle, and the change of spin as a product:
///
///   u f = (w_1 c d + r_1 w_2 w_3 s, w_2 c + r_2 w_3 w_1 s d, w_3 d + r_3 w_1 w_2 s c),
///   f = 1 - r_2 r_3 w_1^2 s^2,
///   w' - w = 2 s (r_1 u_2 u_3, r_2 u_3 u_1 d, r_3 u_1 u_2 c) f^2 / g,  g = f^2 - r_2 r_3 (u_1 f)^2 s^2.
/// The quaternion of the rotation is that of a discrete rotor (see [`crate::dynamics::variational_rotation`])
/// whose moments depend on the energy T, the angular momentum L and the time alone: Hairer & Vilmart (2006),
/// J. Phys. A 39, 13225. It therefore suffices to know the rotation angle where u_1 = 0. With N = I_1^2 r_1^2
/// a_2^2 a_3^2 / L^2 half of that angle is
///
///   phi = 2 T/L - (1 - 2 T I_1/L^2) (J - 1) L/I_1,
///   J = int_0^s dy / ((1 - N y^2) ((1 - x y^2) (1 - z y^2))^(1/2)),
///
/// where J is Legendre's third integral (van Zon & Schofield 2007, J. Comput. Phys. 225, 145). J, s, c and d
/// do not depend on how fast the body rotates but only on how fast its spin moves in the body frame, so that
/// short series suffice.
struct Triaxial;

/// The number of constants of a triaxial rotor.
const TRIAXIAL: usize = 11;

/// The constants of triaxial rotors.
#[derive(Clone, Copy)]
struct RotorMoments<S: Simd> {
    /// The moments in cyclic order beginning with the intermediate one, in units of the largest one.
    inertia: [Numbers<S>; 3],
    /// The ratios r_i.
    rate: [Numbers<S>; 3],
    /// The products r_2 r_3, -r_1 r_2 and -r_1 r_3, which are positive.
    product: [Numbers<S>; 3],
    /// The numbers I_1^2/(r_2 r_3) and 1/I_1.
    scale: Numbers<S>,
    inverse: Numbers<S>,
}

/// The largest x + z, for which the first omitted terms of the series are below 1e-17 of their sums.
const SHORT_STEP: f64 = 0.004;

/// The spin and the conserved quantities of a rotation, with half of the step as the unit of time.
#[derive(Clone, Copy)]
struct RotorState<S: Simd> {
    spin: [Numbers<S>; 3],
    /// The numbers x and z.
    fast: [Numbers<S>; 2],
    /// The square of the angular momentum, L^2.
    square: Numbers<S>,
}

impl Triaxial {
    /// Returns the axis of the intermediate moment, and the constants.
    pub fn constants(inertia: Vec3) -> (usize, [f64; TRIAXIAL]) {
        let middle = inertia.sum() - inertia.min() - inertia.max();
        let distance = |k: &usize| (inertia[*k] - middle).abs();
        let axis = (0..3).min_by(|j, k| distance(j).total_cmp(&distance(k))).unwrap_or(0);
        let [i1, i2, i3] = [0, 1, 2].map(|k| inertia[(axis + k) % 3]);
        // Differences are taken of the moments as given, since they may be small.
        let [r1, r2, r3] = [(i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3];
        let [i1, i2, i3] = [i1, i2, i3].map(|moment| moment / inertia.max());
        (axis, [i1, i2, i3, r1, r2, r3, r2 * r3, -r1 * r2, -r1 * r3, i1 * i1 / (r2 * r3), 1.0 / i1])
    }
}

impl RotorKind<TRIAXIAL> for Triaxial {
    #[inline(always)]
    fn rotate<S: Simd>(
        simd: S,
        constants: [Numbers<S>; TRIAXIAL],
        q: [Numbers<S>; 4],
        spin: [Numbers<S>; 3],
        half: f64,
    ) -> ([Numbers<S>; 4], [Numbers<S>; 3]) {
        let [i1, i2, i3, r1, r2, r3, r23, r12, r13, scale, inverse] = constants;
        let rotor = RotorMoments {
            inertia: [i1, i2, i3],
            rate: [r1, r2, r3],
            product: [r23, r12, r13],
            scale,
            inverse,
        };
        let w = [spin[0] * half, spin[1] * half, spin[2] * half];
        let squares = [w[0] * w[0], w[1] * w[1], w[2] * w[2]];
        let first = rotor.product[0] * squares[0];
        let fast = [first + rotor.product[1] * squares[2], first + rotor.product[2] * squares[1]];
        let mut square = first.constant(0.0);
        for i in 0..3 {
            square = square + rotor.inertia[i] * rotor.inertia[i] * squares[i];
        }
        let state = RotorState { spin: w, fast, square };
        let fastest = (fast[0] + fast[1]).reduce_max();
        let (rotation, change) =
            if fastest <= SHORT_STEP { rotor.piece(simd, state) } else { rotor.pieces(simd, state, fastest) };
        let inverse = if half == 0.0 { 0.0 } else { 1.0 / half };
        (product(q, rotation), [change[0] * inverse, change[1] * inverse, change[2] * inverse])
    }
}

impl<S: Simd> RotorMoments<S> {
    /// Returns the rotation minus one and the change of the spin, computed in several steps.
    #[inline(always)]
    fn pieces(&self, simd: S, state: RotorState<S>, fastest: f64) -> ([Numbers<S>; 4], [Numbers<S>; 3]) {
        let count = (fastest / SHORT_STEP).sqrt().ceil();
        let share = 1.0 / count;
        let fast = [state.fast[0] * (share * share), state.fast[1] * (share * share)];
        let square = state.square * (share * share);
        let zero = square.constant(0.0);
        let (mut rotation, mut change) = ([zero; 4], [zero; 3]);
        for _ in 0..count as u64 {
            let mut spin = state.spin;
            for i in 0..3 {
                spin[i] = (spin[i] + change[i]) * share;
            }
            let (step_rotation, step_change) = self.piece(simd, RotorState { spin, fast, square });
            rotation = product_minus_one(rotation, step_rotation);
            for i in 0..3 {
                change[i] = change[i] + step_change[i] * count;
            }
        }
        (rotation, change)
    }

    /// Returns the rotation minus one and the change of the spin, computed in a single step.
    #[inline(always)]
    fn piece(&self, simd: S, state: RotorState<S>) -> ([Numbers<S>; 4], [Numbers<S>; 3]) {
        let ([i1, i2, i3], [r1, r2, r3]) = (self.inertia, self.rate);
        let RotorState { spin: w, fast: [x, z], square } = state;
        let (zero, one) = (x.constant(0.0), x.constant(1.0));
        // The bound makes the rotation zero for a spin of zero.
        let square = square.max(x.constant(f64::MIN_POSITIVE / f64::EPSILON));
        let (sum, product) = (x + z, x * z);
        let s = sine(sum, product);
        let s2 = s * s;
        let (c, d) = ((one - x * s2).sqrt(), (one - z * s2).sqrt());
        let cd = c * d;
        let [w11, w22, w33] = [w[0] * w[0], w[1] * w[1], w[2] * w[2]];
        let r23 = self.product[0] * s2;
        let facing = one - r23 * w11;
        let u = [
            w[0] * cd + r1 * s * (w[1] * w[2]),
            w[1] * c + r2 * s * d * (w[2] * w[0]),
            w[2] * d + r3 * s * c * (w[0] * w[1]),
        ];
        let by_square = one / square;
        let by_momentum = square.sqrt() * by_square;
        let n = self.scale * product * by_square * s2;
        let along = one - n;
        // One division serves three quotients: by g, by g (1 - n) and by c d.
        let g = facing * facing - r23 * (u[0] * u[0]);
        let denominator = g * along;
        let inverse = one / (denominator * cd);
        let (by_denominator, by_cd) = (inverse * cd, inverse * denominator);
        let twice = s * (by_denominator * along) * 2.0;
        let change =
            [twice * r1 * (u[1] * u[2]), twice * r2 * d * (u[2] * u[0]), twice * r3 * c * (u[0] * u[1])];
        let energy = i1 * w11 + i2 * w22 + i3 * w33;
        // This is L^2 - 2 T I_1 without its cancellation.
        let off = i2 * i3 * (r2 * w33 - r3 * w22);
        let phi =
            (energy - off * self.inverse * (n * s * third(n, sum * s2, product * s2 * s2))) * by_momentum;
        let (less, sine) = cosine_minus_one(simd, phi * phi);
        let cosine = less + 1.0;
        let (sine, slope) = (phi * sine * by_momentum, cosine * s * by_cd);
        let mean = energy * by_square - n * self.inverse;
        let root = by_denominator.sqrt();
        let p = [
            root * cd * u[0] * (i1 * sine + slope * (off * by_square)),
            root * c * u[1] * (i2 * sine + slope * (along - i2 * mean)),
            root * d * u[2] * (i3 * sine + slope * (along - i3 * mean)),
        ];
        let scalar = cosine * along * facing * root;
        let vector_square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        let scalar_minus_one = zero.if_less(scalar, -(vector_square / (scalar + 1.0)), scalar - one);
        ([scalar_minus_one, p[0], p[1], p[2]], change)
    }
}

/// Returns s from x + z and x z: Maclaurin's series of sn, DLMF 22.10(i).
#[inline(always)]
fn sine<S: Simd>(p: Numbers<S>, q: Numbers<S>) -> Numbers<S> {
    let (pp, qq) = (p * p, q * q);
    let low = p.constant(1.0) - p * (1.0 / 6.0) + (pp + q * 12.0) * (1.0 / 120.0)
        - p * (pp + q * 132.0) * (1.0 / 5040.0);
    let high = pp * (pp + q * 1224.0) + qq * 3024.0;
    let highest = p * (pp * (pp + q * 11_064.0) + qq * 132_624.0);
    low + (high * (1.0 / 362_880.0) - highest * (1.0 / 39_916_800.0))
}

/// Returns (J - 1)/(N s^3) from N s^2, (x + z) s^2 and x z s^4, by powers of s. The powers of the integrand
/// are those of (1 - (x + z) y + x z y^2)^(-1/2), summed with N.
#[inline(always)]
fn third<S: Simd>(n: Numbers<S>, p: Numbers<S>, q: Numbers<S>) -> Numbers<S> {
    let b1 = p * 0.5;
    let b2 = p * b1 * 0.75 - q * 0.5;
    let b3 = p * b2 * (5.0 / 6.0) - q * b1 * (2.0 / 3.0);
    let b4 = p * b3 * 0.875 - q * b2 * 0.75;
    let b5 = p * b4 * 0.9 - q * b3 * 0.8;
    let c1 = b1 + n;
    let c2 = b2 + n * c1;
    let c3 = b3 + n * c2;
    let c4 = b4 + n * c3;
    let c5 = b5 + n * c4;
    (c1 * (1.0 / 5.0) + 1.0 / 3.0)
        + (c2 * (1.0 / 7.0) + c3 * (1.0 / 9.0))
        + (c4 * (1.0 / 11.0) + c5 * (1.0 / 13.0))
}
