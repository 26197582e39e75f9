//! The forces of a system as terms of a sum, and their books.

use super::{Force, Load, LoadSlopes, PointPull, Scene, Switch, function, radiation, third_body, tide};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::math::rotation::turned;
use crate::shape::Body;
use std::ops::Range;

/// Numbers of a force in the books: work, impulse, angular impulse.
pub const BOOK: usize = 7;

/// The forces of a system, ready for computing.
#[derive(Debug, Clone)]
pub struct Environment {
    terms: Vec<Term>,
    /// The bodies at the place in question.
    pub scene: Scene,
    /// What the terms do, one after the other.
    loads: Vec<Load>,
    wants_attitudes: bool,
}

#[derive(Debug, Clone)]
struct Term {
    name: String,
    law: Law,
    /// Its part of all loads.
    loads: Range<usize>,
}

#[derive(Debug, Clone)]
enum Law {
    ThirdBody(third_body::Pull),
    Tide(tide::Lagging),
    Yorp(radiation::Turning),
    Byorp(radiation::Pushing),
    Function(function::Called),
}

impl Law {
    /// Places of the bodies that it acts on, in the order in which it gives their loads, and whether it ever turns them.
    fn acts_on(&self, bodies: &[Body]) -> Vec<(usize, bool)> {
        match self {
            Self::ThirdBody(pull) => pull.turns().enumerate().collect(),
            Self::Tide(tide) => vec![(tide.on, true), (tide.by, false)],
            Self::Yorp(turn) => vec![(turn.on, true)],
            Self::Byorp(push) => vec![(push.on, false)],
            Self::Function(_) => (0..bodies.len()).map(|body| (body, true)).collect(),
        }
    }
}

impl Environment {
    /// The forces on bodies.
    pub fn new(forces: &[Force], bodies: &[Body], gravitational_constant: f64) -> Result<Self> {
        let (mut terms, mut loads) = (Vec::<Term>::new(), Vec::new());
        for (of, force) in forces.iter().enumerate() {
            let name = force.name().to_owned();
            if terms.iter().any(|term| term.name == name) {
                return Err(Error::invalid("name of a force", format!("{name:?} twice"), "distinct names"));
            }
            let law = match force {
                Force::ThirdBody(force) => Law::ThirdBody(force.ready(bodies, gravitational_constant)?),
                Force::Tide(force) => Law::Tide(force.ready(bodies, gravitational_constant)?),
                Force::Yorp(force) => Law::Yorp(force.ready(bodies)?),
                Force::Byorp(force) => Law::Byorp(force.ready(bodies, gravitational_constant)?),
                Force::Function(force) => Law::Function(force.ready(bodies)?),
            };
            let first = loads.len();
            let none = |(on, turns)| Load { of, on, force: Vec3::zeros(), torque: Vec3::zeros(), turns };
            loads.extend(law.acts_on(bodies).into_iter().map(none));
            terms.push(Term { name, law, loads: first..loads.len() });
        }
        let wants_attitudes = terms.iter().any(|term| matches!(term.law, Law::Function(_)));
        Ok(Self { terms, scene: Scene::new(bodies.len()), loads, wants_attitudes })
    }

    /// What the forces do at the scene, one force after the other.
    #[inline]
    pub fn loads(&self) -> &[Load] {
        &self.loads
    }

    /// Whether a force needs the attitudes as quaternions.
    #[inline]
    pub fn wants_attitudes(&self) -> bool {
        self.wants_attitudes
    }

    /// Units of work of an evaluation, for [`crate::patience::Patience`].
    pub fn work(&self) -> u64 {
        let of = |term: &Term| match &term.law {
            Law::ThirdBody(_) => 8 * self.scene.bodies.len() as u64,
            Law::Tide(_) | Law::Yorp(_) | Law::Byorp(_) => 4,
            // One that is written in Python takes some ten microseconds.
            Law::Function(_) => 1000,
        };
        self.terms.iter().map(of).sum()
    }

    /// Refuses a run that leaves the times for which a force is given, and third bodies that come inside the system.
    pub fn check(&mut self, from: f64, to: f64) -> Result<()> {
        for Term { name, law, .. } in &mut self.terms {
            if let Law::ThirdBody(pull) = law {
                pull.check(name, from, to, &self.scene)?;
            }
        }
        Ok(())
    }

    /// Where a step from a time towards another has to end, for every force to be given all along it.
    pub fn reach(&self, from: f64, to: f64) -> f64 {
        let ends = self.terms.iter().filter_map(|term| match &term.law {
            Law::ThirdBody(pull) => Some(pull.span()),
            _ => None,
        });
        ends.fold(to, |to, (first, last)| if to < from { to.max(first) } else { to.min(last) })
    }

    /// Decides at the start of a step what is switched on in it. Refuses a step in which a force loses its meaning.
    pub fn switch(&mut self, step: f64) -> Result<()> {
        for Term { name, law, .. } in &mut self.terms {
            match law {
                Law::Byorp(push) => push.switch(&self.scene),
                Law::Yorp(turn) => turn.check(name, &self.scene, step)?,
                _ => {}
            }
        }
        Ok(())
    }

