//! The world around a system: forces and torques that its bodies do not have from each other.
//!
//! Takes where the bodies are at a time; gives each force's loads on every body. A [`Force`] describes one, for archives and the
//! Python package; an [`Environment`] has them ready for computing.
//!
//! Places are seen from the system's *nominal* barycentre: where its barycentre would be without these forces, moving uniformly
//! in the coordinates of the states. A third body's position is given from there, and the coordinates fall with the nominal
//! barycentre in the third body's gravity. What a third body does in them is thus the difference of its pulls on a body and on
//! the nominal barycentre.

mod function;
mod radiation;
mod third_body;
mod tide;

pub use function::{Call, ForceFunction, Function};
pub use radiation::{Byorp, Yorp};
pub use third_body::{Path, ThirdBody, WhoseOrbit};
pub use tide::Tide;

use crate::error::{Error, Refusal, Result};
use crate::math::{Mat3, Vec3};
use crate::shape::Body;
use serde::{Deserialize, Serialize};

/// One force from outside, or one that the bodies have from each other beside gravity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", deny_unknown_fields)]
pub enum Force {
    /// The gravity of a point mass on a prescribed path.
    ThirdBody(ThirdBody),
    /// A tide of constant time lag.
    Tide(Tide),
    /// The torque of radiation on a body.
    Yorp(Yorp),
    /// The force of radiation on a synchronous secondary.
    Byorp(Byorp),
    /// A caller's function.
    Function(Function),
}

impl Force {
    /// The name, which is its own among the forces of a system.
    pub fn name(&self) -> &str {
        match self {
            Self::ThirdBody(force) => &force.name,
            Self::Tide(force) => &force.name,
            Self::Yorp(force) => &force.name,
            Self::Byorp(force) => &force.name,
            Self::Function(force) => &force.name,
        }
    }

    /// Whether it depends on velocities or spins.
    pub fn depends_on_velocity(&self) -> bool {
        match self {
            Self::ThirdBody(_) => false,
            Self::Tide(_) | Self::Yorp(_) | Self::Byorp(_) => true,
            Self::Function(force) => force.depends_on_velocity,
        }
    }
}

/// The bodies at a time, as forces see them.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Time.
    pub time: f64,
    /// Centres from the nominal barycentre, inertial axes.
    pub position: Vec<Vec3>,
    /// Their velocities relative to it.
    pub velocity: Vec<Vec3>,
    /// Attitudes.
    pub attitude: Vec<[f64; 4]>,
    /// The same as matrices from body frames to inertial axes.
    pub rotation: Vec<Mat3>,
    /// Spins, body frames.
    pub spin: Vec<Vec3>,
    /// The nominal barycentre in the coordinates of the states.
    pub origin: Vec3,
    /// Its velocity.
    pub origin_velocity: Vec3,
}

impl Scene {
    /// Of so many bodies.
    pub fn new(bodies: usize) -> Self {
        let zeros = vec![Vec3::zeros(); bodies];
        Self {
            position: zeros.clone(),
            velocity: zeros.clone(),
            attitude: vec![[1.0, 0.0, 0.0, 0.0]; bodies],
            rotation: vec![Mat3::identity(); bodies],
            spin: zeros,
            ..Self::default()
        }
    }

    /// Position and velocity of a body relative to another.
    fn relative(&self, body: usize, about: usize) -> (Vec3, Vec3) {
        (self.position[body] - self.position[about], self.velocity[body] - self.velocity[about])
    }

    /// Angular velocity of a body, inertial axes.
    fn inertial_spin(&self, body: usize) -> Vec3 {
        self.rotation[body] * self.spin[body]
    }
}

/// What one force does to the bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Loads {
    /// Forces, inertial.
    pub force: Vec<Vec3>,
    /// Torques about the bodies' centres, body frames.
    pub torque: Vec<Vec3>,
}

/// Numbers of a force in the books: work, impulse, angular impulse.
pub const BOOK: usize = 7;

/// The forces of a system, ready for computing.
#[derive(Debug, Clone)]
pub struct Environment {
    terms: Vec<Term>,
    /// The bodies at the place in question.
    pub scene: Scene,
    loads: Vec<Loads>,
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

impl Environment {
    /// The forces on bodies.
    pub fn new(forces: &[Force], bodies: &[Body], gravitational_constant: f64) -> Result<Self> {
        let mut terms: Vec<Term> = Vec::new();
        for force in forces {
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
            terms.push(Term { name, law });
        }
        let none =
            Loads { force: vec![Vec3::zeros(); bodies.len()], torque: vec![Vec3::zeros(); bodies.len()] };
        Ok(Self { loads: vec![none; terms.len()], scene: Scene::new(bodies.len()), terms })
    }

