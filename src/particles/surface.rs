//! The surfaces of bodies, for contacts with particles.
//!
//! The level of an ellipsoid along a particle's polynomial is q = sum y_i^2/a_i^2 - 1, where y is the
//! particle's position in the ellipsoid's frame, and its rate is q' = 2 sum y_i w_i/a_i^2, where w is the
//! rate of y. Since q'' >= 2 sum y_i w'_i/a_i^2 >= -M, the level stays above q + q' s - M s^2/2 for a time s,
//! so that the search for the first contact may advance to the positive root of that polynomial. It converges
//! to a contact as Newton's iteration does, and passes a place where the particle misses the surface in a few
//! advances.

use super::body_ephemeris::{BodyEphemeris, BodyMotion};
use crate::integrate::Segment;
use crate::math::rotation::{rotate, rotate_back};
use crate::math::{Mat3, Vec3};
use crate::shape::{Body, Part, Polyhedron, Shape};

/// The shortest advance of the search, relative to the step and to the time in which the particle would pass
/// the body. A contact may be missed whose depth is less than the square of this number times the size of the
/// body.
const SHORTEST_ADVANCE: f64 = 1e-5;

/// The rounding of positions, relative to them.
const ROUNDING: f64 = 4e-15;

/// The ratio of the speed along the normal to the particle's speed below which a particle follows the
/// surface, if its distance from the surface is below the smallest one that counts. It may follow for
/// `MAX_FOLLOWED` evaluations in a row.
const FOLLOWING_SPEED: f64 = 1e-11;
const MAX_FOLLOWED: u32 = 10_000;

/// The surface of a body.
#[derive(Debug, Clone)]
pub struct BodySurface {
    /// An upper bound of the distance of the body's points from its centre; zero for a point.
    pub radius: f64,
    /// How far an equivalent mass distribution with the same exterior field extends from the centre.
    pub focal: f64,
    parts: Vec<PartSurface>,
}

#[derive(Debug, Clone)]
struct PartSurface {
    position: Vec3,
    rotation: Mat3,
    form: SurfaceForm,
}

#[derive(Debug, Clone)]
enum SurfaceForm {
    Ellipsoid { inverse: Vec3, shortest: f64 },
    Polyhedron(Box<Polyhedron>),
}

/// The first contact of a particle with a surface.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceHit {
    /// The time of the contact.
    pub time: f64,
    /// The index of the part of the body.
    pub part: usize,
}

/// A particle at a body's surface, in the body frame.
#[derive(Debug, Clone, Copy)]
pub struct Landing {
    /// The point of the surface.
    pub point: Vec3,
    /// The outward normal.
    pub normal: Vec3,
    /// The velocity relative to the surface.
    pub velocity: Vec3,
}

impl BodyMotion {
    /// Converts position and velocity to the body frame, with the velocity relative to the rotating body.
    pub fn in_body_frame(&self, position: &Vec3, velocity: &Vec3) -> (Vec3, Vec3) {
        let local = rotate_back(&self.rotation, &(position - self.position));
        let velocity = rotate_back(&self.rotation, &(velocity - self.velocity)) - self.spin.cross(&local);
        (local, velocity)
    }

    /// Converts position and velocity from the body frame: the inverse of [`Self::in_body_frame`].
    pub fn in_inertial_frame(&self, local: &Vec3, velocity: &Vec3) -> (Vec3, Vec3) {
        let moving = velocity + self.spin.cross(local);
        (self.position + rotate(&self.rotation, local), self.velocity + rotate(&self.rotation, &moving))
    }
}

/// Returns position and velocity on a particle's polynomial.
pub fn motion_at(segment: &Segment, time: f64) -> (Vec3, Vec3) {
    motion_at_fraction(segment, segment.fraction(time))
}

/// Returns position and velocity on a particle's polynomial at a fraction of the step.
pub fn motion_at_fraction(segment: &Segment, theta: f64) -> (Vec3, Vec3) {
    let mut y = [0.0; 6];
    segment.at(theta, &mut y);
    (Vec3::new(y[0], y[1], y[2]), Vec3::new(y[3], y[4], y[5]))
}

