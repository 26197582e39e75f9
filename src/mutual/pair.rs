//! A pair of parts with a method, evaluated with the rule in use.

use super::faces::Faces;
use super::fragments::Fragments;
use super::harmonic::{Harmonic, Truncation};
use super::rule::{FacetedRules, GradientNodes, Kernel, NodeStore, Rule};
use super::store::NodeKind;
use super::{
    Balance, Interaction, Method, Multipole, PartGravity, Pose, Roles, faces, means, sampled, surface,
};
use crate::error::Result;
use crate::gravity::FieldKernel;
use crate::interrupt::{InterruptCheck, UNITS};
use crate::math::matrix::times;
use crate::math::rotation::{rotate, rotate_back};
use crate::quadrature::{Cell, Degrees, Order};
use crate::shape::{Shape, growth};
use pulp::Arch;
use std::ops::Range;

/// Two shapes and the method of their interaction. Two ordinary bodies make one pair; for composites see
/// [`super::Link`].
#[derive(Debug, Clone)]
pub struct Pair {
    pub(super) method: Method,
    pub(super) tolerance: f64,
    pub(super) fixed: Option<Order>,
    pub(super) arch: Arch,
    /// The unit of length, a power of two near the size of the larger body. The bodies are in this unit.
    pub(super) unit: f64,
    pub(super) bodies: [PartGravity; 2],
    /// The degrees that a rule over each body needs.
    pub(super) degrees: [Degrees; 2],
    /// The kind of nodes for each body where that one is integrated over.
    pub(super) node_kinds: [NodeKind; 2],
    pub(super) multipole: Option<Multipole>,
    /// The harmonic series, where the pair has used it.
    pub(super) harmonic: Option<Harmonic>,
    /// The degrees of the harmonic series, where it is in use.
    pub(super) truncation: Option<Truncation>,
    /// The sum over fragments, where it is in use.
    pub(super) fragments: Option<Box<Fragments>>,
    pub(super) rule: Option<Rule>,
    /// The nodes over which the field's gradient is averaged, where derivatives have been requested.
    pub(super) gradient_nodes: Option<GradientNodes>,
    /// The nodes for the derivatives with respect to the semi-axes.
    pub(super) axis_nodes: Option<GradientNodes>,
    /// The rules for the derivatives of a pair with a polyhedron, where derivatives have been requested.
    pub(super) faceted_rules: Option<Box<FacetedRules>>,
    pub(super) nodes: NodeStore,
}

impl Pair {
    /// The one piece that contains all nodes of a rule.
    pub const ALL: Range<usize> = 0..usize::MAX;

    /// Prepares a pair. `tolerance` is relative to the force; `fixed` overrides the choice of nodes.
    pub fn new(
        first: PartGravity,
        second: PartGravity,
        method: Method,
        tolerance: f64,
        fixed: Option<Order>,
        arch: Arch,
    ) -> Self {
        let unit = match (&first.shape, &second.shape) {
            (Shape::Point, other) | (other, Shape::Point) => other.natural_unit(),
            (first, second) => first.natural_unit().max(second.natural_unit()),
        };
        let nodes = NodeStore::new(first.store.clone());
        let bodies = [first.in_unit(unit), second.in_unit(unit)];
        let multipole = match method {
            Method::Multipole(degree) => Multipole::new(&bodies[0].shape, &bodies[1].shape, degree),
            _ => None,
        };
        // With a prescribed order all rings have the same number of angles.
        let thinned = if fixed.is_none() { tolerance } else { 0.0 };
        let node_kinds = [
            node_kind(method, &bodies[0], &bodies[1], thinned),
            node_kind(method, &bodies[1], &bodies[0], thinned),
        ];
        let points = bodies.iter().all(|body| body.shape == Shape::Point);
        Self {
            method: if points { Method::Point } else { method },
            tolerance,
            fixed,
            arch,
            unit,
            bodies,
            degrees: [Degrees::new(tolerance), Degrees::new(tolerance)],
            node_kinds,
            multipole,
            harmonic: None,
            truncation: None,
            fragments: None,
            rule: None,
            gradient_nodes: None,
            axis_nodes: None,
            faceted_rules: None,
            nodes,
        }
    }

