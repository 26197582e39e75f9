//! The conditions of events, and the functions whose zeros are the events.

use super::sighting::Sighting;
use crate::dynamics::{AttitudeChart, BarycentricFrame, Dynamics, State, System};
use crate::error::{Error, Result, require_finite, require_positive};
use crate::integrate::Segment;
use crate::interrupt::InterruptCheck;
use crate::math::spline::Spline;
use crate::math::{Mat3, Vec3, ascending, rotation};
use crate::shape::{Part, Proximity};
use crate::trajectory::dense::piece_at;
use nalgebra::Rotation3;
use std::fmt;

/// A caller's function of the state.
pub type StateFunction<'a> = dyn FnMut(&State) -> Result<f64> + Send + 'a;

/// The condition of an event; bodies are given by their index in the system.
#[non_exhaustive]
pub enum Condition<'a> {
    /// The centres of two bodies are `value` apart. The function is the distance less the value.
    Separation {
        /// One body.
        first: usize,
        /// The other body.
        second: usize,
        /// The distance.
        value: f64,
    },
    /// The surfaces of two bodies touch. The function is the factor by which both would have to grow to
    /// touch, less one.
    Contact {
        /// One body.
        first: usize,
        /// The other body.
        second: usize,
    },
    /// Two centres are nearest: r . v rises through zero.
    Periapsis {
        /// One body.
        first: usize,
        /// The other body.
        second: usize,
    },
    /// Two centres are furthest: r . v falls through zero.
    Apoapsis {
        /// One body.
        first: usize,
        /// The other body.
        second: usize,
    },
    /// A body's centre goes through a plane. The function is its height above the plane.
    PlaneCrossing {
        /// The body.
        body: usize,
        /// The body whose centre lies in the plane; `None` for a plane through the origin.
        reference: Option<usize>,
        /// The plane's normal, inertial, of any length. With the z axis the crossings are the nodes.
        normal: Vec3,
    },
    /// Two bodies are further apart than a distance, and the energy of their relative motion as points is
    /// positive. The function is the smaller of r v^2 / (2 mu) - 1 and r / distance - 1.
    Escape {
        /// One body.
        first: usize,
        /// The other body.
        second: usize,
        /// The distance beyond which an unbound orbit counts as escape.
        distance: f64,
    },
    /// The angle between a body's long axis and the line to another's centre is smallest. The function is the
    /// rate of its squared cosine over two, which falls through zero; in the plane the angle itself is then
    /// zero.
    Alignment {
        /// The body with the long axis.
        body: usize,
        /// The other body.
        other: usize,
    },
    /// A third body is nearest to the system's barycentre, on its prescribed path.
    ClosestApproach {
        /// The index of the third body among the forces.
        force: usize,
    },
    /// A body's outline and that of another one in front of it touch, as seen from a point: the observer, or the
    /// Sun. The function is the gap between the outlines, or the largest extent of the outline of the body behind
    /// beyond the other outline.
    Occultation {
        /// The body behind.
        body: usize,
        /// The body in front.
        by: usize,
        /// Whether the outline of the body behind has to be inside that of the other.
        total: bool,
        /// The point from which the bodies are seen, or from which light comes.
        viewpoint: Box<Viewpoint>,
    },
    /// Zeros of a function of the state.
    Function(Box<StateFunction<'a>>),
}

/// The path of the point from which bodies are seen, or from which light comes, with the slowness of that light.
#[derive(Debug, Clone)]
pub struct Viewpoint {
    /// The position of the point relative to the barycentre as a function of time: that of the light which
    /// leaves, or passes, the barycentre.
    pub path: Spline<3>,
    /// Whether times outside the path are refused; otherwise the path is extrapolated.
    pub bounded: bool,
    /// Whether only the direction to the point counts, as if it were at an infinite distance.
    pub distant: bool,
    /// The time that light takes per unit length: positive for light to the point, which leaves nearer bodies
    /// later; negative for light from the point, which passes nearer bodies earlier; zero to neglect the light time.
    pub slowness: f64,
}

/// The position of a [`Viewpoint`] at a time.
struct ViewpointPosition {
    /// The unit vector from the barycentre.
    direction: Vec3,
    /// One over the distance from the barycentre; zero for a point at infinity.
    nearness: f64,
}

