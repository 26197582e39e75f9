//! Events of particles.

use super::body_ephemeris::BodyEphemeris;
use super::external_forces::ExternalForces;
use super::surface::motion_at_fraction;
use crate::error::{Error, Result};
use crate::integrate::{SAMPLES, Segment, direction_matches, sample_fractions, zeros};
use crate::math::Vec3;
use std::fmt;

/// A user's function of time, position and velocity, in the coordinates of the states.
pub type ParticleFunction = dyn Fn(f64, &Vec3, &Vec3) -> Result<f64> + Sync;

/// The condition of an event of particles.
#[non_exhaustive]
pub enum ParticleCondition {
    /// The visible part of the source's disc passes through a value.
    Shadow {
        /// The value, between 0 and 1.
        visible: f64,
    },
    /// The particle is nearest to a body's centre: r . v rises through zero.
    Periapsis {
        /// The index of the body.
        body: usize,
    },
    /// A zero of a function.
    Function(Box<ParticleFunction>),
}

impl fmt::Debug for ParticleCondition {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shadow { visible } => formatter.debug_struct("Shadow").field("visible", visible).finish(),
            Self::Periapsis { body } => formatter.debug_struct("Periapsis").field("body", body).finish(),
            Self::Function(_) => formatter.debug_struct("Function").finish_non_exhaustive(),
        }
    }
}

/// A condition with the direction of the zeros that count: 1 rising along the flight, -1 falling, 0 both.
#[derive(Debug)]
pub struct ParticleEvent {
    /// The condition.
    pub condition: ParticleCondition,
    /// The direction.
    pub direction: i8,
}

/// An event that has happened to a particle.
#[derive(Debug, Clone, PartialEq)]
pub struct ParticleOccurrence {
    /// The index in the list of events.
    pub event: usize,
    /// The index of the particle.
    pub particle: usize,
    /// The time of the event.
    pub time: f64,
    /// The position relative to the nominal barycentre.
    pub position: Vec3,
    /// The velocity relative to the nominal barycentre.
    pub velocity: Vec3,
    /// Whether the function rises along the flight.
    pub rising: bool,
}

/// Returns the position and velocity of the origin of the particles' coordinates at a time, in the
/// coordinates of the states.
pub type Origin<'a> = dyn Fn(f64) -> (Vec3, Vec3) + Sync + 'a;

/// Finds the events of a particle in its step, up to the time, position and velocity `after`.
pub fn scan(
    events: &[ParticleEvent],
    (ephemeris, external_forces, origin): (&BodyEphemeris, &mut ExternalForces, &Origin),
    particle: usize,
    step: &Segment,
    after: (f64, Vec3, Vec3),
    out: &mut Vec<ParticleOccurrence>,
) -> Result<()> {
    let first = out.len();
    let along = step.size().signum();
    let fractions = sample_fractions(step.fraction(after.0));
    for (index, event) in events.iter().enumerate() {
        let mut value = |(time, x, v): (f64, Vec3, Vec3)| -> Result<f64> {
            let value = match &event.condition {
                ParticleCondition::Shadow { visible } => {
                    let seen = external_forces.seen(time, &x, |body| {
                        let pose = ephemeris.pose(body, time);
                        (pose.rotation, x - pose.position)
                    });
                    seen? - visible
                }
                ParticleCondition::Periapsis { body } => {
                    let pose = ephemeris.pose(*body, time);
                    (x - pose.position).dot(&(v - pose.velocity)) * along
                }
                ParticleCondition::Function(function) => {
                    let (position, velocity) = origin(time);
                    function(time, &(position + x), &(velocity + v))?
                }
            };
            if value.is_finite() {
                Ok(value)
            } else {
                let what = format!("value of an event of particle {particle} at time {time}");
                Err(Error::invalid(what, value, "a finite number"))
            }
        };
        let mut values = [0.0; SAMPLES];
        for k in 0..SAMPLES - 1 {
            values[k] = value(at_fraction(step, fractions[k]))?;
        }
        // The next step begins at these values, so that a zero is found in exactly one of the two.
        values[SAMPLES - 1] = value(after)?;
        let accepts = |rises| direction_matches(event.direction, rises);
        let take_zero = |theta, rising| {
            let (time, position, velocity) = at_fraction(step, theta);
            out.push(ParticleOccurrence { event: index, particle, time, position, velocity, rising });
        };
        zeros(&fractions, &values, None, |theta| value(at_fraction(step, theta)), accepts, take_zero)?;
    }
    out[first..].sort_by(|a, b| (a.time * along).total_cmp(&(b.time * along)));
    Ok(())
}

/// Returns time, position and velocity at a fraction of a particle's step.
fn at_fraction(step: &Segment, theta: f64) -> (f64, Vec3, Vec3) {
    let (position, velocity) = motion_at_fraction(step, theta);
    (step.time_at(theta), position, velocity)
}
