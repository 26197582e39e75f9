//! The external forces of a system as terms of a sum, with their work and impulse.

use super::evaluator::Evaluator;
use super::{
    Force, ForceParameter, Load, LoadJacobian, LoadSink, MarginGradient, MotionSnapshot, PointAttraction,
    Switch, binary_yarkovsky, byorp, function, third_body, tide, yorp,
};
use crate::error::{Error, Result};
use crate::gravity::{BodyChange, ExtendedAttraction};
use crate::math::Vec3;
use crate::math::rotation::rotate;
use crate::shape::Body;
use pulp::Simd;

/// The number of values of a force's work, impulse and angular impulse: 1 + 3 + 3.
pub const WORK_AND_IMPULSE: usize = 7;

/// The external forces of a system, prepared for evaluation.
#[derive(Debug, Clone)]
pub struct ForceModel {
    terms: Vec<ForceTerm>,
    needs_attitudes: bool,
}

/// The change that a switch makes: the force on a body jumps where a function of the body's motion about
/// another one is zero.
#[derive(Debug, Clone, Copy)]
pub struct SwitchJump {
    /// The index of the body on which the force acts.
    pub on: usize,
    /// The index of the other body.
    pub about: usize,
    /// The force after the switch minus the force before it, inertial.
    pub force: Vec3,
    /// The torque after the switch minus the torque before it, body frame.
    pub torque: Vec3,
    /// The derivatives of the function that is zero at the switch.
    pub gradient: MarginGradient,
}

#[derive(Debug, Clone)]
struct ForceTerm {
    name: String,
    kind: ForceTermKind,
}

#[derive(Debug, Clone)]
enum ForceTermKind {
    ThirdBody(third_body::ThirdBodyAttraction),
    Tide(tide::TidalForce),
    Yorp(yorp::YorpTorque),
    Byorp(byorp::ByorpForce),
    BinaryYarkovsky(binary_yarkovsky::BinaryYarkovskyForce),
    Function(function::FunctionForce),
}

/// Evaluates an expression with the evaluator of a force, of whatever kind it is.
macro_rules! with {
    ($kind:expr, $force:ident => $value:expr) => {
        match $kind {
            ForceTermKind::ThirdBody($force) => $value,
            ForceTermKind::Tide($force) => $value,
            ForceTermKind::Yorp($force) => $value,
            ForceTermKind::Byorp($force) => $value,
            ForceTermKind::BinaryYarkovsky($force) => $value,
            ForceTermKind::Function($force) => $value,
        }
    };
}

impl ForceTerm {
    /// Returns the loads at the last snapshot on the bodies on which the force acts.
    #[inline(always)]
    fn loads(&self) -> &[Load] {
        with!(&self.kind, force => force.loads())
    }

    fn third_body(&self) -> Option<&third_body::ThirdBodyAttraction> {
        if let ForceTermKind::ThirdBody(attraction) = &self.kind { Some(attraction) } else { None }
    }

    fn third_body_mut(&mut self) -> Option<&mut third_body::ThirdBodyAttraction> {
        if let ForceTermKind::ThirdBody(attraction) = &mut self.kind { Some(attraction) } else { None }
    }

    fn byorp(&self) -> Option<&byorp::ByorpForce> {
        if let ForceTermKind::Byorp(byorp) = &self.kind { Some(byorp) } else { None }
    }
}

