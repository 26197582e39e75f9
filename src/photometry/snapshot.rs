//! Bodies at one epoch or at many: which bodies hide light from which, and the Sun's disc.

use super::ellipsoid::{ByBody, Lit, Partials, Placed};
use super::facets::{Faceted, Mesh};
use super::law::Law;
use super::outline::Light;
use super::rule::Rule;
use crate::error::{Error, Result, require_finite};
use crate::interrupt::{InterruptCheck, UNITS};
use crate::math::{Mat3, Vec3, rotation};
use crate::shape::{Body, Part, Proximity, Shape, normal};
use gauss_quad::GaussLegendre;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::num::NonZeroUsize;

/// How a body reflects light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// The scattering law.
    pub law: Law,
    /// The albedo, by which the brightness is multiplied.
    pub albedo: f64,
}

impl Surface {
    /// Returns the units of work of one ellipsoid in a mutual event, in light from one point.
    fn work(&self) -> u64 {
        const WORK: u64 = 1000;
        if self.law.constant().is_some() { WORK } else { 100 * WORK }
    }
}

/// Positions and attitudes of all bodies at an epoch, and the directions to the observer and to the Sun.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// The time, which error messages name.
    pub time: f64,
    /// Positions of the centres, inertial.
    pub position: &'a [Vec3],
    /// Unit quaternions from the body frames to the inertial frame.
    pub attitude: &'a [[f64; 4]],
    /// A vector of any length toward the observer.
    pub to_observer: Vec3,
    /// A vector of any length toward the Sun.
    pub to_sun: Vec3,
}

/// Bodies and surfaces whose brightness is computed.
#[derive(Debug, Clone)]
pub struct Photometer {
    bodies: Vec<Body>,
    surfaces: Vec<Surface>,
    mutual: bool,
    /// Points of the Sun's disc, each as two coordinates in radians from its centre and a weight.
    sun: Vec<[f64; 3]>,
    rule: Rule,
    /// The facets of each body; empty where all bodies are ellipsoids.
    meshes: Vec<Mesh>,
}

/// Numbers of rings on the Sun's disc and of points on each ring.
const RINGS: NonZeroUsize = NonZeroUsize::new(6).unwrap();
const PLACES: usize = 12;

impl Photometer {
    /// Takes bodies with their surfaces. If `mutual` is false, occultations and eclipses are neglected. The
    /// Sun's radius is an angle in radians, zero for parallel light.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] if the numbers of bodies and surfaces differ, and for an albedo, a law or a
    /// radius of the Sun out of its range.
    pub fn new(bodies: Vec<Body>, surfaces: Vec<Surface>, mutual: bool, sun_radius: f64) -> Result<Self> {
        if surfaces.len() != bodies.len() {
            return Err(Error::invalid("number of surfaces", surfaces.len(), format!("{}", bodies.len())));
        }
        for (body, surface) in bodies.iter().zip(&surfaces) {
            if !(surface.albedo >= 0.0 && surface.albedo.is_finite()) {
                let what = format!("albedo of {}", body.name);
                return Err(Error::invalid(what, surface.albedo, "a finite number, zero or above"));
            }
            surface.law.check().map_err(|error| error.of(&format!("the scattering law of {}", body.name)))?;
        }
        if !(0.0..1.0).contains(&sun_radius) {
            return Err(Error::invalid("sun_radius", sun_radius, "an angle from 0 to below 1 radian"));
        }
        let all_exact = bodies.iter().all(|body| ellipsoid(body).is_some());
        let meshes = if all_exact { Vec::new() } else { bodies.iter().map(Mesh::new).collect() };
        Ok(Self { meshes, bodies, surfaces, mutual, sun: disc(sun_radius), rule: Rule::default() })
    }

    /// Returns the bodies.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns the brightness of each body.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a view with another number of bodies or with numbers that are not finite,
    /// [`Error::BodiesOverlap`], and [`Error::Interrupted`].
    pub fn brightness(&self, view: &View<'_>, interrupt: &mut InterruptCheck) -> Result<Vec<f64>> {
        let all = self.each(view, interrupt, |_: &mut (), lit, _, _| lit.brightness())?;
        Ok(all.into_iter().map(|(brightness, ())| brightness).collect())
    }

