//! Bodies at one epoch: the light of each, and the bodies that may hide light from it.

use super::convex::ConvexBody;
use super::ellipsoid::{ByBody, EllipsoidPose, LitEllipsoid, Partials};
use super::faceted::{FacetedBody, Target};
use super::facets::{FacetedPart, Occluder, SurfaceLight};
use super::mesh::Mesh;
use super::outline::Light;
use super::scene::{Scene, Surface};
use crate::error::{Error, Result, require_finite};
use crate::interrupt::InterruptCheck;
use crate::math::{Vec3, rotation};
use crate::shape::{Facets, Proximity, across_separating_plane};

/// Units of work of one ellipsoid, beside those of the integrals.
pub const WORK: u64 = 10;

/// Positions and attitudes of all bodies at an epoch, and the directions to the observer and to the Sun.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// The time, which error messages name.
    pub time: f64,
    /// Positions of the centres, inertial.
    pub position: &'a [Vec3],
    /// Unit quaternions from the body frames to the inertial frame.
    pub attitude: &'a [[f64; 4]],
    /// Velocities of the centres over the speed of light. Each body is then where it was when its light left
    /// it towards the observer; empty if the time of light from body to body is neglected.
    pub velocity: &'a [Vec3],
    /// A vector toward the observer, of any length if this is distant.
    pub to_observer: Vec3,
    /// A vector toward the Sun, of any length if this is distant.
    pub to_sun: Vec3,
    /// Whether the observer and the Sun are infinitely far. Otherwise the vectors go from the origin, each
    /// body has its own directions, and its brightness is that with which it appears at the origin's
    /// distances.
    pub distant: bool,
}

impl View<'_> {
    /// Returns unit vectors to the observer and to the Sun, or an error that says what is wrong with the
    /// view.
    fn directions(&self, bodies: usize) -> Result<[Vec3; 2]> {
        let velocities = if self.velocity.is_empty() { bodies } else { self.velocity.len() };
        let counts = [
            ("positions", self.position.len()),
            ("attitudes", self.attitude.len()),
            ("velocities", velocities),
        ];
        for (what, count) in counts {
            if count != bodies {
                return Err(Error::invalid(format!("number of {what}"), count, format!("{bodies}")));
            }
        }
        for (body, (position, attitude)) in self.position.iter().zip(self.attitude).enumerate() {
            if !position.iter().chain(attitude).all(|number| number.is_finite()) {
                require_finite(&format!("position of body {body}"), position.as_slice())?;
                require_finite(&format!("attitude of body {body}"), attitude)?;
            }
            if let Some(velocity) = self.velocity.get(body) {
                require_finite(&format!("velocity of body {body}"), velocity.as_slice())?;
            }
            if *attitude == [0.0; 4] {
                let expected = "a quaternion [w, x, y, z] of non-zero length";
                return Err(Error::invalid(format!("attitude of body {body}"), "[0, 0, 0, 0]", expected));
            }
        }
        let unit = |what: &str, direction: &Vec3| {
            let square = direction.norm_squared();
            if (1e-280..1e280).contains(&square) {
                return Ok(direction / square.sqrt());
            }
            require_finite(what, direction.as_slice())?;
            let largest = direction.amax();
            if largest == 0.0 {
                return Err(Error::invalid(what, "zero", "a direction, of any length above zero"));
            }
            Ok((direction / largest).normalize())
        };
        Ok([unit("to_observer", &self.to_observer)?, unit("to_sun", &self.to_sun)?])
    }
}

/// The bodies of a scene in one view: their poses, the directions of light, and the pairs of bodies that are near each
/// other. One snapshot is used for many views, so that it allocates once.
pub struct Snapshot<'a> {
    scene: &'a Scene,
    view: View<'a>,
    /// The pose of each body, with semi-axes of zero for a body that is not one ellipsoid about its centre.
    poses: Vec<EllipsoidPose>,
    /// For each body, or for all if they are distant, the directions to the observer and to the Sun's centre,
    /// and one over their distances.
    light_directions: Vec<([Vec3; 2], [f64; 2])>,
    /// Likewise the weights of the points of the Sun's disc, with the directions to the observer and to the
    /// point.
    suns: Vec<(f64, [Vec3; 2])>,
    /// Pairs of bodies whose circumscribed spheres overlap, and for two ellipsoids the normal of a plane
    /// between them, from the first to the second.
    near: Vec<([usize; 2], Option<Vec3>)>,
}

