//! Surfaces of bodies as particles meet them.
//!
//! Along a particle's polynomial the level of an ellipsoid is q = sum y_i^2/a_i^2 - 1, y the particle in its frame, with the rate
//! q' = 2 sum y_i w_i/a_i^2, w the rate of y. Since q'' >= 2 sum y_i w'_i/a_i^2 >= -M, the level stays above
//! q + q' s - M s^2/2 for a time s, so that the search for the first contact may go on to the positive root of that. It comes to a
//! contact as Newton's iteration does, and passes a place where the particle misses the surface in a few bounds.

use super::course::{Course, Pose};
use crate::integrate::Segment;
use crate::math::rotation::{turned, turned_back};
use crate::math::{Mat3, Vec3};
use crate::shape::{Body, Part, Polyhedron, Shape};

/// Shortest stretch by which the search goes on, relative to the step and to the time in which the particle would pass the body.
/// What digs less deep than the square of it times the size of the body may be passed.
const FLOOR: f64 = 1e-5;

/// Rounding of places, relative to them.
const ROUNDING: f64 = 4e-15;

/// A body's surface.
#[derive(Debug, Clone)]
pub struct Surface {
    /// No point of the body is further from its centre; zero for a point.
    pub radius: f64,
    /// How far from the centre the mass reaches that attracts like the body.
    pub focal: f64,
    parts: Vec<PartSurface>,
}

#[derive(Debug, Clone)]
struct PartSurface {
    position: Vec3,
    rotation: Mat3,
    form: Form,
}

#[derive(Debug, Clone)]
enum Form {
    Ellipsoid { inverse: Vec3, shortest: f64 },
    Polyhedron(Box<Polyhedron>),
}

/// Where a surface is met.
#[derive(Debug, Clone, Copy)]
pub struct Meeting {
    /// When.
    pub time: f64,
    /// The part of the body.
    pub part: usize,
}

/// A particle at a body's surface, in the body frame.
#[derive(Debug, Clone, Copy)]
pub struct Landing {
    /// The place.
    pub place: Vec3,
    /// The outward normal.
    pub normal: Vec3,
    /// The velocity relative to the surface.
    pub velocity: Vec3,
}

impl Pose {
    /// A place and a velocity from the nominal barycentre in the body frame, the velocity relative to the turning body.
    pub fn within(&self, position: &Vec3, velocity: &Vec3) -> (Vec3, Vec3) {
        let place = turned_back(&self.rotation, &(position - self.position));
        let velocity = turned_back(&self.rotation, &(velocity - self.velocity)) - self.spin.cross(&place);
        (place, velocity)
    }

    /// The inverse of [`Self::within`].
    pub fn without(&self, place: &Vec3, velocity: &Vec3) -> (Vec3, Vec3) {
        let moving = velocity + self.spin.cross(place);
        (self.position + turned(&self.rotation, place), self.velocity + turned(&self.rotation, &moving))
    }
}

/// Position and velocity on a particle's polynomial.
pub fn motion_at(segment: &Segment, time: f64) -> (Vec3, Vec3) {
    let mut y = [0.0; 6];
    segment.at(segment.fraction(time), &mut y);
    (Vec3::new(y[0], y[1], y[2]), Vec3::new(y[3], y[4], y[5]))
}

impl Surface {
    /// Of a body's outer parts.
    pub fn new(body: &Body) -> Self {
        let part = |part: &Part| {
            let form = match &part.shape {
                Shape::Point => return None,
                Shape::Ellipsoid(ellipsoid) => {
                    let axes = Vec3::from(ellipsoid.semi_axes());
                    Form::Ellipsoid { inverse: axes.map(|a| 1.0 / a), shortest: axes.min() }
                }
                Shape::Polyhedron(polyhedron) => Form::Polyhedron(Box::new(polyhedron.clone())),
            };
            Some(PartSurface { position: part.position(), rotation: part.rotation(), form })
        };
        let reach = |part: &Part| part.position().norm() + part.shape.focal_reach();
        let parts: Vec<_> = body.outer_parts().filter_map(part).collect();
        Self {
            radius: if parts.is_empty() { 0.0 } else { body.circumradius() },
            focal: body.parts().iter().map(reach).fold(0.0, f64::max),
            parts,
        }
    }

