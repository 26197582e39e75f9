//! The forces of a system as terms of a sum, and their books.

use super::{
    Force, Load, LoadSlopes, PointPull, Scene, Switch, TakeLoads, function, radiation, third_body, tide,
};
use crate::error::{Error, Result};
use crate::gravity::ExtendedPull;
use crate::math::Vec3;
use crate::math::rotation::turned;
use crate::shape::Body;
use pulp::Simd;

/// Numbers of a force in the books: work, impulse, angular impulse.
pub const BOOK: usize = 7;

/// The forces of a system, ready for computing.
#[derive(Debug, Clone)]
pub struct Environment {
    terms: Vec<Term>,
    wants_attitudes: bool,
}

#[derive(Debug, Clone)]
struct Term {
    name: String,
    law: Law,
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
    /// What it did at the last scene to the bodies that it acts on.
    #[inline(always)]
    fn loads(&self) -> &[Load] {
        match self {
            Self::ThirdBody(pull) => &pull.loads,
            Self::Tide(tide) => &tide.loads,
            Self::Yorp(turn) => &turn.loads,
            Self::Byorp(push) => &push.loads,
            Self::Function(called) => &called.loads,
        }
    }
}

impl Environment {
    /// The forces on bodies.
    pub fn new(forces: &[Force], bodies: &[Body], gravitational_constant: f64) -> Result<Self> {
        let mut terms = Vec::<Term>::new();
        for (of, force) in forces.iter().enumerate() {
            let name = force.name().to_owned();
            if terms.iter().any(|term| term.name == name) {
                return Err(Error::invalid("name of a force", format!("{name:?} twice"), "distinct names"));
            }
            let law = match force {
                Force::ThirdBody(force) => Law::ThirdBody(force.ready(of, bodies, gravitational_constant)?),
                Force::Tide(force) => Law::Tide(force.ready(of, bodies, gravitational_constant)?),
                Force::Yorp(force) => Law::Yorp(force.ready(of, bodies)?),
                Force::Byorp(force) => Law::Byorp(force.ready(of, bodies, gravitational_constant)?),
                Force::Function(force) => Law::Function(force.ready(of, bodies)?),
            };
            terms.push(Term { name, law });
        }
        let wants_attitudes = terms.iter().any(|term| matches!(term.law, Law::Function(_)));
        Ok(Self { terms, wants_attitudes })
    }

    /// What the forces did at the last scene, one force after the other.
    #[inline]
    pub fn loads(&self) -> impl Iterator<Item = &Load> {
        self.terms.iter().flat_map(|term| term.law.loads())
    }

    /// Whether a force needs the attitudes as quaternions.
    #[inline]
    pub fn wants_attitudes(&self) -> bool {
        self.wants_attitudes
    }

    /// Units of work of an evaluation, for [`crate::patience::Patience`].
    pub fn work(&self) -> u64 {
        let of = |term: &Term| match &term.law {
            Law::ThirdBody(_) => 8 * term.law.loads().len() as u64,
            Law::Tide(_) | Law::Yorp(_) | Law::Byorp(_) => 4,
            // One that is written in Python takes some ten microseconds.
            Law::Function(_) => 1000,
        };
        self.terms.iter().map(of).sum()
    }

    /// Refuses a run from a scene that leaves the times for which a force is given, and third bodies that come inside the system.
    pub fn check(&mut self, scene: Scene, to: f64) -> Result<()> {
        for Term { name, law } in &mut self.terms {
            if let Law::ThirdBody(pull) = law {
                pull.check(name, to, scene)?;
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
    pub fn switch(&mut self, scene: Scene, step: f64) -> Result<()> {
        for Term { name, law } in &mut self.terms {
            match law {
                Law::Byorp(push) => push.switch(scene),
                Law::Yorp(turn) => turn.check(name, scene, step)?,
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

    /// Computes the loads at a scene, and gives those of each force away as soon as they are there. Allocates nothing. What a force
    /// never does stays zero from the beginning.
    #[inline(always)]
    pub fn load<S: Simd>(&mut self, simd: S, scene: Scene, to: &mut impl TakeLoads) -> Result<()> {
        for Term { name, law } in &mut self.terms {
            match law {
                Law::ThirdBody(pull) => {
                    pull.load(simd, name, scene)?;
                    to.take(&pull.loads);
                }
                Law::Tide(tide) => {
                    tide.load(scene);
                    to.take(&tide.loads);
                }
                Law::Yorp(turn) => {
                    turn.load(scene);
                    to.take(&turn.loads);
                }
                Law::Byorp(push) => {
                    push.load(scene);
                    to.take(&push.loads);
                }
                Law::Function(called) => {
                    called.load(name, scene)?;
                    to.take(&called.loads);
                }
            }
        }
        Ok(())
    }

    /// Adds the derivatives of the loads that [`Self::load`] has computed last, at that scene. Allocates nothing.
    pub fn slopes(&mut self, scene: Scene, slopes: &mut LoadSlopes) -> Result<()> {
        for Term { name, law } in &mut self.terms {
            match law {
                Law::ThirdBody(pull) => pull.slopes(name, scene, slopes)?,
                Law::Tide(tide) => tide.slopes(scene, slopes),
                Law::Yorp(turn) => turn.slopes(name, scene, slopes)?,
                Law::Byorp(push) => push.slopes(scene, slopes),
                Law::Function(_) => {
                    let expected = "a system without it: a function does not tell its derivatives";
                    return Err(Error::invalid("derivatives", format!("of the function {name}"), expected));
                }
            }
        }
        Ok(())
    }

    /// The derivatives of what third bodies do to a body by its semi-axes, at its mass: force, inertial, and torque, in its frame.
    pub fn by_axes(&mut self, scene: Scene, body: usize, pull: &mut ExtendedPull) -> Result<[[Vec3; 2]; 3]> {
        let mut sums = [[Vec3::zeros(); 2]; 3];
        for Term { law, .. } in &mut self.terms {
            if let Law::ThirdBody(third) = law {
                third.by_axes(scene, body, pull, &mut sums)?;
            }
        }
        Ok(sums)
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

    /// Power, force and torque about the origin of the coordinates that a force has of the whole system, of the loads that
    /// [`Self::load`] has computed last; velocities and spins may be others than at that scene.
    #[inline(always)]
    pub fn book(&self, scene: Scene, force: usize) -> [f64; BOOK] {
        let (mut power, mut total, mut moment) = (0.0, Vec3::zeros(), Vec3::zeros());
        for load in self.terms[force].law.loads() {
            let of = |vectors: &[[f64; 3]]| Vec3::from(vectors[load.on]);
            power += load.force.dot(&of(scene.velocity));
            total += load.force;
            moment += of(scene.position).cross(&load.force);
            if load.turns {
                power += load.torque.dot(&of(scene.spin));
                moment += turned(&scene.rotation[load.on], &load.torque);
            }
        }
        let [place, motion] = [0, 1].map(|k| scene.nominal[k] + scene.departure[k]);
        power += total.dot(&motion);
        moment += place.cross(&total);
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
            Some(Term { name, law: Law::ThirdBody(pull) }) => Ok((name, pull)),
            _ => Err(Error::invalid("a third body", force, "the place of one among the forces")),
        }
    }
}