impl ViewpointPosition {
    /// Returns the distance of the barycentre minus that of a position, which is relative to the barycentre.
    fn path_difference(&self, position: &Vec3) -> f64 {
        let Self { direction, nearness } = self;
        let distance = (direction - position * *nearness).norm();
        (2.0 * position.dot(direction) - nearness * position.norm_squared()) / (1.0 + distance)
    }
}

impl Viewpoint {
    /// Returns the position at a time.
    fn position(&self, time: f64) -> Result<ViewpointPosition> {
        let (first, last) = self.path.range();
        if self.bounded && !(first..=last).contains(&time) {
            let expected = format!("one from {first} to {last}, for which the point is known");
            return Err(Error::invalid("time of Occultation", time, expected));
        }
        let position = Vec3::from(self.path.at(time).0);
        let distance = position.norm();
        Ok(ViewpointPosition {
            direction: position / distance,
            nearness: if self.distant { 0.0 } else { 1.0 / distance },
        })
    }
}

/// The time, vector and equations at which the functions are evaluated.
#[derive(Clone, Copy)]
pub(super) struct EvaluationPoint<'a> {
    pub equations: &'a Dynamics,
    pub time: f64,
    pub y: &'a [f64],
    pub zeros: &'a [f64],
    /// The known pieces of the continuous solution about the time.
    pub pieces: &'a [Segment],
}

impl EvaluationPoint<'_> {
    fn system(&self) -> &System {
        self.equations.system()
    }

    fn frame(&self) -> &BarycentricFrame {
        self.equations.frame()
    }

    fn position(&self, body: usize) -> Vec3 {
        Vec3::from_column_slice(&self.y[self.frame().layout.position(body)..][..3])
    }

    fn velocity(&self, body: usize) -> Vec3 {
        Vec3::from_column_slice(&self.y[self.frame().layout.velocity(body)..][..3])
    }

    fn rotation(&self, body: usize) -> Mat3 {
        rotation::matrix(self.frame().attitude(body, self.y))
    }

    /// Returns the position of a body relative to the barycentre, and its velocity.
    fn about_barycentre(&self, body: usize) -> (Vec3, Vec3) {
        let (offset, drift) = self.frame().barycentre_offset(self.y);
        (self.position(body) - offset, self.velocity(body) - drift)
    }

    /// Returns the delay of the light that leaves or passes a body, relative to the light that leaves or passes the
    /// barycentre at this time, and the position of the body at that moment, relative to the barycentre. The body is
    /// assumed to move on a straight line. Each iteration gains the digits of the speed of light over the body's.
    fn on_straight_line(
        &self,
        body: usize,
        viewpoint_position: &ViewpointPosition,
        slowness: f64,
        iterations: usize,
    ) -> (f64, Vec3) {
        let (position, velocity) = self.about_barycentre(body);
        let delay = (0..iterations).fold(0.0, |delay, _| {
            slowness * viewpoint_position.path_difference(&(position + velocity * delay))
        });
        (delay, position + velocity * delay)
    }

    /// Returns the position of a body relative to the barycentre, and its rotation, at the moment at which the light
    /// leaves or passes it.
    ///
    /// Unless a straight line is exact but for rounding, one correction leads to the position on the continuous
    /// solution, up to the square of the speed over that of light. Beyond the known pieces, the position follows from
    /// the acceleration at their end and the attitude from the spin.
    fn at_light_time(
        &self,
        body: usize,
        viewpoint_position: &ViewpointPosition,
        slowness: f64,
    ) -> (Vec3, Mat3) {
        /// The square of an angle that counts as zero.
        const NEGLIGIBLE: f64 = 1e-16;
        let (delay, on_straight_line) = self.on_straight_line(body, viewpoint_position, slowness, 4);
        let spin = |y: &[f64]| Vec3::from_column_slice(&y[self.frame().layout.spin(body)..][..3]);
        let velocity = self.about_barycentre(body).1;
        let rate = spin(self.y).norm_squared() + velocity.norm_squared() / on_straight_line.norm_squared();
        let Some(first) = self.pieces.first().filter(|_| delay * delay * rate > NEGLIGIBLE) else {
            let rotation = Rotation3::from_scaled_axis(spin(self.y) * delay);
            return (on_straight_line, self.rotation(body) * rotation.matrix());
        };
        let piece = piece_at(self.pieces, self.time + delay, first.size() > 0.0);
        let present = piece.fraction(self.time);
        let theta = (present + delay / piece.size()).clamp(0.0, 1.0);
        let remainder = delay - (theta - present) * piece.size();
        let (mut y, mut rates) = (self.y.to_vec(), vec![0.0; self.y.len()]);
        piece.at(theta, &mut y);
        piece.rate(theta, &mut rates);
        let delayed = EvaluationPoint { y: &y, ..*self };
        let (position, velocity) = delayed.about_barycentre(body);
        let (_, acceleration) = EvaluationPoint { y: &rates, ..*self }.about_barycentre(body);
        let position = position + (velocity + acceleration * (0.5 * remainder)) * remainder;
        let correction = slowness * viewpoint_position.path_difference(&position) - delay;
        let rotation = Rotation3::from_scaled_axis(spin(&y) * (remainder + correction));
        (
            position + (velocity + acceleration * remainder) * correction,
            delayed.rotation(body) * rotation.matrix(),
        )
    }

    fn relative(&self, first: usize, second: usize) -> (Vec3, Vec3) {
        (self.position(second) - self.position(first), self.velocity(second) - self.velocity(first))
    }
}

