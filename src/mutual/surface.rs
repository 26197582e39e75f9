//! The paper's surface integrals: force (Eq. 2), torque (Eq. 3) and mutual potential (Eq. 4).
//!
//! On the surface y = (a u, b v, c w) over the unit sphere, n dS = a b c (u/a, v/b, w/c) dOmega and the
//! density of unit mass is 3 / (4 pi a b c), so that with <.> the mean over the sphere
//!
//! ```text
//! F_i = (3/a_i) <Phi u_i>,    M_i = 3 (a_j/a_k - a_k/a_j) <Phi u_j u_k>,
//! U = <Phi - |y|^2/2 sum_i g_i u_i / a_i>.
//! ```
//!
//! The constant and the linear part of the monopole's potential 1/|x| about the centre x_0 are integrated in
//! closed form: the constant gives no force and the linear part the force -x_0/|x_0|^3, and neither gives a
//! torque; in a sum their round-off would be larger than the remainder. The sums contain the monopole beyond
//! its linear part, and K - K(x_0) with K = Phi - 1/|x|, both without cancellation. The monopole exerts no
//! torque on its own body, so that the field body's torque is that of K alone, without the round-off of the
//! monopole's lever; M_A + M_B + r x F_B = 0 still holds.
//!
//! F_i is a difference of pressures on opposite faces, divided by the distance of the faces. Bodies for which
//! that loses too many digits are integrated over by the field instead: see [`super::means`].

use super::{Balance, Roles};
use crate::gravity::FieldKernel;
use crate::math::Vec3;
use crate::math::lanes::{Lanes, Total, dot, splat_vector, total_vector};
use crate::quadrature::{NodeRange, Nodes};
use pulp::{Arch, Simd, WithSimd};
use std::ops::AddAssign;

/// Returns force and torques; `semi_axes` are those of the body that is integrated over.
pub(super) fn force_and_torque(
    arch: Arch,
    kernel: impl FieldKernel,
    nodes: &Nodes,
    semi_axes: [f64; 3],
    roles: &Roles,
) -> Balance {
    let [monopole, perturbation] =
        nodes.sum(|nodes| arch.dispatch(MomentSum { kernel, nodes, semi_axes, roles })).0;
    let [a, b, c] = semi_axes;
    let ratio = |x: f64, y: f64| (x - y) * (x + y) / (x * y);
    let lever = Vec3::new(ratio(b, c), ratio(c, a), ratio(a, b));
    let force = |m: &SurfaceMoments| roles.rotation * (3.0 * m.first.component_div(&Vec3::from(semi_axes)));
    let torque = |m: &SurfaceMoments| roles.rotation * (3.0 * lever.component_mul(&m.second));
    let (force_perturbation, torque_perturbation) = (force(&perturbation), torque(&perturbation));
    let r = roles.origin.norm();
    Balance {
        force: force(&monopole) - roles.origin / r / r / r + force_perturbation,
        torque: torque(&monopole) + torque_perturbation,
        torque_field: -(torque_perturbation + roles.origin.cross(&force_perturbation)),
    }
}

/// Returns the paper's U of Eq. (4) per unit G m m: a positive number, minus the potential energy.
pub(super) fn mutual_potential(
    arch: Arch,
    kernel: impl FieldKernel,
    nodes: &Nodes,
    semi_axes: [f64; 3],
    roles: &Roles,
) -> f64 {
    nodes.sum(|nodes| arch.dispatch(SurfaceEnergySum { kernel, nodes, semi_axes, roles }))
}

/// Returns a point of the surface in the body's canonical frame, and its position from the field body's
/// centre in that body's canonical frame.
#[inline(always)]
fn surface_point<S: Simd>(
    unit: [Lanes<S>; 3],
    semi_axes: [f64; 3],
    roles: &Roles,
) -> ([Lanes<S>; 3], [Lanes<S>; 3]) {
    let c = |value| unit[0].constant(value);
    let y = [unit[0] * c(semi_axes[0]), unit[1] * c(semi_axes[1]), unit[2] * c(semi_axes[2])];
    let x = position_from_field(y, roles);
    (y, x)
}

/// Returns the position of a point y of the body from the field body's centre, in the canonical frame of the
/// field body.
#[inline(always)]
pub(super) fn position_from_field<S: Simd>(y: [Lanes<S>; 3], roles: &Roles) -> [Lanes<S>; 3] {
    let c = |value| y[0].constant(value);
    let mut x = [c(roles.origin.x), c(roles.origin.y), c(roles.origin.z)];
    for i in 0..3 {
        for k in 0..3 {
            x[i] = y[k].mul_add(c(roles.rotation[(i, k)]), x[i]);
        }
    }
    x
}

/// Returns n . g, with n in the surface's frame rotated into the field's, and g_i = -x_i R_i.
#[inline(always)]
pub(super) fn flux<S: Simd>(
    n: [Lanes<S>; 3],
    x: [Lanes<S>; 3],
    rd: [Lanes<S>; 3],
    roles: &Roles,
) -> Lanes<S> {
    let c = |value| n[0].constant(value);
    let mut flux = c(0.0);
    for i in 0..3 {
        let row = [c(roles.rotation[(i, 0)]), c(roles.rotation[(i, 1)]), c(roles.rotation[(i, 2)])];
        flux = (dot(n, row) * x[i]).mul_add(-rd[i], flux);
    }
    flux
}

