//! Particles, the rules of their flight, and their fates.

use crate::error::{Error, Result, require_finite, require_positive};
use crate::integrate::{Controller, Tableau, Tolerance, VERNER98};
use crate::math::Vec3;

/// The largest magnitude of a number at a particle's start. The search for contacts takes fourth powers,
/// which must stay doubles on the way.
pub const LARGEST: f64 = 1e60;

/// A particle with larger numbers is lost, since fourth powers overflow soon.
pub(super) const BEYOND: f64 = 1e75;

/// The fate of a particle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Fate {
    /// The particle is still flying.
    #[default]
    Flying,
    /// The particle has struck a body, which ended its flight.
    Impact,
    /// The particle has left the system, as [`Escape`] defines.
    Escape,
    /// The particle rests on a body.
    Rest,
    /// The motion of the particle cannot be integrated: it has come too near to a point mass, or has gone so
    /// far that powers of the distance overflow.
    Lost,
}

impl Fate {
    /// All fates with their names, in the order of their numbers.
    pub const ALL: [(&'static str, Self); 5] = [
        ("flying", Self::Flying),
        ("impact", Self::Impact),
        ("escape", Self::Escape),
        ("rest", Self::Rest),
        ("lost", Self::Lost),
    ];
}

/// What happens when a particle touches a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ContactResponse {
    /// The flight ends, and the particle stays where it struck.
    Stop,
    /// The flight ends, and the particle is removed.
    Remove,
    /// The particle flies on, with its velocity relative to the surface multiplied by these factors.
    Bounce {
        /// The factor along the normal, from 0 to 1.
        normal: f64,
        /// The factor perpendicular to the normal, from 0 to 1.
        tangential: f64,
        /// A particle that leaves the surface along the normal more slowly than this comes to rest: sliding
        /// is not modelled.
        rest: f64,
    },
}

impl ContactResponse {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a factor outside of 0 to 1, and a speed of rest that is not above zero.
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

/// The condition under which a particle has left the system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Escape {
    /// The least distance from the barycentre.
    pub distance: f64,
    /// Whether the energy relative to a point of the system's mass must be positive as well.
    pub unbound: bool,
}

impl Escape {
    /// Checks the distance.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a distance that is not a finite number above zero.
    pub fn check(&self) -> Result<()> {
        require_positive("distance of Escape", self.distance)
    }

    /// Returns a function that rises through zero at the escape.
    pub fn value(&self, mu: f64, position: &Vec3, velocity: &Vec3) -> f64 {
        let distance = position.norm();
        let far = distance / self.distance - 1.0;
        if self.unbound { far.min(distance * velocity.norm_squared() / (2.0 * mu) - 1.0) } else { far }
    }
}

/// The rules of a flight.
#[derive(Debug, Clone)]
pub struct Rules {
    /// The Runge-Kutta pair.
    pub tableau: &'static Tableau,
    /// The tolerance of a step: errors of the position are relative to the distance from the nearest centre,
    /// errors of the velocity to sqrt(v^2 + Phi), with Phi the potential of the bodies' masses in their
    /// centres.
    pub tolerance: Tolerance,
    /// What happens at a contact.
    pub contact: ContactResponse,
    /// The condition under which a particle has left the system, if there is one.
    pub escape: Option<Escape>,
}

impl Rules {
    /// Makes the rules of a flight by Verner's pair of orders 9 and 8, on which particles stop at a contact and
    /// never count as escaped.
    pub fn new(tolerance: Tolerance) -> Self {
        Self { tableau: &VERNER98, tolerance, contact: ContactResponse::Stop, escape: None }
    }
}

/// The status of a particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParticleStatus {
    /// The particle is in flight; `leaving` while it is still at the surface that it has left.
    Flying { leaving: bool },
    /// The particle is on a body, at a point of the body frame with this normal; it is `held` up to a time,
    /// and rests from then on until it lifts off.
    On { body: usize, point: Vec3, normal: Vec3, held: f64 },
    /// The particle has been removed.
    Gone,
}

/// A particle.
#[derive(Debug, Clone, PartialEq)]
pub struct Particle {
    /// The time that the particle has reached.
    pub time: f64,
    /// The position relative to the nominal barycentre, and the velocity.
    pub motion: [f64; 6],
    /// The low part of position and velocity.
    pub low: [f64; 6],
    /// The area-to-mass ratio.
    pub area_to_mass: f64,
    pub(super) status: ParticleStatus,
    /// The planned size of the next step; zero before the first.
    pub(super) next: f64,
    pub(super) controller: Controller,
    /// The distance and the speed at the start, against which errors are measured.
    pub(super) scales: Option<[f64; 2]>,
    /// The number of outputs so far.
    pub(super) recorded: usize,
    /// The fate of the particle, with its time and body.
    pub end: End,
    /// The number of contacts with surfaces.
    pub strikes: u32,
    /// The time at which the particle last left a surface, and how often in a row it returned at once.
    pub(super) left_at: f64,
    pub(super) returns: u32,
}

/// The end of a particle's flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// The fate of the particle.
    pub fate: Fate,
    /// The time at which the flight ended.
    pub time: f64,
    /// The index of the body, if there is one.
    pub body: Option<usize>,
    /// The longitude of the point in the body frame.
    pub longitude: f64,
    /// The latitude of the point in the body frame.
    pub latitude: f64,
    /// The speed relative to the surface.
    pub speed: f64,
    /// The angle between the path and the normal.
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
    /// Makes a particle from its position and velocity relative to the nominal barycentre.
    pub fn new(time: f64, position: &Vec3, velocity: &Vec3, area_to_mass: f64) -> Self {
        let (x, v) = (position, velocity);
        Self {
            time,
            motion: [x.x, x.y, x.z, v.x, v.y, v.z],
            low: [0.0; 6],
            area_to_mass,
            status: ParticleStatus::Flying { leaving: false },
            next: 0.0,
            controller: Controller::new(),
            scales: None,
            recorded: 0,
            end: End::default(),
            strikes: 0,
            left_at: f64::NEG_INFINITY,
            returns: 0,
        }
    }

    /// Checks the numbers of the particle with this index.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] names the particle and its number that is not finite or out of range.
    pub fn check(&self, index: usize) -> Result<()> {
        let ratio = [self.area_to_mass];
        let named = [
            ("position", &self.motion[..3]),
            ("velocity", &self.motion[3..]),
            ("low part of the motion", &self.low[..]),
            ("area_to_mass", &ratio[..]),
        ];
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

    /// Returns the position relative to the nominal barycentre.
    pub fn position(&self) -> Vec3 {
        Vec3::new(self.motion[0], self.motion[1], self.motion[2])
    }

    /// Returns the velocity relative to the nominal barycentre.
    pub fn velocity(&self) -> Vec3 {
        Vec3::new(self.motion[3], self.motion[4], self.motion[5])
    }

    /// Sets time, position and velocity anew.
    pub(super) fn set_motion(&mut self, time: f64, position: &Vec3, velocity: &Vec3) {
        self.time = time;
        self.motion = [position.x, position.y, position.z, velocity.x, velocity.y, velocity.z];
        self.low = [0.0; 6];
    }
}