impl fmt::Debug for Condition<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct(self.name()).finish_non_exhaustive()
    }
}

impl Condition<'_> {
    /// Returns the name that error messages use.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Separation { .. } => "Separation",
            Self::Contact { .. } => "Contact",
            Self::Periapsis { .. } => "Periapsis",
            Self::Apoapsis { .. } => "Apoapsis",
            Self::PlaneCrossing { .. } => "PlaneCrossing",
            Self::Escape { .. } => "Escape",
            Self::Alignment { .. } => "Alignment",
            Self::ClosestApproach { .. } => "ClosestApproach",
            Self::Occultation { .. } => "Occultation",
            Self::Function(_) => "Function",
        }
    }

    /// Returns the work of evaluating the function, in units of that of most conditions.
    pub(super) fn weight(&self) -> u64 {
        if matches!(self, Self::Occultation { .. }) { 30 } else { 1 }
    }

    /// Returns the direction that belongs to the condition, if there is one.
    pub(super) fn direction(&self) -> Option<i8> {
        match self {
            Self::Periapsis { .. } | Self::ClosestApproach { .. } => Some(1),
            Self::Apoapsis { .. } | Self::Alignment { .. } => Some(-1),
            _ => None,
        }
    }

    /// Returns a bound of the function's derivative with respect to the fraction of a piece, for functions
    /// that have sharp bends and more than one extremum within a few samples; `None` for others.
    pub(super) fn steepness(&self, equations: &Dynamics, piece: &Segment) -> Option<f64> {
        /// Light time adds a fraction of the speed over that of light, far less than the excess of the other bounds.
        const MARGIN: f64 = 1.01;
        let Self::Occultation { body, by, viewpoint, .. } = self else { return None };
        let layout = equations.frame().layout;
        let (mut speed, mut distance, mut rotation_speed, mut size) = (0.0, 0.0, 0.0, 0.0);
        for index in [*body, *by] {
            let position = layout.position(index);
            distance += Vec3::from_column_slice(&piece.start_vector().0[position..][..3]).norm();
            speed += piece.derivative_bounds(position, 3)[0];
            let attitude = layout.attitude(index);
            let rate = match layout.chart {
                AttitudeChart::Quaternion => 2.0 * piece.derivative_bounds(attitude, 4)[0],
                AttitudeChart::TaitBryan => (0..3).map(|c| piece.derivative_bounds(attitude + c, 1)[0]).sum(),
            };
            let body = &equations.system().bodies()[index];
            // The outline of a sphere does not change when it rotates.
            let lever = match body.parts() {
                [Part { shape, placement: None, .. }] => shape.focal_reach(),
                _ => body.circumradius(),
            };
            rotation_speed += rate * lever;
            size += body.circumradius();
        }
        let (position, rate) = viewpoint.path.at(piece.start());
        let far = Vec3::from(position).norm();
        let drift = Vec3::from(rate).norm() / far * piece.size().abs();
        // From a near point, a position x is seen at x / (1 - x.u / far).
        let share = if viewpoint.distant { 0.0 } else { (distance + speed + size) / far };
        let growth = if share < 1.0 { ((1.0 + share) / (1.0 - share)).powi(2) } else { f64::INFINITY };
        Some(growth * (MARGIN * (speed + rotation_speed) + 2.0 * drift * (distance + speed + size)))
    }

    /// Returns an error for bodies that do not exist and for meaningless values.
    pub(super) fn check(&self, equations: &Dynamics) -> Result<()> {
        let bodies = equations.system().bodies();
        let body = |index: usize| {
            if index < bodies.len() {
                Ok(())
            } else {
                Err(Error::invalid(
                    format!("a body of {}", self.name()),
                    index,
                    format!("0 to {}", bodies.len() - 1),
                ))
            }
        };
        let two = |first: usize, second: usize| {
            body(first)?;
            body(second)?;
            if first == second {
                return Err(Error::invalid(
                    format!("bodies of {}", self.name()),
                    format!("{first} twice"),
                    "two bodies",
                ));
            }
            Ok(())
        };
        match self {
            Self::Separation { first, second, value } => {
                two(*first, *second)?;
                require_positive("value of Separation", *value)
            }
            Self::Escape { first, second, distance } => {
                two(*first, *second)?;
                require_positive("distance of Escape", *distance)
            }
            Self::Contact { first, second } => {
                two(*first, *second)?;
                bodies[*first].require_surface().and(bodies[*second].require_surface())
            }
            Self::Periapsis { first, second } | Self::Apoapsis { first, second } => two(*first, *second),
            Self::PlaneCrossing { body: index, reference, normal } => {
                reference.map_or(body(*index), |other| two(*index, other))?;
                require_finite("normal of PlaneCrossing", normal.as_slice())?;
                require_positive("length of the normal of PlaneCrossing", normal.norm())
            }
            Self::Alignment { body, other } => {
                two(*body, *other)?;
                let axes = bodies[*body].semi_axes();
                let [_, middle, longest] = ascending(axes);
                if axes[longest] > axes[middle] {
                    Ok(())
                } else {
                    let name = &bodies[*body].name;
                    Err(Error::invalid(
                        format!("shape of {name}"),
                        format!("{axes:?}"),
                        "one longest axis, for Alignment",
                    ))
                }
            }
            Self::ClosestApproach { force } => equations.external_forces().expect_third_body(*force),
            Self::Occultation { body, by, viewpoint, .. } => {
                two(*body, *by)?;
                bodies[*body].require_surface().and(bodies[*by].require_surface())?;
                require_finite("slowness of Occultation", &[viewpoint.slowness])
            }
            Self::Function(_) => Ok(()),
        }
    }

    /// Evaluates the function whose zeros are the events.
    pub(super) fn value(&mut self, at: &EvaluationPoint, interrupt: &mut InterruptCheck) -> Result<f64> {
        Ok(match self {
            Self::Separation { first, second, value } => at.relative(*first, *second).0.norm() - *value,
            Self::Contact { first, second } => contact(at, *first, *second, interrupt)?,
            Self::Periapsis { first, second } | Self::Apoapsis { first, second } => {
                let (r, v) = at.relative(*first, *second);
                r.dot(&v)
            }
            Self::PlaneCrossing { body, reference, normal } => {
                let from = match reference {
                    Some(other) => at.position(*other),
                    None => -at.frame().barycentre_at(at.time, at.y),
                };
                normal.normalize().dot(&(at.position(*body) - from))
            }
            Self::Escape { first, second, distance } => {
                let (r, v) = at.relative(*first, *second);
                let bodies = at.system().bodies();
                let mu = at.system().gravitational_constant() * (bodies[*first].mass + bodies[*second].mass);
                let r = r.norm();
                (r * v.norm_squared() / (2.0 * mu) - 1.0).min(r / *distance - 1.0)
            }
            Self::Alignment { body, other } => alignment(at, *body, *other),
            Self::ClosestApproach { force } => {
                let (position, velocity) = at.equations.external_forces().third_body(*force, at.time)?;
                let (offset, offset_rate) = at.frame().barycentre_offset(at.y);
                (position - offset).dot(&(velocity - offset_rate))
            }
            Self::Occultation { body, by, total, viewpoint } => {
                occultation(at, [*body, *by], *total, viewpoint, interrupt)?
            }
            Self::Function(function) => function(&at.frame().state(at.time, at.y, at.zeros))?,
        })
    }
}