    /// Returns the quadrature in use, if the method has one and a state has been seen.
    pub fn rule(&self) -> Option<&Rule> {
        self.rule.as_ref()
    }

    /// Returns the method in use: for two points it is always that of point masses, and the harmonic series
    /// where the default has chosen it, for the bodies or their fragments.
    pub fn method(&self) -> Method {
        match self.method {
            Method::Surface | Method::Focal if self.truncation.is_some() || self.fragments.is_some() => {
                Method::Harmonic
            }
            method => method,
        }
    }

    /// Returns the number of points of the rule in use at a pose.
    pub fn points(&self, pose: &Pose) -> Option<usize> {
        let rule = self.rule.as_ref()?;
        let pose = self.scaled(pose);
        let roles = self.roles(rule.integrated, &pose);
        let points = |cell: Cell| cell.points * cell.points;
        let faces = self.faces(rule, &roles, &Self::ALL).map(|faces| faces.cells().map(points).sum());
        Some(faces.unwrap_or(rule.nodes()))
    }

    /// Returns the units of work of an evaluation with the rule in use, for
    /// [`crate::interrupt::InterruptCheck`].
    pub fn work(&self) -> u64 {
        if let Some(fragments) = &self.fragments {
            return fragments.work;
        }
        self.rule.as_ref().map_or(0, |rule| (rule.nodes() * self.work_of_node(rule)) as u64)
    }

    pub(super) fn work_of_node(&self, rule: &Rule) -> usize {
        match &rule.kernel {
            Kernel::Far(_) | Kernel::Near(_) => 1,
            Kernel::Facets => self.field_and_set(rule)[0].polyhedron().map_or(1, |p| p.faces().len()),
            // Points of a layer take less work than nodes of a rule.
            Kernel::Layer(layer) => 1 + layer.count / 4,
        }
    }

    /// Returns the nodes of the rule in use in pieces of about [`UNITS`] of work, whose interactions add up
    /// to the whole. Ranges are of nodes, or of units of faces. A rule that takes less work has one piece, as
    /// has every rule without a polyhedron.
    pub fn pieces(&self) -> impl ExactSizeIterator<Item = Range<usize>> + use<> {
        /// The least number of evaluations in a piece: the potential at the centre, which every piece
        /// evaluates, must cost little beside them.
        const FEWEST: usize = 4;
        let divisible = |rule: &&Rule| matches!(rule.kernel, Kernel::Facets | Kernel::Layer(_));
        let begins = match (&self.fragments, &self.rule) {
            (Some(fragments), _) => fragments.ranges().skip(1).map(|piece| piece.start).collect(),
            (None, Some(rule)) => rule.begins.clone(),
            (None, None) => Vec::new(),
        };
        let (length, count) = match self.rule.as_ref().filter(divisible) {
            Some(rule) if rule.node_kind != NodeKind::Faces && self.work() > UNITS => {
                let length = (UNITS as usize / self.work_of_node(rule)).max(FEWEST);
                (length, rule.nodes().div_ceil(length))
            }
            _ => (usize::MAX, begins.len() + 1),
        };
        let begin = move |k: usize| match k.checked_sub(1) {
            None => 0,
            Some(previous) => begins.get(previous).copied().unwrap_or(length.saturating_mul(k)),
        };
        (0..count).map(move |k| begin(k)..begin(k + 1))
    }

    /// Returns the pieces for the energy at a pose.
    pub fn energy_pieces(&self, pose: &Pose, interrupt: &mut InterruptCheck) -> Result<Vec<Range<usize>>> {
        let scaled = self.scaled(pose);
        let pieces = match self.pieces_of_fragments(&scaled, interrupt)? {
            Some(pieces) => Some(pieces),
            None => self.pieces_of_faces(&scaled, interrupt)?,
        };
        Ok(pieces.unwrap_or_else(|| self.pieces().collect()))
    }

