//! The gravity of a point mass on a prescribed path: the Sun, a planet that is passed.
//!
//! With r a body from the nominal barycentre, p the third body from there and d = r - p, a point is accelerated relative to the
//! nominal barycentre by
//!
//! a = -(mu/|d|^3) [r + f(q) p],  q = r.(r - 2p)/|p|^2,  f = q (3 + 3q + q^2) / (1 + (1+q)^(3/2)):
//!
//! R. H. Battin, An Introduction to the Mathematics and Methods of Astrodynamics (1999), section 8.4: the difference of two nearly
//! equal accelerations without their cancellation. On a body with extent the third body acts as the body's own exact field
//! says, by the third law.

use super::{Load, LoadSlopes, Scene, Triple};
use crate::error::{Error, Result, require_finite, require_positive};
use crate::gravity::{BodyPull, ExtendedPull, slopes_of_point};
use crate::math::Vec3;
use crate::math::matrix::{times, times_cross, times_transposed};
use crate::math::rotation::{turned, turned_back};
use crate::math::spline::Spline;
use crate::orbit::{KeplerElements, OrbitCells, OrbitPath, Place};
use crate::shape::Body;
use pulp::{Scalar, Simd};
use serde::{Deserialize, Serialize};

/// A point mass on a prescribed path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThirdBody {
    /// Its name.
    pub name: String,
    /// G times its mass.
    pub mu: f64,
    /// Whose path about whom is given.
    pub of: WhoseOrbit,
    /// The path.
    pub path: Path,
}

/// Whose path about whom is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WhoseOrbit {
    /// That of the system's barycentre about the third body: an orbit round the Sun.
    System,
    /// That of the third body about the system's barycentre: a planet that passes.
    Body,
}

/// A prescribed path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Path {
    /// A Kepler orbit whose mu is that of the third body and the system together.
    Orbit {
        /// The elements.
        elements: KeplerElements,
        /// Time to which the mean anomaly belongs.
        time: f64,
    },
    /// Places at times, with a cubic spline between.
    Table {
        /// Times.
        times: Vec<f64>,
        /// Positions.
        positions: Vec<[f64; 3]>,
    },
}

impl ThirdBody {
    pub(super) fn ready(&self, of: usize, bodies: &[Body], gravitational_constant: f64) -> Result<Pull> {
        require_positive(&format!("mu of {}", self.name), self.mu)?;
        let total: f64 = bodies.iter().map(|body| body.mass).sum();
        // Whoever moves about whom: seen from the other one, the path is mirrored.
        let mirrored = self.of == WhoseOrbit::System;
        let motion = match &self.path {
            Path::Orbit { elements, time } => {
                require_finite(&format!("time of the elements of {}", self.name), &[*time])?;
                let orbit = OrbitPath::new(elements, self.mu + gravitational_constant * total);
                let orbit = orbit.map_err(|error| error.of(&self.name))?;
                let orbit = if mirrored { orbit.mirrored() } else { orbit };
                Motion::Orbit {
                    cells: Box::new(OrbitCells::new(orbit)),
                    time: *time,
                    periapsis: elements.periapsis_distance(),
                }
            }
            Path::Table { times, positions } => {
                let sign = if mirrored { -1.0 } else { 1.0 };
                let positions: Vec<_> = positions.iter().map(|place| place.map(|x| sign * x)).collect();
                Motion::Table(Spline::new(&format!("times of {}", self.name), times, &positions)?)
            }
        };
        let pulled: Vec<_> = bodies.iter().map(Pulled::new).collect();
        Ok(Pull {
            mu: self.mu,
            motion,
            largest: bodies.iter().map(|body| body.circumradius()).fold(0.0, f64::max),
            loads: pulled
                .iter()
                .enumerate()
                .map(|(on, body)| Load::none(of, on, body.extended.is_some()))
                .collect(),
            bodies: pulled,
        })
    }
}

#[derive(Debug, Clone)]
enum Motion {
    Orbit { cells: Box<OrbitCells>, time: f64, periapsis: f64 },
    Table(Spline<3>),
}

/// A third body ready for computing.
#[derive(Debug, Clone)]
pub(super) struct Pull {
    pub mu: f64,
    motion: Motion,
    /// The largest radius of a body.
    largest: f64,
    bodies: Vec<Pulled>,
    pub loads: Vec<Load>,
}