/// Evaluates the function of a contact: the factor of growth, less one.
fn contact(at: &EvaluationPoint, first: usize, second: usize, interrupt: &mut InterruptCheck) -> Result<f64> {
    let (r, _) = at.relative(first, second);
    let bodies = at.system().bodies();
    let rotations = [&at.rotation(first), &at.rotation(second)];
    // Bodies so thin that rounding decides the sign are an error.
    Ok(Proximity::compute([&bodies[first], &bodies[second]], &r, rotations, at.time, interrupt)?.factor - 1.0)
}

/// Evaluates the function of an alignment: the rate of the squared cosine over two.
fn alignment(at: &EvaluationPoint, body: usize, other: usize) -> f64 {
    let (r, v) = at.relative(body, other);
    let axes = at.system().bodies()[body].semi_axes();
    let longest = (0..3).fold(0, |best, k| if axes[k] > axes[best] { k } else { best });
    let mut axis = Vec3::zeros();
    axis[longest] = 1.0;
    let rotation = at.rotation(body);
    let spin = Vec3::from_column_slice(&at.y[at.frame().layout.spin(body)..][..3]);
    let distance = r.norm();
    let line = r / distance;
    let line_rate = (v - line * line.dot(&v)) / distance;
    let (long, long_rate) = (rotation * axis, rotation * spin.cross(&axis));
    long.dot(&line) * (long_rate.dot(&line) + long.dot(&line_rate))
}

