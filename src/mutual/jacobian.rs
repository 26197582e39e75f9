//! The derivatives of a pair's force and torques with respect to its pose.

use super::choice::order_for;
use super::gradient::{CanonicalJacobian, canonical_jacobian};
use super::rule::{GradientNodes, Kernel, Rule};
use super::store::NodeKind;
use super::{Balance, Interaction, Pair, PartGravity, Pose, Roles};
use crate::error::Result;
use crate::gravity::FieldKernel;
use crate::interrupt::InterruptCheck;
use crate::math::Mat3;
use crate::math::matrix::{times, times_cross, times_transposed, transposed_times};
use crate::math::rotation::{rotate, rotate_back};
use crate::quadrature::Nodes;

/// Derivatives of force and torques of a pair, per unit G m_first m_second.
///
/// Let U be the mutual potential (positive), r the separation and v_1, v_2 rotation vectors in the body
/// frames, R -> R exp(v). The force on the first body is -dU/dr and the torques are dU/dv_1 and dU/dv_2.
/// Three blocks therefore follow from the others: the derivatives of the force with respect to the rotations
/// are minus the transposes of the derivatives of the torques with respect to the separation, and rotations
/// of different bodies commute.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jacobian {
    /// The force and the torques.
    pub loads: Interaction,
    /// The derivative of the force on the first body, inertial, with respect to the separation.
    pub force_by_separation: Mat3,
    /// The derivatives of the torque on either body, in its frame, with respect to the separation.
    pub torque_by_separation: [Mat3; 2],
    /// The derivatives of the torque on either body with respect to its own rotation.
    pub torque_by_rotation: [Mat3; 2],
    /// The derivative of the torque on the first body with respect to the rotation of the second one. Its
    /// transpose is the derivative of the torque on the second body with respect to the rotation of the first
    /// one.
    pub torque_first_by_second: Mat3,
}

impl Jacobian {
    /// Returns the derivatives for two points.
    pub(super) fn monopole(pose: &Pose) -> Self {
        let r = pose.separation.norm();
        let u = pose.separation / r;
        let force_by_separation = (Mat3::identity() - 3.0 * u * u.transpose()) / r / r / r;
        Self { force_by_separation, ..Self::of_loads(super::pair::monopole(pose)) }
    }

    /// Returns these loads with derivatives of zero.
    pub(super) fn of_loads(loads: Interaction) -> Self {
        let zero = Mat3::zeros();
        Self {
            loads,
            force_by_separation: zero,
            torque_by_separation: [zero; 2],
            torque_by_rotation: [zero; 2],
            torque_first_by_second: zero,
        }
    }

    /// Converts the means over a body from the field body's canonical frame.
    pub(super) fn from_canonical(
        canonical: &CanonicalJacobian,
        integrated: usize,
        pose: &Pose,
        roles: &Roles,
        bodies: [&PartGravity; 2],
    ) -> Self {
        let s = canonical;
        let frame_rotations = FrameRotations::new(integrated, pose, roles, bodies);
        let FrameRotations { from_set, from_field, to_inertial, .. } = &frame_rotations;
        let sign = if frame_rotations.first { 1.0 } else { -1.0 };
        let loads = frame_rotations.in_bodies(&s.balance);
        let torque_set = if frame_rotations.first { loads.torque_first } else { loads.torque_second };
        // The position is the separation for the second body in the field of the first, and minus the
        // separation otherwise.
        let by_separation = |slope: &Mat3| times_transposed(slope, to_inertial) * -sign;
        let set_by_separation = transposed_times(from_set, &by_separation(&s.force_by_rotation.transpose()));
        let field_by_separation = transposed_times(from_field, &by_separation(&s.field_by_position));
        let field_by_set = transposed_times(from_field, &times(&s.field_by_rotation, from_set));
        // The torque is expressed in a frame that rotates with the body.
        let set_by_set =
            transposed_times(from_set, &times(&s.torque_by_rotation, from_set)) + torque_set.cross_matrix();
        // A rotation of the field body moves the other one in the opposite sense.
        let opposite = times_cross(&s.field_by_position, &roles.origin) - s.field_by_rotation;
        let field_by_field = transposed_times(from_field, &times(&opposite, from_field));
        let force_by_separation = -times_transposed(&times(to_inertial, &s.force_by_position), to_inertial);
        let in_order = |set, field| if integrated == 0 { [set, field] } else { [field, set] };
        Self {
            loads,
            force_by_separation,
            torque_by_separation: in_order(set_by_separation, field_by_separation),
            torque_by_rotation: in_order(set_by_set, field_by_field),
            torque_first_by_second: if integrated == 0 { field_by_set.transpose() } else { field_by_set },
        }
    }

