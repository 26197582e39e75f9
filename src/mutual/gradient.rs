//! The derivatives of force and torques as means of the other body's field gradient, over the nodes of
//! [`super::means`].
//!
//! With x = o + z, z = sum_k e_k y_k the arm of a node, g the field and H = dg/dx, the force on the body that
//! is integrated over is `F = <g>`, its torque `M = <z x g>` and that of the field body `N = <-x x g>`. A
//! displacement of o by do and a rotation of the arms by alpha give
//!
//! ```text
//! dF = <H> do + <H (alpha x z)>,
//! dM = <z x H do> + <(alpha x z) x g + z x H (alpha x z)>,
//! dN = <dn/dx> do + <dn/dx (alpha x z)>,   n = -x x g,
//! ```
//!
//! so that only the means of H, H y_k, H y_k y_l, dn/dx and dn/dx y_k are needed. From a distance n is much
//! smaller than |x| |g|. With Q_i the differences of the R_i, n_1 = x_2 x_3 Q_1 and dQ_1/dx_j = f n_2 n_3 n_j
//! (a_3^2 - a_2^2) / (x_2 x_3) in the notation of [`crate::gravity::PointField::gradient_factors`], no digits
//! are lost.

use super::means::{NodePositions, NodesInField, load};
use super::{Balance, Roles};
use crate::gravity::{FieldKernel, PointField};
use crate::math::lanes::{Lanes, Total, total_vector};
use crate::math::matrix::{cross_times, times_cross};
use crate::math::rotation::rotate;
use crate::math::{Mat3, Vec3};
use crate::quadrature::Nodes;
use pulp::{Arch, Simd, WithSimd};
use std::ops::AddAssign;

/// The number of registers that are processed side by side.
pub(super) const ABREAST: usize = 4;

/// Loads and their derivatives, in the field body's canonical frame.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CanonicalJacobian {
    pub balance: Balance,
    /// The derivative of the force with respect to the position.
    pub force_by_position: Mat3,
    /// The derivative of the force with respect to a rotation of the body that is integrated over. The
    /// derivative of the torque with respect to the position is its transpose.
    pub force_by_rotation: Mat3,
    /// The derivative of the torque with respect to a rotation of the body that is integrated over.
    pub torque_by_rotation: Mat3,
    /// The derivative of the field body's torque with respect to the position.
    pub field_by_position: Mat3,
    /// The derivative of the field body's torque with respect to a rotation of the body that is integrated
    /// over.
    pub field_by_rotation: Mat3,
    /// The derivatives of the loads with respect to a factor of all lengths of the body that is integrated
    /// over, at its mass.
    pub by_scale: Balance,
}

/// Returns the loads and their derivatives; `node_scales` are the factors from the nodes' coordinates to the
/// body's canonical frame. M = (D + 1) (D + 2) / 2.
pub(super) fn canonical_jacobian<const D: usize, const M: usize>(
    arch: Arch,
    kernel: impl FieldKernel,
    nodes: &Nodes,
    node_scales: [f64; D],
    roles: &Roles,
) -> CanonicalJacobian {
    let axes: [Vec3; D] = std::array::from_fn(|k| roles.rotation.column(k) * node_scales[k]);
    let origin = roles.origin;
    let sums = nodes
        .sum(|nodes| arch.dispatch(GradientSum::<_, D, M>(NodesInField { kernel, nodes, origin, axes })));
    let mut jacobian = CanonicalJacobian {
        balance: Balance { force: sums.force, torque_field: sums.torque_field, ..Balance::default() },
        force_by_position: sums.gradient[0],
        field_by_position: sums.torque_gradient[0],
        ..CanonicalJacobian::default()
    };
    let mut second = 1 + D;
    for k in 0..D {
        let attraction = &sums.moment[k];
        jacobian.balance.torque += axes[k].cross(attraction);
        jacobian.force_by_rotation -= times_cross(&sums.gradient[1 + k], &axes[k]);
        jacobian.field_by_rotation -= times_cross(&sums.torque_gradient[1 + k], &axes[k]);
        jacobian.by_scale.force += rotate(&sums.gradient[1 + k], &axes[k]);
        jacobian.by_scale.torque_field += rotate(&sums.torque_gradient[1 + k], &axes[k]);
        // This is the term (alpha x e) x g.
        jacobian.torque_by_rotation +=
            axes[k] * attraction.transpose() - Mat3::from_diagonal_element(axes[k].dot(attraction));
        for l in k..D {
            let product = times_cross(&cross_times(&axes[k], &sums.gradient[second]), &axes[l]);
            jacobian.torque_by_rotation -= if l == k { product } else { product + product.transpose() };
            jacobian.by_scale.torque += axes[k].cross(&rotate(&sums.gradient[second], &axes[l]));
            if l > k {
                jacobian.by_scale.torque += axes[l].cross(&rotate(&sums.gradient[second], &axes[k]));
            }
            second += 1;
        }
    }
    // The arms grow with the lengths, too.
    jacobian.by_scale.torque += jacobian.balance.torque;
    jacobian
}