impl<'a> Snapshot<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let view = View {
            time: 0.0,
            position: &[],
            attitude: &[],
            velocity: &[],
            to_observer: Vec3::zeros(),
            to_sun: Vec3::zeros(),
            distant: true,
        };
        Self {
            scene,
            view,
            poses: Vec::new(),
            light_directions: Vec::new(),
            suns: Vec::new(),
            near: Vec::new(),
        }
    }

    /// Replaces the view by another one.
    pub fn set_view(&mut self, view: &View<'a>, interrupt: &mut InterruptCheck) -> Result<()> {
        let semi_axes = &self.scene.semi_axes;
        let distant = view.directions(semi_axes.len())?;
        self.view = *view;
        self.poses.clear();
        self.poses.extend(semi_axes.iter().enumerate().map(|(body, semi_axes)| EllipsoidPose {
            body,
            semi_axes: semi_axes.unwrap_or_default(),
            position: view.position[body],
            rotation: rotation::matrix(view.attitude[body]),
        }));
        self.light_directions.clear();
        self.suns.clear();
        let observers = if view.distant { view.position.len().min(1) } else { view.position.len() };
        for position in &view.position[..observers] {
            let vectors = [view.to_observer, view.to_sun];
            let (directions, nearness, share) = if view.distant {
                (distant, [0.0; 2], 1.0)
            } else {
                let nearness = vectors.map(|vector| (vector - position).norm().recip());
                let share = [0, 1].map(|k| vectors[k].norm_squared() * nearness[k] * nearness[k]);
                ([0, 1].map(|k| (vectors[k] - position) * nearness[k]), nearness, share[0] * share[1])
            };
            self.light_directions.push((directions, nearness));
            let [e, s] = directions;
            match self.scene.sun.as_slice() {
                [[_, _, weight]] => self.suns.push((share * weight, directions)),
                _ => self.suns.extend(self.scene.suns(&s).map(|(weight, sun)| (share * weight, [e, sun]))),
            }
        }
        self.near.clear();
        if self.scene.hides() { self.find_close_pairs(interrupt) } else { Ok(()) }
    }

    /// Computes the brightness of each body by `compute`, which is called for every point of the Sun's disc with a
    /// result to which it may add, the body in the light from that point, the point's factor, and the
    /// directions to the observer and to the Sun's centre, and to the observer and to the point. `take` is
    /// called with the brightness and the result of each body.
    pub fn for_each_body<T: Default>(
        &self,
        interrupt: &mut InterruptCheck,
        compute: impl Fn(&mut T, &Target<'_>, f64, [&[Vec3; 2]; 2], &mut InterruptCheck) -> Result<f64>,
        mut take: impl FnMut(f64, T),
    ) -> Result<()> {
        let Scene { bodies, surfaces, .. } = self.scene;
        let name = |index: usize| format!("brightness of {} at time {}", bodies[index].name, self.view.time);
        let count = self.scene.sun.len();
        for (index, surface) in surfaces.iter().enumerate() {
            let suns = &self.suns[self.direction_index(index) * count..][..count];
            let (mut total, mut result) = (0.0, T::default());
            for (weight, directions) in suns {
                interrupt.charge(WORK, self.view.time)?;
                let (target, factor) = if let Some(facets) = bodies[index].facets() {
                    (Target::Convex(self.convex(index, facets, directions)), *weight)
                } else if self.needs_facets(index, directions) {
                    (Target::Facets(self.faceted(index, directions, interrupt)?), *weight)
                } else {
                    let (pose, time) = (&self.poses[index], self.view.time);
                    let in_front = self.bodies_in_front(index, directions);
                    let lit = LitEllipsoid::new(pose, &surface.law, time, *directions, in_front);
                    (Target::Ellipsoid(lit), weight * surface.albedo[0])
                };
                let directions = [&self.light_directions[self.direction_index(index)].0, directions];
                let light = compute(&mut result, &target, factor, directions, interrupt);
                total += factor
                    * light.map_err(|error| match error {
                        Error::NotConverged { detail, .. } => {
                            Error::NotConverged { what: name(index), detail }
                        }
                        other => other,
                    })?;
            }
            if !total.is_finite() {
                return Err(Error::invalid(name(index), total, "a finite number from the scattering law"));
            }
            take(total, result);
        }
        Ok(())
    }

    /// Finds the bodies that are near each other, with planes between them; returns an error for bodies that
    /// overlap.
    fn find_close_pairs(&mut self, interrupt: &mut InterruptCheck) -> Result<()> {
        let (bodies, view) = (&self.scene.bodies, self.view);
        for first in 0..bodies.len() {
            interrupt.charge(bodies.len() as u64, view.time)?;
            for second in first + 1..bodies.len() {
                let offset = view.position[second] - view.position[first];
                if offset.norm() > bodies[first].circumradius() + bodies[second].circumradius() {
                    continue;
                }
                let rotations = [&self.poses[first].rotation, &self.poses[second].rotation];
                let proximity = Proximity::compute(
                    [&bodies[first], &bodies[second]],
                    &offset,
                    rotations,
                    view.time,
                    interrupt,
                )?;
                if proximity.overlap {
                    let [first, second] = [first, second].map(|body| bodies[body].name.clone());
                    return Err(Error::BodiesOverlap { first, second, time: view.time });
                }
                let are_ellipsoids = [first, second].iter().all(|body| self.scene.semi_axes[*body].is_some());
                let shapes = [first, second].map(|body| &bodies[body].parts()[0].shape);
                let plane = are_ellipsoids.then(|| across_separating_plane(shapes, rotations, &offset));
                self.near.push(([first, second], plane));
            }
        }
        Ok(())
    }

    /// Returns whether a body may hide another one along a direction: it is in front of that one, or beside
    /// it and near.
    fn is_in_front(&self, other: usize, body: usize, direction: &Vec3) -> bool {
        let bodies = &self.scene.bodies;
        let offset = self.view.position[other] - self.view.position[body];
        let aside = offset - direction * offset.dot(direction);
        if aside.norm() >= bodies[body].circumradius() + bodies[other].circumradius() {
            return false;
        }
        // Any plane between two bodies tells which one is in front. Facets that are near each other are
        // compared one by one elsewhere.
        let near = self.near.iter().find_map(|([first, second], plane)| match [*first, *second] {
            pair if pair == [body, other] => Some(plane.map_or(*direction, |plane| plane)),
            pair if pair == [other, body] => Some(plane.map_or(*direction, |plane| -plane)),
            _ => None,
        });
        near.unwrap_or(offset).dot(direction) > 0.0
    }

    /// Iterates over the bodies that may hide the observer or the Sun from a body.
    fn others(&self, body: usize, directions: &[Vec3; 2]) -> impl Iterator<Item = usize> {
        let count = if self.scene.hides() { self.poses.len() } else { 0 };
        (0..count).filter(move |&other| {
            other != body && directions.iter().any(|direction| self.is_in_front(other, body, direction))
        })
    }

    /// Returns whether a body, or one that may hide light from it, is not an ellipsoid.
    pub fn needs_facets(&self, body: usize, directions: &[Vec3; 2]) -> bool {
        let Scene { meshes, semi_axes, .. } = self.scene;
        !meshes.is_empty()
            && (semi_axes[body].is_none()
                || self.others(body, directions).any(|other| semi_axes[other].is_none()))
    }

    /// Returns the surface of a body in light from these directions.
    fn surface(&self, body: usize, [e, s]: &[Vec3; 2]) -> SurfaceLight<'a> {
        let Surface { law, albedo } = &self.scene.surfaces[body];
        let scattering = law.at(e.cross(s).norm().atan2(e.dot(s)));
        SurfaceLight { law, scattering, albedo, time: self.view.time }
    }

    /// Returns a convex body in sunlight by the areas of its facets.
    fn convex(&self, body: usize, facets: &'a Facets, directions: &[Vec3; 2]) -> ConvexBody<'a> {
        let rotation = self.poses[body].rotation;
        let lights = directions.map(|direction| rotation.tr_mul(&direction));
        ConvexBody { body, facets, surface: self.surface(body, directions), rotation, lights }
    }

    /// Returns a body in sunlight by its facets.
    fn faceted(
        &self,
        body: usize,
        directions: &[Vec3; 2],
        interrupt: &mut InterruptCheck,
    ) -> Result<FacetedBody<'a>> {
        let surface = self.surface(body, directions);
        Ok(FacetedBody { parts: self.parts(body, directions, interrupt)?, surface })
    }

    /// Returns the facets of the parts of a body, with the parts that may hide either direction from them.
    pub fn parts(
        &self,
        body: usize,
        directions: &[Vec3; 2],
        interrupt: &mut InterruptCheck,
    ) -> Result<Vec<FacetedPart<'a>>> {
        let all: Vec<usize> = std::iter::once(body).chain(self.others(body, directions)).collect();
        let part = |mesh: &'a Mesh| {
            let rotation = self.poses[body].rotation * mesh.pose.1;
            let lights = directions.map(|direction| rotation.tr_mul(&direction));
            let occluders = self.occluders(mesh, directions, &all);
            Ok(FacetedPart { mesh, horizons: mesh.horizons(interrupt)?, rotation, lights, occluders })
        };
        self.scene.meshes.iter().filter(|mesh| mesh.indices[0] == body).map(part).collect()
    }

    /// Returns the parts of some bodies that may hide light from a part.
    fn occluders(&self, mesh: &Mesh, directions: &[Vec3; 2], bodies: &[usize]) -> Vec<Occluder<'a>> {
        let body = mesh.indices[0];
        let EllipsoidPose { position: centre, rotation, .. } = self.poses[body];
        let (origin, part_rotation) = (rotation * mesh.pose.0, rotation * mesh.pose.1);
        let others = self.scene.meshes.iter().filter(|other| other.indices != mesh.indices);
        let mut all = Vec::new();
        for other in others.filter(|other| bodies.contains(&other.indices[0])) {
            for light in [Light::Sight, Light::Sun] {
                let (other_pose, growth) = self.pose_in_light(light, other.indices[0], body, directions);
                let offset =
                    other_pose.position - centre + other_pose.rotation * other.pose.0 * growth - origin;
                let back = |v: &Vec3| part_rotation.tr_mul(v);
                let pose = (back(&offset), part_rotation.tr_mul(&(other_pose.rotation * other.pose.1)));
                let direction = back(&directions[light as usize]);
                all.extend(Occluder::new(mesh, other, pose, growth, light as usize, &direction));
            }
        }
        all
    }

    /// Returns the index of a body in the lists of directions.
    fn direction_index(&self, body: usize) -> usize {
        if self.view.distant { 0 } else { body }
    }

    /// Returns the pose that a body had when the light that arrives from another body passed it, and the factor by which
    /// it is enlarged about the centre of that other body, so that it hides along one direction what it hides in the
    /// cone of a near observer or Sun. The observer's light left both at the positions of the view; sunlight passed the
    /// first one by D.(e + s) / c before that, D its position relative to the second one.
    #[inline(always)]
    fn pose_in_light(
        &self,
        light: Light,
        other: usize,
        body: usize,
        directions: &[Vec3; 2],
    ) -> (EllipsoidPose, f64) {
        let (mut pose, [e, s], centre) = (self.poses[other], directions, self.poses[body].position);
        if let (Light::Sun, Some(velocity)) = (light, self.view.velocity.get(other)) {
            pose.position -= velocity * (pose.position - centre).dot(&(e + s));
        }
        if self.view.distant || other == body {
            return (pose, 1.0);
        }
        let nearness = self.light_directions[body].1[light as usize];
        let offset = pose.position - centre;
        let growth = (1.0 - offset.dot(&directions[light as usize]) * nearness).recip();
        (pose.position, pose.semi_axes) = (centre + offset * growth, pose.semi_axes * growth);
        (pose, growth)
    }

    /// Returns unit vectors from a body to the observer and to the Sun.
    pub fn directions(&self, body: usize) -> [Vec3; 2] {
        self.light_directions[self.direction_index(body)].0
    }

    /// Returns the pose of a body, with semi-axes of zero if it is not one ellipsoid about its centre.
    pub fn pose(&self, body: usize) -> &EllipsoidPose {
        &self.poses[body]
    }

    /// Iterates over the ellipsoids that may hide light from a body.
    pub fn bodies_in_front(
        &self,
        body: usize,
        directions: &[Vec3; 2],
    ) -> impl Iterator<Item = (Light, EllipsoidPose)> {
        let has_occultations = self.scene.hides();
        let directions = *directions;
        [Light::Sight, Light::Sun].into_iter().filter(move |_| has_occultations).flat_map(move |light| {
            let direction = directions[light as usize];
            let others = self
                .poses
                .iter()
                .filter(move |other| other.body != body && self.is_in_front(other.body, body, &direction));
            others.map(move |other| (light, self.pose_in_light(light, other.body, body, &directions).0))
        })
    }
}