impl ForceModel {
    /// Prepares the forces on bodies.
    pub fn new(forces: &[Force], bodies: &[Body], gravitational_constant: f64) -> Result<Self> {
        let mut terms = Vec::<ForceTerm>::new();
        for (of, force) in forces.iter().enumerate() {
            let name = force.name().to_owned();
            if terms.iter().any(|term| term.name == name) {
                return Err(Error::invalid("name of a force", format!("{name:?} twice"), "distinct names"));
            }
            let kind = match force {
                Force::ThirdBody(force) => {
                    bodies.iter().try_for_each(Body::require_vertices)?;
                    ForceTermKind::ThirdBody(force.prepared(of, bodies, gravitational_constant)?)
                }
                Force::Tide(force) => {
                    ForceTermKind::Tide(force.prepared(of, bodies, gravitational_constant)?)
                }
                Force::Yorp(force) => ForceTermKind::Yorp(force.prepared(of, bodies)?),
                Force::Byorp(force) => {
                    ForceTermKind::Byorp(force.prepared(of, bodies, gravitational_constant)?)
                }
                Force::BinaryYarkovsky(force) => {
                    ForceTermKind::BinaryYarkovsky(force.prepared(of, bodies, gravitational_constant)?)
                }
                Force::Function(force) => ForceTermKind::Function(force.prepared(of, bodies)?),
            };
            terms.push(ForceTerm { name, kind });
        }
        let needs_attitudes = terms.iter().any(|term| matches!(term.kind, ForceTermKind::Function(_)));
        Ok(Self { terms, needs_attitudes })
    }

    /// Iterates over the loads at the last snapshot, one force after the other.
    #[inline]
    pub fn loads(&self) -> impl Iterator<Item = &Load> {
        self.terms.iter().flat_map(ForceTerm::loads)
    }

    /// Returns whether a force needs the attitudes as quaternions.
    #[inline]
    pub fn needs_attitudes(&self) -> bool {
        self.needs_attitudes
    }

    /// Returns the units of work of an evaluation, for [`crate::interrupt::InterruptCheck`].
    pub fn work(&self) -> u64 {
        self.terms.iter().map(|term| with!(&term.kind, force => force.work())).sum()
    }

    /// Returns an error for a run, from a snapshot to another time, that leaves the times for which a force
    /// is given, or in which a third body comes inside the system.
    pub fn check(&self, snapshot: MotionSnapshot, to: f64) -> Result<()> {
        self.third_bodies().try_for_each(|(name, attraction)| attraction.check(name, to, snapshot))
    }

    /// Returns the time at which a step from one time towards another must end for every force to be defined
    /// all along it.
    pub fn reach(&self, from: f64, to: f64) -> f64 {
        let ends = self.third_bodies().map(|(_, attraction)| attraction.span());
        ends.fold(to, |to, (first, last)| if to < from { to.max(first) } else { to.min(last) })
    }

    /// Begins a step; the first step of a motion decides which forces act. Returns an error for a step in
    /// which a force loses its meaning.
    pub fn begin_step(&mut self, snapshot: MotionSnapshot, step: f64) -> Result<()> {
        let mut terms = self.terms.iter_mut();
        terms
            .try_for_each(|term| with!(&mut term.kind, force => force.begin_step(&term.name, snapshot, step)))
    }

    /// Returns the switch of each force; `None` for forces that are never switched off.
    pub fn switches(&self) -> Vec<Option<Switch>> {
        self.terms.iter().map(|term| term.byorp().and_then(|byorp| byorp.state)).collect()
    }

