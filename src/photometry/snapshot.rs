//! Bodies at one epoch or at many: which bodies hide light from which, and the Sun's disc.

use super::ellipsoid::{ByBody, Lit, Partials, Placed};
use super::facets::{Faceted, Mesh};
use super::law::Law;
use super::outline::Light;
use crate::error::{Error, Result, require_finite};
use crate::interrupt::{InterruptCheck, UNITS};
use crate::math::{Vec3, perpendicular, rotation};
use crate::shape::{Body, Part, Proximity, Shape, across_separating_plane};
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
    /// Returns the units of work of one ellipsoid in light from one point, which others may hide or not.
    fn work(&self, mutual: bool) -> u64 {
        match (self.law.constant(), mutual) {
            (Some(_), false) => WORK,
            (Some(_), true) => 1000,
            (None, _) => 100_000,
        }
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
///
/// ```
/// use fullbody::interrupt::InterruptCheck;
/// use fullbody::math::Vec3;
/// use fullbody::photometry::{Law, Photometer, Surface, View};
/// use fullbody::shape::{Body, Shape};
/// use std::f64::consts::PI;
///
/// // A ball of radius 2 at full phase reflects pi r^2 / 2 by Lommel-Seeliger's law.
/// let ball = Body::with_mass("Ball", Shape::ellipsoid([2.0, 2.0, 2.0])?, 1.0)?;
/// let surface = Surface { law: Law::LOMMEL_SEELIGER, albedo: 1.0 };
/// let photometer = Photometer::new(vec![ball], vec![surface], true, 0.0)?;
/// let toward = Vec3::new(0.0, 0.0, 1.0);
/// let (position, attitude) = ([Vec3::zeros()], [[1.0, 0.0, 0.0, 0.0]]);
/// let view =
///     View { time: 0.0, position: &position, attitude: &attitude, to_observer: toward, to_sun: toward };
/// let brightness = photometer.brightness(&view, &mut InterruptCheck::never())?;
/// assert!((brightness[0] - 2.0 * PI).abs() < 1e-14);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Photometer {
    bodies: Vec<Body>,
    surfaces: Vec<Surface>,
    mutual: bool,
    /// Points of the Sun's disc, each as two coordinates in radians from its centre and a weight.
    sun: Vec<[f64; 3]>,
    /// The semi-axes of each body that is one ellipsoid about its centre.
    semi_axes: Vec<Option<Vec3>>,
    /// The facets of each body; empty where all bodies are ellipsoids.
    meshes: Vec<Mesh>,
}

