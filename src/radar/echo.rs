//! The echoes of bodies at one time or at many.

use super::ellipsoid::{Ellipsoid, HidingEllipsoid, Linear};
use super::facets::Facets;
use super::law::Law;
use crate::error::{Error, Result, require_finite};
use crate::interrupt::InterruptCheck;
use crate::math::rotation::rotate_back;
use crate::math::{Mat3, Vec3};
use crate::photometry::{Law as Reflection, Light, Scene, Snapshot, Surface, View, in_parallel};
use crate::shape::Body;

/// The number of spectra that a thread computes between two interrupt checks.
const GROUP: usize = 8;
/// The largest number of edges of bins of frequency or of delay.
const EDGES: usize = 100_000;

/// How the frequency and the delay of the echo of a body change over its surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyEcho {
    /// Frequency and delay of the echo from the centre of mass.
    pub at_centre: [f64; 2],
    /// The gradients of frequency and delay along the surface, inertial.
    pub gradients: [Vec3; 2],
}

/// Bodies at one time as the radar sees them.
#[derive(Debug, Clone, Copy)]
pub struct EchoView<'a> {
    /// The poses of the bodies; the receiver is the observer, and the transmitter is the Sun of the view.
    pub view: View<'a>,
    /// The echo of each body.
    pub echoes: &'a [BodyEcho],
}

/// The edges of bins.
#[derive(Debug, Clone, Copy)]
pub struct Bins<'a> {
    frequencies: &'a [f64],
    delays: &'a [f64],
}

/// Bodies with their scattering laws, for which echoes at any number of times are computed.
///
/// ```
/// use fullbody::interrupt::InterruptCheck;
/// use fullbody::math::Vec3;
/// use fullbody::photometry::View;
/// use fullbody::radar::{Bins, BodyEcho, EchoView, Law, Radar};
/// use fullbody::shape::{Body, Shape};
/// use std::f64::consts::PI;
///
/// // A ball of radius 2 whose law is 2 cos^2(theta) has the cross section 4/3 pi r^2.
/// let ball = Body::with_mass("Ball", Shape::ellipsoid([2.0, 2.0, 2.0])?, 1.0)?;
/// let radar = Radar::new(vec![ball], vec![Law::cosine(1.0, 1.0)?], true)?;
/// let toward = Vec3::new(0.0, 0.0, 1.0);
/// let (position, attitude) = (&[Vec3::zeros()], &[[1.0, 0.0, 0.0, 0.0]]);
/// let (to_observer, to_sun) = (toward, toward);
/// let view = View { time: 0.0, position, attitude, velocity: &[], to_observer, to_sun, distant: true };
/// // The frequency is x, and the delay is -2 z.
/// let gradients = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 0.0, -2.0)];
/// let echoes = &[BodyEcho { at_centre: [0.0, 0.0], gradients }];
/// let bins = Bins::new(&[-2.0, 0.0, 2.0], &[])?;
/// let power = radar.echo(&[EchoView { view, echoes }], &bins, &mut InterruptCheck::never())?;
/// assert!((power[0] - 8.0 / 3.0 * PI).abs() < 1e-12 && (power[1] - power[0]).abs() < 1e-12);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Radar {
    scene: Scene,
    laws: Vec<Law>,
}

impl<'a> Bins<'a> {
    /// Takes the edges of bins of frequency and of delay; without delays there are no bins of delay.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for edges that do not increase, and for fewer than two.
    pub fn new(frequencies: &'a [f64], delays: &'a [f64]) -> Result<Self> {
        for (what, edges, count) in [("frequencies", frequencies, 2), ("delays", delays, 0)] {
            if edges.len() < count || edges.len() == 1 || edges.len() > EDGES {
                let expected = format!("edges of bins, two or more and at most {EDGES}");
                return Err(Error::invalid(format!("number of {what}"), edges.len(), expected));
            }
            require_finite(what, edges)?;
            if let Some(k) = (1..edges.len()).find(|&k| edges[k] <= edges[k - 1]) {
                let value = format!("{} after {}", edges[k], edges[k - 1]);
                return Err(Error::invalid(
                    format!("edge {k} of {what}"),
                    value,
                    "edges of bins that increase",
                ));
            }
        }
        Ok(Self { frequencies, delays })
    }

    /// Returns the number of bins of a body.
    pub fn count(&self) -> usize {
        (self.frequencies.len() - 1) * self.delays.len().saturating_sub(1).max(1)
    }
}

impl Radar {
    /// Takes bodies with their laws. If `mutual` is false, bodies do not hide each other.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] if the numbers of bodies and laws differ, and for a body without a known surface.
    pub fn new(bodies: Vec<Body>, laws: Vec<Law>, mutual: bool) -> Result<Self> {
        if laws.len() != bodies.len() {
            return Err(Error::invalid("number of laws", laws.len(), format!("{}", bodies.len())));
        }
        // The scene is that of photometry, which asks how the bodies reflect light; this has no effect here.
        let surface = Surface { law: Reflection::LAMBERT, albedo: vec![1.0] };
        let surfaces = vec![surface; bodies.len()];
        Ok(Self { scene: Scene::new(bodies, surfaces, mutual, 0.0)?, laws })
    }

    /// Returns the bodies.
    pub fn bodies(&self) -> &[Body] {
        &self.scene.bodies
    }

