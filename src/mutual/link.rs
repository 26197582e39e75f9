//! A part of one body and a part of another: their pair, with lever arms.

use super::{AxisSlopes, BodyGravity, Interaction, Jacobian, Method, Pair, Pose, Store};
use crate::error::Result;
use crate::math::rotation::{turned, turned_back};
use crate::math::{Mat3, Vec3};
use crate::patience::Patience;
use crate::quadrature::Order;
use crate::shape::{Body, Part, Place, Shape};
use pulp::Arch;
use std::ops::Range;
use std::sync::Arc;

/// Nothing is gained by a smaller tolerance of a force.
const ROUND_OFF: f64 = 1e-16;

/// Two parts of two bodies. All that is asked of it is in terms of the bodies: their pose, their centres, their masses.
#[derive(Debug, Clone)]
pub struct Link {
    /// The pair of the shapes.
    pub pair: Pair,
    /// What the parts are of their bodies; none for two ordinary bodies.
    arms: Option<Box<Arms>>,
}

#[derive(Debug, Clone)]
struct Arms {
    /// The numbers of the parts in their bodies.
    parts: [usize; 2],
    /// Product of the parts' shares of the masses of their bodies.
    share: f64,
    places: [Option<Place>; 2],
}

/// How two bodies may move in the time that a rule is chosen for.
#[derive(Debug, Clone, Copy)]
pub struct Foreseen {
    /// The least separation of their centres.
    pub reach: f64,
    /// By how much each turns, in rad.
    pub turns: [f64; 2],
    /// The factor by which they would have to grow to touch; infinite where it is not known.
    pub growth: f64,
}

/// Two parts are nearer to each other than the rule in force holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TooNear {
    /// Separation of the parts' centres.
    pub separation: f64,
    /// The least at which the rule holds.
    pub valid_from: f64,
}

impl Link {
    /// The parts of two bodies that make links; one of each where the bodies count as points.
    pub fn parts_of(bodies: [&Body; 2], method: Method) -> [usize; 2] {
        if method == Method::Point { [1; 2] } else { bodies.map(|body| body.parts().len()) }
    }

    /// The link of two parts, by their places in the bodies. `tolerance` is relative to the force between the bodies.
    pub fn new(
        bodies: [&Body; 2],
        parts: [usize; 2],
        method: Method,
        tolerance: f64,
        fixed: Option<Order>,
        arch: Arch,
        store: &Arc<Store>,
    ) -> Self {
        let pair = |[first, second]: [BodyGravity; 2], tolerance| {
            Pair::new(first, second, method, tolerance, fixed, arch)
        };
        if method == Method::Point {
            let points = bodies.map(|body| BodyGravity::new(&body.name, &Shape::Point, store));
            return Self { pair: pair(points, tolerance), arms: None };
        }
        let [first, second] = [0, 1].map(|k| &bodies[k].parts()[parts[k]]);
        let gravity =
            [gravity(bodies[0], parts[0], first, store), gravity(bodies[1], parts[1], second, store)];
        if first.place.is_none() && second.place.is_none() {
            return Self { pair: pair(gravity, tolerance), arms: None };
        }
        // The forces of voids and of what they are cut from cancel, but their errors do not.
        let terms = bodies.map(|body| body.mass_without_signs() / body.mass);
        let tolerance = (tolerance / (terms[0] * terms[1])).max(tolerance.min(ROUND_OFF));
        let share = (first.mass / bodies[0].mass) * (second.mass / bodies[1].mass);
        let arms = Box::new(Arms { parts, share, places: [first.place, second.place] });
        Self { pair: pair(gravity, tolerance), arms: Some(arms) }
    }

    /// Chooses the rule for a pose, and for what is foreseen from there. May allocate: call it between steps.
    pub fn prepare(
        &mut self,
        pose: &Pose,
        foreseen: Option<&Foreseen>,
        patience: &mut Patience,
    ) -> Result<()> {
        let own = self.pose(pose);
        let closing = foreseen.map_or(0.0, |foreseen| self.closing(pose, &own, foreseen));
        self.pair.prepare(&own, closing, patience)
    }

