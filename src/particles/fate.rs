//! Particles, and what may become of them.

use crate::error::{Error, Result, require_finite, require_positive};
use crate::integrate::{Controller, Tableau, Tolerance};
use crate::math::Vec3;

/// The largest number of a particle's start. The search for contact takes fourth powers, which stay doubles on the way.
const LARGEST: f64 = 1e60;

/// A particle with larger numbers is lost: fourth powers overflow soon.
pub(super) const BEYOND: f64 = 1e75;

/// What has become of a particle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Fate {
    /// It flies on.
    #[default]
    Flying,
    /// It has struck a body, which ended its flight.
    Impact,
    /// It has left, as [`Escape`] says.
    Escape,
    /// It lies on a body.
    Rest,
    /// Its motion cannot be followed: it has come too near to a point mass, or has gone so far that powers of the distance overflow.
    Lost,
}

impl Fate {
    /// All of them, in the order of their numbers.
    pub const ALL: [(&'static str, Self); 5] = [
        ("flying", Self::Flying),
        ("impact", Self::Impact),
        ("escape", Self::Escape),
        ("rest", Self::Rest),
        ("lost", Self::Lost),
    ];
}

/// What happens where a particle meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contact {
    /// Its flight ends, and it stays where it struck.
    Stop,
    /// Its flight ends, and it is gone.
    Remove,
    /// It flies on, with the velocity relative to the surface times these.
    Bounce {
        /// Along the normal, from 0 to 1.
        normal: f64,
        /// Across it, from 0 to 1.
        tangential: f64,
        /// Where it leaves the surface more slowly than this along the normal it comes to rest: sliding is not modelled.
        rest: f64,
    },
}

impl Contact {
    /// Refuses numbers that mean nothing.
    pub fn check(&self) -> Result<()> {
        let Self::Bounce { normal, tangential, rest } = *self else { return Ok(()) };
        for (what, value) in [("normal of Bounce", normal), ("tangential of Bounce", tangential)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(Error::invalid(what, value, "a number from 0 to 1"));
            }
        }
        require_positive("rest of Bounce", rest)
    }
}

/// When a particle has left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Escape {
    /// It is further from the barycentre.
    pub distance: f64,
    /// Whether its energy about a point of the system's mass has to be positive as well.
    pub unbound: bool,
}

impl Escape {
    /// Refuses distances that mean nothing.
    pub fn check(&self) -> Result<()> {
        require_positive("distance of Escape", self.distance)
    }

    /// Rises through zero at the escape.
    pub fn value(&self, mu: f64, position: &Vec3, velocity: &Vec3) -> f64 {
        let distance = position.norm();
        let far = distance / self.distance - 1.0;
        if self.unbound { far.min(distance * velocity.norm_squared() / (2.0 * mu) - 1.0) } else { far }
    }
}

/// How particles fly.
#[derive(Debug, Clone)]
pub struct Rules {
    /// The pair.
    pub tableau: &'static Tableau,
    /// Errors of a step: of the position relative to the distance from the nearest centre, of the velocity relative to
    /// sqrt(v^2 + Phi), Phi the potential of the bodies' masses in their centres.
    pub tolerance: Tolerance,
    /// What happens at a surface.
    pub contact: Contact,
    /// When a particle has left.
    pub escape: Option<Escape>,
}

/// Where a particle is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// In flight; `departing` from a surface.
    Flying { departing: bool },
    /// On a body, at a place of its frame, on a part of it; `held` for good, or until it lifts off.
    On { body: usize, place: Vec3, normal: Vec3, held: bool },
    /// Nowhere.
    Gone,
}

/// A particle.
#[derive(Debug, Clone, PartialEq)]
pub struct Particle {
    /// Time to which it has come.
    pub time: f64,
    /// Position from the nominal barycentre, velocity relative to it.
    pub motion: [f64; 6],
    /// What rounding dropped of them.
    pub low: [f64; 6],
    /// Area-to-mass ratio.
    pub area_to_mass: f64,
    pub(super) place: Place,
    /// Planned size of the next step; zero before the first.
    pub(super) next: f64,
    pub(super) controller: Controller,
    /// Distance and speed at the start that errors are measured against.
    pub(super) scales: Option<[f64; 2]>,
    /// Outputs so far.
    pub(super) recorded: usize,
    /// What has become of it, when, and on which body.
    pub end: End,
    /// How often it has struck a surface.
    pub strikes: u32,
}

/// The end of a particle's flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// What it was.
    pub fate: Fate,
    /// When.
    pub time: f64,
    /// On which body.
    pub body: Option<usize>,
    /// Longitude and latitude of the place in the body frame.
    pub longitude: f64,
    /// See [`Self::longitude`].
    pub latitude: f64,
    /// Speed relative to the surface.
    pub speed: f64,
    /// Angle between the path and the normal.
    pub incidence: f64,
}

impl Default for End {
    fn default() -> Self {
        let none = f64::NAN;
        Self {
            fate: Fate::Flying,
            time: none,
            body: None,
            longitude: none,
            latitude: none,
            speed: none,
            incidence: none,
        }
    }
}

impl Particle {
    /// At a place and with a velocity from the nominal barycentre.
    pub fn new(time: f64, position: &Vec3, velocity: &Vec3, area_to_mass: f64) -> Self {
        let (x, v) = (position, velocity);
        Self {
            time,
            motion: [x.x, x.y, x.z, v.x, v.y, v.z],
            low: [0.0; 6],
            area_to_mass,
            place: Place::Flying { departing: false },
            next: 0.0,
            controller: Controller::new(),
            scales: None,
            recorded: 0,
            end: End::default(),
            strikes: 0,
        }
    }

    /// Refuses numbers that are not finite or out of range, naming the particle.
    pub fn check(&self, index: usize) -> Result<()> {
        let ratio = [self.area_to_mass];
        let named =
            [("position", &self.motion[..3]), ("velocity", &self.motion[3..]), ("area_to_mass", &ratio)];
        for (name, values) in named {
            let what = format!("{name} of particle {index}");
            require_finite(&what, values)?;
            if let Some(&value) = values.iter().find(|value| value.abs() > LARGEST) {
                let expected =
                    format!("at most {LARGEST:e} in size; choose units that keep the numbers in range");
                return Err(Error::invalid(what, value, expected));
            }
        }
        if self.area_to_mass < 0.0 {
            let what = format!("area_to_mass of particle {index}");
            return Err(Error::invalid(what, self.area_to_mass, "zero or more"));
        }
        Ok(())
    }

    /// Position from the nominal barycentre.
    pub fn position(&self) -> Vec3 {
        Vec3::new(self.motion[0], self.motion[1], self.motion[2])
    }

    /// Velocity relative to it.
    pub fn velocity(&self) -> Vec3 {
        Vec3::new(self.motion[3], self.motion[4], self.motion[5])
    }

    /// Places it anew.
    pub(super) fn put(&mut self, time: f64, position: &Vec3, velocity: &Vec3) {
        self.time = time;
        self.motion = [position.x, position.y, position.z, velocity.x, velocity.y, velocity.z];
        self.low = [0.0; 6];
    }
}