    /// Iterates over the indices of the forces that can be switched on and off.
    pub fn switched(&self) -> impl Iterator<Item = usize> + use<'_> {
        (0..self.terms.len()).filter(|force| self.byorp_force(*force).is_some())
    }

    /// Returns whether an evaluation of the present step came near a switch.
    pub fn nears_switch(&self) -> bool {
        self.terms.iter().filter_map(ForceTerm::byorp).any(byorp::ByorpForce::nears_switch)
    }

    /// Returns how far a snapshot is from the next switch of a force: below zero beyond the switch.
    pub fn switch_margin(&self, force: usize, snapshot: MotionSnapshot) -> f64 {
        self.byorp_force(force).map_or(f64::INFINITY, |byorp| byorp.margin(snapshot))
    }

    /// Returns what the next switch of a force changes, at a snapshot where the switch occurs; `None` where
    /// the lock has no derivatives.
    pub fn switch_jump(&self, force: usize, snapshot: MotionSnapshot) -> Option<SwitchJump> {
        let byorp = self.byorp_force(force)?;
        let (on, about) = (byorp.lock.on, byorp.lock.about);
        let [force, torque] = byorp.jump(snapshot);
        Some(SwitchJump { on, about, force, torque, gradient: byorp.lock.gradient(snapshot)? })
    }

    /// Switches a force.
    pub fn switch(&mut self, force: usize) {
        if let Some(ForceTerm { kind: ForceTermKind::Byorp(byorp), .. }) = self.terms.get_mut(force) {
            byorp.switch();
        }
    }

    /// Returns the name of a force.
    pub fn name(&self, force: usize) -> &str {
        &self.terms[force].name
    }

    fn byorp_force(&self, force: usize) -> Option<&byorp::ByorpForce> {
        self.terms.get(force)?.byorp()
    }

    /// Restores what [`Self::switches`] returned.
    pub fn set_switches(&mut self, switches: &[Option<Switch>]) -> Result<()> {
        if switches.len() != self.terms.len() {
            return Err(Error::invalid("number of switches", switches.len(), self.terms.len().to_string()));
        }
        for (term, switch) in self.terms.iter_mut().zip(switches) {
            if let (ForceTermKind::Byorp(byorp), Some(switch)) = (&mut term.kind, switch) {
                byorp.state = Some(*switch);
            }
        }
        Ok(())
    }

    /// Computes the loads at a snapshot, and passes those of each force to `to` as soon as they are known.
    /// Allocates nothing. Components that a force never has stay zero.
    #[inline(always)]
    pub fn load<S: Simd>(&mut self, simd: S, snapshot: MotionSnapshot, to: &mut impl LoadSink) -> Result<()> {
        for ForceTerm { name, kind } in &mut self.terms {
            with!(kind, force => {
                force.load(simd, name, snapshot)?;
                to.take(force.loads());
            });
        }
        Ok(())
    }

    /// Adds the derivatives of the loads at the snapshot for which [`Self::load`] was called last. Allocates
    /// nothing.
    pub fn add_jacobian(&mut self, snapshot: MotionSnapshot, jacobian: &mut LoadJacobian) -> Result<()> {
        let mut terms = self.terms.iter_mut();
        terms.try_for_each(
            |term| with!(&mut term.kind, force => force.add_jacobian(&term.name, snapshot, jacobian)),
        )
    }

    /// Returns the derivatives of the loads of third bodies on a body with respect to its semi-axes, at a
    /// fixed mass: force, inertial, and torque, in its frame.
    pub fn semi_axis_derivatives(
        &mut self,
        snapshot: MotionSnapshot,
        body: usize,
        attraction: &mut ExtendedAttraction,
    ) -> Result<[[Vec3; 2]; 3]> {
        let mut sums = [[Vec3::zeros(); 2]; 3];
        for third in self.terms.iter_mut().filter_map(ForceTerm::third_body_mut) {
            third.semi_axis_derivatives(snapshot, body, attraction, &mut sums)?;
        }
        Ok(sums)
    }

    /// Returns whether there is a third body.
    pub fn has_third_body(&self) -> bool {
        self.third_bodies().next().is_some()
    }

    /// Passes the derivative of a force's loads with respect to one of its numbers to the sink, at the
    /// snapshot of the last [`Self::load`]. Allocates nothing.
    pub fn by_parameter(
        &mut self,
        snapshot: MotionSnapshot,
        force: usize,
        parameter: ForceParameter,
        gravitational_constant: f64,
        to: &mut impl FnMut(&Load, f64),
    ) -> Result<()> {
        let ForceTerm { name, kind } = &mut self.terms[force];
        with!(kind, force => force.by_parameter(name, snapshot, parameter, gravitational_constant, to))
    }

    /// Passes the derivative of a third body's loads along a change of the mu of its orbit to the sink. `by`
    /// is the change of G times the masses of the system; the mu of a third body that is given by its mass
    /// changes by `of_g` times itself.
    pub fn by_total_mu(
        &mut self,
        snapshot: MotionSnapshot,
        force: usize,
        by: f64,
        of_g: f64,
        to: &mut impl FnMut(&Load, f64),
    ) -> Result<()> {
        let ForceTerm { name, kind: ForceTermKind::ThirdBody(attraction) } = &mut self.terms[force] else {
            return Ok(());
        };
        if by != 0.0 {
            let by = by + if attraction.by_mass { of_g * attraction.mu } else { 0.0 };
            let (position, derivatives) = attraction.path_derivatives(snapshot.time)?;
            let moved = attraction.along(name, snapshot, position, &(derivatives[7] * by))?;
            moved.iter().for_each(|load| to(load, 1.0));
        }
        Ok(())
    }

    /// Computes the derivatives of the loads of third bodies on a body whose own field changes while its mass
    /// stays the same: of the force, inertial, and of the torque, body frame.
    pub fn by_change(
        &mut self,
        snapshot: MotionSnapshot,
        body: usize,
        change: &BodyChange,
    ) -> Result<[Vec3; 2]> {
        let mut sums = [Vec3::zeros(); 2];
        for attraction in self.terms.iter_mut().filter_map(ForceTerm::third_body_mut) {
            let moved = attraction.by_change(snapshot, body, change)?;
            (0..2).for_each(|k| sums[k] += moved[k]);
        }
        Ok(sums)
    }

    /// Returns the number of forces.
    pub fn count(&self) -> usize {
        self.terms.len()
    }

    /// Returns the powers of G and of a body's mass to which a force's loads on another body are
    /// proportional, at a fixed path of a third body.
    pub fn powers(&self, force: usize, mass_of: usize, on: usize) -> [f64; 2] {
        with!(&self.terms[force].kind, force => force.powers(mass_of, on))
    }

    /// Returns the rates of work, impulse and angular impulse of a force on the whole system: power, force
    /// and torque about the origin of the coordinates. The loads are those that [`Self::load`] has computed
    /// last; velocities and spins may differ from that snapshot.
    #[inline(always)]
    pub fn work_and_impulse_rates(&self, snapshot: MotionSnapshot, force: usize) -> [f64; WORK_AND_IMPULSE] {
        let (mut power, mut total, mut moment) = (0.0, Vec3::zeros(), Vec3::zeros());
        for load in self.terms[force].loads() {
            let of = |vectors: &[[f64; 3]]| Vec3::from(vectors[load.on]);
            power += load.force.dot(&of(snapshot.velocity));
            total += load.force;
            moment += of(snapshot.position).cross(&load.force);
            if load.can_rotate {
                power += load.torque.dot(&of(snapshot.spin));
                moment += rotate(&snapshot.rotation[load.on], &load.torque);
            }
        }
        let [position, velocity] = [0, 1].map(|k| snapshot.nominal[k] + snapshot.barycentre_offset[k]);
        power += total.dot(&velocity);
        moment += position.cross(&total);
        [power, total.x, total.y, total.z, moment.x, moment.y, moment.z]
    }

    /// Returns the third bodies in the form in which they act on particles.
    pub fn on_points(&self) -> Vec<PointAttraction> {
        self.third_bodies().map(|(name, attraction)| PointAttraction::new(name, attraction)).collect()
    }

    /// Returns position and velocity of a third body relative to the nominal barycentre at a time.
    pub fn third_body(&self, force: usize, time: f64) -> Result<(Vec3, Vec3)> {
        let (name, attraction) = self.attraction(force)?;
        attraction.covers(name, time, time)?;
        attraction.position_and_velocity(time)
    }

    /// Returns an error for the index of a force that is not a third body.
    pub fn expect_third_body(&self, force: usize) -> Result<()> {
        self.attraction(force).map(drop)
    }

    fn attraction(&self, force: usize) -> Result<(&str, &third_body::ThirdBodyAttraction)> {
        let attraction =
            self.terms.get(force).and_then(|term| Some((term.name.as_str(), term.third_body()?)));
        attraction.ok_or_else(|| Error::invalid("a third body", force, "the index of one among the forces"))
    }

    /// Iterates over the third bodies with their names.
    fn third_bodies(&self) -> impl Iterator<Item = (&str, &third_body::ThirdBodyAttraction)> {
        self.terms.iter().filter_map(|term| Some((term.name.as_str(), term.third_body()?)))
    }
}