    /// Converts to units of length that are smaller by a factor.
    pub(super) fn in_unit(mut self, unit: f64) -> Self {
        self.loads.force_on_first /= unit * unit;
        self.loads.torque_first /= unit;
        self.loads.torque_second /= unit;
        let inverse = 1.0 / unit;
        self.force_by_separation *= inverse * inverse * inverse;
        for body in 0..2 {
            self.torque_by_separation[body] *= inverse * inverse;
            self.torque_by_rotation[body] *= inverse;
        }
        self.torque_first_by_second *= inverse;
        self
    }

    /// Returns the whole matrix: rows are the force on the first body, the torque on the first and that on
    /// the second; columns are the separation and the rotations of the first and the second.
    pub fn rows(&self) -> [[f64; 9]; 9] {
        let [first, second] = &self.torque_by_separation;
        let blocks = [
            [self.force_by_separation, -first.transpose(), -second.transpose()],
            [*first, self.torque_by_rotation[0], self.torque_first_by_second],
            [*second, self.torque_first_by_second.transpose(), self.torque_by_rotation[1]],
        ];
        std::array::from_fn(|i| std::array::from_fn(|j| blocks[i / 3][j / 3][(i % 3, j % 3)]))
    }
}

/// The rotations from the frames of the bodies into the field body's canonical frame, and from there into the
/// inertial frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrameRotations {
    pub from_set: Mat3,
    pub from_field: Mat3,
    pub to_inertial: Mat3,
    /// Whether the first body is integrated over.
    pub first: bool,
}

impl FrameRotations {
    pub fn new(integrated: usize, pose: &Pose, roles: &Roles, [field, set]: [&PartGravity; 2]) -> Self {
        let first = integrated == 0;
        let rotation = if first { &pose.rotation_second } else { &pose.rotation_first };
        Self {
            from_set: times(&roles.rotation, &set.canonical),
            from_field: field.canonical,
            to_inertial: times_transposed(rotation, &field.canonical),
            first,
        }
    }

    /// Converts loads in the field body's canonical frame to those of the first and the second body.
    #[inline(always)]
    pub fn in_bodies(&self, balance: &Balance) -> Interaction {
        let force = rotate(&self.to_inertial, &balance.force);
        let torque_field = rotate_back(&self.from_field, &balance.torque_field);
        let torque_set = rotate_back(&self.from_set, &balance.torque);
        if self.first {
            return Interaction {
                force_on_first: force,
                torque_first: torque_set,
                torque_second: torque_field,
            };
        }
        Interaction { force_on_first: -force, torque_first: torque_field, torque_second: torque_set }
    }
}