/// A body that it pulls.
#[derive(Debug, Clone)]
struct Pulled {
    name: String,
    mass: f64,
    radius: f64,
    extended: Option<BodyPull>,
}

impl Pulled {
    fn new(body: &Body) -> Self {
        let (name, extended) = (body.name.clone(), BodyPull::new(body));
        Self { name, mass: body.mass, radius: body.circumradius(), extended }
    }
}

impl Pull {
    /// Position and velocity from the nominal barycentre.
    pub fn place(&self, time: f64) -> Result<(Vec3, Vec3)> {
        match &self.motion {
            Motion::Orbit { cells, time: epoch, .. } => cells.orbit().after(time - epoch),
            Motion::Table(spline) => {
                let (position, velocity) = spline.at(time);
                Ok((Vec3::from(position), Vec3::from(velocity)))
            }
        }
    }

    /// The position alone, quickly.
    #[inline(always)]
    pub fn position<S: Simd>(&mut self, simd: S, time: f64) -> Result<Place> {
        match &mut self.motion {
            Motion::Orbit { cells, time: epoch, .. } => cells.after(simd, time - *epoch),
            Motion::Table(spline) => Ok(Place::from(Vec3::from(spline.at(time).0))),
        }
    }

    /// First and last time for which the path is given.
    pub fn span(&self) -> (f64, f64) {
        match &self.motion {
            Motion::Orbit { .. } => (f64::NEG_INFINITY, f64::INFINITY),
            Motion::Table(spline) => spline.range(),
        }
    }

    /// Refuses times beyond the table's.
    pub fn covers(&self, name: &str, from: f64, to: f64) -> Result<()> {
        let what = format!("the time of {name}");
        require_finite(&what, &[from])?;
        require_finite(&what, &[to])?;
        let (first, last) = self.span();
        if from.min(to) >= first && from.max(to) <= last {
            return Ok(());
        }
        let found = if from == to { format!("{from}") } else { format!("{from} to {to}") };
        Err(Error::invalid(what, found, format!("times from {first} to {last}, which its table covers")))
    }

    /// Refuses times beyond the table's, and a third body that is or comes inside the system.
    pub fn check(&self, name: &str, to: f64, scene: Scene) -> Result<()> {
        let from = scene.time;
        self.covers(name, from, to)?;
        let extent =
            self.bodies.iter().enumerate().map(|(index, body)| scene.place(index).norm() + body.radius);
        let extent = extent.fold(0.0, f64::max);
        let distance = self.place(from)?.0.norm();
        let nearest = match &self.motion {
            Motion::Orbit { periapsis, .. } => periapsis.min(distance),
            Motion::Table(_) => distance,
        };
        if nearest > extent {
            return Ok(());
        }
        let what = if nearest < distance { "periapsis distance" } else { "distance" };
        let expected = format!("more than {extent}, out to which the system reaches");
        Err(Error::invalid(format!("{what} of {name}"), nearest, expected))
    }

    #[inline(always)]
    pub fn load<S: Simd>(&mut self, simd: S, name: &str, scene: Scene) -> Result<()> {
        let Place { position: p, inverse_square, inverse_cube } = self.position(simd, scene.time)?;
        let places = scene.position.iter().zip(scene.rotation);
        for (((place, turn), body), load) in places.zip(&mut self.bodies).zip(&mut self.loads) {
            let r = scene.departure[0] + Vec3::from(*place);
            // |d|^2 = |p|^2 (1 + q).
            let from = p - r;
            let q = r.dot(&(r - 2.0 * p)) * inverse_square;
            let Powers { f, square, cube } = Powers::of(q);
            let (inverse_square, cube) = (inverse_square * square, inverse_cube * cube);
            let strength = -self.mu * body.mass;
            let mut force = (r + f * p) * (cube * strength);
            if let Some(extended) = &mut body.extended {
                let pulled = extended.at(&turned_back(turn, &from), inverse_square, cube, strength);
                let Some((excess, moment)) = pulled else {
                    return Err(inside(name, scene.time, body));
                };
                force += turned(turn, &excess);
                load.torque = moment;
            } else if inverse_square * body.radius * body.radius > 1.0 {
                return Err(inside(name, scene.time, body));
            }
            load.force = force;
        }
        // The fall of the barycentre has no bound there.
        if inverse_square * self.largest * self.largest > 1.0 {
            let detail = "it comes as near to the barycentre as the largest body is wide";
            return Err(failed(name, scene.time, detail));
        }
        Ok(())
    }
}