    /// Returns the least separation at which the rule in use is valid.
    #[inline]
    pub fn valid_from(&self) -> f64 {
        let series = self.truncation.as_ref().map(|truncation| truncation.valid_from);
        let rule = self.rule.as_ref().map(|rule| rule.valid_from);
        series.or(rule).unwrap_or(0.0) * self.unit
    }

    /// Returns the harmonic series with its degrees, where it is in use.
    #[inline(always)]
    pub(super) fn series(&self) -> Option<(&Harmonic, &Truncation)> {
        self.harmonic.as_ref().zip(self.truncation.as_ref())
    }

    /// Returns the highest degrees of both bodies in the harmonic series, where it is in use.
    pub fn degrees_in_use(&self) -> Option<[usize; 2]> {
        self.truncation.as_ref().map(|truncation| truncation.degrees)
    }

    /// Returns whether the rule in use is valid at this separation.
    #[inline]
    pub fn covers(&self, distance: f64) -> bool {
        distance >= self.valid_from()
    }

    /// Returns the largest separation at which the shapes can touch, whatever their rotations.
    pub fn contact_distance(&self) -> f64 {
        self.bodies.iter().map(|body| body.shape.circumradius()).sum::<f64>() * self.unit
    }

    /// Returns whether the method integrates over a polyhedron or its field.
    pub(super) fn is_faceted(&self) -> bool {
        self.multipole.is_none()
            && self.truncation.is_none()
            && self.fragments.is_none()
            && self.method != Method::Point
            && self.bodies.iter().any(|body| body.polyhedron().is_some())
    }

    /// Returns the factor by which both shapes must grow to touch.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::error::Error::Interrupted).
    pub fn growth(&self, pose: &Pose, interrupt: &mut InterruptCheck) -> Result<f64> {
        let Pose { separation, rotation_first, rotation_second } = self.scaled(pose);
        let shapes = [&self.bodies[0].shape, &self.bodies[1].shape];
        Ok(growth(shapes, &separation, [&rotation_first, &rotation_second], 0.0, interrupt)?.factor)
    }

    /// Returns force and torques with the rule in use.
    #[inline]
    pub fn interaction(&self, pose: &Pose) -> Interaction {
        self.interaction_of(pose, Self::ALL)
    }

    /// Returns the contribution of one of the [`Pair::pieces`] to force and torques.
    #[inline]
    pub fn interaction_of(&self, pose: &Pose, nodes: Range<usize>) -> Interaction {
        self.loads_in_unit(&self.scaled_interaction(&self.scaled(pose), nodes), 0)
    }

    /// Returns the truncation error of a series, the size of its next two degrees, or the bound of the error
    /// of a sum over fragments at the pose for which the rule was chosen: the larger of the error of the force
    /// and the error of the torques over the body's radius. `None` for other methods.
    pub fn truncation_error(&self, pose: &Pose) -> Option<f64> {
        if let Some(fragments) = &self.fragments {
            return Some(fragments.bound / self.unit / self.unit);
        }
        let Method::Multipole(degree) = self.method else { return None };
        let scaled = self.scaled(pose);
        let (more, less) = match (&self.multipole, self.series()) {
            (Some(multipole), _) => (multipole.next().interaction(&scaled), multipole.interaction(&scaled)),
            (None, Some((harmonic, truncation))) => {
                let next = Truncation::new([degree + 2; 2], degree + 2, truncation.valid_from);
                (harmonic.interaction(&next, &scaled), harmonic.interaction(truncation, &scaled))
            }
            (None, None) => return None,
        };
        Some(self.change(&more, &less) / self.unit / self.unit)
    }

    /// Returns the potential energy per unit G m m with the rule in use: negative.
    pub fn potential_energy(&self, pose: &Pose) -> f64 {
        self.potential_energy_of(pose, Self::ALL)
    }

