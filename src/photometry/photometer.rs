//! The brightness of bodies at one epoch or at many.

use super::ellipsoid::{ByBody, Partials};
use super::faceted::Target;
use super::parallel::in_parallel;
use super::scene::{Scene, Surface};
use super::snapshot::{Snapshot, View, WORK};
use crate::error::{Error, Result};
use crate::interrupt::{InterruptCheck, UNITS};
use crate::math::Vec3;
use crate::shape::{Body, Part, Shape};

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
/// let (position, attitude) = (&position, &attitude);
/// let (to_observer, to_sun) = (toward, toward);
/// let view = View { time: 0.0, position, attitude, velocity: &[], to_observer, to_sun, distant: true };
/// let brightness = photometer.brightness(&view, &mut InterruptCheck::never())?;
/// assert!((brightness[0] - 2.0 * PI).abs() < 1e-14);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Photometer {
    scene: Scene,
}

/// Returns the units of work of one ellipsoid in light from one point, which others may hide or not.
fn work(surface: &Surface, mutual: bool) -> u64 {
    match (surface.law.constant(), mutual) {
        (Some(_), false) => WORK,
        (Some(_), true) => 1000,
        (None, _) => 100_000,
    }
}

impl Photometer {
    /// Takes bodies with their surfaces. If `mutual` is false, occultations and eclipses are neglected. The
    /// Sun's radius is an angle in radians, zero for parallel light.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] if the numbers of bodies and surfaces differ, and for an albedo, a law or a
    /// radius of the Sun out of its range.
    pub fn new(bodies: Vec<Body>, surfaces: Vec<Surface>, mutual: bool, sun_radius: f64) -> Result<Self> {
        Ok(Self { scene: Scene::new(bodies, surfaces, mutual, sun_radius)? })
    }

    /// Returns the bodies.
    pub fn bodies(&self) -> &[Body] {
        &self.scene.bodies
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
        self.for_views(views, interrupt, |snapshot, interrupt, all| {
            let compute_body =
                |_: &mut (), target: &Target<'_>, _, _: [&_; 2], interrupt: &mut InterruptCheck<'_>| {
                    Ok(target.light::<1>(interrupt)?[0])
                };
            snapshot.for_each_body(interrupt, compute_body, |brightness, ()| all.push(brightness))
        })
    }

    /// Returns the brightness of each body in each view with its first moments: the sums of the light of all surface
    /// elements times the vectors to them from the body's centre, inertial, in cubed length.
    ///
    /// # Errors
    /// Returns the errors of [`Self::brightness`], and [`Error::InvalidInput`] for a body of facets without
    /// vertices.
    pub fn moments_in(&self, views: &[View<'_>], interrupt: &mut InterruptCheck) -> Result<Vec<(f64, Vec3)>> {
        self.scene.bodies.iter().try_for_each(Body::require_vertices)?;
        self.for_views(views, interrupt, |snapshot, interrupt, all| {
            let compute_body = |sum: &mut Vec3,
                                target: &Target<'_>,
                                factor,
                                _: [&_; 2],
                                interrupt: &mut InterruptCheck<'_>| {
                let [brightness, x, y, z] = target.light(interrupt)?;
                *sum += Vec3::new(x, y, z) * factor;
                Ok(brightness)
            };
            snapshot
                .for_each_body(interrupt, compute_body, |brightness, moment| all.push((brightness, moment)))
        })
    }

    /// Returns the brightness of each body with its derivatives. The derivative with respect to the albedo is
    /// not among them: it is the brightness divided by the albedo.
    ///
    /// # Errors
    /// Returns the errors of [`Self::brightness`], and [`Error::InvalidInput`] for a law of a rough surface.
    pub fn partials(&self, view: &View<'_>, interrupt: &mut InterruptCheck) -> Result<Vec<(f64, Partials)>> {
        self.partials_in(std::slice::from_ref(view), true, interrupt)
    }

