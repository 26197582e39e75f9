//! The derivatives of force and torques with respect to the semi-axes of either body, at constant masses.
//!
//! For the body that is integrated over, with s = 1 on its surface and 0 in its centre, partial integration
//! over the body gives for the mean of any harmonic h that `d<h>/da_i = (a_i/5) <d^2 h/dy_i^2>'`, where
//! `<.>'` is the mean with a density in proportion to 1 - s^2. By Ferrers' potentials this mean can be taken
//! over the focal ellipse, with a density in proportion to (1 - x^2/(a^2-c^2) - y^2/(b^2-c^2))^(3/2). There
//! is no 0/0 for equal axes. With T the third derivatives of the field body's potential along the axis e_i,
//!
//! ```text
//! dF/da_i = (a_i/5) <T e_i e_i>',   dM/da_i = (a_i/5) <z x T e_i e_i + 2 e_i x H e_i>'.
//! ```
//!
//! The derivatives with respect to the axes of the field body have no 0/0 either, see
//! [`PointField::semi_axis_derivatives`](crate::gravity::PointField::semi_axis_derivatives).
//!
//! The field body's torque follows from M + N + o x F = 0.

use super::gradient::{ABREAST, gradient, trace_free};
use super::jacobian::FrameRotations;
use super::means::NodePositions;
use super::rule::Kernel;
use super::{Balance, Interaction, Pair, PartGravity, Pose, Roles};
use crate::error::Result;
use crate::gravity::FieldKernel;
use crate::interrupt::InterruptCheck;
use crate::math::lanes::{Lanes, Total};
use crate::math::rotation::rotate;
use crate::math::{Mat3, Vec3};
use crate::quadrature::Nodes;
use pulp::{Arch, Simd, WithSimd};

/// The derivatives of the loads with respect to the lengths of the first and of the second body at fixed
/// masses, per unit G m_first m_second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapeDerivatives {
    /// The derivatives with respect to the semi-axes of an ellipsoid; zero for other shapes.
    pub axes: [[Interaction; 3]; 2],
    /// The derivatives with respect to a factor of all lengths of a polyhedron; zero for other shapes.
    pub scale: [Interaction; 2],
}

impl ShapeDerivatives {
    /// The derivatives for two points.
    pub(super) const ZERO: Self = Self { axes: [[Interaction::ZERO; 3]; 2], scale: [Interaction::ZERO; 2] };

    /// Returns the derivatives with a function applied to all loads.
    pub(super) fn map(&self, convert: impl Fn(Interaction) -> Interaction) -> Self {
        Self { axes: self.axes.map(|body| body.map(&convert)), scale: self.scale.map(&convert) }
    }
}

impl Pair {
    /// Returns the derivatives with respect to the lengths of both shapes with the rule in use, after
    /// [`Self::prepare_jacobian`]; zero for points. Allocates nothing.
    pub fn shape_derivatives(&self, pose: &Pose, interrupt: &mut InterruptCheck) -> Result<ShapeDerivatives> {
        if self.is_faceted() {
            return self.faceted_lengths(pose, interrupt);
        }
        if let Some(fragments) = &self.fragments {
            let scaled = self.scaled(pose);
            let derivatives = fragments.shape_derivatives(&scaled, interrupt)?;
            let derivatives = derivatives.ok_or_else(|| self.fragments_not_converged(&scaled))?;
            return Ok(derivatives.map(|loads| self.loads_in_unit(&loads, 0)));
        }
        let mut out = ShapeDerivatives::ZERO;
        let by_series = match (&self.multipole, self.series()) {
            (_, Some((harmonic, _))) => Some(harmonic.shape_derivatives(&self.scaled(pose))),
            (Some(multipole), None) => Some(multipole.shape_derivatives(&self.scaled(pose))),
            (None, None) => None,
        };
        if let Some(derivatives) = by_series {
            out.axes = derivatives.axes.map(|body| body.map(|loads| self.loads_in_unit(&loads, 1)));
            out.scale = derivatives.scale.map(|loads| self.loads_in_unit(&loads, 0));
            return Ok(out);
        }
        let (Some(rule), Some(nodes)) = (&self.rule, &self.axis_nodes) else { return Ok(out) };
        let pose = self.scaled(pose);
        let [field, set] = self.field_and_set(rule);
        let roles = self.roles(rule.integrated, &pose);
        let (arch, nodes) = (self.arch, &*nodes.nodes);
        let derivatives = match &rule.kernel {
            Kernel::Near(near) => sum_derivatives(arch, *near, nodes, [field, set], &roles),
            Kernel::Far(truncation) => {
                sum_derivatives(arch, field.series.truncated(*truncation), nodes, [field, set], &roles)
            }
            // Kernels of polyhedra were handled above, by [`Pair::is_faceted`].
            Kernel::Facets | Kernel::Layer(_) => return Ok(out),
        };
        let frame_rotations = FrameRotations::new(rule.integrated, &pose, &roles, [field, set]);
        for (which, body) in [field, set].into_iter().enumerate() {
            let body_index = if which == 1 { rule.integrated } else { 1 - rule.integrated };
            for (axis, row) in body.rows_of_axes().into_iter().enumerate() {
                out.axes[body_index][axis] =
                    self.loads_in_unit(&frame_rotations.in_bodies(&derivatives[which][row]), 1);
            }
        }
        Ok(out)
    }