impl BodySurface {
    /// Takes the outer parts of a body.
    pub fn new(body: &Body) -> Self {
        let part = |part: &Part| {
            let form = match &part.shape {
                Shape::Point => return None,
                // The field is known outside the sphere alone, where particles end.
                Shape::Stokes(stokes) => {
                    let (inverse, shortest) = (Vec3::repeat(1.0 / stokes.radius()), stokes.radius());
                    SurfaceForm::Ellipsoid { inverse, shortest }
                }
                Shape::Ellipsoid(ellipsoid) => {
                    let axes = Vec3::from(ellipsoid.semi_axes());
                    SurfaceForm::Ellipsoid { inverse: axes.map(|a| 1.0 / a), shortest: axes.min() }
                }
                Shape::Polyhedron(polyhedron) => SurfaceForm::Polyhedron(Box::new(polyhedron.clone())),
            };
            Some(PartSurface { position: part.position(), rotation: part.rotation(), form })
        };
        let focal = |part: &Part| part.position().norm() + part.shape.focal_reach();
        let parts: Vec<_> = body.outer_parts().filter_map(part).collect();
        Self {
            radius: if parts.is_empty() { 0.0 } else { body.circumradius() },
            focal: body.parts().iter().map(focal).fold(0.0, f64::max),
            parts,
        }
    }

    /// Returns the outermost point of the surface in a direction from the body's centre, and the outward
    /// normal there, in the body frame.
    pub fn outermost(&self, direction: &Vec3) -> Option<(Vec3, Vec3)> {
        let d = direction.normalize();
        let far = |index: usize| {
            let part = &self.parts[index];
            let (from, along) = (part.part_frame(&Vec3::zeros()), rotate_back(&part.rotation, &d));
            Some((part.exit(&from, &along)?, index))
        };
        let (distance, index) = (0..self.parts.len()).filter_map(far).max_by(|a, b| a.0.total_cmp(&b.0))?;
        let part = &self.parts[index];
        let local = d * distance;
        Some((local, rotate(&part.rotation, &part.normal(&part.part_frame(&local)))))
    }

    /// Returns the units of work of [`Self::contains`], for [`crate::interrupt::InterruptCheck`].
    pub fn work(&self) -> u64 {
        let of = |part: &PartSurface| match &part.form {
            SurfaceForm::Ellipsoid { .. } => 5,
            SurfaceForm::Polyhedron(polyhedron) => 5 * polyhedron.faces().len() as u64,
        };
        self.parts.iter().map(of).sum()
    }

    /// Returns whether a point of the body frame is inside by more than rounding.
    pub fn contains(&self, local: &Vec3) -> bool {
        self.parts.iter().any(|part| {
            let y = part.part_frame(local);
            match &part.form {
                SurfaceForm::Ellipsoid { inverse, .. } => {
                    y.component_mul(inverse).norm_squared() < 1.0 - 1e-12
                }
                SurfaceForm::Polyhedron(polyhedron) => {
                    polyhedron.contains(&y) && polyhedron.distance(&y) > 1e-12 * polyhedron.circumradius()
                }
            }
        })
    }

    /// Returns the first contact of a particle's step up to a time. `leaving` says that the step begins at
    /// the surface.
    pub fn search(
        &self,
        ephemeris: &BodyEphemeris,
        body: usize,
        step: &Segment,
        until: f64,
        leaving: bool,
    ) -> Option<SurfaceHit> {
        let mut first: Option<SurfaceHit> = None;
        for (part, surface) in self.parts.iter().enumerate() {
            let end = first.map_or(until, |hit| hit.time);
            let time = surface.search(ephemeris, body, step, end, leaving);
            first = time.map(|time| SurfaceHit { time, part }).or(first);
        }
        first
    }

    /// Describes a particle at the surface of a part.
    pub fn landing(&self, pose: &BodyMotion, part: usize, (position, velocity): (&Vec3, &Vec3)) -> Landing {
        let (point, velocity) = pose.in_body_frame(position, velocity);
        let part = &self.parts[part];
        let normal = rotate(&part.rotation, &part.normal(&part.part_frame(&point)));
        Landing { point, normal, velocity }
    }
}

