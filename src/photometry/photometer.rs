//! Bodies with their surfaces, whose brightness is computed at one epoch or at many.

use super::ellipsoid::{ByBody, Lit, Partials};
use super::facets::Mesh;
use super::law::Law;
use super::snapshot::{Snapshot, View, WORK};
use crate::error::{Error, Result};
use crate::interrupt::{InterruptCheck, UNITS};
use crate::math::{Vec3, perpendicular};
use crate::shape::{Body, Part, Shape};
use gauss_quad::GaussLegendre;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::num::NonZeroUsize;

/// How a body reflects light.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// The scattering law.
    pub law: Law,
    /// The albedo, by which the brightness is multiplied: one number, or one for each face of a polyhedron.
    pub albedo: Vec<f64>,
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
/// let surface = Surface { law: Law::LOMMEL_SEELIGER, albedo: vec![1.0] };
/// let photometer = Photometer::new(vec![ball], vec![surface], true, 0.0)?;
/// let toward = Vec3::new(0.0, 0.0, 1.0);
/// let (position, attitude) = ([Vec3::zeros()], [[1.0, 0.0, 0.0, 0.0]]);
/// let view =
///     View { time: 0.0, position: &position, attitude: &attitude, velocity: &[], to_observer: toward, to_sun: toward };
/// let brightness = photometer.brightness(&view, &mut InterruptCheck::never())?;
/// assert!((brightness[0] - 2.0 * PI).abs() < 1e-14);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Photometer {
    pub(super) bodies: Vec<Body>,
    pub(super) surfaces: Vec<Surface>,
    mutual: bool,
    /// Points of the Sun's disc, each as two coordinates in radians from its centre and a weight.
    pub(super) sun: Vec<[f64; 3]>,
    /// The semi-axes of each body that is one ellipsoid about its centre.
    pub(super) semi_axes: Vec<Option<Vec3>>,
    /// The facets of each body; empty where all bodies are ellipsoids.
    pub(super) meshes: Vec<Mesh>,
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
            let what = format!("albedo of {}", body.name);
            if let Some(wrong) = surface.albedo.iter().find(|a| !(**a >= 0.0 && a.is_finite())) {
                return Err(Error::invalid(what, wrong, "a finite number, zero or above"));
            }
            let faces = match body.parts() {
                [Part { shape: Shape::Polyhedron(polyhedron), .. }] => polyhedron.faces().len(),
                _ => 1,
            };
            if surface.albedo.len() != 1 && surface.albedo.len() != faces {
                let expected = match faces {
                    1 => "one: only a polyhedron has one for each face".to_string(),
                    _ => format!("one, or {faces}, one for each face"),
                };
                return Err(Error::invalid(
                    format!("number of values of {what}"),
                    surface.albedo.len(),
                    expected,
                ));
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
    pub(super) fn hides(&self) -> bool {
        self.mutual && self.bodies.len() > 1
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

impl Photometer {
    /// Iterates over the weights of the points of the Sun's disc and the unit vectors to them, for a unit
    /// vector to its centre.
    pub(super) fn suns(&self, to_sun: &Vec3) -> impl Iterator<Item = (f64, Vec3)> {
        let first = perpendicular(to_sun);
        let (second, to_sun) = (to_sun.cross(&first), *to_sun);
        self.sun.iter().map(move |[x, y, weight]| (*weight, (to_sun + first * *x + second * *y).normalize()))
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