    /// Returns the derivatives of the loads with respect to a harmonic moment of a body, by its index; zero
    /// where no series is in use.
    pub fn by_moment(&self, pose: &Pose, body: usize, index: usize) -> Interaction {
        let Some((harmonic, truncation)) = self.series() else { return Interaction::ZERO };
        self.loads_in_unit(&harmonic.by_moment(truncation, &self.scaled(pose), body, index), 0)
    }

    /// Converts loads, divided by this power of a length, from the pair's unit of length to that of the bodies.
    #[inline]
    pub(super) fn loads_in_unit(&self, loads: &Interaction, lengths: i32) -> Interaction {
        // The unit is a power of two, so that the scaling is exact.
        let inverse = self.unit.powi(-lengths) / self.unit;
        Interaction {
            force_on_first: loads.force_on_first * (inverse / self.unit),
            torque_first: loads.torque_first * inverse,
            torque_second: loads.torque_second * inverse,
        }
    }
}

/// Returns the derivatives for the field body and for the one that is integrated over, along their canonical
/// axes.
fn sum_derivatives(
    arch: Arch,
    kernel: impl FieldKernel,
    nodes: &Nodes,
    [field, set]: [&PartGravity; 2],
    roles: &Roles,
) -> [[Balance; 3]; 2] {
    let focal = set.focal_axes();
    let arms: [Vec3; 2] = std::array::from_fn(|k| roles.rotation.column(k) * focal[k]);
    let sums = arch.dispatch(AxisSum { kernel, nodes, origin: roles.origin, arms });
    let (field_axes, set_axes) = (field.semi_axes(), set.semi_axes());
    let zero = Vec3::zeros();
    let mut all = [[Balance { force: zero, torque: zero, torque_field: zero }; 3]; 2];
    for i in 0..3 {
        let e = Vec3::new(roles.rotation[(0, i)], roles.rotation[(1, i)], roles.rotation[(2, i)]);
        let factor = set_axes[i] / 5.0;
        let gradient_torque = e.cross(&rotate(&sums.gradient, &e)) * (2.0 * factor);
        for (which, balance) in all.iter_mut().enumerate() {
            let balance = &mut balance[i];
            let mut means = [zero; 3];
            for m in 0..3 {
                let by = &sums.semi_axis_derivatives[m];
                means[m] = match which {
                    0 => Vec3::new(by[(i, 0)], by[(i, 1)], by[(i, 2)]) * field_axes[i],
                    _ => contract(&sums.third[m], &e) * factor,
                };
            }
            balance.force = means[0];
            balance.torque = arms[0].cross(&means[1]) + arms[1].cross(&means[2]);
            if which == 1 {
                balance.torque += gradient_torque;
            }
            balance.torque_field = -(balance.torque + roles.origin.cross(&balance.force));
        }
    }
    all
}

/// Returns T e e for a symmetric, trace-free tensor, given by its components 000, 001, 002, 011, 012, 111 and
/// 112.
fn contract(t: &[f64; 7], e: &Vec3) -> Vec3 {
    let [t000, t001, t002, t011, t012, t111, t112] = *t;
    let (t022, t122, t222) = (-t000 - t011, -t001 - t111, -t002 - t112);
    let [x, y, z] = [e.x, e.y, e.z];
    let form = |xx: f64, xy: f64, xz: f64, yy: f64, yz: f64, zz: f64| {
        xx * x * x + yy * y * y + zz * z * z + 2.0 * (xy * x * y + xz * x * z + yz * y * z)
    };
    Vec3::new(
        form(t000, t001, t002, t011, t012, t022),
        form(t001, t011, t012, t111, t112, t122),
        form(t002, t012, t022, t112, t122, t222),
    )
}

struct AxisSum<'a, K> {
    kernel: K,
    nodes: &'a Nodes,
    origin: Vec3,
    arms: [Vec3; 2],
}

struct AxisMeans {
    /// The means of T, T y_1 and T y_2 with the density 1 - s^2.
    third: [[f64; 7]; 3],
    /// The mean of H with that density.
    gradient: Mat3,
    /// Means of dg_j/da_i over a_i, in row i, and of these times y_1 and y_2.
    semi_axis_derivatives: [Mat3; 3],
}