    /// The outermost place of the surface in a direction from the body's centre, and the outward normal there, in the body frame.
    pub fn outermost(&self, direction: &Vec3) -> Option<(Vec3, Vec3)> {
        let d = direction.normalize();
        let far = |index: usize| {
            let part = &self.parts[index];
            let (from, along) = (part.own(&Vec3::zeros()), turned_back(&part.rotation, &d));
            Some((part.exit(&from, &along)?, index))
        };
        let (distance, index) = (0..self.parts.len()).filter_map(far).max_by(|a, b| a.0.total_cmp(&b.0))?;
        let part = &self.parts[index];
        let place = d * distance;
        Some((place, turned(&part.rotation, &part.normal(&part.own(&place)))))
    }

    /// Units of work of [`Self::contains`], for [`crate::patience::Patience`].
    pub fn work(&self) -> u64 {
        let of = |part: &PartSurface| match &part.form {
            Form::Ellipsoid { .. } => 5,
            Form::Polyhedron(polyhedron) => 5 * polyhedron.faces().len() as u64,
        };
        self.parts.iter().map(of).sum()
    }

    /// Whether a place in the body frame is inside by more than rounding.
    pub fn contains(&self, place: &Vec3) -> bool {
        self.parts.iter().any(|part| {
            let y = part.own(place);
            match &part.form {
                Form::Ellipsoid { inverse, .. } => y.component_mul(inverse).norm_squared() < 1.0 - 1e-12,
                Form::Polyhedron(polyhedron) => {
                    polyhedron.contains(&y) && polyhedron.distance(&y) > 1e-12 * polyhedron.circumradius()
                }
            }
        })
    }

    /// The first contact of a particle's step up to a time. `departing` says that the step begins at the surface.
    pub fn search(
        &self,
        course: &Course,
        body: usize,
        step: &Segment,
        until: f64,
        departing: bool,
    ) -> Option<Meeting> {
        let mut first: Option<Meeting> = None;
        for (part, surface) in self.parts.iter().enumerate() {
            let end = first.map_or(until, |meeting| meeting.time);
            let time = surface.search(course, body, step, end, departing);
            first = time.map(|time| Meeting { time, part }).or(first);
        }
        first
    }

    /// A particle at the surface of a part.
    pub fn landing(&self, pose: &Pose, part: usize, (position, velocity): (&Vec3, &Vec3)) -> Landing {
        let (place, velocity) = pose.within(position, velocity);
        let part = &self.parts[part];
        let normal = turned(&part.rotation, &part.normal(&part.own(&place)));
        Landing { place, normal, velocity }
    }
}

/// How far a particle is outside a part: q of an ellipsoid, the distance from a polyhedron.
struct Level {
    value: f64,
    /// Its rate of change, wherever it matters.
    rate: f64,
    /// What rounding may make of zero.
    rounding: f64,
}

impl Form {
    fn size(&self) -> f64 {
        match self {
            Self::Ellipsoid { shortest, .. } => *shortest,
            Self::Polyhedron(polyhedron) => polyhedron.circumradius(),
        }
    }
}

/// How a particle moves near a part in a step, at worst.
struct Worst {
    /// Bound of |w|.
    speed: f64,
    /// Bound of |y| |w'|.
    bend: f64,
}

impl PartSurface {
    fn own(&self, place: &Vec3) -> Vec3 {
        turned_back(&self.rotation, &(place - self.position))
    }