/// Units of work of one ellipsoid, beside those of the integrals.
const WORK: u64 = 10;

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
        let semi_axes: Vec<_> = bodies.iter().map(ellipsoid).collect();
        let all_exact = semi_axes.iter().all(Option::is_some);
        let meshes = if all_exact { Vec::new() } else { bodies.iter().map(Mesh::new).collect() };
        Ok(Self { bodies, surfaces, mutual, sun: disc(sun_radius), semi_axes, meshes })
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
        self.brightness_in(std::slice::from_ref(view), interrupt)
    }

    /// Returns the brightness of each body in each view: those in the first view, then those in the second.
    ///
    /// # Errors
    /// Returns the errors of [`Self::brightness`].
    pub fn brightness_in(&self, views: &[View<'_>], interrupt: &mut InterruptCheck) -> Result<Vec<f64>> {
        self.many(views, interrupt, |snapshot, interrupt, all| {
            let of = |_: &mut (), lit: &Lit<'_>, _, _: &_, interrupt: &mut InterruptCheck<'_>| {
                lit.brightness(interrupt)
            };
            snapshot.each(interrupt, of, |brightness, ()| all.push(brightness))
        })
    }

    /// Returns the brightness of each body with its derivatives. The derivative with respect to the albedo is
    /// not among them: it is the brightness divided by the albedo.
    ///
    /// # Errors
    /// Returns the errors of [`Self::brightness`], and [`Error::InvalidInput`] for a body that is not an
    /// ellipsoid and for a law of a rough surface.
    pub fn partials(&self, view: &View<'_>, interrupt: &mut InterruptCheck) -> Result<Vec<(f64, Partials)>> {
        self.partials_in(std::slice::from_ref(view), interrupt)
    }

    /// Returns the brightness of each body in each view, with its derivatives.
    ///
    /// # Errors
    /// Returns the errors of [`Self::partials`].
    pub fn partials_in(
        &self,
        views: &[View<'_>],
        interrupt: &mut InterruptCheck,
    ) -> Result<Vec<(f64, Partials)>> {
        for ((body, surface), semi_axes) in self.bodies.iter().zip(&self.surfaces).zip(&self.semi_axes) {
            if semi_axes.is_none() {
                let expected = "an ellipsoid or a sphere, which alone have derivatives of their brightness";
                return Err(Error::invalid(format!("shape of {}", body.name), "another one", expected));
            }
            if surface.law.has_edges() {
                let what = format!("roughness of the scattering law of {}", body.name);
                return Err(Error::invalid(what, "above zero", "zero, with which there are derivatives"));
            }
        }
        let none = || Partials { by_body: vec![ByBody::default(); self.bodies.len()], ..Partials::default() };
        self.many(views, interrupt, |snapshot, interrupt, all| {
            let of = |sums: &mut Option<Partials>,
                      lit: &Lit<'_>,
                      factor,
                      directions: &_,
                      interrupt: &mut InterruptCheck<'_>| {
                let mut part = none();
                let brightness = lit.partials(&mut part, interrupt)?;
                sums.get_or_insert_with(none).add(&part, factor, [&snapshot.centre, directions]);
                Ok(brightness)
            };
            snapshot.each(interrupt, of, |value, sums| all.push((value, sums.unwrap_or_else(none))))
        })
    }

    /// Adds what `of` appends for each view to a list, in order. Short views are distributed over the threads
    /// of the machine. In a long one, such as a view of facets, the threads share the work, and the view
    /// itself checks for interrupts.
    fn many<'a, T: Send>(
        &'a self,
        views: &[View<'a>],
        interrupt: &mut InterruptCheck,
        of: impl Fn(&Snapshot<'a>, &mut InterruptCheck, &mut Vec<T>) -> Result<()> + Sync,
    ) -> Result<Vec<T>> {
        let some = |views: &[View<'a>], interrupt: &mut InterruptCheck| {
            let mut all = Vec::with_capacity(views.len() * self.bodies.len());
            let mut snapshot = Snapshot::new(self);
            for view in views {
                snapshot.look(view, interrupt)?;
                of(&snapshot, interrupt, &mut all)?;
            }
            Ok(all)
        };
        let work: u64 = self.surfaces.iter().map(|surface| surface.work(self.hides())).sum();
        let work = self.sun.len() as u64 * work.max(1);
        let threads = rayon::current_num_threads();
        if threads == 1 || views.len() == 1 || work > 5 * UNITS || !self.meshes.is_empty() {
            return some(views, interrupt);
        }
        let share = (UNITS / work).max(1) as usize;
        let mut all = Vec::with_capacity(views.len() * self.bodies.len());
        for group in views.chunks(share * threads) {
            interrupt.charge(UNITS, group[0].time)?;
            let share = group.len().div_ceil(threads);
            let parts = group.par_chunks(share).map(|views| some(views, &mut InterruptCheck::never()));
            for part in parts.collect::<Vec<_>>() {
                all.extend(part?);
            }
        }
        Ok(all)
    }

    /// Returns whether a body can hide another one.
    fn hides(&self) -> bool {
        self.mutual && self.bodies.len() > 1
    }
}

/// A view as it is seen: every body in its pose, and the bodies that are near each other. One snapshot serves
/// for many views, so that it allocates once.
struct Snapshot<'a> {
    photometer: &'a Photometer,
    view: View<'a>,
    /// The pose of each body, with semi-axes of zero for a body that is not one ellipsoid about its centre.
    placed: Vec<Placed>,
    /// Directions to the observer and to the Sun's centre.
    centre: [Vec3; 2],
    /// Weights of the points of the Sun's disc, with the directions to the observer and to the point.
    suns: Vec<(f64, [Vec3; 2])>,
    /// Pairs of bodies whose circumscribed spheres overlap, and for two ellipsoids the normal of a plane
    /// between them, from the first to the second.
    near: Vec<([usize; 2], Option<Vec3>)>,
}

impl<'a> Snapshot<'a> {
    fn new(photometer: &'a Photometer) -> Self {
        let view = View {
            time: 0.0,
            position: &[],
            attitude: &[],
            to_observer: Vec3::zeros(),
            to_sun: Vec3::zeros(),
        };
        let (placed, suns, near) = (Vec::new(), Vec::new(), Vec::new());
        Self { photometer, view, placed, centre: [Vec3::zeros(); 2], suns, near }
    }

    /// Takes a view in place of the one before.
    fn look(&mut self, view: &View<'a>, interrupt: &mut InterruptCheck) -> Result<()> {
        let semi_axes = &self.photometer.semi_axes;
        let [e, s] = view.directions(semi_axes.len())?;
        (self.view, self.centre) = (*view, [e, s]);
        self.placed.clear();
        self.placed.extend(semi_axes.iter().enumerate().map(|(body, semi_axes)| Placed {
            body,
            semi_axes: semi_axes.unwrap_or_default(),
            position: view.position[body],
            rotation: rotation::matrix(view.attitude[body]),
        }));
        self.suns.clear();
        match self.photometer.sun.as_slice() {
            [[_, _, weight]] => self.suns.push((*weight, [e, s])),
            _ => self.suns.extend(self.photometer.suns(&s).map(|(weight, sun)| (weight, [e, sun]))),
        }
        self.near.clear();
        if self.photometer.hides() { self.look_between(interrupt) } else { Ok(()) }
    }