impl<K: FieldKernel> WithSimd for AxisSum<'_, K> {
    type Output = AxisMeans;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> AxisMeans {
        let zero = Total::zero(simd);
        let mut running = AxisAccumulator {
            thirds: [[zero; 7]; 3],
            gradients: [zero; 5],
            axes: [[zero; 9]; 3],
            density: zero,
        };
        let registers = self.nodes.weights.len() / S::F64_LANES;
        let (groups, remainder) = (registers / ABREAST, registers % ABREAST);
        for k in 0..groups {
            running.add::<_, ABREAST>(simd, &self, ABREAST * k);
        }
        for k in 0..remainder / 2 {
            running.add::<_, 2>(simd, &self, ABREAST * groups + 2 * k);
        }
        let AxisAccumulator { thirds, gradients, axes, density } = running;
        let inverse = 1.0 / density.value();
        let mut sums = AxisMeans {
            third: [[0.0; 7]; 3],
            gradient: Mat3::zeros(),
            semi_axis_derivatives: [Mat3::zeros(); 3],
        };
        for m in 0..3 {
            for k in 0..7 {
                sums.third[m][k] = thirds[m][k].value() * inverse;
            }
            for k in 0..9 {
                sums.semi_axis_derivatives[m][(k / 3, k % 3)] = axes[m][k].value();
            }
        }
        sums.gradient = trace_free(gradients.map(|total| total.value() * inverse));
        sums
    }
}

/// The running sums over the nodes.
struct AxisAccumulator<S: Simd> {
    thirds: [[Total<S>; 7]; 3],
    gradients: [Total<S>; 5],
    axes: [[Total<S>; 9]; 3],
    density: Total<S>,
}

impl<S: Simd> AxisAccumulator<S> {
    /// Adds the nodes of `N` registers, starting from one.
    #[inline(always)]
    fn add<K: FieldKernel, const N: usize>(&mut self, simd: S, sum: &AxisSum<'_, K>, register: usize) {
        let positions: NodePositions<S, 2, N> = NodePositions::new(simd, &sum.origin, &sum.arms);
        let (nodes, from) = (sum.nodes, register * S::F64_LANES);
        let [u, v] =
            [Lanes::load(simd, &nodes.points[0][from..], 0), Lanes::load(simd, &nodes.points[1][from..], 0)];
        let weight: Lanes<S, N> = Lanes::load(simd, &nodes.weights[from..], 0);
        let w = weight.constant(0.0);
        let x = positions.at([u, v, w]);
        let c = |value: f64| weight.constant(value);
        let (field, second_integrals) = sum.kernel.second_integrals(x);
        let (n, f) = field.gradient_factors(x);
        let (inverse, _) = field.reciprocals();
        let square = [n[0] * n[0], n[1] * n[1], n[2] * n[2]];
        let normal_square = square[0] + square[1] + square[2];
        let weighted_square =
            square[0].mul_add(inverse[0], square[1].mul_add(inverse[1], square[2] * inverse[2]));
        let twice_inverse = c(2.0) / normal_square;
        let common = weighted_square.mul_add(twice_inverse, c(-0.5) * (inverse[0] + inverse[1] + inverse[2]));
        // T_ijk = f (delta_ij n_k / s_i + ...) + 2 f n_i n_j n_k (common - 1/s_i - 1/s_j - 1/s_k) / S.
        let [i1, i2, i3] = inverse;
        let [n1, n2, n3] = n;
        let high = f * twice_inverse;
        let (h11, h12, h22) = (high * square[0], high * n1 * n2, high * square[1]);
        let reduced = common - i1 - i2;
        let third = [
            f * n1 * c(3.0) * i1 + h11 * n1 * (common - i1 - i1 - i1),
            f * n2 * i1 + h11 * n2 * (reduced - i1),
            f * n3 * i1 + h11 * n3 * (common - i1 - i1 - i3),
            f * n1 * i2 + h12 * n2 * (reduced - i2),
            h12 * n3 * (reduced - i3),
            f * n2 * c(3.0) * i2 + h22 * n2 * (common - i2 - i2 - i2),
            f * n3 * i2 + h22 * n3 * (common - i2 - i2 - i3),
        ];
        let gradient = gradient(&field, (n, f));
        let density = weight * (c(1.0) - u * u - v * v);
        self.density.add(density);
        let shares = [density, density * u, density * v];
        for m in 0..3 {
            for k in 0..7 {
                self.thirds[m][k].add_product(shares[m], third[k]);
            }
        }
        for k in 0..5 {
            self.gradients[k].add_product(density, gradient[k]);
        }
        let semi_axis_derivatives = field.semi_axis_derivatives(x, (n, f), second_integrals);
        let shares = [weight, weight * u, weight * v];
        for m in 0..3 {
            for k in 0..9 {
                self.axes[m][k].add_product(shares[m], semi_axis_derivatives[k / 3][k % 3]);
            }
        }
    }
}