    /// Returns the brightness of each body with its derivatives. The derivative by the albedo is not among
    /// them: it is the brightness divided by the albedo.
    ///
    /// # Errors
    /// Those of [`Self::brightness`], and [`Error::InvalidInput`] for a body that is not an ellipsoid and for
    /// a law of a rough surface.
    pub fn partials(&self, view: &View<'_>, interrupt: &mut InterruptCheck) -> Result<Vec<(f64, Partials)>> {
        for (body, surface) in self.bodies.iter().zip(&self.surfaces) {
            if ellipsoid(body).is_none() {
                let expected = "an ellipsoid or a sphere, which alone have derivatives of their brightness";
                return Err(Error::invalid(format!("shape of {}", body.name), "another one", expected));
            }
            if surface.law.has_edges() {
                let what = format!("roughness of the scattering law of {}", body.name);
                return Err(Error::invalid(what, "above zero", "zero, with which there are derivatives"));
            }
        }
        let none = || Partials { by_body: vec![ByBody::default(); self.bodies.len()], ..Partials::default() };
        self.each(view, interrupt, |sums: &mut Option<Partials>, lit, factor, directions| {
            let mut part = none();
            let brightness = lit.partials(&mut part);
            sums.get_or_insert_with(none).add(&part, factor, directions);
            brightness
        })
        .map(|all| all.into_iter().map(|(value, sums)| (value, sums.unwrap_or_else(none))).collect())
    }