/// How far a particle is outside a part: q for an ellipsoid, the distance from a polyhedron.
struct Clearance {
    value: f64,
    /// The rate of change of the value, where it matters.
    rate: f64,
    /// The effect of rounding on a value of zero, and on a rate of zero.
    rounding: f64,
    still: f64,
}

impl SurfaceForm {
    fn size(&self) -> f64 {
        match self {
            Self::Ellipsoid { shortest, .. } => *shortest,
            Self::Polyhedron(polyhedron) => polyhedron.circumradius(),
        }
    }
}

/// Bounds of a particle's motion near a part in a step.
struct MotionBound {
    /// A bound of |w|.
    speed: f64,
    /// A bound of |y| |w'|.
    curvature: f64,
    /// Size of the part, where levels are lengths.
    scale: f64,
}

impl PartSurface {
    fn part_frame(&self, local: &Vec3) -> Vec3 {
        rotate_back(&self.rotation, &(local - self.position))
    }

    /// Returns the distance at which a ray leaves the part for good.
    fn exit(&self, from: &Vec3, along: &Vec3) -> Option<f64> {
        match &self.form {
            SurfaceForm::Ellipsoid { inverse, .. } => {
                let (p, d) = (from.component_mul(inverse), along.component_mul(inverse));
                let (a, b, c) = (d.norm_squared(), p.dot(&d), p.norm_squared() - 1.0);
                let square = b * b - a * c;
                (square >= 0.0).then(|| (square.sqrt() - b) / a).filter(|distance| *distance > 0.0)
            }
            SurfaceForm::Polyhedron(polyhedron) => {
                let crossing = |face: usize| {
                    let [a, b, c] = polyhedron.corners(face);
                    let normal = (b - a).cross(&(c - a));
                    let distance = normal.dot(&(a - from)) / normal.dot(along);
                    let x = from + along * distance;
                    let sides = [(a, b), (b, c), (c, a)];
                    let within = sides
                        .iter()
                        .all(|(u, v)| (v - u).cross(&(x - u)).dot(&normal) >= -1e-14 * normal.norm_squared());
                    (within && distance > 0.0 && distance.is_finite()).then_some(distance)
                };
                (0..polyhedron.faces().len()).filter_map(crossing).max_by(f64::total_cmp)
            }
        }
    }

    fn normal(&self, y: &Vec3) -> Vec3 {
        match &self.form {
            SurfaceForm::Ellipsoid { inverse, .. } => {
                y.component_mul(inverse).component_mul(inverse).normalize()
            }
            SurfaceForm::Polyhedron(polyhedron) => polyhedron.outward(y).0,
        }
    }