impl Pair {
    /// Chooses the nodes for [`Self::jacobian`] with the rule in use. It may allocate: call it after
    /// [`Self::prepare`].
    ///
    /// Where the paper's integrals of the potential are in use, the means of the gradient are taken over the
    /// same surface, by [`crate::quadrature::Nodes::surface`].
    ///
    /// With a polyhedron the nodes are chosen for the given pose, and `lengths` says whether
    /// [`Self::shape_derivatives`] will be called.
    pub fn prepare_jacobian(
        &mut self,
        pose: &Pose,
        lengths: bool,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let is_fixed = self.has_fixed_degrees();
        if let (Some(harmonic), Some(truncation)) = (&mut self.harmonic, &self.truncation) {
            return if lengths { harmonic.prepare_lengths(truncation, is_fixed, interrupt) } else { Ok(()) };
        }
        if self.is_faceted() {
            return self.prepare_faceted_jacobian(pose, lengths, interrupt);
        }
        let Some(rule) = &self.rule else { return Ok(()) };
        let (integrated, order, node_kind) = (rule.integrated, rule.order, rule.node_kind);
        if self.gradient_nodes.as_ref().is_some_and(|n| n.integrated == integrated && n.order == order) {
            return Ok(());
        }
        let set = &self.bodies[integrated];
        let smooth = match node_kind {
            NodeKind::SurfacePotential => NodeKind::SurfaceField(set.semi_axes()),
            other => other,
        };
        // Derivatives with respect to semi-axes are taken over the focal ellipse.
        let flat = match node_kind {
            NodeKind::FocalEllipse(_) => node_kind,
            _ if set.focal_axes()[0] > 0.0 => NodeKind::FocalEllipse(0.0),
            _ => NodeKind::Centre,
        };
        let (nodes_in_use, degree) = (rule.nodes.clone(), rule.degree);
        let mut nodes = |kind| {
            let nodes = if kind == node_kind {
                nodes_in_use.clone()
            } else {
                self.nodes.get(order_for(kind, [degree; 2]), kind, set, self.arch, interrupt)?
            };
            Ok(Some(GradientNodes { integrated, order, node_kind: kind, nodes }))
        };
        (self.gradient_nodes, self.axis_nodes) = (nodes(smooth)?, nodes(flat)?);
        Ok(())
    }

    /// Returns the derivatives of force and torques with the rule in use, after [`Self::prepare_jacobian`].
    /// Allocates nothing.
    pub fn jacobian(&self, pose: &Pose, interrupt: &mut InterruptCheck) -> Result<Jacobian> {
        if self.is_faceted() {
            return self.faceted_jacobian(pose, interrupt);
        }
        let scaled = self.scaled(pose);
        if let Some((harmonic, truncation)) = self.series() {
            return Ok(harmonic.jacobian(truncation, &scaled).in_unit(self.unit));
        }
        if let Some(fragments) = &self.fragments {
            let jacobian = fragments.jacobian(&scaled, interrupt)?;
            return Ok(jacobian.ok_or_else(|| self.fragments_not_converged(&scaled))?.in_unit(self.unit));
        }
        if let Some(multipole) = &self.multipole {
            return Ok(multipole.jacobian(&scaled).in_unit(self.unit));
        }
        let jacobian = match (&self.rule, &self.gradient_nodes) {
            (Some(rule), Some(nodes)) => self.jacobian_by(rule, nodes, &scaled),
            _ => Jacobian::monopole(&scaled),
        };
        Ok(jacobian.in_unit(self.unit))
    }

    fn jacobian_by(&self, rule: &Rule, nodes: &GradientNodes, pose: &Pose) -> Jacobian {
        let [field, set] = self.field_and_set(rule);
        let roles = self.roles(rule.integrated, pose);
        let canonical = match &rule.kernel {
            Kernel::Near(near) => self.canonical_jacobian(*near, nodes.node_kind, &nodes.nodes, set, &roles),
            Kernel::Far(truncation) => self.canonical_jacobian(
                field.series.truncated(*truncation),
                nodes.node_kind,
                &nodes.nodes,
                set,
                &roles,
            ),
            // Kernels of polyhedra were handled above, by [`Pair::is_faceted`].
            Kernel::Facets | Kernel::Layer(_) => return Jacobian::monopole(pose),
        };
        Jacobian::from_canonical(&canonical, rule.integrated, pose, &roles, [field, set])
    }

    pub(super) fn canonical_jacobian(
        &self,
        kernel: impl FieldKernel,
        node_kind: NodeKind,
        nodes: &Nodes,
        set: &PartGravity,
        roles: &Roles,
    ) -> CanonicalJacobian {
        match node_kind {
            NodeKind::SurfaceField(semi_axes) => {
                canonical_jacobian::<3, 10>(self.arch, kernel, nodes, semi_axes, roles)
            }
            NodeKind::Layer => canonical_jacobian::<3, 10>(self.arch, kernel, nodes, [1.0; 3], roles),
            _ => canonical_jacobian::<2, 6>(self.arch, kernel, nodes, set.focal_axes(), roles),
        }
    }
}