    /// How often each force has been switched off, and whether it is: `None` for those that never are.
    pub fn switches(&self) -> Vec<Option<Switch>> {
        let of = |term: &Term| match &term.law {
            Law::Byorp(push) => Some(push.state),
            _ => None,
        };
        self.terms.iter().map(of).collect()
    }

    /// The inverse of [`Self::switches`].
    pub fn recall(&mut self, switches: &[Option<Switch>]) -> Result<()> {
        if switches.len() != self.terms.len() {
            return Err(Error::invalid("number of switches", switches.len(), self.terms.len().to_string()));
        }
        for (term, switch) in self.terms.iter_mut().zip(switches) {
            if let (Law::Byorp(push), Some(switch)) = (&mut term.law, switch) {
                push.state = *switch;
            }
        }
        Ok(())
    }

    /// Computes the loads at the scene. Allocates nothing. What a force never does stays zero from the beginning.
    #[inline(always)]
    pub fn load(&mut self) -> Result<()> {
        for Term { name, law, loads } in &mut self.terms {
            let loads = &mut self.loads[loads.clone()];
            match law {
                Law::ThirdBody(pull) => pull.load(name, &self.scene, loads)?,
                Law::Tide(tide) => tide.load(&self.scene, loads),
                Law::Yorp(turn) => turn.load(&self.scene, loads),
                Law::Byorp(push) => push.load(&self.scene, loads),
                Law::Function(called) => called.load(name, &self.scene, loads)?,
            }
        }
        Ok(())
    }

    /// Adds the derivatives of the loads that [`Self::load`] has computed last. Allocates nothing.
    pub fn slopes(&mut self, slopes: &mut LoadSlopes) -> Result<()> {
        for Term { name, law, .. } in &mut self.terms {
            match law {
                Law::ThirdBody(pull) => pull.slopes(name, &self.scene, slopes)?,
                Law::Tide(tide) => tide.slopes(&self.scene, slopes),
                Law::Yorp(turn) => turn.slopes(name, &self.scene, slopes)?,
                Law::Byorp(push) => push.slopes(&self.scene, slopes),
                Law::Function(_) => {
                    let expected = "a system without it: a function does not tell its derivatives";
                    return Err(Error::invalid("derivatives", format!("of the function {name}"), expected));
                }
            }
        }
        Ok(())
    }

    /// Whether a third body pulls.
    pub fn has_third_body(&self) -> bool {
        self.terms.iter().any(|term| matches!(term.law, Law::ThirdBody(_)))
    }

    /// The powers of G and of a body's mass that a force's loads on another body go with. The path of a third body stays as it is.
    pub fn powers(&self, force: usize, mass_of: usize, on: usize) -> [f64; 2] {
        match &self.terms[force].law {
            Law::ThirdBody(_) => [0.0, if mass_of == on { 1.0 } else { 0.0 }],
            Law::Tide(tide) => [1.0, if mass_of == tide.by { 2.0 } else { 0.0 }],
            Law::Yorp(_) | Law::Byorp(_) | Law::Function(_) => [0.0; 2],
        }
    }

    /// Power, force and torque about the origin that a force has of the whole system, for velocities relative to the nominal
    /// barycentre and spins that may differ from the scene's.
    #[inline(always)]
    pub fn book(&self, force: usize, motion: impl Fn(usize) -> (Vec3, Vec3)) -> [f64; BOOK] {
        let scene = &self.scene;
        let (mut power, mut total, mut moment) = (0.0, Vec3::zeros(), Vec3::zeros());
        for load in &self.loads[self.terms[force].loads.clone()] {
            let (body, (velocity, spin)) = (&scene.bodies[load.on], motion(load.on));
            power += load.force.dot(&velocity);
            total += load.force;
            moment += body.position.cross(&load.force);
            if load.turns {
                power += load.torque.dot(&spin);
                moment += turned(&body.rotation, &load.torque);
            }
        }
        power += total.dot(&scene.origin_velocity);
        moment += scene.origin.cross(&total);
        [power, total.x, total.y, total.z, moment.x, moment.y, moment.z]
    }

    /// The third bodies, as points among the system's bodies feel them.
    pub fn on_points(&self) -> Vec<PointPull> {
        let of = |term: &Term| match &term.law {
            Law::ThirdBody(pull) => Some(PointPull::new(&term.name, pull)),
            _ => None,
        };
        self.terms.iter().filter_map(of).collect()
    }

    /// Position and velocity of a third body from the nominal barycentre at a time.
    pub fn third_body(&self, force: usize, time: f64) -> Result<(Vec3, Vec3)> {
        let (name, pull) = self.pull(force)?;
        pull.covers(name, time, time)?;
        pull.place(time)
    }

    /// Refuses the place of a force that is not a third body.
    pub fn expect_third_body(&self, force: usize) -> Result<()> {
        self.pull(force).map(drop)
    }

    fn pull(&self, force: usize) -> Result<(&str, &third_body::Pull)> {
        match self.terms.get(force) {
            Some(Term { name, law: Law::ThirdBody(pull), .. }) => Ok((name, pull)),
            _ => Err(Error::invalid("a third body", force, "the place of one among the forces")),
        }
    }
}