    fn search(
        &self,
        ephemeris: &BodyEphemeris,
        body: usize,
        step: &Segment,
        until: f64,
        leaving: bool,
    ) -> Option<f64> {
        let (start, direction) = (step.start(), step.size().signum());
        let length = (until - start).abs();
        let bound = self.motion_bound(ephemeris, body, step, length);
        // A shorter advance would be lost in the rounding of `passed`, and the search would not end.
        let floor =
            (SHORTEST_ADVANCE * length.min(self.form.size() / bound.speed)).max(f64::EPSILON * length);
        let clearance = |passed: f64| self.clearance(ephemeris, body, step, start + direction * passed);
        let first = if leaving { floor } else { 0.0 };
        let (mut passed, mut followed) = (first, 0_u32);
        while passed <= length {
            let Clearance { value, rate, rounding, still } = clearance(passed);
            // A particle that lies on the surface to rounding does not reach it. A particle that follows the
            // surface for long does reach it: otherwise it would follow the surface forever at a meaningless
            // distance.
            let follows = value.abs() <= SHORTEST_ADVANCE * SHORTEST_ADVANCE * bound.scale
                && rate.abs() <= FOLLOWING_SPEED / ROUNDING * still;
            followed = if follows { followed + 1 } else { 0 };
            if followed > MAX_FOLLOWED {
                return Some(start + direction * passed);
            }
            let lies = value >= -rounding && rate.abs() <= still;
            if value <= rounding && rate * direction < 0.0 && !lies {
                // Newton's iteration refines the contact from here.
                let mut contact = passed - value / (rate * direction);
                for _ in 0..2 {
                    let Clearance { value, rate, .. } = clearance(contact.clamp(0.0, length));
                    contact -= value / (rate * direction);
                }
                // The contact is not before the beginning of the search: a particle that has just left moves
                // on.
                let near = contact.clamp((passed - 2.0 * floor).max(first), passed + floor);
                return Some(start + direction * near.clamp(0.0, length));
            }
            let advance = match &self.form {
                SurfaceForm::Ellipsoid { shortest, .. } => {
                    let (rate, curvature) = (rate * direction, 2.0 * bound.curvature / (shortest * shortest));
                    let value = value.max(0.0);
                    let root = (rate * rate + 2.0 * curvature * value).sqrt();
                    // In neither form nearly equal numbers are subtracted.
                    if rate < 0.0 { 2.0 * value / (root - rate) } else { (rate + root) / curvature }
                }
                SurfaceForm::Polyhedron(_) => value / bound.speed,
            };
            passed += if advance > floor { advance } else { floor };
        }
        None
    }

    /// Returns by how much a particle is outside at a time, and the rate of that.
    fn clearance(&self, ephemeris: &BodyEphemeris, body: usize, step: &Segment, time: f64) -> Clearance {
        let (position, velocity) = motion_at(step, time);
        let pose = ephemeris.pose(body, time);
        let (local, w) = pose.in_body_frame(&position, &velocity);
        let still = ROUNDING * (velocity.norm() + pose.spin.norm() * local.norm());
        let (y, w) = (self.part_frame(&local), rotate_back(&self.rotation, &w));
        let distance_from_origin = position.norm();
        match &self.form {
            SurfaceForm::Ellipsoid { inverse, shortest } => {
                let (y, w) = (y.component_mul(inverse), w.component_mul(inverse));
                let rounding = ROUNDING * (1.0 + distance_from_origin / shortest);
                Clearance {
                    value: y.norm_squared() - 1.0,
                    rate: 2.0 * y.dot(&w),
                    rounding,
                    still: 2.0 * still / shortest,
                }
            }
            SurfaceForm::Polyhedron(polyhedron) => {
                let (distance, size) = (polyhedron.distance(&y), polyhedron.circumradius());
                if distance > 1e-3 * size {
                    return Clearance { value: distance, rate: 0.0, rounding: 0.0, still };
                }
                // A little above the surface the nearest face tells whether the point is inside or outside.
                let (normal, height) = polyhedron.outward(&y);
                let value = distance.copysign(height);
                Clearance {
                    value,
                    rate: normal.dot(&w),
                    rounding: ROUNDING * (size + distance_from_origin),
                    still,
                }
            }
        }
    }

    fn motion_bound(
        &self,
        ephemeris: &BodyEphemeris,
        body: usize,
        step: &Segment,
        length: f64,
    ) -> MotionBound {
        let bounds = ephemeris.bounds[body];
        let acceleration = bounds.acceleration + step.derivative_bounds(3, 3)[0] / step.size().abs();
        let (position, velocity) = motion_at(step, step.start());
        let pose = ephemeris.pose(body, step.start());
        let speed = (velocity - pose.velocity).norm() + acceleration * length;
        let farthest = (position - pose.position).norm() + speed * length;
        let rotation_speed = bounds.spin * farthest;
        let scale = match &self.form {
            SurfaceForm::Ellipsoid { .. } => 1.0,
            SurfaceForm::Polyhedron(_) => self.form.size(),
        };
        MotionBound {
            scale,
            speed: speed + rotation_speed,
            curvature: (farthest + self.position.norm())
                * (acceleration + bounds.spin * (2.0 * speed + rotation_speed) + bounds.spin_rate * farthest),
        }
    }
}