/// Returns the field's gradient. Its trace is zero, so that five numbers suffice: xx, yy, xy, xz, yz.
#[inline(always)]
pub(super) fn gradient<S: Simd, const N: usize>(
    field: &PointField<S, N>,
    (n, f): ([Lanes<S, N>; 3], Lanes<S, N>),
) -> [Lanes<S, N>; 5] {
    let [fx, fy] = [f * n[0], f * n[1]];
    [fx * n[0] - field.rd[0], fy * n[1] - field.rd[1], fx * n[1], fx * n[2], fy * n[2]]
}

/// Returns the symmetric matrix of trace zero with these components xx, yy, xy, xz and yz.
pub(super) fn trace_free([xx, yy, xy, xz, yz]: [f64; 5]) -> Mat3 {
    Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, -(xx + yy))
}

struct GradientSum<'a, K, const D: usize, const M: usize>(NodesInField<'a, K, D>);

struct GradientMeans<const D: usize, const M: usize> {
    /// The mean of g.
    force: Vec3,
    /// The means of y_k g.
    moment: [Vec3; D],
    /// The mean of n.
    torque_field: Vec3,
    /// The means of H, of H y_k, and of H y_k y_l with l not below k.
    gradient: [Mat3; M],
    /// The means of dn/dx, and of dn/dx y_k in the first D of the other elements.
    torque_gradient: [Mat3; M],
}

impl<const D: usize, const M: usize> AddAssign for GradientMeans<D, M> {
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.torque_field += other.torque_field;
        self.moment.iter_mut().zip(other.moment).for_each(|(sum, more)| *sum += more);
        let matrices = self.gradient.iter_mut().chain(&mut self.torque_gradient);
        matrices
            .zip(other.gradient.into_iter().chain(other.torque_gradient))
            .for_each(|(sum, more)| *sum += more);
    }
}

impl<K: FieldKernel, const D: usize, const M: usize> WithSimd for GradientSum<'_, K, D, M> {
    type Output = GradientMeans<D, M>;

    /// Processes several registers side by side, as in [`super::means`].
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> GradientMeans<D, M> {
        let zero = Total::zero(simd);
        let mut running = GradientAccumulator {
            force: [zero; 3],
            moments: [[zero; 3]; D],
            torque: [zero; 3],
            gradients: [[zero; 5]; M],
            torque_gradients: [[zero; 9]; M],
        };
        let registers = self.0.nodes.weights.len() / S::F64_LANES;
        let (groups, remainder) = (registers / ABREAST, registers % ABREAST);
        for k in 0..groups {
            running.add::<_, ABREAST>(simd, &self.0, ABREAST * k);
        }
        for k in 0..remainder / 2 {
            running.add::<_, 2>(simd, &self.0, ABREAST * groups + 2 * k);
        }
        let (mut moment, mut gradient, mut torque_gradient) =
            ([Vec3::zeros(); D], [Mat3::zeros(); M], [Mat3::zeros(); M]);
        for k in 0..D {
            moment[k] = -total_vector(running.moments[k]);
        }
        for m in 0..M {
            gradient[m] = trace_free(running.gradients[m].map(Total::value));
        }
        for m in 0..=D {
            for c in 0..9 {
                torque_gradient[m][(c / 3, c % 3)] = running.torque_gradients[m][c].value();
            }
        }
        let torque_field = total_vector(running.torque);
        GradientMeans { force: -total_vector(running.force), moment, torque_field, gradient, torque_gradient }
    }
}

/// The running sums over the nodes.
struct GradientAccumulator<S: Simd, const D: usize, const M: usize> {
    force: [Total<S>; 3],
    moments: [[Total<S>; 3]; D],
    torque: [Total<S>; 3],
    gradients: [[Total<S>; 5]; M],
    torque_gradients: [[Total<S>; 9]; M],
}

impl<S: Simd, const D: usize, const M: usize> GradientAccumulator<S, D, M> {
    /// Adds the nodes of `N` registers, starting from one.
    #[inline(always)]
    fn add<K: FieldKernel, const N: usize>(
        &mut self,
        simd: S,
        sum: &NodesInField<'_, K, D>,
        register: usize,
    ) {
        let positions: NodePositions<S, D, N> = NodePositions::new(simd, &sum.origin, &sum.axes);
        let (y, weight) = load(simd, &sum.nodes, register);
        let x = positions.at(y);
        let field = sum.kernel.field(x);
        let (n, f) = field.gradient_factors(x);
        let gradient = gradient(&field, (n, f));
        let mut share = [weight; M];
        let mut next = 1 + D;
        for k in 0..D {
            share[1 + k] = weight * y[k];
            for l in k..D {
                share[next] = share[1 + k] * y[l];
                next += 1;
            }
        }
        for m in 0..M {
            for i in 0..5 {
                self.gradients[m][i].add_product(share[m], gradient[i]);
            }
        }
        let torque_gradient = field.torque_gradient(x, (n, f), sum.kernel.square_differences());
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let attraction = x[i] * field.rd[i];
            self.force[i].add_product(weight, attraction);
            for m in 0..D {
                self.moments[m][i].add_product(share[1 + m], attraction);
            }
            self.torque[i].add_product(weight * x[j], x[k] * field.rd_difference[i]);
            for m in 0..=D {
                for c in 0..3 {
                    self.torque_gradients[m][3 * i + c].add_product(share[m], torque_gradient[i][c]);
                }
            }
        }
    }
}
