//! The derivatives of the loads of a pair with a polyhedron: by the pose, and by the lengths of either shape.
//!
//! Where the integration is over points (the nodes of a layer, or a centre), the derivatives are sums over
//! the field and its gradient at each point, as in [`super::gradient`]; where it is over faces, they are the
//! sums of [`super::face_gradient`]. The derivatives have their own cells, since the field is less smooth
//! than the potential: the digits of these cells are raised until two rules agree, and an error is returned where
//! they do not.
//!
//! A factor s of all lengths of the body that is integrated over moves its points by z ds. With both bodies
//! and the separation multiplied by s, the force is proportional to s^-2 and the torques to s^-1, which gives
//! the derivatives with respect to the other body's scale.

use super::face_gradient::{self, FaceSums};
use super::faces::Faces;
use super::faceted::{FINER, MOST_DIGITS, MOST_EVALUATIONS};
use super::gradient::CanonicalJacobian;
use super::jacobian::FrameRotations;
use super::rule::{FacetedRules, Kernel, Rule};
use super::store::NodeKind;
use super::{Balance, Interaction, Jacobian, Pair, Pose, Roles, ShapeDerivatives, means, sampled};
use crate::error::Result;
use crate::gravity::FieldKernel;
use crate::interrupt::{InterruptCheck, UNITS};
use crate::math::lanes::{Lanes, Total, total_matrix};
use crate::math::matrix::{cross_times, times_cross};
use crate::math::{Mat3, Vec3};
use crate::quadrature::{Division, NodeRange, Order};
use pulp::{Simd, WithSimd};
use std::ops::{AddAssign, Range};

/// The relative difference below which two rules over faces for the derivatives agree to round-off.
const AGREEMENT_OF_DERIVATIVES: f64 = 1e-13;

impl Pair {
    /// Chooses the rules for the derivatives at a pose; see [`Self::prepare_jacobian`].
    pub(super) fn prepare_faceted_jacobian(
        &mut self,
        pose: &Pose,
        lengths: bool,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let previous_rules = self.faceted_rules.take();
        let Some(rule_in_use) = self.rule.clone() else { return Ok(()) };
        let pose = self.scaled(pose);
        let pose_rule = self.rule_for_derivatives(rule_in_use.clone(), &pose, interrupt)?;
        let has_ellipsoid = self.bodies[rule_in_use.integrated].ellipsoid().is_some();
        let lengths_rule = if lengths && has_ellipsoid {
            // The choice starts from the previous rule, whose tables it may keep.
            self.rule = previous_rules.and_then(|rules| rules.lengths);
            let reach = self
                .rule
                .as_ref()
                .map_or(pose.separation.norm(), |rule| rule.valid_from / super::choice::MARGIN);
            let chosen = self.prepare_over_polyhedron(&pose, reach.min(pose.separation.norm()), interrupt);
            let rule = self.rule.replace(rule_in_use);
            chosen?;
            rule.map(|rule| self.rule_for_derivatives(rule, &pose, interrupt)).transpose()?
        } else {
            None
        };
        self.faceted_rules = Some(Box::new(FacetedRules { pose: pose_rule, lengths: lengths_rule }));
        Ok(())
    }

    /// Returns the rule for the derivatives: over faces with as many digits as make two rules agree.
    fn rule_for_derivatives(
        &self,
        mut rule: Rule,
        pose: &Pose,
        interrupt: &mut InterruptCheck,
    ) -> Result<Rule> {
        if rule.node_kind != NodeKind::Faces {
            return Ok(rule);
        }
        let roles = self.roles(rule.integrated, pose);
        let (mut coarse, mut difference) = (None, f64::INFINITY);
        let mut digits = rule.degree;
        while digits + FINER <= MOST_DIGITS {
            let coarser = match coarse.take() {
                Some(coarser) => Some(coarser),
                None => self.jacobian_by_cells(&mut rule, digits, &roles, interrupt)?,
            };
            let Some(coarser) = coarser else { break };
            let saved = (rule.points, rule.begins.clone());
            let Some(fine) = self.jacobian_by_cells(&mut rule, digits + FINER, &roles, interrupt)? else {
                break;
            };
            difference = self.difference_of_jacobians(rule.integrated, &fine, &coarser);
            if difference <= self.tolerance.max(AGREEMENT_OF_DERIVATIVES) {
                rule.order = Order { gauss: digits, angles: digits };
                (rule.points, rule.begins) = saved;
                return Ok(rule);
            }
            coarse = Some(fine);
            digits += FINER;
        }
        let tolerance = self.tolerance;
        let why = if difference.is_finite() {
            format!(
                "two rules for the derivatives differ by {difference:.1e}, more than the tolerance \
                 {tolerance:e}"
            )
        } else {
            self.too_many_evaluations()
        };
        Err(self.not_converged(rule.integrated, pose, &why))
    }