    /// Returns the contribution of one of the [`Self::energy_pieces`] to the potential energy.
    pub fn potential_energy_of(&self, pose: &Pose, nodes: Range<usize>) -> f64 {
        let pose = self.scaled(pose);
        if let Some((harmonic, truncation)) = self.series() {
            return -harmonic.mutual_potential(truncation, &pose) / self.unit;
        }
        if let Some(fragments) = &self.fragments {
            return -fragments.mutual_potential(&pose, &nodes) / self.unit;
        }
        let mutual_potential = match (&self.multipole, &self.rule) {
            (Some(multipole), _) => multipole.mutual_potential(&pose),
            (None, None) => 1.0 / pose.separation.norm(),
            (None, Some(rule)) => {
                let field = &self.bodies[1 - rule.integrated];
                let roles = self.roles(rule.integrated, &pose);
                match &rule.kernel {
                    Kernel::Far(truncation) => {
                        self.potential(field.series.truncated(*truncation), rule, &roles, nodes)
                    }
                    Kernel::Near(near) => self.potential(*near, rule, &roles, nodes),
                    Kernel::Facets | Kernel::Layer(_) => match self.faces(rule, &roles, &nodes) {
                        Some(faces) => sampled::mutual_potential_over(faces, rule),
                        None => sampled::mutual_potential(self.arch, field, rule, &roles, nodes),
                    },
                }
            }
        };
        -mutual_potential / self.unit
    }

    #[inline(always)]
    pub(super) fn scaled(&self, pose: &Pose) -> Pose {
        Pose { separation: pose.separation * (1.0 / self.unit), ..*pose }
    }

    /// Returns the interaction in the pair's unit of length, checking for interrupts between pieces.
    pub(super) fn interaction_with(
        &self,
        pose: &Pose,
        interrupt: &mut InterruptCheck,
    ) -> Result<Interaction> {
        let pieces = self.pieces();
        let work = self.work() / pieces.len() as u64;
        // Only negative zero plus any number is that number to the last bit.
        let mut sum = Interaction::ZERO.times(-1.0);
        for nodes in pieces {
            interrupt.charge(work, 0.0)?;
            sum.add(&self.scaled_interaction(pose, nodes));
        }
        Ok(sum)
    }

    /// Returns the contribution of some nodes to the interaction, in the pair's unit of length.
    pub(super) fn scaled_interaction(&self, pose: &Pose, nodes: Range<usize>) -> Interaction {
        if let Some((harmonic, truncation)) = self.series() {
            return harmonic.interaction(truncation, pose);
        }
        if let Some(fragments) = &self.fragments {
            return fragments.interaction(pose, &nodes);
        }
        if let Some(multipole) = &self.multipole {
            return multipole.interaction(pose);
        }
        let Some(rule) = &self.rule else { return monopole(pose) };
        let [field, set] = self.field_and_set(rule);
        let roles = self.roles(rule.integrated, pose);
        let balance = match &rule.kernel {
            Kernel::Far(truncation) => self.balance(field.series.truncated(*truncation), rule, &roles, nodes),
            Kernel::Near(near) => self.balance(*near, rule, &roles, nodes),
            Kernel::Facets | Kernel::Layer(_) => match self.faces(rule, &roles, &nodes) {
                Some(faces) => sampled::force_and_torque_over(faces, rule),
                None => sampled::force_and_torque(self.arch, field, rule, &roles, nodes),
            },
        };
        let torque_field = field.in_body(balance.torque_field);
        let torque_set = set.in_body(rotate_back(&roles.rotation, &balance.torque));
        let force = field.in_body(balance.force);
        match rule.integrated {
            0 => Interaction {
                force_on_first: rotate(&pose.rotation_second, &force),
                torque_first: torque_set,
                torque_second: torque_field,
            },
            _ => Interaction {
                force_on_first: rotate(&pose.rotation_first, &-force),
                torque_first: torque_field,
                torque_second: torque_set,
            },
        }
    }

    fn balance(&self, kernel: impl FieldKernel, rule: &Rule, roles: &Roles, range: Range<usize>) -> Balance {
        let (arch, nodes, set) = (self.arch, &*rule.nodes, &self.bodies[rule.integrated]);
        if let Some(faces) = self.faces(rule, roles, &range) {
            return faces::force_and_torque(kernel, faces);
        }
        match rule.node_kind {
            NodeKind::SurfacePotential => {
                surface::force_and_torque(arch, kernel, nodes, set.semi_axes(), roles)
            }
            NodeKind::Layer => means::force_and_torque(arch, kernel, nodes, [1.0; 3], roles),
            NodeKind::SurfaceField(semi_axes) => {
                means::force_and_torque(arch, kernel, nodes, semi_axes, roles)
            }
            _ => means::force_and_torque(arch, kernel, nodes, set.focal_axes(), roles),
        }
    }