    /// The distance at which a ray leaves the part for good.
    fn exit(&self, from: &Vec3, along: &Vec3) -> Option<f64> {
        match &self.form {
            Form::Ellipsoid { inverse, .. } => {
                let (p, d) = (from.component_mul(inverse), along.component_mul(inverse));
                let (a, b, c) = (d.norm_squared(), p.dot(&d), p.norm_squared() - 1.0);
                let square = b * b - a * c;
                (square >= 0.0).then(|| (square.sqrt() - b) / a).filter(|distance| *distance > 0.0)
            }
            Form::Polyhedron(polyhedron) => {
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
            Form::Ellipsoid { inverse, .. } => y.component_mul(inverse).component_mul(inverse).normalize(),
            Form::Polyhedron(polyhedron) => polyhedron.outward(y).0,
        }
    }

    fn search(
        &self,
        course: &Course,
        body: usize,
        step: &Segment,
        until: f64,
        departing: bool,
    ) -> Option<f64> {
        let (start, direction) = (step.start(), step.size().signum());
        let length = (until - start).abs();
        let worst = self.worst(course, body, step, length);
        // A shorter stretch would be lost in the rounding of `passed`, and the search would not end.
        let floor = (FLOOR * length.min(self.form.size() / worst.speed)).max(f64::EPSILON * length);
        let level = |passed: f64| self.level(course, body, step, start + direction * passed);
        let mut passed = if departing { floor } else { 0.0 };
        while passed <= length {
            let Level { value, rate, rounding } = level(passed);
            if value <= rounding && rate * direction < 0.0 {
                // Newton's steps from there.
                let mut met = passed - value / (rate * direction);
                for _ in 0..2 {
                    let Level { value, rate, .. } = level(met.clamp(0.0, length));
                    met -= value / (rate * direction);
                }
                let near = met.clamp(passed - 2.0 * floor, passed + floor);
                return Some(start + direction * near.clamp(0.0, length));
            }
            let ahead = match &self.form {
                Form::Ellipsoid { shortest, .. } => {
                    let (rate, bend) = (rate * direction, 2.0 * worst.bend / (shortest * shortest));
                    let value = value.max(0.0);
                    let root = (rate * rate + 2.0 * bend * value).sqrt();
                    // Neither is a difference of nearly equal numbers.
                    if rate < 0.0 { 2.0 * value / (root - rate) } else { (rate + root) / bend }
                }
                Form::Polyhedron(_) => value / worst.speed,
            };
            passed += if ahead > floor { ahead } else { floor };
        }
        None
    }

    /// How far a particle is outside at a time.
    fn level(&self, course: &Course, body: usize, step: &Segment, time: f64) -> Level {
        let (position, velocity) = motion_at(step, time);
        let (place, w) = course.pose(body, time).within(&position, &velocity);
        let (y, w) = (self.own(&place), turned_back(&self.rotation, &w));
        let away = position.norm();
        match &self.form {
            Form::Ellipsoid { inverse, shortest } => {
                let (y, w) = (y.component_mul(inverse), w.component_mul(inverse));
                let rounding = ROUNDING * (1.0 + away / shortest);
                Level { value: y.norm_squared() - 1.0, rate: 2.0 * y.dot(&w), rounding }
            }
            Form::Polyhedron(polyhedron) => {
                let (distance, size) = (polyhedron.distance(&y), polyhedron.circumradius());
                if distance > 1e-3 * size {
                    return Level { value: distance, rate: 0.0, rounding: 0.0 };
                }
                // A little above the surface the nearest face tells whether the place is in or out.
                let (normal, height) = polyhedron.outward(&y);
                let value = distance.copysign(height);
                Level { value, rate: normal.dot(&w), rounding: ROUNDING * (size + away) }
            }
        }
    }

    fn worst(&self, course: &Course, body: usize, step: &Segment, length: f64) -> Worst {
        let bounds = course.bounds[body];
        let acceleration = bounds.acceleration + step.rates(3, 3)[0] / step.size().abs();
        let (position, velocity) = motion_at(step, step.start());
        let pose = course.pose(body, step.start());
        let speed = (velocity - pose.velocity).norm() + acceleration * length;
        let reach = (position - pose.position).norm() + speed * length;
        let turning = bounds.spin * reach;
        Worst {
            speed: speed + turning,
            bend: (reach + self.position.norm())
                * (acceleration + bounds.spin * (2.0 * speed + turning) + bounds.spin_rate * reach),
        }
    }
}