    /// Returns the cross section in each bin, for each view and each body: of all bins of frequency, or for each bin
    /// of delay those of frequency.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a view with another number of bodies or with numbers that are not finite, and for
    /// antennas in opposite directions, [`Error::BodiesOverlap`], [`Error::NotConverged`] and
    /// [`Error::Interrupted`].
    pub fn echo(
        &self,
        views: &[EchoView<'_>],
        bins: &Bins<'_>,
        interrupt: &mut InterruptCheck,
    ) -> Result<Vec<f64>> {
        let size = self.scene.bodies.len() * bins.count() * views.len();
        Vec::<f64>::new()
            .try_reserve_exact(size)
            .map_err(|_| Error::invalid("number of bins", size, "fewer, for which there is memory"))?;
        let echoes =
            |views: &[EchoView<'_>], interrupt: &mut InterruptCheck| self.echoes(views, bins, interrupt);
        // Spectra of ellipsoids take less than a millisecond each. Images are divided among cores by themselves.
        if views.len() == 1 || !bins.delays.is_empty() || !self.scene.meshes.is_empty() {
            return echoes(views, interrupt);
        }
        in_parallel(views, GROUP, &|view| view.view.time, interrupt, echoes)
    }

    /// Returns the echoes of all bodies in views that one thread computes.
    fn echoes(
        &self,
        views: &[EchoView<'_>],
        bins: &Bins<'_>,
        interrupt: &mut InterruptCheck,
    ) -> Result<Vec<f64>> {
        let bodies = &self.scene.bodies;
        let mut power = vec![0.0; views.len() * bodies.len() * bins.count()];
        let mut snapshot = Snapshot::new(&self.scene);
        let mut rows = power.chunks_exact_mut(bins.count());
        for view in views {
            snapshot.set_view(&view.view, interrupt)?;
            if view.echoes.len() != bodies.len() {
                let expected = format!("{}", bodies.len());
                return Err(Error::invalid("number of echoes", view.echoes.len(), expected));
            }
            for ((body, echo), power) in view.echoes.iter().enumerate().zip(&mut rows) {
                let name = &bodies[body].name;
                require_finite(&format!("frequency and delay of {name}"), &echo.at_centre)?;
                for gradient in &echo.gradients {
                    require_finite(&format!("gradient of the echo of {name}"), gradient.as_slice())?;
                }
                self.add(&snapshot, body, (echo, view.view.time), bins, power, interrupt).map_err(
                    |error| match error {
                        Error::NotConverged { detail, .. } => {
                            Error::NotConverged { what: format!("radar echo of {name}"), detail }
                        }
                        other => other,
                    },
                )?;
            }
        }
        Ok(power)
    }

    /// Adds the echo of a body to `power`.
    fn add(
        &self,
        snapshot: &Snapshot<'_>,
        body: usize,
        (echo, time): (&BodyEcho, f64),
        bins: &Bins<'_>,
        power: &mut [f64],
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let (directions, pose) = (snapshot.directions(body), snapshot.pose(body));
        if (directions[0] + directions[1]).norm() < 1e-6 {
            let what = format!("transmitter as seen from {}", self.scene.bodies[body].name);
            return Err(Error::invalid(
                what,
                "right behind the body from the receiver",
                "one on the same side",
            ));
        }
        let (law, rotation) = (&self.laws[body], &pose.rotation);
        let in_frame = |k: usize, rotation: &Mat3, position: &Vec3| Linear {
            at_centre: echo.at_centre[k] + echo.gradients[k].dot(position),
            gradient: rotate_back(rotation, &echo.gradients[k]),
        };
        if snapshot.needs_facets(body, &directions) {
            for part in &snapshot.parts(body, &directions, interrupt)? {
                let position = rotation * part.mesh.pose.0;
                let [frequency, delay] = [0, 1].map(|k| in_frame(k, &part.rotation, &position));
                let facets = Facets { part, law, frequency, delay, time };
                facets.add(bins.frequencies, bins.delays, power, interrupt)?;
            }
            return Ok(());
        }
        if pose.semi_axes.min() <= 0.0 {
            // A point mass has no surface.
            return Ok(());
        }
        let is_monostatic = directions[0] == directions[1];
        let in_front = snapshot.bodies_in_front(body, &directions);
        let hiding =
            in_front.filter(|(light, _)| !is_monostatic || *light == Light::Sight).map(|(light, other)| {
                let relative = rotation.tr_mul(&other.rotation);
                let matrix = relative
                    * Mat3::from_diagonal(&other.semi_axes.map(|a| (a * a).recip()))
                    * relative.transpose();
                let centre = rotation.tr_mul(&(other.position - pose.position));
                HidingEllipsoid {
                    direction: rotate_back(rotation, &directions[light as usize]),
                    centre,
                    matrix,
                }
            });
        let [frequency, delay] = [0, 1].map(|k| in_frame(k, rotation, &Vec3::zeros()));
        Ellipsoid {
            semi_axes: pose.semi_axes,
            law,
            directions: directions.map(|direction| rotate_back(rotation, &direction)),
            hiding: hiding.collect(),
            frequency,
            delay,
            time,
        }
        .add(bins.frequencies, bins.delays, power, interrupt)
    }
}
