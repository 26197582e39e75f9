//! The derivatives of a pair's force and torques with respect to its pose.

use super::choice::order_for;
use super::gradient::{Slopes, slopes};
use super::rule::{GradientNodes, Kernel, Rule};
use super::store::Carrier;
use super::{Balance, BodyGravity, Interaction, Method, Pair, Pose, Roles};
use crate::error::{Error, Result};
use crate::gravity::FieldKernel;
use crate::math::Mat3;
use crate::math::matrix::{times, times_cross, times_transposed, transposed_times};
use crate::math::rotation::{turned, turned_back};
use crate::patience::Patience;

/// Derivatives of force and torques of a pair, per unit G m_first m_second.
///
/// With U the mutual potential (positive), r the separation and v_1, v_2 rotation vectors in the body frames, R -> R exp(v), the
/// force on the first body is -dU/dr and the torques are dU/dv_1 and dU/dv_2. So three blocks say what the others are: the
/// force's by the rotations are minus the transposed of the torques' by the separation, and rotations of different bodies commute.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jacobian {
    /// Force and torques themselves.
    pub loads: Interaction,
    /// Of the force on the first body, inertial, with the separation.
    pub force_by_separation: Mat3,
    /// Of the torque on either body, in its frame, with the separation.
    pub torque_by_separation: [Mat3; 2],
    /// Of the torque on either body with its own rotation.
    pub torque_by_rotation: [Mat3; 2],
    /// Of the torque on the first body with the rotation of the second; that of the second with the first's is the transposed.
    pub torque_first_by_second: Mat3,
}

impl Jacobian {
    /// Of two points.
    pub(super) fn monopole(pose: &Pose) -> Self {
        let r = pose.separation.norm();
        let u = pose.separation / r;
        let zero = Mat3::zeros();
        Self {
            loads: super::pair::monopole(pose),
            force_by_separation: (Mat3::identity() - 3.0 * u * u.transpose()) / r / r / r,
            torque_by_separation: [zero; 2],
            torque_by_rotation: [zero; 2],
            torque_first_by_second: zero,
        }
    }

    /// From the means over a body in the field body's canonical frame.
    pub(super) fn from_slopes(
        slopes: &Slopes,
        integrated: usize,
        pose: &Pose,
        roles: &Roles,
        bodies: [&BodyGravity; 2],
    ) -> Self {
        let s = slopes;
        let turns = Turns::new(integrated, pose, roles, bodies);
        let Turns { of_set, of_field, to_inertial, .. } = &turns;
        let sign = if turns.first { 1.0 } else { -1.0 };
        let loads = turns.in_bodies(&s.balance);
        let torque_set = if turns.first { loads.torque_first } else { loads.torque_second };
        // The place is the separation for the second body in the field of the first, minus the separation otherwise.
        let by_separation = |slope: &Mat3| times_transposed(slope, to_inertial) * -sign;
        let set_by_separation = transposed_times(of_set, &by_separation(&s.force_by_turn.transpose()));
        let field_by_separation = transposed_times(of_field, &by_separation(&s.field_by_place));
        let field_by_set = transposed_times(of_field, &times(&s.field_by_turn, of_set));
        // The torque in a frame that turns with the body.
        let set_by_set =
            transposed_times(of_set, &times(&s.torque_by_turn, of_set)) + torque_set.cross_matrix();
        // A turn of the field body moves the other one back.
        let back = times_cross(&s.field_by_place, &roles.origin) - s.field_by_turn;
        let field_by_field = transposed_times(of_field, &times(&back, of_field));
        let force_by_separation = -times_transposed(&times(to_inertial, &s.force_by_place), to_inertial);
        let in_order = |set, field| if integrated == 0 { [set, field] } else { [field, set] };
        Self {
            loads,
            force_by_separation,
            torque_by_separation: in_order(set_by_separation, field_by_separation),
            torque_by_rotation: in_order(set_by_set, field_by_field),
            torque_first_by_second: if integrated == 0 { field_by_set.transpose() } else { field_by_set },
        }
    }

    /// The same in units of length that are smaller by a factor.
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

    /// The whole: rows are the force on the first body, the torque on the first and that on the second; columns are the separation
    /// and the rotations of the first and the second.
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

/// The turns from the frames of the bodies into the field body's canonical one, and from there into the inertial one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turns {
    pub of_set: Mat3,
    pub of_field: Mat3,
    pub to_inertial: Mat3,
    /// Whether the first body is integrated over.
    pub first: bool,
}