/// Evaluates the function of an occultation of the first body by the second.
fn occultation(
    at: &EvaluationPoint,
    indices: [usize; 2],
    total: bool,
    viewpoint: &Viewpoint,
    interrupt: &mut InterruptCheck,
) -> Result<f64> {
    let (viewpoint_position, slowness) = (viewpoint.position(at.time)?, viewpoint.slowness);
    let ViewpointPosition { direction, nearness } = viewpoint_position;
    let bodies = indices.map(|index| &at.system().bodies()[index]);
    let [behind, front] = indices.map(|index| at.on_straight_line(index, &viewpoint_position, slowness, 1).1);
    for (position, body) in [behind, front].iter().zip(bodies) {
        let extent = position.dot(&direction) + body.circumradius();
        if extent * nearness >= 1.0 {
            let what =
                format!("distance of the observer, or the Sun, from the barycentre at time {}", at.time);
            let expected = format!("one above {extent}, as far as {} reaches toward it", body.name);
            return Err(Error::invalid(what, nearness.recip(), expected));
        }
    }
    // Far from an occultation a bound suffices.
    let size = bodies[0].circumradius() + bodies[1].circumradius();
    let depth = (behind - front).dot(&direction);
    if depth > size {
        return Ok(depth);
    }
    let projected = |position: &Vec3| {
        (position - direction * position.dot(&direction)) / (1.0 - position.dot(&direction) * nearness)
    };
    let across = (projected(&front) - projected(&behind)).norm();
    let [near, far] = [behind, front].map(|position| 1.0 - (position.norm() + size) * nearness);
    let size = size / (near.min(far)).powi(2);
    if near.min(far) > 0.0 && across > 2.0 * size {
        return Ok(depth.max(across - size));
    }
    let [(behind, first), (front, second)] =
        indices.map(|index| at.at_light_time(index, &viewpoint_position, slowness));
    let (centres, rotations) = ([&behind, &front], [&first, &second]);
    interrupt.charge(Sighting::work(bodies), at.time)?;
    let sighting = Sighting { bodies, centres, rotations, direction: &direction, nearness };
    Ok(if total { sighting.overhang() } else { sighting.gap() })
}