impl Partials {
    /// Returns derivatives of zero with respect to the same quantities.
    pub fn zeros(&self) -> Self {
        Self {
            by_body: vec![ByBody::default(); self.by_body.len()],
            by_direction: [Vec3::zeros(); 2],
            by_vertex: self.by_vertex.iter().map(|by| vec![Vec3::zeros(); by.len()]).collect(),
            by_area: self.by_area.iter().map(|by| vec![0.0; by.len()]).collect(),
        }
    }

    /// Adds derivatives times a factor. A derivative with respect to the direction to a point of the Sun's
    /// disc counts as one with respect to the direction to its centre, with which the disc rotates.
    pub fn add(&mut self, part: &Self, factor: f64, [centre, position]: [&[Vec3; 2]; 2]) {
        for (sum, by) in self.by_body.iter_mut().zip(&part.by_body) {
            sum.position += by.position * factor;
            sum.rotation += by.rotation * factor;
            sum.semi_axes += by.semi_axes * factor;
        }
        for (sums, by) in self.by_vertex.iter_mut().zip(&part.by_vertex) {
            sums.iter_mut().zip(by).for_each(|(sum, by)| *sum += by * factor);
        }
        for (sums, by) in self.by_area.iter_mut().zip(&part.by_area) {
            sums.iter_mut().zip(by).for_each(|(sum, by)| *sum += by * factor);
        }
        for k in 0..2 {
            // The directions are unit vectors, so that derivatives along them have no meaning.
            let rotated = position[k].cross(&part.by_direction[k]).cross(&centre[k]);
            self.by_direction[k] += rotated * factor;
        }
    }
}