    /// How much of the parts' separation may close without overlap.
    fn closing(&self, pose: &Pose, own: &Pose, foreseen: &Foreseen) -> f64 {
        let distance = own.separation.norm();
        let (mut reach, mut growth) = (foreseen.reach, foreseen.growth);
        if let Some(arms) = &self.arms {
            // A chord is no longer than its arc, nor than two radii.
            let swing = |body: usize| {
                foreseen.turns[body].min(2.0) * arms.places[body].map_or(0.0, |place| place.position.norm())
            };
            reach = distance - (pose.separation.norm() - foreseen.reach) - swing(0) - swing(1);
            growth = f64::INFINITY;
        }
        let touching = if reach > self.pair.apart_from() {
            0.0
        } else if growth.is_finite() {
            1.0 / growth
        } else {
            1.0 / self.pair.growth(own)
        };
        (1.0 - (reach / distance).max(touching)).clamp(0.0, 0.5)
    }

    /// Whether the parts are nearer to each other than the rule in force holds.
    #[inline(always)]
    pub fn too_near(&self, pose: &Pose) -> Option<TooNear> {
        let separation = match &self.arms {
            None => pose.separation.norm(),
            Some(arms) => arms.separation(pose).norm(),
        };
        if self.pair.covers(separation) {
            return None;
        }
        Some(TooNear { separation, valid_from: self.pair.valid_from() })
    }

    /// Force on the bodies' centres and torques about them, with the rule in force: the share of this link in the whole of the
    /// two bodies.
    pub fn interaction(&self, pose: &Pose) -> Interaction {
        self.interaction_of(pose, Pair::ALL)
    }

    /// The share of a piece of [`Pair::pieces`].
    pub fn interaction_of(&self, pose: &Pose, nodes: Range<usize>) -> Interaction {
        match &self.arms {
            None => self.pair.interaction_of(pose, nodes),
            Some(arms) => arms.about_centres(pose, self.pair.interaction_of(&arms.pose(pose), nodes)),
        }
    }

    /// Chooses the nodes for [`Self::jacobian`]; see [`Pair::prepare_jacobian`].
    pub fn prepare_jacobian(&mut self, patience: &mut Patience) -> Result<()> {
        self.pair.prepare_jacobian(patience)
    }

    /// The share of this link in the derivatives of force and torques of the bodies.
    #[inline]
    pub fn jacobian(&self, pose: &Pose) -> Jacobian {
        match &self.arms {
            None => self.pair.jacobian(pose),
            Some(arms) => arms.jacobian_about_centres(pose, &self.pair.jacobian(&arms.pose(pose))),
        }
    }

    /// The share of this link in the derivatives of the bodies' loads by the semi-axes of its parts.
    pub fn axis_slopes(&self, pose: &Pose) -> AxisSlopes {
        match &self.arms {
            None => self.pair.axis_slopes(pose),
            Some(arms) => self
                .pair
                .axis_slopes(&arms.pose(pose))
                .map(|body| body.map(|loads| arms.about_centres(pose, loads))),
        }
    }

    /// The numbers of the parts in their bodies; none of two ordinary bodies.
    pub fn parts(&self) -> Option<[usize; 2]> {
        self.arms.as_ref().map(|arms| arms.parts)
    }

    /// As [`Pair::points`].
    pub fn points(&self, pose: &Pose) -> Option<usize> {
        self.pair.points(&self.pose(pose))
    }

    /// The pair of two ordinary bodies, whose interaction is this.
    #[inline]
    pub fn ordinary(&self) -> Option<&Pair> {
        self.arms.is_none().then_some(&self.pair)
    }

    /// As [`Pair::left_out`], of this link's share in the force between the bodies.
    pub fn left_out(&self, pose: &Pose) -> Option<f64> {
        match &self.arms {
            None => self.pair.left_out(pose),
            Some(arms) => Some(arms.share.abs() * self.pair.left_out(&arms.pose(pose))?),
        }
    }

    /// The share of this link in the potential energy per unit G m m.
    pub fn potential_energy(&self, pose: &Pose) -> f64 {
        self.potential_energy_of(pose, Pair::ALL)
    }

    /// As [`Pair::energy_pieces`].
    pub fn energy_pieces(&self, pose: &Pose, patience: &mut Patience) -> Result<Vec<Range<usize>>> {
        self.pair.energy_pieces(&self.pose(pose), patience)
    }