    /// Number of forces.
    pub fn len(&self) -> usize {
        self.terms.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// What every force does at the scene, by its place in the list.
    pub fn loads(&self) -> &[Loads] {
        &self.loads
    }

    /// Units of work of an evaluation, for [`crate::patience::Patience`].
    pub fn work(&self) -> u64 {
        let of = |term: &Term| match &term.law {
            Law::ThirdBody(_) => 8 * self.scene.position.len() as u64,
            Law::Tide(_) | Law::Yorp(_) | Law::Byorp(_) => 4,
            // One that is written in Python takes some ten microseconds.
            Law::Function(_) => 1000,
        };
        self.terms.iter().map(of).sum()
    }

    /// Refuses a run that leaves the times for which a force is given, and third bodies that come inside the system.
    pub fn check(&mut self, from: f64, to: f64) -> Result<()> {
        for Term { name, law } in &mut self.terms {
            if let Law::ThirdBody(pull) = law {
                pull.check(name, from, to, &self.scene)?;
            }
        }
        Ok(())
    }

    /// Decides at the start of a step what is switched on in it.
    pub fn switch(&mut self) {
        for Term { law, .. } in &mut self.terms {
            if let Law::Byorp(push) = law {
                push.switch(&self.scene);
            }
        }
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

    /// Computes the loads at the scene. Allocates nothing.
    pub fn load(&mut self) -> std::result::Result<(), Refusal> {
        for (Term { name, law }, loads) in self.terms.iter_mut().zip(&mut self.loads) {
            loads.force.fill(Vec3::zeros());
            loads.torque.fill(Vec3::zeros());
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

    /// Power, force and torque about the origin that a force has of the whole system, for velocities relative to the nominal
    /// barycentre and spins that may differ from the scene's.
    pub fn book(&self, force: usize, velocity: &[Vec3], spin: &[Vec3], out: &mut [f64]) {
        let (scene, loads) = (&self.scene, &self.loads[force]);
        let (mut power, mut total, mut moment) = (0.0, Vec3::zeros(), Vec3::zeros());
        for body in 0..velocity.len() {
            let (f, m) = (&loads.force[body], &loads.torque[body]);
            power += f.dot(&(scene.origin_velocity + velocity[body])) + m.dot(&spin[body]);
            total += f;
            moment += scene.position[body].cross(f) + scene.rotation[body] * m;
        }
        moment += scene.origin.cross(&total);
        out[0] = power;
        out[1..4].copy_from_slice(total.as_slice());
        out[4..7].copy_from_slice(moment.as_slice());
    }

    /// The times between which all forces are given.
    pub fn span(&self) -> (f64, f64) {
        self.terms.iter().fold((f64::NEG_INFINITY, f64::INFINITY), |(first, last), term| match &term.law {
            Law::ThirdBody(pull) => (first.max(pull.span().0), last.min(pull.span().1)),
            _ => (first, last),
        })
    }

    /// Refuses a time for which a third body's path is not given.
    pub fn covers(&self, force: usize, time: f64) -> Result<()> {
        crate::error::require_finite("time", &[time])?;
        match self.terms.get(force) {
            Some(Term { name, law: Law::ThirdBody(pull) }) => pull.covers(name, time, time),
            _ => Ok(()),
        }
    }

    /// Position and velocity of a third body from the nominal barycentre at a time.
    pub fn third_body(&self, force: usize, time: f64) -> Result<(Vec3, Vec3)> {
        match self.terms.get(force).map(|term| &term.law) {
            Some(Law::ThirdBody(pull)) => pull.place(time),
            _ => Err(Error::invalid("a third body", force, "the place of one among the forces")),
        }
    }
}

/// Whether a force acts, and how often it has been switched off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Switch {
    /// Whether it acts.
    pub on: bool,
    /// How often it was switched off.
    pub times: u64,
}

/// The place of a body that a force names.
fn place(force: &str, role: &str, name: &str, bodies: &[Body]) -> Result<usize> {
    bodies.iter().position(|body| body.name == name).ok_or_else(|| {
        let names: Vec<_> = bodies.iter().map(|body| body.name.as_str()).collect();
        Error::invalid(format!("{role} of {force}"), format!("{name:?}"), format!("one of {names:?}"))
    })
}

/// The place of a body that a force turns.
fn place_to_turn(force: &str, role: &str, name: &str, bodies: &[Body]) -> Result<usize> {
    let at = place(force, role, name, bodies)?;
    if bodies[at].inertia() == Vec3::zeros() {
        let expected = "a body with extent, which a torque can turn";
        return Err(Error::invalid(format!("{role} of {force}"), format!("the point {name}"), expected));
    }
    Ok(at)
}

/// Two places of bodies that a force names.
fn two_places(
    force: &str,
    [first_role, second_role]: [&str; 2],
    [first, second]: [&str; 2],
    bodies: &[Body],
) -> Result<(usize, usize)> {
    let (i, j) = (place(force, first_role, first, bodies)?, place(force, second_role, second, bodies)?);
    if i == j {
        let what = format!("{first_role} and {second_role} of {force}");
        return Err(Error::invalid(what, format!("{first:?} twice"), "two bodies"));
    }
    Ok((i, j))
}
