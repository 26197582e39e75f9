//! Events of particles.

use super::course::Course;
use super::outside::Outside;
use super::surface::motion_at;
use crate::error::{Error, Result};
use crate::integrate::{Segment, root};
use crate::math::Vec3;

/// A caller's function of time, position and velocity, in the coordinates of the states.
pub type ParticleFunction = dyn Fn(f64, &Vec3, &Vec3) -> Result<f64> + Sync;

/// What is watched for.
pub enum Condition {
    /// The visible part of the source's disc goes through a value.
    Shadow {
        /// The value, between 0 and 1.
        visible: f64,
    },
    /// The particle is nearest to a body's centre: r . v rises through zero.
    Periapsis {
        /// The body.
        body: usize,
    },
    /// Zeros of a function.
    Function(Box<ParticleFunction>),
}

/// A condition with the direction of the zeros that are wanted: 1 rising along the flight, -1 falling, 0 both.
pub struct Watch {
    /// The condition.
    pub condition: Condition,
    /// The direction.
    pub direction: i8,
}

/// What happened to a particle.
#[derive(Debug, Clone, PartialEq)]
pub struct Happened {
    /// Place in the list of what is watched for.
    pub watch: usize,
    /// The particle.
    pub particle: usize,
    /// When.
    pub time: f64,
    /// Position from the nominal barycentre.
    pub position: Vec3,
    /// Velocity relative to it.
    pub velocity: Vec3,
    /// Whether the function rises along the flight.
    pub rising: bool,
}

/// Places of a step at which functions are looked at.
const LOOKS: usize = 8;

/// Where the coordinates of the states have their origin at a time, and its velocity.
pub type Origin<'a> = dyn Fn(f64) -> (Vec3, Vec3) + Sync + 'a;

/// What happens to a particle in its step up to a time.
pub fn scan(
    watches: &[Watch],
    (course, outside, origin): (&Course, &mut Outside, &Origin),
    particle: usize,
    step: &Segment,
    until: f64,
    out: &mut Vec<Happened>,
) -> Result<()> {
    let start = step.start();
    let first = out.len();
    for (index, watch) in watches.iter().enumerate() {
        let mut value = |time: f64| -> Result<f64> {
            let (x, v) = motion_at(step, time);
            let value = match &watch.condition {
                Condition::Shadow { visible } => {
                    let seen = outside.seen(time, &x, |body| {
                        let pose = course.pose(body, time);
                        (pose.rotation, x - pose.position)
                    });
                    seen? - visible
                }
                Condition::Periapsis { body } => {
                    let pose = course.pose(*body, time);
                    (x - pose.position).dot(&(v - pose.velocity)) * step.size().signum()
                }
                Condition::Function(function) => {
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
        let mut last = (start, value(start)?);
        for look in 1..=LOOKS {
            let time =
                if look == LOOKS { until } else { start + (until - start) * look as f64 / LOOKS as f64 };
            let next = (time, value(time)?);
            let rising = next.1 > last.1;
            let crossed = last.1 * next.1 < 0.0 || (next.1 == 0.0 && last.1 != 0.0);
            if crossed && (watch.direction == 0 || (watch.direction > 0) == rising) {
                let time = root(&mut value, last, next)?;
                let (position, velocity) = motion_at(step, time);
                out.push(Happened { watch: index, particle, time, position, velocity, rising });
            }
            last = next;
        }
    }
    let along = step.size().signum();
    out[first..].sort_by(|a, b| (a.time * along).total_cmp(&(b.time * along)));
    Ok(())
}