    /// The share of a piece of [`Self::energy_pieces`].
    pub fn potential_energy_of(&self, pose: &Pose, nodes: Range<usize>) -> f64 {
        match &self.arms {
            None => self.pair.potential_energy_of(pose, nodes),
            Some(arms) => arms.share * self.pair.potential_energy_of(&arms.pose(pose), nodes),
        }
    }

    fn pose(&self, pose: &Pose) -> Pose {
        self.arms.as_ref().map_or(*pose, |arms| arms.pose(pose))
    }
}

impl Arms {
    /// The vector from the first part's centre to the second's.
    #[inline(never)]
    fn separation(&self, pose: &Pose) -> Vec3 {
        let mut separation = pose.separation;
        if let Some(place) = &self.places[0] {
            separation -= turned(&pose.rotation_first, &place.position);
        }
        if let Some(place) = &self.places[1] {
            separation += turned(&pose.rotation_second, &place.position);
        }
        separation
    }

    #[inline]
    fn pose(&self, pose: &Pose) -> Pose {
        let mut own = Pose { separation: self.separation(pose), ..*pose };
        if let Some(place) = &self.places[0] {
            own.rotation_first *= place.rotation;
        }
        if let Some(place) = &self.places[1] {
            own.rotation_second *= place.rotation;
        }
        own
    }

    /// From the parts' centres and frames to those of the bodies.
    #[inline]
    fn about_centres(&self, pose: &Pose, parts: Interaction) -> Interaction {
        let force = parts.force_on_first * self.share;
        let about = |place: &Option<Place>, rotation, torque: Vec3, force: Vec3| match place {
            None => torque * self.share,
            Some(place) => {
                turned(&place.rotation, &torque) * self.share
                    + place.position.cross(&turned_back(rotation, &force))
            }
        };
        Interaction {
            force_on_first: force,
            torque_first: about(&self.places[0], &pose.rotation_first, parts.torque_first, force),
            torque_second: about(&self.places[1], &pose.rotation_second, parts.torque_second, -force),
        }
    }
}

impl Arms {
    /// The same of derivatives. The parts' separation changes with the bodies' turns by A_i = dr/dv_i = +-R_i [p_i]x.
    fn jacobian_about_centres(&self, pose: &Pose, parts: &Jacobian) -> Jacobian {
        let rotations = [&pose.rotation_first, &pose.rotation_second];
        let signs = [1.0, -1.0];
        let turn = [0, 1].map(|i| self.places[i].map_or(Mat3::identity(), |place| place.rotation));
        let lever =
            [0, 1].map(|i| self.places[i].map_or(Mat3::zeros(), |place| place.position.cross_matrix()));
        let k = &parts.force_by_separation;
        let force = parts.loads.force_on_first;
        let moved = [0, 1].map(|i| rotations[i] * lever[i] * signs[i]);
        let by_turn =
            [0, 1].map(|i| k * moved[i] - parts.torque_by_separation[i].transpose() * turn[i].transpose());
        let by_separation = [0, 1].map(|i| {
            turn[i] * parts.torque_by_separation[i] + lever[i] * rotations[i].transpose() * k * signs[i]
        });
        let by_own = [0, 1].map(|i| {
            let own =
                parts.torque_by_separation[i] * moved[i] + parts.torque_by_rotation[i] * turn[i].transpose();
            let pull =
                (rotations[i].transpose() * force).cross_matrix() + rotations[i].transpose() * by_turn[i];
            (turn[i] * own + lever[i] * pull * signs[i]) * self.share
        });
        let other =
            parts.torque_by_separation[0] * moved[1] + parts.torque_first_by_second * turn[1].transpose();
        let first_by_second = turn[0] * other + lever[0] * rotations[0].transpose() * by_turn[1];
        Jacobian {
            loads: self.about_centres(pose, parts.loads),
            force_by_separation: k * self.share,
            torque_by_separation: by_separation.map(|block| block * self.share),
            torque_by_rotation: by_own,
            torque_first_by_second: first_by_second * self.share,
        }
    }
}

/// What of a part's gravity does not depend on the state, with the name that errors use.
fn gravity(body: &Body, index: usize, part: &Part, store: &Arc<Store>) -> BodyGravity {
    if part.place.is_none() {
        return BodyGravity::new(&body.name, &part.shape, store);
    }
    BodyGravity::new(&format!("part {index} of {}", body.name), &part.shape, store)
}
