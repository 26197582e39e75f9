//! A pair of parts with a method, evaluated with the rule in force.

use super::faces::Faces;
use super::rule::{GradientNodes, Kernel, NodeStore, Rule};
use super::store::Carrier;
use super::{
    Balance, BodyGravity, Interaction, Method, Multipole, Pose, Roles, faces, means, sampled, surface,
};
use crate::error::Result;
use crate::gravity::FieldKernel;
use crate::math::Vec3;
use crate::math::matrix::times;
use crate::math::rotation::{turned, turned_back};
use crate::patience::{Patience, UNITS};
use crate::quadrature::{Cell, Degrees, Order};
use crate::shape::{Shape, growth};
use pulp::Arch;
use std::ops::Range;

/// Two shapes and the method of their interaction. A pair of ordinary bodies is one of these; see [`super::Link`] for composites.
#[derive(Debug, Clone)]
pub struct Pair {
    pub(super) method: Method,
    pub(super) tolerance: f64,
    pub(super) fixed: Option<Order>,
    pub(super) arch: Arch,
    /// Unit of length, a power of two near the size of the larger body; the bodies are in this unit.
    pub(super) unit: f64,
    pub(super) bodies: [BodyGravity; 2],
    /// What a rule over each body needs.
    pub(super) degrees: [Degrees; 2],
    /// The points that stand for each body where that one is integrated over.
    pub(super) carriers: [Carrier; 2],
    pub(super) multipole: Option<Multipole>,
    pub(super) rule: Option<Rule>,
    /// The nodes over which the field's gradient is averaged, where they have been asked for.
    pub(super) gradient_nodes: Option<GradientNodes>,
    /// Those over which derivatives by the semi-axes are.
    pub(super) axis_nodes: Option<GradientNodes>,
    pub(super) nodes: NodeStore,
}

impl Pair {
    /// The one piece that has all nodes of a rule.
    pub const ALL: Range<usize> = 0..usize::MAX;