    /// Returns the derivatives over cells for this many digits, which become the rule's digits; `None` where
    /// there would be too many cells.
    fn jacobian_by_cells(
        &self,
        rule: &mut Rule,
        digits: usize,
        roles: &Roles,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<CanonicalJacobian>> {
        rule.order = Order { gauss: digits, angles: digits };
        let Some(faces) = self.faces(rule, roles, &Self::ALL) else { return Ok(None) };
        let cells = faces.gradient_cells();
        let Some(Division { points, begins }) =
            cells.divide(self.work_of_node(rule) as u64, MOST_EVALUATIONS, interrupt)?
        else {
            return Ok(None);
        };
        (rule.points, rule.begins) = (points, begins);
        self.canonical_by_rule(rule, roles, interrupt).map(Some)
    }

    /// Returns the largest difference of two evaluations, scaled by the bodies' radii, and relative to the
    /// force's derivative with respect to the position.
    fn difference_of_jacobians(
        &self,
        integrated: usize,
        reference: &CanonicalJacobian,
        other: &CanonicalJacobian,
    ) -> f64 {
        let [set, field] = [integrated, 1 - integrated].map(|k| self.bodies[k].shape.circumradius());
        // A point has no radius, and no torque.
        let over = |value: f64, radius: f64| if radius > 0.0 { value / radius } else { 0.0 };
        let by = |a: &Mat3, b: &Mat3| (a - b).norm();
        let by_scale = [&reference.by_scale, &other.by_scale];
        let all = [
            by(&reference.force_by_position, &other.force_by_position),
            over(by(&reference.force_by_rotation, &other.force_by_rotation), set),
            over(over(by(&reference.torque_by_rotation, &other.torque_by_rotation), set), set),
            over(by(&reference.field_by_position, &other.field_by_position), field),
            over(over(by(&reference.field_by_rotation, &other.field_by_rotation), field), set),
            over((by_scale[0].force - by_scale[1].force).norm(), set),
            over(over((by_scale[0].torque - by_scale[1].torque).norm(), set), set),
        ];
        all.into_iter().fold(0.0, f64::max) / reference.force_by_position.norm()
    }

    /// Returns the derivatives of force and torques with respect to the pose, after
    /// [`Self::prepare_faceted_jacobian`].
    pub(super) fn faceted_jacobian(&self, pose: &Pose, interrupt: &mut InterruptCheck) -> Result<Jacobian> {
        let pose = &self.scaled(pose);
        let Some(rules) = &self.faceted_rules else { return Ok(Jacobian::monopole(pose).in_unit(self.unit)) };
        let roles = self.roles(rules.pose.integrated, pose);
        let canonical = self.canonical_by_rule(&rules.pose, &roles, interrupt)?;
        let bodies = self.field_and_set(&rules.pose);
        Ok(Jacobian::from_canonical(&canonical, rules.pose.integrated, pose, &roles, bodies)
            .in_unit(self.unit))
    }

    /// Returns the derivatives by a rule, with interrupt checks between its pieces.
    fn canonical_by_rule(
        &self,
        rule: &Rule,
        roles: &Roles,
        interrupt: &mut InterruptCheck,
    ) -> Result<CanonicalJacobian> {
        let [field, set] = self.field_and_set(rule);
        if let Some(faces) = self.faces(rule, roles, &Self::ALL) {
            let mut sums = FaceSums::default();
            self.for_each_piece(rule, interrupt, |range| {
                let faces = Faces { range: &range, ..faces };
                sums += match &rule.kernel {
                    Kernel::Far(truncation) => {
                        face_gradient::sums(field.series.truncated(*truncation), faces)
                    }
                    Kernel::Near(near) => face_gradient::sums(*near, faces),
                    Kernel::Facets | Kernel::Layer(_) => face_gradient::sums_beside_polyhedron(faces, rule),
                };
            })?;
            return Ok(sums.jacobian(roles));
        }
        match &rule.kernel {
            Kernel::Far(truncation) => Ok(self.canonical_jacobian(
                field.series.truncated(*truncation),
                rule.node_kind,
                &rule.nodes,
                set,
                roles,
            )),
            Kernel::Near(near) => Ok(self.canonical_jacobian(*near, rule.node_kind, &rule.nodes, set, roles)),
            Kernel::Facets | Kernel::Layer(_) => {
                let mut canonical = CanonicalJacobian::default();
                self.for_each_piece(rule, interrupt, |range| {
                    for k in range.start..range.end.min(rule.nodes.len()) {
                        let z = roles.rotation * sampled::vector(&rule.nodes.points, k);
                        let x = roles.origin + z;
                        let (g, h) = sampled::gradient(self.arch, field, &rule.kernel, &x);
                        canonical.add_point(rule.nodes.weights[k], &x, &z, &g, &h);
                    }
                })?;
                Ok(canonical)
            }
        }
    }

    /// Calls a function for each piece of a rule, with an interrupt check before each. Allocates nothing.
    fn for_each_piece(
        &self,
        rule: &Rule,
        interrupt: &mut InterruptCheck,
        mut run: impl FnMut(Range<usize>),
    ) -> Result<()> {
        /// The cost of potential, field and gradient in units of the cost of the potential.
        const GRADIENT: usize = 2;
        let work_per_node = GRADIENT * self.work_of_node(rule);
        if rule.node_kind == NodeKind::Faces {
            let pieces = rule.begins.len() + 1;
            let work = (rule.points * work_per_node / pieces) as u64;
            for piece in 0..pieces {
                let begin = if piece == 0 { 0 } else { rule.begins[piece - 1] };
                let end = rule.begins.get(piece).copied().unwrap_or(usize::MAX);
                interrupt.charge(work, 0.0)?;
                run(begin..end);
            }
            return Ok(());
        }
        let length = (UNITS as usize / work_per_node).max(1);
        for begin in (0..rule.nodes.len()).step_by(length) {
            interrupt.charge((length * work_per_node) as u64, 0.0)?;
            run(begin..begin + length);
        }
        Ok(())
    }

    /// Returns the derivatives of the loads with respect to the semi-axes of an ellipsoid and the scales of
    /// polyhedra, after [`Self::prepare_faceted_jacobian`].
    pub(super) fn faceted_lengths(
        &self,
        pose: &Pose,
        interrupt: &mut InterruptCheck,
    ) -> Result<ShapeDerivatives> {
        let mut out = ShapeDerivatives::ZERO;
        let Some(rules) = &self.faceted_rules else { return Ok(out) };
        let pose = &self.scaled(pose);
        let rule = &rules.pose;
        let roles = self.roles(rule.integrated, pose);
        let canonical = self.canonical_by_rule(rule, &roles, interrupt)?;
        let bodies = self.field_and_set(rule);
        let frame_rotations = FrameRotations::new(rule.integrated, pose, &roles, bodies);
        let by_scale = frame_rotations.in_bodies(&canonical.by_scale);
        let jacobian = Jacobian::from_canonical(&canonical, rule.integrated, pose, &roles, bodies);
        let by_separation = |block: &Mat3| block * pose.separation;
        let loads = &jacobian.loads;
        let [first, second] = &jacobian.torque_by_separation;
        let other = Interaction {
            force_on_first: -2.0 * loads.force_on_first
                - by_separation(&jacobian.force_by_separation)
                - by_scale.force_on_first,
            torque_first: -(loads.torque_first + by_separation(first) + by_scale.torque_first),
            torque_second: -(loads.torque_second + by_separation(second) + by_scale.torque_second),
        };
        for (body, loads) in [(rule.integrated, by_scale), (1 - rule.integrated, other)] {
            if self.bodies[body].polyhedron().is_some() {
                out.scale[body] = self.loads_in_unit(&loads, 0);
            }
        }
        let rule = rules.lengths.as_ref().unwrap_or(rule);
        let [field, _] = self.field_and_set(rule);
        if field.ellipsoid().is_some() {
            let roles = self.roles(rule.integrated, pose);
            let balances = match &rule.kernel {
                Kernel::Far(truncation) => {
                    self.by_field_axes(field.series.truncated(*truncation), rule, &roles, interrupt)?
                }
                Kernel::Near(near) => self.by_field_axes(*near, rule, &roles, interrupt)?,
                Kernel::Facets | Kernel::Layer(_) => return Ok(out),
            };
            let frame_rotations =
                FrameRotations::new(rule.integrated, pose, &roles, self.field_and_set(rule));
            for (axis, row) in field.rows_of_axes().into_iter().enumerate() {
                out.axes[1 - rule.integrated][axis] =
                    self.loads_in_unit(&frame_rotations.in_bodies(&balances[row]), 1);
            }
        }
        Ok(out)
    }

    /// Returns the derivatives of the loads with respect to the canonical semi-axes of the field body, an
    /// ellipsoid.
    fn by_field_axes(
        &self,
        kernel: impl FieldKernel,
        rule: &Rule,
        roles: &Roles,
        interrupt: &mut InterruptCheck,
    ) -> Result<[Balance; 3]> {
        let semi_axes = self.bodies[1 - rule.integrated].semi_axes();
        let mut sums = [[Vec3::zeros(); 2]; 3];
        if let Some(faces) = self.faces(rule, roles, &Self::ALL) {
            self.for_each_piece(rule, interrupt, |range| {
                let more = face_gradient::semi_axis_derivatives(kernel, Faces { range: &range, ..faces });
                sums.iter_mut().flatten().zip(more.iter().flatten()).for_each(|(sum, more)| *sum += more);
            })?;
        } else {
            let arms = [0, 1, 2].map(|k| roles.rotation.column(k).into_owned());
            let origin = roles.origin;
            let all = rule.nodes.sum(|nodes| self.arch.dispatch(NodeAxisSum { kernel, nodes, origin, arms }));
            for (axis, sum) in sums.iter_mut().enumerate() {
                let mean = |m: usize| all.0[m].row(axis).transpose();
                *sum = [mean(0), (0..3).map(|k| arms[k].cross(&mean(1 + k))).sum()];
            }
        }
        Ok([0, 1, 2].map(|axis| {
            let [force, torque] = sums[axis].map(|sum| sum * semi_axes[axis]);
            Balance { force, torque, torque_field: -(torque + roles.origin.cross(&force)) }
        }))
    }
}

impl CanonicalJacobian {
    /// Adds a point with a weight, the position x and the arm z, given the field and its gradient there.
    fn add_point(&mut self, weight: f64, x: &Vec3, z: &Vec3, field: &Vec3, gradient: &Mat3) {
        let (g, h) = (field * weight, gradient * weight);
        // These are the derivatives of n = -x cross g.
        let torque_gradient = g.cross_matrix() - cross_times(x, &h);
        let by_rotation = times_cross(&h, z);
        self.balance.force += g;
        self.balance.torque += z.cross(&g);
        self.balance.torque_field -= x.cross(&g);
        self.force_by_position += h;
        self.force_by_rotation -= by_rotation;
        self.torque_by_rotation +=
            z * g.transpose() - Mat3::from_diagonal_element(z.dot(&g)) - cross_times(z, &by_rotation);
        self.field_by_position += torque_gradient;
        self.field_by_rotation -= times_cross(&torque_gradient, z);
        let force = h * z;
        self.by_scale.force += force;
        self.by_scale.torque += z.cross(&(g + force));
        self.by_scale.torque_field += torque_gradient * z;
    }
}

/// The means of dg_j/da_i over a_i in row i, and the means of these times the coordinates of the nodes.
struct NodeAxisSum<'a, K> {
    kernel: K,
    nodes: NodeRange<'a>,
    origin: Vec3,
    arms: [Vec3; 3],
}

struct Means([Mat3; 4]);

impl AddAssign for Means {
    fn add_assign(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, more)| *sum += more);
    }
}

impl<K: FieldKernel> WithSimd for NodeAxisSum<'_, K> {
    type Output = Means;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Means {
        let positions: means::NodePositions<S, 3, 2> =
            means::NodePositions::new(simd, &self.origin, &self.arms);
        let mut totals = [[[Total::zero(simd); 3]; 3]; 4];
        for register in 0..self.nodes.weights.len() / (2 * S::F64_LANES) {
            let (y, weight): ([Lanes<S, 2>; 3], _) = means::load(simd, &self.nodes, 2 * register);
            let x = positions.at(y);
            let (field, second) = self.kernel.second_integrals(x);
            let rows = field.semi_axis_derivatives(x, field.gradient_factors(x), second);
            let shares = [weight, weight * y[0], weight * y[1], weight * y[2]];
            for m in 0..4 {
                for i in 0..3 {
                    for j in 0..3 {
                        totals[m][i][j].add_product(shares[m], rows[i][j]);
                    }
                }
            }
        }
        let [of_nodes, x, y, z] = totals;
        Means([total_matrix(of_nodes), total_matrix(x), total_matrix(y), total_matrix(z)])
    }
}