/// The monopole's potential 1/|x| beyond its linear part about the centre x_0, without cancellation.
#[derive(Clone, Copy)]
pub(super) struct BeyondLinear<S: Simd> {
    inverse_centre: Lanes<S>,
    inverse_square: Lanes<S>,
    half_inverse_centre: Lanes<S>,
    /// Twice x_0, in the frame of y.
    twice_origin: [Lanes<S>; 3],
}

impl<S: Simd> BeyondLinear<S> {
    #[inline(always)]
    pub fn new(simd: S, roles: &Roles) -> Self {
        let splat = |v| Lanes::splat(simd, v);
        let inverse_centre = splat(1.0 / roles.origin.norm());
        Self {
            inverse_centre,
            inverse_square: inverse_centre * inverse_centre,
            half_inverse_centre: splat(0.5) * inverse_centre,
            twice_origin: splat_vector(simd, &(roles.rotation.transpose() * roles.origin * 2.0)),
        }
    }

    /// Evaluates at a point y of the body, with x its position from the field body's centre. With s =
    /// |x|/|x_0| and s^2 - 1 = y . (y + 2 x_0)/|x_0|^2 the value is ((s - 1)^2 (s + 2)/s - y^2/|x_0|^2) / (2
    /// |x_0|).
    #[inline(always)]
    pub fn at(self, y: [Lanes<S>; 3], x: [Lanes<S>; 3]) -> Lanes<S> {
        let c = |value| y[0].constant(value);
        let mut gain = c(0.0);
        for i in 0..3 {
            gain = y[i].mul_add(y[i] + self.twice_origin[i], gain);
        }
        let s = dot(x, x).sqrt() * self.inverse_centre;
        let beyond = gain * self.inverse_square / (s + c(1.0));
        let monopole = beyond * beyond * (s + c(2.0)) / s - dot(y, y) * self.inverse_square;
        monopole * self.half_inverse_centre
    }
}

struct MomentSum<'a, K> {
    kernel: K,
    nodes: NodeRange<'a>,
    semi_axes: [f64; 3],
    roles: &'a Roles,
}

/// The means <f u_i> and <f u_j u_k> of a part f of the potential.
struct SurfaceMoments {
    first: Vec3,
    second: Vec3,
}

/// The means for the monopole and for the rest of the potential.
struct PotentialMoments([SurfaceMoments; 2]);

impl AddAssign for PotentialMoments {
    fn add_assign(&mut self, other: Self) {
        for (sum, more) in self.0.iter_mut().zip(other.0) {
            sum.first += more.first;
            sum.second += more.second;
        }
    }
}

impl<K: FieldKernel> WithSimd for MomentSum<'_, K> {
    type Output = PotentialMoments;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> PotentialMoments {
        let [u, v, w] = self.nodes.points;
        let (u, v, w) = (Lanes::blocks(simd, u), Lanes::blocks(simd, v), Lanes::blocks(simd, w));
        let weights = Lanes::blocks(simd, self.nodes.weights);
        let beyond_linear = BeyondLinear::new(simd, self.roles);
        let at_centre = splat_vector(simd, &self.roles.origin);
        let (perturbation_at_centre, _) = self.kernel.potential_perturbation(at_centre);
        let zero = Total::zero(simd);
        let (mut first, mut second) = ([[zero; 3]; 2], [[zero; 3]; 2]);
        for (((u, v), w), weight) in u.zip(v).zip(w).zip(weights) {
            let unit = [u, v, w];
            let (y, x) = surface_point(unit, self.semi_axes, self.roles);
            let (perturbation, _) = self.kernel.potential_perturbation(x);
            let monopole = beyond_linear.at(y, x);
            let parts = [weight * monopole, weight * (perturbation - perturbation_at_centre)];
            for i in 0..3 {
                let product = unit[(i + 1) % 3] * unit[(i + 2) % 3];
                for (part, f) in parts.into_iter().enumerate() {
                    first[part][i].add_product(f, unit[i]);
                    second[part][i].add_product(f, product);
                }
            }
        }
        PotentialMoments([
            SurfaceMoments { first: total_vector(first[0]), second: total_vector(second[0]) },
            SurfaceMoments { first: total_vector(first[1]), second: total_vector(second[1]) },
        ])
    }
}

struct SurfaceEnergySum<'a, K> {
    kernel: K,
    nodes: NodeRange<'a>,
    semi_axes: [f64; 3],
    roles: &'a Roles,
}

impl<K: FieldKernel> WithSimd for SurfaceEnergySum<'_, K> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let [u, v, w] = self.nodes.points;
        let (u, v, w) = (Lanes::blocks(simd, u), Lanes::blocks(simd, v), Lanes::blocks(simd, w));
        let weights = Lanes::blocks(simd, self.nodes.weights);
        let splat = |v| Lanes::splat(simd, v);
        let mut sum = Total::zero(simd);
        for (((u, v), w), weight) in u.zip(v).zip(w).zip(weights) {
            let unit = [u, v, w];
            let (y, x) = surface_point(unit, self.semi_axes, self.roles);
            let (perturbation, field) = self.kernel.potential_perturbation(x);
            let distance = dot(x, x).sqrt();
            let phi = splat(1.0) / distance + perturbation;
            // The normal is n = u_i / a_i.
            let [a, b, c] = self.semi_axes;
            let normal = [unit[0] * splat(1.0 / a), unit[1] * splat(1.0 / b), unit[2] * splat(1.0 / c)];
            let flux = flux(normal, x, field.rd, self.roles);
            let y2 = dot(y, y);
            sum.add_product(weight, phi - splat(0.5) * y2 * flux);
        }
        sum.value()
    }
}