    /// `tolerance` is relative to the force; `fixed` overrides the choice of nodes.
    pub fn new(
        first: BodyGravity,
        second: BodyGravity,
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
            Method::Multipole(degree) => Some(Multipole::new(&bodies[0].shape, &bodies[1].shape, degree)),
            _ => None,
        };
        // Of an order that is prescribed all rings have the angles.
        let thinned = if fixed.is_none() { tolerance } else { 0.0 };
        let carriers = [
            carrier(method, &bodies[0], &bodies[1], thinned),
            carrier(method, &bodies[1], &bodies[0], thinned),
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
            carriers,
            multipole,
            rule: None,
            gradient_nodes: None,
            axis_nodes: None,
            nodes,
        }
    }

    /// The quadrature in force, if the method has one and a state has been seen.
    pub fn rule(&self) -> Option<&Rule> {
        self.rule.as_ref()
    }

    /// The method; that of points for two points.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The points of the rule in force at a pose.
    pub fn points(&self, pose: &Pose) -> Option<usize> {
        let rule = self.rule.as_ref()?;
        let pose = self.scaled(pose);
        let roles = self.roles(rule.integrated, &pose);
        let of = |cell: Cell| cell.points * cell.points;
        let faces = self.faces(rule, &roles).map(|faces| faces.cells(&Self::ALL).map(of).sum());
        Some(faces.unwrap_or(rule.nodes()))
    }

    /// Units of work of an evaluation with the rule in force, for [`crate::patience::Patience`].
    pub fn work(&self) -> u64 {
        self.rule.as_ref().map_or(0, |rule| (rule.nodes() * self.work_of_node(rule)) as u64)
    }

    pub(super) fn work_of_node(&self, rule: &Rule) -> usize {
        match &rule.kernel {
            Kernel::Far(_) | Kernel::Near(_) => 1,
            Kernel::Facets => self.field_and_set(rule)[0].polyhedron().map_or(1, |p| p.faces().len()),
            // Its points take less than nodes do.
            Kernel::Layer(layer) => 1 + layer.count / 4,
        }
    }

    /// The nodes of the rule in force in pieces of about [`UNITS`] of work, whose interactions add up to the whole: numbers of nodes,
    /// or of units of faces. One piece has all nodes of a rule that takes less, and of one without a polyhedron, which always does.
    pub fn pieces(&self) -> impl ExactSizeIterator<Item = Range<usize>> + use<> {
        /// The potential at the centre, which every piece takes, has to cost little beside it.
        const FEWEST: usize = 4;
        let divisible = |rule: &&Rule| matches!(rule.kernel, Kernel::Facets | Kernel::Layer(_));
        let begins = self.rule.as_ref().map_or(Vec::new(), |rule| rule.begins.clone());
        let (length, count) = match self.rule.as_ref().filter(divisible) {
            Some(rule) if rule.carrier != Carrier::Faces && self.work() > UNITS => {
                let length = (UNITS as usize / self.work_of_node(rule)).max(FEWEST);
                (length, rule.nodes().div_ceil(length))
            }
            _ => (usize::MAX, begins.len() + 1),
        };
        let begin = move |k: usize| match k.checked_sub(1) {
            None => 0,
            Some(before) => begins.get(before).copied().unwrap_or(length.saturating_mul(k)),
        };
        (0..count).map(move |k| begin(k)..begin(k + 1))
    }

    /// The same for the energy, at a pose.
    pub fn energy_pieces(&self, pose: &Pose, patience: &mut Patience) -> Result<Vec<Range<usize>>> {
        let faces = self.pieces_of_faces(&self.scaled(pose), patience)?;
        Ok(faces.unwrap_or_else(|| self.pieces().collect()))
    }

    /// The least separation at which the rule in force holds.
    #[inline]
    pub fn valid_from(&self) -> f64 {
        self.rule.as_ref().map_or(0.0, |rule| rule.valid_from * self.unit)
    }

    /// Whether the rule in force holds at this separation.
    #[inline]
    pub fn covers(&self, distance: f64) -> bool {
        distance >= self.valid_from()
    }

    /// The separation from which on the series converges, where it does not at a pose.
    pub(super) fn diverges(&self, pose: &Pose) -> Option<f64> {
        let from = self.multipole.as_ref().map_or(0.0, Multipole::converges_from) * self.unit;
        (pose.separation.norm() <= from).then_some(from)
    }

    /// The separation from which on the shapes cannot touch, however they are turned.
    pub fn apart_from(&self) -> f64 {
        self.bodies.iter().map(|body| body.shape.circumradius()).sum::<f64>() * self.unit
    }

    /// The factor by which both must grow to touch.
    pub fn growth(&self, pose: &Pose) -> f64 {
        let Pose { separation, rotation_first, rotation_second } = self.scaled(pose);
        let [first, second] = &self.bodies;
        growth(&first.shape, &second.shape, &separation, &rotation_first, &rotation_second).factor
    }

    /// Force and torques with the rule in force.
    #[inline]
    pub fn interaction(&self, pose: &Pose) -> Interaction {
        self.interaction_of(pose, Self::ALL)
    }

    /// The share of a piece of [`Pair::pieces`].
    #[inline]
    pub fn interaction_of(&self, pose: &Pose, nodes: Range<usize>) -> Interaction {
        let f = self.scaled_interaction(&self.scaled(pose), nodes);
        // Exact, by a power of two.
        let inverse = 1.0 / self.unit;
        Interaction {
            force_on_first: f.force_on_first * inverse * inverse,
            torque_first: f.torque_first * inverse,
            torque_second: f.torque_second * inverse,
        }
    }

    /// The size of the two degrees after the last one of the series: of the force, and of the torques by the body's radius. None of
    /// a method that is no series.
    pub fn left_out(&self, pose: &Pose) -> Option<f64> {
        let multipole = self.multipole.as_ref()?;
        let scaled = self.scaled(pose);
        let (more, own) = (multipole.next().interaction(&scaled), multipole.interaction(&scaled));
        Some(self.change(&more, &own) * more.force_on_first.norm() / self.unit / self.unit)
    }

    /// Potential energy per unit G m m with the rule in force: negative.
    pub fn potential_energy(&self, pose: &Pose) -> f64 {
        self.potential_energy_of(pose, Self::ALL)
    }

    /// The share of a piece of [`Self::energy_pieces`].
    pub fn potential_energy_of(&self, pose: &Pose, nodes: Range<usize>) -> f64 {
        let pose = self.scaled(pose);
        let mutual_potential = match (&self.multipole, &self.rule) {
            (Some(multipole), _) => multipole.mutual_potential(&pose),
            (None, None) => 1.0 / pose.separation.norm(),
            (None, Some(rule)) => {
                let [field, set] = self.field_and_set(rule);
                let roles = self.roles(rule.integrated, &pose);
                match &rule.kernel {
                    Kernel::Far(cut) => self.potential(field.series.cut(*cut), rule, set, &roles, nodes),
                    Kernel::Near(near) => self.potential(*near, rule, set, &roles, nodes),
                    Kernel::Facets | Kernel::Layer(_) => match self.faces(rule, &roles) {
                        Some(faces) => sampled::mutual_potential_over(faces, rule, &nodes),
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

    /// The interaction in the pair's unit of length, which asks between pieces.
    pub(super) fn asking(&self, pose: &Pose, patience: &mut Patience) -> Result<Interaction> {
        let pieces = self.pieces();
        let work = self.work() / pieces.len() as u64;
        let zero = Vec3::repeat(-0.0);
        let mut sum = Interaction { force_on_first: zero, torque_first: zero, torque_second: zero };
        for nodes in pieces {
            patience.spend(work, 0.0)?;
            let f = self.scaled_interaction(pose, nodes);
            sum.force_on_first += f.force_on_first;
            sum.torque_first += f.torque_first;
            sum.torque_second += f.torque_second;
        }
        Ok(sum)
    }

    /// The share of some nodes in the interaction in the pair's unit of length.
    pub(super) fn scaled_interaction(&self, pose: &Pose, nodes: Range<usize>) -> Interaction {
        if let Some(multipole) = &self.multipole {
            return multipole.interaction(pose);
        }
        let Some(rule) = &self.rule else { return monopole(pose) };
        let [field, set] = self.field_and_set(rule);
        let roles = self.roles(rule.integrated, pose);
        let balance = match &rule.kernel {
            Kernel::Far(cut) => self.balance(field.series.cut(*cut), rule, set, &roles, nodes),
            Kernel::Near(near) => self.balance(*near, rule, set, &roles, nodes),
            Kernel::Facets | Kernel::Layer(_) => match self.faces(rule, &roles) {
                Some(faces) => sampled::force_and_torque_over(faces, rule, &nodes),
                None => sampled::force_and_torque(self.arch, field, rule, &roles, nodes),
            },
        };
        let torque_field = field.in_body(balance.torque_field);
        let torque_set = set.in_body(turned_back(&roles.turn, &balance.torque));
        let force = field.in_body(balance.force);
        match rule.integrated {
            0 => Interaction {
                force_on_first: turned(&pose.rotation_second, &force),
                torque_first: torque_set,
                torque_second: torque_field,
            },
            _ => Interaction {
                force_on_first: turned(&pose.rotation_first, &-force),
                torque_first: torque_field,
                torque_second: torque_set,
            },
        }
    }

    fn balance(
        &self,
        kernel: impl FieldKernel,
        rule: &Rule,
        set: &BodyGravity,
        roles: &Roles,
        range: Range<usize>,
    ) -> Balance {
        let (arch, nodes) = (self.arch, &*rule.nodes);
        if let Some(faces) = self.faces(rule, roles) {
            return faces::force_and_torque(kernel, nodes, faces, &range);
        }
        match rule.carrier {
            Carrier::Pressures => surface::force_and_torque(arch, kernel, nodes, set.semi_axes(), roles),
            Carrier::Layer => means::force_and_torque(arch, kernel, nodes, [1.0; 3], roles),
            Carrier::Surface(semi_axes) => means::force_and_torque(arch, kernel, nodes, semi_axes, roles),
            _ => means::force_and_torque(arch, kernel, nodes, set.focal_axes(), roles),
        }
    }

    fn potential(
        &self,
        kernel: impl FieldKernel,
        rule: &Rule,
        set: &BodyGravity,
        roles: &Roles,
        range: Range<usize>,
    ) -> f64 {
        let (arch, nodes) = (self.arch, &*rule.nodes);
        if let Some(faces) = self.faces(rule, roles) {
            return faces::mutual_potential(kernel, nodes, faces, &range);
        }
        match rule.carrier {
            Carrier::Pressures => surface::mutual_potential(arch, kernel, nodes, set.semi_axes(), roles),
            Carrier::Layer => means::mean_potential(arch, kernel, nodes, [1.0; 3], roles),
            Carrier::Surface(semi_axes) => means::mean_potential(arch, kernel, nodes, semi_axes, roles),
            _ => means::mean_potential(arch, kernel, nodes, set.focal_axes(), roles),
        }
    }

    /// The faces that a rule goes over, if it does.
    pub(super) fn faces<'a>(&'a self, rule: &Rule, roles: &'a Roles) -> Option<Faces<'a>> {
        let [field, set] = self.field_and_set(rule);
        let polyhedron = set.polyhedron().filter(|_| rule.carrier == Carrier::Faces)?;
        Some(Faces { polyhedron, field, roles, digits: rule.order.gauss, arch: self.arch })
    }

    pub(super) fn field_and_set(&self, rule: &Rule) -> [&BodyGravity; 2] {
        [&self.bodies[1 - rule.integrated], &self.bodies[rule.integrated]]
    }

    #[inline(always)]
    pub(super) fn roles(&self, integrated: usize, pose: &Pose) -> Roles {
        let (field, set) = (&self.bodies[1 - integrated], &self.bodies[integrated]);
        let (rotation_field, rotation_set, separation) = match integrated {
            0 => (&pose.rotation_second, &pose.rotation_first, -pose.separation),
            _ => (&pose.rotation_first, &pose.rotation_second, pose.separation),
        };
        let to_field = field.to_canonical(rotation_field.transpose());
        Roles {
            origin: turned(&to_field, &separation),
            turn: set.out_of_canonical(times(&to_field, rotation_set)),
        }
    }
}

/// The points that stand for a body in the field of the other one.
fn carrier(method: Method, set: &BodyGravity, field: &BodyGravity, thinned: f64) -> Carrier {
    /// The difference of the paper's pressures across the shortest axis c loses up to 1.5 epsilon (a + a') / c of the
    /// force, a and a' the longest semi-axes of both bodies: the default tolerance at thirty.
    const PRESSURES_TELL: f64 = 30.0;
    let semi_axes = set.semi_axes();
    let [longest, _, shortest] = semi_axes;
    match (method, set.ellipsoid()) {
        (Method::Surface, Some(_)) if longest + field.semi_axes()[0] <= PRESSURES_TELL * shortest => {
            Carrier::Pressures
        }
        (Method::Surface, Some(_)) => Carrier::Surface(semi_axes),
        _ if set.focal_axes()[0] > 0.0 => Carrier::FocalEllipse(thinned),
        _ => Carrier::Centre,
    }
}

pub(super) fn monopole(pose: &Pose) -> Interaction {
    let r = pose.separation.norm();
    let zero = Vec3::zeros();
    Interaction { force_on_first: pose.separation / r / r / r, torque_first: zero, torque_second: zero }
}
