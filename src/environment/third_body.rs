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

use super::{Loads, Scene};
use crate::error::{Error, Result, require_finite, require_positive};
use crate::gravity::BodyPull;
use crate::math::Vec3;
use crate::math::rotation::{turned, turned_back};
use crate::math::spline::Spline;
use crate::orbit::{KeplerElements, OrbitCells, OrbitPath, Place};
use crate::shape::Body;
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
    pub(super) fn ready(&self, bodies: &[Body], gravitational_constant: f64) -> Result<Pull> {
        require_positive(&format!("mu of {}", self.name), self.mu)?;
        let total: f64 = bodies.iter().map(|body| body.mass).sum();
        let motion = match &self.path {
            Path::Orbit { elements, time } => {
                require_finite(&format!("time of the elements of {}", self.name), &[*time])?;
                let orbit = OrbitPath::new(elements, self.mu + gravitational_constant * total);
                let orbit = orbit.map_err(|error| error.of(&self.name))?;
                Motion::Orbit {
                    cells: Box::new(OrbitCells::new(orbit)),
                    time: *time,
                    periapsis: elements.periapsis_distance(),
                }
            }
            Path::Table { times, positions } => {
                Motion::Table(Spline::new(&format!("times of {}", self.name), times, positions)?)
            }
        };
        Ok(Pull {
            mu: self.mu,
            sign: if self.of == WhoseOrbit::System { -1.0 } else { 1.0 },
            motion,
            names: bodies.iter().map(|body| body.name.clone()).collect(),
            masses: bodies.iter().map(|body| body.mass).collect(),
            radii: bodies.iter().map(|body| body.circumradius()).collect(),
            largest: bodies.iter().map(|body| body.circumradius()).fold(0.0, f64::max),
            extended: bodies.iter().map(BodyPull::new).collect(),
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
    mu: f64,
    sign: f64,
    motion: Motion,
    names: Vec<String>,
    masses: Vec<f64>,
    radii: Vec<f64>,
    /// The largest of them.
    largest: f64,
    extended: Vec<Option<BodyPull>>,
}

impl Pull {
    /// Position and velocity from the nominal barycentre.
    pub fn place(&self, time: f64) -> Result<(Vec3, Vec3)> {
        let (position, velocity) = match &self.motion {
            Motion::Orbit { cells, time: epoch, .. } => cells.orbit().after(time - epoch)?,
            Motion::Table(spline) => {
                let (position, velocity) = spline.at(time);
                (Vec3::from(position), Vec3::from(velocity))
            }
        };
        Ok((position * self.sign, velocity * self.sign))
    }

    /// The position alone, quickly.
    #[inline]
    fn position(&mut self, time: f64) -> Result<Place> {
        let place = match &mut self.motion {
            Motion::Orbit { cells, time: epoch, .. } => cells.after(time - *epoch)?,
            Motion::Table(spline) => Place::from(Vec3::from(spline.at(time).0)),
        };
        Ok(Place { position: place.position * self.sign, ..place })
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
    pub fn check(&self, name: &str, from: f64, to: f64, scene: &Scene) -> Result<()> {
        self.covers(name, from, to)?;
        let extent = scene.position.iter().zip(&self.radii).map(|(r, radius)| r.norm() + radius);
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

    pub fn load(&mut self, name: &str, scene: &Scene, loads: &mut Loads) -> Result<()> {
        let Place { position: p, inverse_square, inverse_cube } = self.position(scene.time)?;
        let rate = -self.mu * inverse_cube;
        for (body, r) in scene.position.iter().enumerate() {
            // |d|^2 = |p|^2 (1 + q).
            let q = r.dot(&(r - 2.0 * p)) * inverse_square;
            let Powers { f, square, cube } = Powers::of(q);
            let d = r - p;
            let mut force = (r + f * p) * (rate * cube);
            let inside = || Error::ForceFailed {
                force: name.to_owned(),
                time: scene.time,
                detail: format!("it comes inside {}", self.names[body]),
            };
            let inverse_square = inverse_square * square;
            if let Some(extended) = &mut self.extended[body] {
                let turn = &scene.rotation[body];
                let (excess, moment) = extended
                    .at(&turned_back(turn, &-d), inverse_square, inverse_cube * cube)
                    .ok_or_else(inside)?;
                force -= turned(turn, &excess) * self.mu;
                loads.torque[body] = -moment * (self.mu * self.masses[body]);
            } else if inverse_square * self.radii[body] * self.radii[body] > 1.0 {
                return Err(inside());
            }
            loads.force[body] = force * self.masses[body];
        }
        // The fall of the barycentre has no bound there.
        if inverse_square * self.largest * self.largest > 1.0 {
            return Err(Error::ForceFailed {
                force: name.to_owned(),
                time: scene.time,
                detail: "it comes as near to the barycentre as the largest body is wide".to_owned(),
            });
        }
        Ok(())
    }
}

/// What is needed of 1 + q.
struct Powers {
    /// (1 + q)^(3/2) - 1, without its cancellation.
    f: f64,
    /// 1 / (1 + q).
    square: f64,
    /// 1 / (1 + q)^(3/2).
    cube: f64,
}

impl Powers {
    #[inline(always)]
    fn of(q: f64) -> Self {
        // A third body is far from most systems: the series to the fifth power are then as good as the formulas.
        if q.abs() < 5e-4 {
            let (q2, q4) = (q * q, (q * q) * (q * q));
            let f = (1.5 + 0.375 * q) + q2 * (-0.0625 + 0.0234375 * q) - 0.01171875 * q4;
            let square = (1.0 - q) + q2 * (1.0 - q) + q4 * (1.0 - q);
            let cube = (1.0 - 1.5 * q) + q2 * (1.875 - 2.1875 * q) + q4 * (2.4609375 - 2.70703125 * q);
            return Self { f: q * f, square, cube };
        }
        let square = 1.0 / (1.0 + q);
        let root = (1.0 + q).sqrt();
        let cube = (1.0 + q) * root;
        Self { f: q * (3.0 + q * (3.0 + q)) / (1.0 + cube), square, cube: square / root }
    }
}