    fn potential(&self, kernel: impl FieldKernel, rule: &Rule, roles: &Roles, range: Range<usize>) -> f64 {
        let (arch, nodes, set) = (self.arch, &*rule.nodes, &self.bodies[rule.integrated]);
        if let Some(faces) = self.faces(rule, roles, &range) {
            return faces::mutual_potential(kernel, faces);
        }
        match rule.node_kind {
            NodeKind::SurfacePotential => {
                surface::mutual_potential(arch, kernel, nodes, set.semi_axes(), roles)
            }
            NodeKind::Layer => means::mean_potential(arch, kernel, nodes, [1.0; 3], roles),
            NodeKind::SurfaceField(semi_axes) => means::mean_potential(arch, kernel, nodes, semi_axes, roles),
            _ => means::mean_potential(arch, kernel, nodes, set.focal_axes(), roles),
        }
    }

    /// Returns the cells over which a rule integrates; `None` for rules over other nodes.
    pub(super) fn faces<'a>(
        &'a self,
        rule: &'a Rule,
        roles: &'a Roles,
        range: &'a Range<usize>,
    ) -> Option<Faces<'a>> {
        let [field, set] = self.field_and_set(rule);
        let polyhedron = set.polyhedron().filter(|_| rule.node_kind == NodeKind::Faces)?;
        let (nodes, digits, arch) = (&*rule.nodes, rule.order.gauss, self.arch);
        Some(Faces { polyhedron, field, roles, nodes, digits, range, arch })
    }

    pub(super) fn field_and_set(&self, rule: &Rule) -> [&PartGravity; 2] {
        [&self.bodies[1 - rule.integrated], &self.bodies[rule.integrated]]
    }

    #[inline(always)]
    pub(super) fn roles(&self, integrated: usize, pose: &Pose) -> Roles {
        let (field, set) = (&self.bodies[1 - integrated], &self.bodies[integrated]);
        let (rotation_field, rotation_set, separation) = match integrated {
            0 => (&pose.rotation_second, &pose.rotation_first, -pose.separation),
            _ => (&pose.rotation_first, &pose.rotation_second, pose.separation),
        };
        let to_field = field.rotation_to_canonical(rotation_field.transpose());
        Roles {
            origin: rotate(&to_field, &separation),
            rotation: set.rotation_from_canonical(times(&to_field, rotation_set)),
        }
    }
}

/// Returns the kind of nodes for a body in the field of the other one.
fn node_kind(method: Method, set: &PartGravity, field: &PartGravity, thinned: f64) -> NodeKind {
    /// The largest ratio of the sum of both bodies' longest semi-axes to the shortest axis for which the
    /// potential is integrated. The difference of pressures across a shortest axis c loses up to 1.5 epsilon
    /// (a + a') / c of the force, with a and a' the longest semi-axes: at this ratio as much as the default
    /// tolerance.
    const MAX_AXIS_RATIO: f64 = 30.0;
    let semi_axes = set.semi_axes();
    let [longest, _, shortest] = semi_axes;
    match (method, set.ellipsoid()) {
        (Method::Surface, Some(_)) if longest + field.semi_axes()[0] <= MAX_AXIS_RATIO * shortest => {
            NodeKind::SurfacePotential
        }
        (Method::Surface, Some(_)) => NodeKind::SurfaceField(semi_axes),
        _ if set.focal_axes()[0] > 0.0 => NodeKind::FocalEllipse(thinned),
        _ => NodeKind::Centre,
    }
}

pub(super) fn monopole(pose: &Pose) -> Interaction {
    let r = pose.separation.norm();
    Interaction { force_on_first: pose.separation / r / r / r, ..Interaction::ZERO }
}
