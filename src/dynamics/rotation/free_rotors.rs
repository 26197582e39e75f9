//! The free rotation of rigid bodies.
//!
//! Takes moments of inertia, attitudes, spins and a time; gives the changes of attitude and spin. Bodies of
//! the same kind are processed side by side.

use super::{Numbers, RotorKind, Symmetric, TRIAXIAL, Triaxial};
use crate::error::Result;
use crate::math::lanes::WIDEST;
use crate::math::{Vec3, ascending};
use pulp::{Scalar, Simd};

pub(super) type Quaternion = [f64; 4];

/// The largest angle by which a body with three different moments is rotated in one call, in rad: about 160
/// revolutions.
pub const MAX_ROTATION_ANGLE: f64 = 1024.0;

/// The angle, in rad, up to which a loose bound of the angle is accepted.
const LOOSE_BOUND_LIMIT: f64 = 64.0;

/// Returns an upper bound of the angle by which a freely rotating body with three different moments rotates
/// in a time.
///
/// The spin stays below |L| over the smallest moment. For a needle that tumbles end over end this bound is
/// too large by the ratio of its moments. Beyond `LOOSE_BOUND_LIMIT` a second bound is computed and the smaller one is
/// taken. It follows from the conserved L^2 and energy T, which limit every component of the spin. With I_1 <
/// I_2 < I_3, L^2 - 2 T I_1 = I_2 (I_2 - I_1) w_2^2 + I_3 (I_3 - I_1) w_3^2 and 2 T I_3 - L^2 = I_1 (I_3 -
/// I_1) w_1^2 + I_2 (I_3 - I_2) w_2^2.
pub fn rotation_angle_bound(inertia: Vec3, spin: Vec3, time: f64) -> f64 {
    let by_momentum = inertia.component_mul(&spin).norm() / inertia.min() * time.abs();
    if by_momentum <= LOOSE_BOUND_LIMIT {
        return by_momentum;
    }
    let order = ascending(inertia.into());
    let [i1, i2, i3] = order.map(|k| inertia[k]);
    let [s1, s2, s3] = order.map(|k| spin[k] * spin[k]);
    let (first, third) = (i1 * (i3 - i1), i3 * (i3 - i1));
    let (second_by_first, second_by_third) = (i2 * (i3 - i2), i2 * (i2 - i1));
    let largest1 = s1 + second_by_first / first * s2;
    let largest2 = s2 + (first / second_by_first * s1).min(third / second_by_third * s3);
    let largest3 = s3 + second_by_third / third * s2;
    by_momentum.min((largest1 + largest2 + largest3).sqrt() * time.abs())
}

/// A freely rotating rigid body, given by its principal moments of inertia.
#[derive(Debug, Clone)]
pub struct FreeRotor {
    /// The group that holds this body alone.
    rotors: FreeRotors,
}

impl FreeRotor {
    /// Takes the moments of inertia; zeros for a point.
    pub fn new(inertia: Vec3) -> Self {
        Self { rotors: FreeRotors::new(&[inertia]) }
    }

    /// Returns the changes of attitude and spin over a time without torque; `None` where the body would
    /// rotate further than [`MAX_ROTATION_ANGLE`].
    pub fn rotate(&self, q: Quaternion, spin: Vec3, time: f64) -> Option<(Quaternion, Vec3)> {
        let (mut attitude_change, mut spin_change) = ([[0.0; 4]], [[0.0; 3]]);
        let bodies = RotorStates {
            attitude: &[q],
            spin: &[spin.into()],
            attitude_change: &mut attitude_change,
            spin_change: &mut spin_change,
        };
        match self.rotors.rotate(Scalar, time, bodies, |_| Ok(())) {
            Ok(None) => Some((attitude_change[0], spin_change[0].into())),
            _ => None,
        }
    }
}

/// Attitudes and spins of bodies, and the arrays for their changes.
pub struct RotorStates<'a> {
    pub attitude: &'a [Quaternion],
    pub spin: &'a [[f64; 3]],
    pub attitude_change: &'a mut [Quaternion],
    pub spin_change: &'a mut [[f64; 3]],
}

/// Freely rotating bodies, grouped so that bodies of the same kind are processed side by side.
///
/// The rotation of a body with two equal moments is composed of two uniform rotations; for other bodies see
/// `Triaxial`.
#[derive(Debug, Clone)]
pub struct FreeRotors {
    /// The bodies with two equal moments; their constant is the ratio of the third moment to the equal ones.
    symmetric: RotorGroup<1>,
    triaxial: RotorGroup<TRIAXIAL>,
}

/// Bodies of the same kind.
#[derive(Debug, Clone)]
struct RotorGroup<const K: usize> {
    members: Vec<GroupedRotor>,
    /// The constants of the members, padded to whole registers.
    constants: [Vec<f64>; K],
}

#[derive(Debug, Clone)]
struct GroupedRotor {
    body: usize,
    /// The axes in cyclic order, beginning with the distinguished one.
    axes: [usize; 3],
    inertia: Vec3,
    /// The square of the ratio of the largest to the smallest moment; zero for a body whose angle is not
    /// limited.
    spread: f64,
}