    /// Computes `of` for each view and returns the results in order. Short views are distributed over the
    /// threads of the machine. In a long one, such as a view of facets, the threads share the work, and the
    /// view itself checks for interrupts.
    ///
    /// # Errors
    /// The first error of `of` in the order of the views, and [`Error::Interrupted`].
    pub fn many<T: Send>(
        &self,
        views: &[View<'_>],
        interrupt: &mut InterruptCheck,
        of: impl Fn(&Self, &View<'_>, &mut InterruptCheck) -> Result<T> + Sync,
    ) -> Result<Vec<T>> {
        let mut all = Vec::with_capacity(views.len());
        let short = self.meshes.is_empty() && self.work() <= 5 * UNITS;
        let group =
            if short { (UNITS / self.work()).max(1) as usize * rayon::current_num_threads() } else { 1 };
        for views in views.chunks(group) {
            interrupt.charge(UNITS, views[0].time)?;
            if let [view] = views {
                all.push(of(self, view, interrupt)?);
                continue;
            }
            let alone = |view| of(self, view, &mut InterruptCheck::never());
            let answers: Vec<_> = views.par_iter().map(alone).collect();
            for answer in answers {
                all.push(answer?);
            }
        }
        Ok(all)
    }

    /// Returns the units of work of a view, as if all bodies were ellipsoids.
    fn work(&self) -> u64 {
        self.sun.len() as u64 * self.surfaces.iter().map(Surface::work).sum::<u64>().max(1)
    }

    /// Computes the brightness of each body by `of`, which is called for every point of the Sun's disc with a
    /// result to which it may add, the ellipsoid in the light from that point, the point's factor, and two
    /// pairs of directions: to the observer and to the Sun's centre, and to the observer and to the point.
    fn each<T: Default>(
        &self,
        view: &View<'_>,
        interrupt: &mut InterruptCheck,
        of: impl Fn(&mut T, &Lit<'_>, f64, [&[Vec3; 2]; 2]) -> f64,
    ) -> Result<Vec<(f64, T)>> {
        let snapshot = Snapshot::new(self, view, interrupt)?;
        let mut all = Vec::with_capacity(self.bodies.len());
        for (index, surface) in self.surfaces.iter().enumerate() {
            let (mut total, mut gathered) = (0.0, T::default());
            for (weight, directions) in &snapshot.suns {
                interrupt.charge(surface.work(), view.time)?;
                let factor = weight * surface.albedo;
                if snapshot.needs_facets(index, directions) {
                    total += factor * snapshot.faceted(index, directions, interrupt)?;
                    continue;
                }
                let Some(placed) = &snapshot.placed[index] else { continue };
                let before = snapshot.before(index, directions);
                let lit = Lit::new(placed, &surface.law, &self.rule, *directions, before);
                total += factor * of(&mut gathered, &lit, factor, [&snapshot.centre, directions]);
            }
            if !total.is_finite() {
                let what = format!("brightness of {} at time {}", self.bodies[index].name, view.time);
                return Err(Error::invalid(what, total, "a finite number from the scattering law"));
            }
            all.push((total, gathered));
        }
        Ok(all)
    }
}

/// A view as it is seen: every body in its pose, and the bodies that are near each other.
struct Snapshot<'a> {
    photometer: &'a Photometer,
    view: &'a View<'a>,
    rotations: Vec<Mat3>,
    /// The ellipsoid of each body that is one ellipsoid about its centre.
    placed: Vec<Option<Placed>>,
    /// Directions to the observer and to the Sun's centre.
    centre: [Vec3; 2],
    /// Weights of the points of the Sun's disc, with the directions to the observer and to the point.
    suns: Vec<(f64, [Vec3; 2])>,
    /// Pairs of bodies whose circumscribed spheres overlap, and for two ellipsoids the normal of a plane
    /// between them, from the first to the second.
    near: Vec<([usize; 2], Option<Vec3>)>,
}

impl<'a> Snapshot<'a> {
    fn new(photometer: &'a Photometer, view: &'a View<'a>, interrupt: &mut InterruptCheck) -> Result<Self> {
        let bodies = &photometer.bodies;
        let [e, s] = view.directions(bodies.len())?;
        let rotations: Vec<Mat3> = view.attitude.iter().map(|&q| rotation::matrix(q)).collect();
        let place = |(index, body): (usize, &Body)| {
            ellipsoid(body).map(|semi_axes| Placed {
                body: index,
                semi_axes,
                position: view.position[index],
                rotation: rotations[index],
            })
        };
        let placed = bodies.iter().enumerate().map(place).collect();
        let suns = photometer.suns(&s).map(|(weight, sun)| (weight, [e, sun])).collect();
        let mut snapshot =
            Self { photometer, view, rotations, placed, centre: [e, s], suns, near: Vec::new() };
        if photometer.mutual {
            snapshot.look_between(interrupt)?;
        }
        Ok(snapshot)
    }

    /// Finds the bodies that are near each other, with planes between them; returns an error for bodies that
    /// overlap.
    fn look_between(&mut self, interrupt: &mut InterruptCheck) -> Result<()> {
        let (bodies, view) = (&self.photometer.bodies, self.view);
        for first in 0..bodies.len() {
            interrupt.charge(bodies.len() as u64, view.time)?;
            for second in first + 1..bodies.len() {
                let from = view.position[second] - view.position[first];
                if from.norm() > bodies[first].circumradius() + bodies[second].circumradius() {
                    continue;
                }
                let turns = [&self.rotations[first], &self.rotations[second]];
                let meeting =
                    Proximity::of([&bodies[first], &bodies[second]], &from, turns, view.time, interrupt)?;
                if meeting.overlap {
                    let [first, second] = [first, second].map(|body| bodies[body].name.clone());
                    return Err(Error::BodiesOverlap { first, second, time: view.time });
                }
                let both = self.placed[first].is_some() && self.placed[second].is_some();
                let shapes = [first, second].map(|body| &bodies[body].parts()[0].shape);
                let plane = both.then(|| normal(shapes, turns, &from, &mut 0.0).unwrap_or(from));
                self.near.push(([first, second], plane));
            }
        }
        Ok(())
    }

    /// Returns whether a body may hide another one along a direction: it is in front of that one, or beside
    /// it and near.
    fn is_before(&self, other: usize, body: usize, direction: &Vec3) -> bool {
        let bodies = &self.photometer.bodies;
        let from = self.view.position[other] - self.view.position[body];
        let aside = from - direction * from.dot(direction);
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
        near.unwrap_or(from).dot(direction) > 0.0
    }

    /// Iterates over the bodies that may hide the observer or the Sun from a body.
    fn others(&self, body: usize, directions: &[Vec3; 2]) -> impl Iterator<Item = usize> {
        let count = if self.photometer.mutual { self.placed.len() } else { 0 };
        (0..count).filter(move |&other| {
            other != body && directions.iter().any(|direction| self.is_before(other, body, direction))
        })
    }

    /// Returns whether a body, or one that may hide light from it, is not an ellipsoid.
    fn needs_facets(&self, body: usize, directions: &[Vec3; 2]) -> bool {
        !self.photometer.meshes.is_empty()
            && (self.placed[body].is_none()
                || self.others(body, directions).any(|other| self.placed[other].is_none()))
    }

    /// Returns the brightness of a body by its facets. An ellipsoid has its exact brightness less what is
    /// hidden of its facets.
    fn faceted(&self, body: usize, directions: &[Vec3; 2], interrupt: &mut InterruptCheck) -> Result<f64> {
        let Photometer { surfaces, meshes, rule, .. } = self.photometer;
        let law = &surfaces[body].law;
        let place = |k: usize| (k, &meshes[k], self.view.position[k], self.rotations[k]);
        let all: Vec<_> = std::iter::once(body).chain(self.others(body, directions)).map(place).collect();
        let faceted = Faceted::new(&all, directions);
        let [e, s] = directions;
        let phase = e.cross(s).norm().atan2(e.dot(s));
        let facets = faceted.brightness(0, &law.at(phase), self.view.time, interrupt)?;
        let mut total: f64 = facets.iter().map(|[left, _]| left).sum();
        for (part, range) in &meshes[body].ellipsoids {
            let placed = Placed {
                body,
                semi_axes: Vec3::from(part.shape.semi_axes()),
                position: self.view.position[body],
                rotation: self.rotations[body] * part.rotation(),
            };
            let whole: f64 = facets[range.clone()].iter().map(|[_, whole]| whole).sum();
            total += Lit::new(&placed, law, rule, *directions, std::iter::empty()).brightness() - whole;
        }
        Ok(total.max(0.0))
    }

    /// Iterates over the ellipsoids that may hide light from a body.
    fn before(&self, body: usize, directions: &[Vec3; 2]) -> impl Iterator<Item = (Light, &Placed)> {
        let mutual = self.photometer.mutual;
        let lights = [(Light::Sight, directions[0]), (Light::Sun, directions[1])];
        lights.into_iter().filter(move |_| mutual).flat_map(move |(light, direction)| {
            let others = self
                .placed
                .iter()
                .flatten()
                .filter(move |other| other.body != body && self.is_before(other.body, body, &direction));
            others.map(move |other| (light, other))
        })
    }
}

/// Returns the semi-axes of a body that is one ellipsoid about its centre; `None` for another body.
fn ellipsoid(body: &Body) -> Option<Vec3> {
    match body.parts() {
        [Part { shape: Shape::Ellipsoid(ellipsoid), place: None, .. }] => {
            Some(Vec3::from(ellipsoid.semi_axes()))
        }
        _ => None,
    }
}

impl View<'_> {
    /// Returns unit vectors to the observer and to the Sun, or an error that says what is wrong with the
    /// view.
    fn directions(&self, bodies: usize) -> Result<[Vec3; 2]> {
        for (what, count) in [("positions", self.position.len()), ("attitudes", self.attitude.len())] {
            if count != bodies {
                return Err(Error::invalid(format!("number of {what}"), count, format!("{bodies}")));
            }
        }
        for (body, (position, attitude)) in self.position.iter().zip(self.attitude).enumerate() {
            if !position.iter().chain(attitude).all(|number| number.is_finite()) {
                require_finite(&format!("position of body {body}"), position.as_slice())?;
                require_finite(&format!("attitude of body {body}"), attitude)?;
            }
            if *attitude == [0.0; 4] {
                let expected = "a quaternion [w, x, y, z] of non-zero length";
                return Err(Error::invalid(format!("attitude of body {body}"), "[0, 0, 0, 0]", expected));
            }
        }
        let unit = |what: &str, direction: &Vec3| {
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

impl Photometer {
    /// Iterates over the weights of the points of the Sun's disc and the unit vectors to them, for a unit
    /// vector to its centre.
    fn suns(&self, to_sun: &Vec3) -> impl Iterator<Item = (f64, Vec3)> {
        let mut axis = Vec3::zeros();
        axis[to_sun.iamin()] = 1.0;
        let first = to_sun.cross(&axis).normalize();
        let (second, to_sun) = (to_sun.cross(&first), *to_sun);
        self.sun.iter().map(move |[x, y, weight]| (*weight, (to_sun + first * *x + second * *y).normalize()))
    }
}

impl Partials {
    /// Adds derivatives times a factor. A derivative by the direction to a point of the Sun's disc counts as
    /// one by the direction to its centre, with which the disc rotates.
    fn add(&mut self, part: &Self, factor: f64, [centre, place]: [&[Vec3; 2]; 2]) {
        for (sum, by) in self.by_body.iter_mut().zip(&part.by_body) {
            sum.position += by.position * factor;
            sum.rotation += by.rotation * factor;
            sum.semi_axes += by.semi_axes * factor;
        }
        for k in 0..2 {
            // The directions are unit vectors, so that derivatives along them have no meaning.
            let turned = place[k].cross(&part.by_direction[k]).cross(&centre[k]);
            self.by_direction[k] += turned * factor;
        }
    }
}

/// Returns points of the Sun's disc with weights: Gauss's rule in the squared radius, and equal angles that
/// are shifted from ring to ring.
fn disc(radius: f64) -> Vec<[f64; 3]> {
    if radius == 0.0 {
        return vec![[0.0, 0.0, 1.0]];
    }
    let rule = GaussLegendre::new(RINGS);
    let rings = rule.nodes().zip(rule.weights()).enumerate();
    let ring = |(index, (x, weight)): (usize, (&f64, &f64))| {
        let distance = radius.tan() * (0.5 * (1.0 + x)).sqrt();
        let weight = 0.5 * weight / PLACES as f64;
        (0..PLACES).map(move |place| {
            let angle = TAU * (place as f64 + 0.5 * (index % 2) as f64) / PLACES as f64;
            [distance * angle.cos(), distance * angle.sin(), weight]
        })
    };
    rings.flat_map(ring).collect()
}