impl Pull {
    /// The derivatives of the loads, from the slopes of every body's own field at the third body. The force on a body is
    /// F = -mu m R g(x) at x = R^T (p - r), its torque mu m n(x) with n = -x cross g, and dF/dtheta is dn/dr transposed, as both are
    /// derivatives of one potential.
    pub fn slopes(&mut self, name: &str, scene: Scene, slopes: &mut LoadSlopes) -> Result<()> {
        let Place { position: p, .. } = self.position(Scalar, scene.time)?;
        for (index, (rotation, body)) in scene.rotation.iter().zip(&mut self.bodies).enumerate() {
            let strength = self.mu * body.mass;
            let x = turned_back(rotation, &(p - scene.place(index)));
            let (gradient, turning) = match &mut body.extended {
                None => slopes_of_point(&x),
                Some(extended) => extended.slopes(&x).ok_or_else(|| {
                    let found = format!("of the force {name} on {}, a polyhedron", body.name);
                    Error::invalid("derivatives", found, "ellipsoids, composites of them, and points")
                })?,
            };
            let (centre, turn) = (Triple::centre(index), Triple::turn(index));
            let inertial = times_transposed(&times(rotation, &gradient), rotation);
            slopes.add(centre, centre, &inertial, strength);
            let by_place = -times_transposed(&turning, rotation);
            slopes.add(turn, centre, &by_place, strength);
            slopes.add(centre, turn, &by_place.transpose(), strength);
            slopes.add(turn, turn, &times_cross(&turning, &x), strength);
        }
        Ok(())
    }
}

impl Pull {
    /// Adds the derivatives of the force on a body, inertial, and of the torque, in its frame, by its semi-axes: with [`Self::slopes`]'
    /// terms -mu m R dg/da_i and -mu m x cross dg/da_i.
    pub fn by_axes(
        &mut self,
        scene: Scene,
        body: usize,
        extended: &mut ExtendedPull,
        sums: &mut [[Vec3; 2]; 3],
    ) -> Result<()> {
        let Place { position: p, .. } = self.position(Scalar, scene.time)?;
        let (rotation, strength) = (&scene.rotation[body], self.mu * self.bodies[body].mass);
        let x = turned_back(rotation, &(p - scene.place(body)));
        for (slope, [force, torque]) in extended.by_axes(&x).iter().zip(sums) {
            *force -= turned(rotation, slope) * strength;
            *torque -= x.cross(slope) * strength;
        }
        Ok(())
    }
}

#[cold]
fn failed(name: &str, time: f64, detail: &str) -> Error {
    Error::ForceFailed { force: name.to_owned(), time, detail: detail.to_owned(), answer: None }
}

#[cold]
fn inside(name: &str, time: f64, body: &Pulled) -> Error {
    failed(name, time, &format!("it comes inside {}", body.name))
}

/// What is needed of 1 + q.
pub(super) struct Powers {
    /// (1 + q)^(3/2) - 1, without its cancellation.
    pub f: f64,
    /// 1 / (1 + q).
    pub square: f64,
    /// 1 / (1 + q)^(3/2).
    pub cube: f64,
}

impl Powers {
    #[inline(always)]
    pub fn of(q: f64) -> Self {
        // A third body is far from most systems: the series to the third power are then as good as the formulas. In sums of two
        // parts, that neither waits for the other.
        if q.abs() < 1e-5 {
            let qq = q * q;
            return Self {
                f: 1.5 * q + qq * (0.375 - 0.0625 * q),
                square: (1.0 - q) + qq * (1.0 - q),
                cube: (1.0 - 1.5 * q) + qq * (1.875 - 2.1875 * q),
            };
        }
        let square = 1.0 / (1.0 + q);
        let root = (1.0 + q).sqrt();
        let cube = (1.0 + q) * root;
        Self { f: q * (3.0 + q * (3.0 + q)) / (1.0 + cube), square, cube: square / root }
    }
}