    /// Computes the brightness of each body by `of`, which is called for every point of the Sun's disc with a
    /// result to which it may add, the ellipsoid in the light from that point, the point's factor, and the
    /// directions to the observer and to the point. `take` is called with the brightness and the result of
    /// each body.
    fn each<T: Default>(
        &self,
        interrupt: &mut InterruptCheck,
        of: impl Fn(&mut T, &Lit<'_>, f64, &[Vec3; 2], &mut InterruptCheck) -> Result<f64>,
        mut take: impl FnMut(f64, T),
    ) -> Result<()> {
        let Photometer { bodies, surfaces, .. } = self.photometer;
        let name = |index: usize| format!("brightness of {} at time {}", bodies[index].name, self.view.time);
        for (index, surface) in surfaces.iter().enumerate() {
            let (mut total, mut gathered) = (0.0, T::default());
            for (weight, directions) in &self.suns {
                interrupt.charge(WORK, self.view.time)?;
                let factor = weight * surface.albedo;
                if self.needs_facets(index, directions) {
                    total += factor * self.faceted(index, directions, interrupt)?;
                    continue;
                }
                let before = self.before(index, directions);
                let lit = Lit::new(&self.placed[index], &surface.law, self.view.time, *directions, before);
                let light = of(&mut gathered, &lit, factor, directions, interrupt);
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
            take(total, gathered);
        }
        Ok(())
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
                let turns = [&self.placed[first].rotation, &self.placed[second].rotation];
                let meeting =
                    Proximity::of([&bodies[first], &bodies[second]], &from, turns, view.time, interrupt)?;
                if meeting.overlap {
                    let [first, second] = [first, second].map(|body| bodies[body].name.clone());
                    return Err(Error::BodiesOverlap { first, second, time: view.time });
                }
                let both = [first, second].iter().all(|body| self.photometer.semi_axes[*body].is_some());
                let shapes = [first, second].map(|body| &bodies[body].parts()[0].shape);
                let plane = both.then(|| across_separating_plane(shapes, turns, &from));
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
        let count = if self.photometer.hides() { self.placed.len() } else { 0 };
        (0..count).filter(move |&other| {
            other != body && directions.iter().any(|direction| self.is_before(other, body, direction))
        })
    }

    /// Returns whether a body, or one that may hide light from it, is not an ellipsoid.
    fn needs_facets(&self, body: usize, directions: &[Vec3; 2]) -> bool {
        let Photometer { meshes, semi_axes, .. } = self.photometer;
        !meshes.is_empty()
            && (semi_axes[body].is_none()
                || self.others(body, directions).any(|other| semi_axes[other].is_none()))
    }

    /// Returns the brightness of a body by its facets. An ellipsoid has the share of its exact brightness
    /// that is left of its cells.
    fn faceted(&self, body: usize, directions: &[Vec3; 2], interrupt: &mut InterruptCheck) -> Result<f64> {
        let Photometer { surfaces, meshes, .. } = self.photometer;
        let (law, placed, time) = (&surfaces[body].law, &self.placed, self.view.time);
        let (centre, rotation) = (placed[body].position, placed[body].rotation);
        let place = |k: usize| (k, &meshes[k], placed[k].position - centre, placed[k].rotation);
        let all: Vec<_> = std::iter::once(body).chain(self.others(body, directions)).map(place).collect();
        let faceted = Faceted::new(&all, directions);
        let [e, s] = directions;
        let phase = e.cross(s).norm().atan2(e.dot(s));
        let facets = meshes[body].lit(body, &rotation, directions, &law.at(phase));
        let mut total = faceted.left(&facets, time, interrupt)?;
        for (place, part) in &meshes[body].ellipsoids {
            let placed = Placed {
                body,
                semi_axes: Vec3::from(part.shape.semi_axes()),
                position: rotation * part.position(),
                rotation: rotation * part.rotation(),
            };
            let lit = Lit::new(&placed, law, time, *directions, std::iter::empty());
            let cells = lit.cells([body, *place]);
            let whole: f64 = cells.iter().map(|(_, brightness)| brightness).sum();
            if whole > 0.0 {
                total += lit.brightness(interrupt)? * faceted.left(&cells, time, interrupt)? / whole;
            }
        }
        Ok(total)
    }

    /// Iterates over the ellipsoids that may hide light from a body.
    fn before(&self, body: usize, directions: &[Vec3; 2]) -> impl Iterator<Item = (Light, &Placed)> {
        let mutual = self.photometer.hides();
        let lights = [(Light::Sight, directions[0]), (Light::Sun, directions[1])];
        lights.into_iter().filter(move |_| mutual).flat_map(move |(light, direction)| {
            let others = self
                .placed
                .iter()
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

impl Photometer {
    /// Iterates over the weights of the points of the Sun's disc and the unit vectors to them, for a unit
    /// vector to its centre.
    fn suns(&self, to_sun: &Vec3) -> impl Iterator<Item = (f64, Vec3)> {
        let first = perpendicular(to_sun);
        let (second, to_sun) = (to_sun.cross(&first), *to_sun);
        self.sun.iter().map(move |[x, y, weight]| (*weight, (to_sun + first * *x + second * *y).normalize()))
    }
}

impl Partials {
    /// Adds derivatives times a factor. A derivative with respect to the direction to a point of the Sun's
    /// disc counts as one with respect to the direction to its centre, with which the disc rotates.
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