    /// Returns the brightness of each body in each view, with its derivatives; those with respect to vertices
    /// and to areas of facets only on demand.
    ///
    /// # Errors
    /// Returns the errors of [`Self::partials`].
    pub fn partials_in(
        &self,
        views: &[View<'_>],
        by_vertex: bool,
        interrupt: &mut InterruptCheck,
    ) -> Result<Vec<(f64, Partials)>> {
        let Scene { bodies, surfaces, semi_axes, .. } = &self.scene;
        for (body, surface) in bodies.iter().zip(surfaces) {
            if surface.law.has_edges() {
                let what = format!("roughness of the scattering law of {}", body.name);
                return Err(Error::invalid(what, "above zero", "zero, with which there are derivatives"));
            }
        }
        let vertices = |body: &Body| match body.parts() {
            [Part { shape: Shape::Polyhedron(polyhedron), .. }] => polyhedron.vertices().count(),
            _ => 0,
        };
        let counts: Vec<usize> = bodies.iter().filter(|_| by_vertex).map(vertices).collect();
        let areas = |body: &Body| body.facets().map_or(0, |facets| facets.areas().len());
        let areas: Vec<usize> = bodies.iter().filter(|_| by_vertex).map(areas).collect();
        let zeros = || Partials {
            by_body: vec![ByBody::default(); bodies.len()],
            by_vertex: counts.iter().map(|count| vec![Vec3::zeros(); *count]).collect(),
            by_area: areas.iter().map(|count| vec![0.0; *count]).collect(),
            ..Partials::default()
        };
        self.for_views(views, interrupt, |snapshot, interrupt, all| {
            let compute_body = |sums: &mut Option<Partials>,
                                target: &Target<'_>,
                                factor,
                                directions: [&_; 2],
                                interrupt: &mut InterruptCheck<'_>| {
                let mut part = zeros();
                let brightness = target.partials(&mut part, interrupt)?;
                sums.get_or_insert_with(zeros).add(&part, factor, directions);
                Ok(brightness)
            };
            snapshot.for_each_body(interrupt, compute_body, |value, sums| {
                let mut sums = sums.unwrap_or_else(zeros);
                // The ellipsoids of a composite are not its own semi-axes.
                let composites = sums.by_body.iter_mut().zip(semi_axes).filter(|(_, axes)| axes.is_none());
                composites.for_each(|(by, _)| by.semi_axes = Vec3::zeros());
                all.push((value, sums));
            })
        })
    }

    /// Returns the list to which `append` adds the results of each view, in order. Short views are distributed over the
    /// threads of the machine. A long one, such as a view of many facets, itself checks for interrupts.
    fn for_views<'a, T: Send>(
        &'a self,
        views: &[View<'a>],
        interrupt: &mut InterruptCheck,
        append: impl Fn(&Snapshot<'a>, &mut InterruptCheck, &mut Vec<T>) -> Result<()> + Sync,
    ) -> Result<Vec<T>> {
        let compute = |views: &[View<'a>], interrupt: &mut InterruptCheck| {
            let mut all = Vec::with_capacity(views.len() * self.scene.bodies.len());
            let mut snapshot = Snapshot::new(&self.scene);
            for view in views {
                snapshot.set_view(view, interrupt)?;
                append(&snapshot, interrupt, &mut all)?;
            }
            Ok(all)
        };
        for mesh in &self.scene.meshes {
            mesh.horizons(interrupt)?;
        }
        let work: u64 = self.scene.surfaces.iter().map(|surface| work(surface, self.scene.hides())).sum();
        let work = work + self.scene.meshes.iter().map(|mesh| WORK * mesh.facets.len() as u64).sum::<u64>();
        let areas =
            self.scene.bodies.iter().filter_map(Body::facets).map(|facets| facets.areas().len() as u64);
        let work = work + areas.sum::<u64>();
        let work = self.scene.sun.len() as u64 * work.max(1);
        if views.len() == 1 || work > 5 * UNITS {
            return compute(views, interrupt);
        }
        in_parallel(views, (UNITS / work).max(1) as usize, &|view| view.time, interrupt, compute)
    }
}