impl FreeRotors {
    /// Takes moments of inertia; zeros for a point.
    pub fn new(inertia: &[Vec3]) -> Self {
        let (mut symmetric, mut triaxial) = (RotorGroup::new(), RotorGroup::new());
        for (body, moments) in inertia.iter().enumerate() {
            match (0..3).find(|&k| moments[(k + 1) % 3] == moments[(k + 2) % 3]) {
                Some(axis) => {
                    let across = moments[(axis + 1) % 3];
                    // A point has no inertia and keeps rotating as a sphere would.
                    let ratio = if across > 0.0 { moments[axis] / across } else { 1.0 };
                    symmetric.add(body, axis, *moments, 0.0, [ratio]);
                }
                None => {
                    let (axis, constants) = Triaxial::constants(*moments);
                    triaxial.add(body, axis, *moments, (moments.max() / moments.min()).powi(2), constants);
                }
            }
        }
        Self { symmetric, triaxial }
    }

    /// Rotates the bodies over a time without torque: takes attitude and spin of each at the start, and
    /// writes the changes of both. `check` is called before each body and may interrupt. Returns the index of
    /// a body that would rotate further than [`MAX_ROTATION_ANGLE`].
    #[inline(always)]
    pub fn rotate<S: Simd>(
        &self,
        simd: S,
        time: f64,
        mut bodies: RotorStates,
        mut check: impl FnMut(usize) -> Result<()>,
    ) -> Result<Option<usize>> {
        let too_far = self.symmetric.rotate::<S, Symmetric>(simd, time, &mut bodies, &mut check)?;
        if too_far.is_some() {
            return Ok(too_far);
        }
        self.triaxial.rotate::<S, Triaxial>(simd, time, &mut bodies, &mut check)
    }
}

impl<const K: usize> RotorGroup<K> {
    fn new() -> Self {
        Self { members: Vec::new(), constants: std::array::from_fn(|_| Vec::new()) }
    }

    fn add(&mut self, body: usize, axis: usize, inertia: Vec3, spread: f64, constants: [f64; K]) {
        let index = self.members.len();
        self.members.push(GroupedRotor {
            body,
            axes: [axis, (axis + 1) % 3, (axis + 2) % 3],
            inertia,
            spread,
        });
        for (list, constant) in self.constants.iter_mut().zip(constants) {
            list.resize((index + 1).next_multiple_of(WIDEST), 0.0);
            list[index] = constant;
        }
    }

    #[inline(always)]
    fn rotate<S: Simd, T: RotorKind<K>>(
        &self,
        simd: S,
        time: f64,
        bodies: &mut RotorStates,
        check: &mut impl FnMut(usize) -> Result<()>,
    ) -> Result<Option<usize>> {
        let order = Numbers::load(simd, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], 0);
        let zero = order.constant(0.0);
        for (block, members) in self.members.chunks(S::F64_LANES).enumerate() {
            let mut numbers = [zero; 7];
            for (lane, member) in members.iter().enumerate().rev() {
                check(member.body)?;
                let [i, j, k] = member.axes;
                let (q, spin) = (&bodies.attitude[member.body], &bodies.spin[member.body]);
                let columns @ [_, _, _, _, x, y, z] =
                    [q[0], q[1 + i], q[1 + j], q[1 + k], spin[i], spin[j], spin[k]];
                let bound = (x * x + y * y + z * z) * (time * time) * member.spread;
                // The loose bound may exceed the limit where the angle itself does not.
                if bound > LOOSE_BOUND_LIMIT * LOOSE_BOUND_LIMIT || bound.is_nan() {
                    let angle = rotation_angle_bound(member.inertia, (*spin).into(), time);
                    if angle > MAX_ROTATION_ANGLE || angle.is_nan() {
                        return Ok(Some(member.body));
                    }
                }
                // Values are moved between registers, because loading a vector that was stored element by
                // element would stall.
                let next = order.constant(lane as f64 + 1.0);
                for c in 0..7 {
                    numbers[c] = order.if_less(next, order.constant(columns[c]), numbers[c]);
                }
            }
            let mut constants = [zero; K];
            for k in 0..K {
                constants[k] = Numbers::load(simd, &self.constants[k], block);
            }
            let [q0, q1, q2, q3, x, y, z] = numbers;
            let (rotation, change) = T::rotate(simd, constants, [q0, q1, q2, q3], [x, y, z], 0.5 * time);
            let mut changes = [[0.0; WIDEST]; 7];
            for k in 0..4 {
                rotation[k].store(&mut changes[k], 0);
            }
            for k in 0..3 {
                change[k].store(&mut changes[4 + k], 0);
            }
            for (lane, member) in members.iter().enumerate() {
                let (q, spin) =
                    (&mut bodies.attitude_change[member.body], &mut bodies.spin_change[member.body]);
                q[0] = changes[0][lane];
                for (c, axis) in member.axes.into_iter().enumerate() {
                    (q[1 + axis], spin[axis]) = (changes[1 + c][lane], changes[4 + c][lane]);
                }
            }
        }
        Ok(None)
    }
}