impl Turns {
    pub fn new(integrated: usize, pose: &Pose, roles: &Roles, [field, set]: [&BodyGravity; 2]) -> Self {
        let first = integrated == 0;
        let rotation = if first { &pose.rotation_second } else { &pose.rotation_first };
        Self {
            of_set: times(&roles.turn, &set.canonical),
            of_field: field.canonical,
            to_inertial: times_transposed(rotation, &field.canonical),
            first,
        }
    }

    /// Loads in the field body's canonical frame as those of the first and the second body.
    #[inline(always)]
    pub fn in_bodies(&self, balance: &Balance) -> Interaction {
        let force = turned(&self.to_inertial, &balance.force);
        let torque_field = turned_back(&self.of_field, &balance.torque_field);
        let torque_set = turned_back(&self.of_set, &balance.torque);
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
    /// Chooses the nodes for [`Self::jacobian`] with the rule in force. May allocate: call it after [`Self::prepare`].
    ///
    /// The paper's integrals over pressures take the means of the gradient over the same surface, by [`crate::quadrature::Nodes::surface`].
    pub fn prepare_jacobian(&mut self, patience: &mut Patience) -> Result<()> {
        if self.bodies.iter().any(|body| body.polyhedron().is_some()) && self.method != Method::Point {
            let body = self.bodies.iter().find(|body| body.polyhedron().is_some());
            let name = body.map_or("", |body| body.name.as_str());
            return Err(Error::invalid(
                "derivatives",
                format!("of the gravity of {name}, a polyhedron"),
                "ellipsoids and points",
            ));
        }
        let Some(rule) = &self.rule else { return Ok(()) };
        let (integrated, order, carrier) = (rule.integrated, rule.order, rule.carrier);
        if self.gradient_nodes.as_ref().is_some_and(|n| n.integrated == integrated && n.order == order) {
            return Ok(());
        }
        let set = &self.bodies[integrated];
        let smooth = match carrier {
            Carrier::Pressures => Carrier::Surface(set.semi_axes()),
            other => other,
        };
        // Semi-axes act by the focal ellipse.
        let flat = match carrier {
            Carrier::FocalEllipse(_) => carrier,
            _ if set.focal_axes()[0] > 0.0 => Carrier::FocalEllipse(0.0),
            _ => Carrier::Centre,
        };
        let (own, degree) = (rule.nodes.clone(), rule.degree);
        let mut nodes = |wanted| {
            let nodes = if wanted == carrier {
                own.clone()
            } else {
                self.nodes.get(order_for(wanted, [degree; 2]), wanted, set, self.arch, patience)?
            };
            Ok(Some(GradientNodes { integrated, order, carrier: wanted, nodes }))
        };
        (self.gradient_nodes, self.axis_nodes) = (nodes(smooth)?, nodes(flat)?);
        Ok(())
    }

    /// Derivatives of force and torques with the rule in force, after [`Self::prepare_jacobian`]. Allocates nothing.
    pub fn jacobian(&self, pose: &Pose) -> Jacobian {
        let scaled = self.scaled(pose);
        if let Some(multipole) = &self.multipole {
            return multipole.jacobian(&scaled).in_unit(self.unit);
        }
        let jacobian = match (&self.rule, &self.gradient_nodes) {
            (Some(rule), Some(nodes)) => self.jacobian_by(rule, nodes, &scaled),
            _ => Jacobian::monopole(&scaled),
        };
        jacobian.in_unit(self.unit)
    }

    fn jacobian_by(&self, rule: &Rule, nodes: &GradientNodes, pose: &Pose) -> Jacobian {
        let [field, set] = self.field_and_set(rule);
        let roles = self.roles(rule.integrated, pose);
        let slopes = match &rule.kernel {
            Kernel::Near(near) => self.slopes(*near, nodes, set, &roles),
            Kernel::Far(cut) => self.slopes(field.series.cut(*cut), nodes, set, &roles),
            // Polyhedra have been refused.
            Kernel::Facets | Kernel::Layer(_) => {
                self.slopes(field.series.cut(Default::default()), nodes, set, &roles)
            }
        };
        Jacobian::from_slopes(&slopes, rule.integrated, pose, &roles, [field, set])
    }

    fn slopes(
        &self,
        kernel: impl FieldKernel,
        nodes: &GradientNodes,
        set: &BodyGravity,
        roles: &Roles,
    ) -> Slopes {
        match nodes.carrier {
            Carrier::Surface(semi_axes) => slopes::<3, 10>(self.arch, kernel, &nodes.nodes, semi_axes, roles),
            _ => slopes::<2, 6>(self.arch, kernel, &nodes.nodes, set.focal_axes(), roles),
        }
    }
}
