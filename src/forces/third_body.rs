//! The gravity of a point mass on a prescribed path, such as the Sun or a planet that passes.
//!
//! With r the position of a body and p that of the third body relative to the nominal barycentre, and d = r -
//! p, a point is accelerated relative to the nominal barycentre by
//!
//! a = -(mu/|d|^3) [r + f(q) p],  q = r.(r - 2p)/|p|^2,  f = q (3 + 3q + q^2) / (1 + (1+q)^(3/2)).
//!
//! This is the form of R. H. Battin, An Introduction to the Mathematics and Methods of Astrodynamics (1999),
//! section 8.4, for the difference of two nearly equal accelerations without their cancellation. By the third
//! law, the force of the third body on a body with extent is the opposite of the force of the body's exact
//! field on the third body.

use super::evaluator::Evaluator;
use super::{BodyBlock, ForceParameter, Load, LoadJacobian, MotionSnapshot};
use crate::error::{Error, Result, require_finite, require_positive};
use crate::gravity::{BodyAttraction, BodyChange, ExtendedAttraction, point_jacobian};
use crate::math::Vec3;
use crate::math::matrix::{times, times_cross, times_transposed};
use crate::math::rotation::{rotate, rotate_back};
use crate::math::spline::Spline;
use crate::orbit::{KeplerElements, OrbitCells, OrbitPath, OrbitPosition};
use crate::shape::Body;
use pulp::{Scalar, Simd};
use serde::{Deserialize, Serialize};

/// A point mass on a prescribed path.
///
/// ```
/// use fullbody::dynamics::{Settings, State, System};
/// use fullbody::forces::{Force, Path, ThirdBody, WhoseOrbit};
/// use fullbody::math::Vec3;
/// use fullbody::orbit::KeplerElements;
/// use fullbody::shape::{Body, Shape};
///
/// let circle = KeplerElements::new(1000.0, 0.0, 0.0, 0.0, 0.0, 0.0)?;
/// let path = Path::Orbit { elements: circle, time: 0.0 };
/// let sun = ThirdBody { name: "Sun".into(), mu: 1e7, mass: None, of: WhoseOrbit::System, path };
/// let point = |name| Body::with_mass(name, Shape::Point, 0.5);
/// let system = System::new(vec![point("One")?, point("Two")?], 1.0, Settings::default())?
///     .with_forces(vec![Force::ThirdBody(sun)])?;
/// let (rest, upright) = (vec![Vec3::zeros(); 2], vec![[1.0, 0.0, 0.0, 0.0]; 2]);
/// let state = State::new(0.0, vec![-Vec3::x(), Vec3::x()], rest.clone(), upright, rest)?;
/// // The Sun pulls the points apart: 2 mu x / r^3 for each unit of mass, to first order.
/// let loads = system.external_loads(&state)?;
/// assert!((loads[1].force.x - 0.5 * 2.0 * 1e7 / 1e9).abs() < 1e-4);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThirdBody {
    /// The name of the third body.
    pub name: String,
    /// G times the mass of the third body.
    pub mu: f64,
    /// The mass of the third body, where it was given: mu is G times this mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Which of the two moves on the given path about the other.
    pub of: WhoseOrbit,
    /// The path.
    pub path: Path,
}

/// Which of the two moves on the given path about the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WhoseOrbit {
    /// The path of the system's barycentre about the third body: an orbit round the Sun.
    System,
    /// The path of the third body about the system's barycentre: a planet that passes.
    Body,
}

/// A prescribed path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Path {
    /// A Kepler orbit whose mu is that of the third body and the system together.
    Orbit {
        /// The elements.
        elements: KeplerElements,
        /// The time of the mean anomaly.
        time: f64,
    },
    /// Positions at times, with a cubic spline between.
    Table {
        /// Times.
        times: Vec<f64>,
        /// Positions.
        positions: Vec<[f64; 3]>,
    },
}

impl ThirdBody {
    /// Returns an error for numbers that no third body has, whatever system it acts on.
    pub(super) fn check(&self) -> Result<()> {
        self.motion(self.mu).map(drop)
    }

    /// Makes the evaluator of the path as seen from the system's barycentre; `mu` is that of the third body
    /// and the system together.
    fn motion(&self, mu: f64) -> Result<PathEvaluator> {
        require_positive(&format!("mu of {}", self.name), self.mu)?;
        // The path is mirrored where it is given as seen from the third body.
        let mirrored = self.of == WhoseOrbit::System;
        match &self.path {
            Path::Orbit { elements, time } => {
                require_finite(&format!("time of the elements of {}", self.name), &[*time])?;
                let orbit = OrbitPath::new(elements, mu);
                let orbit = orbit.map_err(|error| error.of(&self.name))?;
                let orbit = if mirrored { orbit.mirrored() } else { orbit };
                Ok(PathEvaluator::Orbit {
                    cells: Box::new(OrbitCells::new(orbit)),
                    time: *time,
                    periapsis: elements.periapsis_distance(),
                })
            }
            Path::Table { times, positions } => {
                let sign = if mirrored { -1.0 } else { 1.0 };
                let positions: Vec<_> = positions.iter().map(|row| row.map(|x| sign * x)).collect();
                Ok(PathEvaluator::Table(Spline::new(&format!("times of {}", self.name), times, &positions)?))
            }
        }
    }

    pub(super) fn prepared(
        &self,
        of: usize,
        bodies: &[Body],
        gravitational_constant: f64,
    ) -> Result<ThirdBodyAttraction> {
        let total: f64 = bodies.iter().map(|body| body.mass).sum();
        let motion = self.motion(self.mu + gravitational_constant * total)?;
        let attracted: Vec<_> = bodies.iter().map(AttractedBody::new).collect();
        let on_body = |(on, body): (usize, &AttractedBody)| Load::none(of, on, body.extended.is_some());
        let loads: Vec<_> = attracted.iter().enumerate().map(on_body).collect();
        Ok(ThirdBodyAttraction {
            mu: self.mu,
            by_mass: self.mass.is_some(),
            motion,
            path_derivatives: None,
            largest: bodies.iter().map(|body| body.circumradius()).fold(0.0, f64::max),
            loads: loads.clone(),
            changes: loads,
            bodies: attracted,
        })
    }
}

#[derive(Debug, Clone)]
enum PathEvaluator {
    Orbit { cells: Box<OrbitCells>, time: f64, periapsis: f64 },
    Table(Spline<3>),
}

/// The evaluator of a third body.
#[derive(Debug, Clone)]
pub(super) struct ThirdBodyAttraction {
    pub mu: f64,
    pub by_mass: bool,
    motion: PathEvaluator,
    /// The derivatives of the path that were computed last, with their time.
    pub path_derivatives: Option<(f64, (Vec3, [Vec3; 8]))>,
    /// The largest circumradius of a body.
    largest: f64,
    pub bodies: Vec<AttractedBody>,
    pub loads: Vec<Load>,
    /// The buffers for the derivatives of the loads.
    pub changes: Vec<Load>,
}

/// A body on which the third body acts.
#[derive(Debug, Clone)]
pub(super) struct AttractedBody {
    pub name: String,
    pub mass: f64,
    radius: f64,
    pub extended: Option<BodyAttraction>,
}

impl AttractedBody {
    fn new(body: &Body) -> Self {
        let (name, extended) = (body.name.clone(), BodyAttraction::new(body));
        Self { name, mass: body.mass, radius: body.circumradius(), extended }
    }
}

impl ThirdBodyAttraction {
    /// Returns position and velocity relative to the nominal barycentre.
    pub fn position_and_velocity(&self, time: f64) -> Result<(Vec3, Vec3)> {
        match &self.motion {
            PathEvaluator::Orbit { cells, time: epoch, .. } => cells.orbit().after(time - epoch),
            PathEvaluator::Table(spline) => {
                let (position, velocity) = spline.at(time);
                Ok((Vec3::from(position), Vec3::from(velocity)))
            }
        }
    }

    /// Returns the orbit and the time of its elements; `None` for a table.
    pub fn orbit(&self) -> Option<(&OrbitPath, f64)> {
        match &self.motion {
            PathEvaluator::Orbit { cells, time, .. } => Some((cells.orbit(), *time)),
            PathEvaluator::Table(_) => None,
        }
    }

    /// Returns the position alone, which is quicker.
    #[inline(always)]
    pub fn position<S: Simd>(&mut self, simd: S, time: f64) -> Result<OrbitPosition> {
        match &mut self.motion {
            PathEvaluator::Orbit { cells, time: epoch, .. } => cells.after(simd, time - *epoch),
            PathEvaluator::Table(spline) => Ok(OrbitPosition::from(Vec3::from(spline.at(time).0))),
        }
    }

    /// Returns the first and last time for which the path is given.
    pub fn span(&self) -> (f64, f64) {
        match &self.motion {
            PathEvaluator::Orbit { .. } => (f64::NEG_INFINITY, f64::INFINITY),
            PathEvaluator::Table(spline) => spline.range(),
        }
    }

    /// Returns an error for times beyond those of the table.
    pub fn covers(&self, name: &str, from: f64, to: f64) -> Result<()> {
        let what = format!("the time of {name}");
        require_finite(&what, &[from])?;
        require_finite(&what, &[to])?;
        let (first, last) = self.span();
        if from.min(to) >= first && from.max(to) <= last {
            return Ok(());
        }
        let interval = if from == to { format!("{from}") } else { format!("{from} to {to}") };
        Err(Error::invalid(what, interval, format!("times from {first} to {last}, which its table covers")))
    }

    /// Returns an error for times beyond those of the table, and for a third body that is or comes inside the
    /// system.
    pub fn check(&self, name: &str, to: f64, snapshot: MotionSnapshot) -> Result<()> {
        let from = snapshot.time;
        self.covers(name, from, to)?;
        let extent = self
            .bodies
            .iter()
            .enumerate()
            .map(|(index, body)| snapshot.position_from_barycentre(index).norm() + body.radius);
        let extent = extent.fold(0.0, f64::max);
        let distance = self.position_and_velocity(from)?.0.norm();
        let nearest = match &self.motion {
            PathEvaluator::Orbit { periapsis, .. } => periapsis.min(distance),
            PathEvaluator::Table(_) => distance,
        };
        if nearest > extent {
            return Ok(());
        }
        let what = if nearest < distance { "periapsis distance" } else { "distance" };
        let expected = format!("more than {extent}, out to which the system reaches");
        Err(Error::invalid(format!("{what} of {name}"), nearest, expected))
    }
}

impl Evaluator for ThirdBodyAttraction {
    #[inline(always)]
    fn loads(&self) -> &[Load] {
        &self.loads
    }

    fn work(&self) -> u64 {
        8 * self.loads.len() as u64
    }

    fn powers(&self, mass_of: usize, on: usize) -> [f64; 2] {
        [f64::from(self.by_mass), if mass_of == on { 1.0 } else { 0.0 }]
    }

    fn by_parameter(
        &mut self,
        name: &str,
        snapshot: MotionSnapshot,
        parameter: ForceParameter,
        gravitational_constant: f64,
        to: &mut impl FnMut(&Load, f64),
    ) -> Result<()> {
        let (position, derivatives) = self.path_derivatives(snapshot.time)?;
        let (change, mu) = match parameter {
            ForceParameter::Element(which) => (derivatives[which], 0.0),
            ForceParameter::Mass => (derivatives[7] * gravitational_constant, gravitational_constant),
            _ => (derivatives[7], 1.0),
        };
        self.loads.iter().for_each(|load| to(load, mu / self.mu));
        self.along(name, snapshot, position, &change)?.iter().for_each(|load| to(load, 1.0));
        Ok(())
    }

    #[inline(always)]
    fn load<S: Simd>(&mut self, simd: S, name: &str, snapshot: MotionSnapshot) -> Result<()> {
        let OrbitPosition { position: p, inverse_square, inverse_cube } =
            self.position(simd, snapshot.time)?;
        if !inverse_square.is_finite() {
            return Err(failed(name, snapshot.time, AT_BARYCENTRE));
        }
        let positions = snapshot.position.iter().zip(snapshot.rotation);
        for (((position, rotation), body), load) in positions.zip(&mut self.bodies).zip(&mut self.loads) {
            let r = snapshot.barycentre_offset[0] + Vec3::from(*position);
            // The squared distance is |d|^2 = |p|^2 (1 + q).
            let from = p - r;
            let q = r.dot(&(r - 2.0 * p)) * inverse_square;
            let BattinFactors { f, square, cube } = BattinFactors::of(q);
            let (inverse_square, cube) = (inverse_square * square, inverse_cube * cube);
            let strength = -self.mu * body.mass;
            let mut force = (r + f * p) * (cube * strength);
            if let Some(extended) = &mut body.extended {
                let attracted = extended.at(&rotate_back(rotation, &from), inverse_square, cube, strength);
                let Some((perturbation, moment)) = attracted else {
                    return Err(inside(name, snapshot.time, &body.name));
                };
                force += rotate(rotation, &perturbation);
                load.torque = moment;
            } else if inverse_square * body.radius * body.radius > 1.0 {
                return Err(inside(name, snapshot.time, &body.name));
            }
            load.force = force;
        }
        // The acceleration of the barycentre has no bound at such distances.
        if inverse_square * self.largest * self.largest > 1.0 {
            return Err(failed(name, snapshot.time, AT_BARYCENTRE));
        }
        Ok(())
    }

    /// Adds the derivatives of the loads, from the Jacobian of every body's own field at the third body. The
    /// force on a body is F = -mu m R g(x) at x = R^T (p - r), and its torque is mu m n(x) with n = -x cross
    /// g. dF/dtheta is the transpose of dn/dr, since both are derivatives of one potential.
    fn add_jacobian(&mut self, _: &str, snapshot: MotionSnapshot, jacobian: &mut LoadJacobian) -> Result<()> {
        let OrbitPosition { position: p, .. } = self.position(Scalar, snapshot.time)?;
        for (index, (rotation, body)) in snapshot.rotation.iter().zip(&mut self.bodies).enumerate() {
            let strength = self.mu * body.mass;
            let x = rotate_back(rotation, &(p - snapshot.position_from_barycentre(index)));
            let (gradient, torque_gradient) = match &mut body.extended {
                None => point_jacobian(&x),
                Some(extended) => extended.jacobian(&x),
            };
            let (centre, attitude) = (BodyBlock::translation(index), BodyBlock::rotation(index));
            let inertial = times_transposed(&times(rotation, &gradient), rotation);
            jacobian.add(centre, centre, &inertial, strength);
            let by_position = -times_transposed(&torque_gradient, rotation);
            jacobian.add(attitude, centre, &by_position, strength);
            jacobian.add(centre, attitude, &by_position.transpose(), strength);
            jacobian.add(attitude, attitude, &times_cross(&torque_gradient, &x), strength);
        }
        Ok(())
    }
}

impl ThirdBodyAttraction {
    /// Adds the derivatives of the force on a body, inertial, and of the torque, in its frame, with respect
    /// to its semi-axes: in the notation of [`Self::add_jacobian`] these are -mu m R dg/da_i and -mu m x
    /// cross dg/da_i.
    pub fn semi_axis_derivatives(
        &mut self,
        snapshot: MotionSnapshot,
        body: usize,
        extended: &mut ExtendedAttraction,
        sums: &mut [[Vec3; 2]; 3],
    ) -> Result<()> {
        let OrbitPosition { position: p, .. } = self.position(Scalar, snapshot.time)?;
        let (rotation, strength) = (&snapshot.rotation[body], self.mu * self.bodies[body].mass);
        let x = rotate_back(rotation, &(p - snapshot.position_from_barycentre(body)));
        for (slope, [force, torque]) in extended.semi_axis_derivatives(&x).iter().zip(sums) {
            *force -= rotate(rotation, slope) * strength;
            *torque -= x.cross(slope) * strength;
        }
        Ok(())
    }
}

impl ThirdBodyAttraction {
    /// Returns the derivatives with respect to a change of a body at its mass, of the contribution of the
    /// body's extent to the force and to the torque, both in the body frame.
    pub fn perturbation_by_change(
        &mut self,
        snapshot: MotionSnapshot,
        body: usize,
        change: &BodyChange,
        third_body: &OrbitPosition,
    ) -> [Vec3; 2] {
        let (p, r) = (third_body.position, snapshot.position_from_barycentre(body));
        let BattinFactors { square, cube, .. } =
            BattinFactors::of(r.dot(&(r - 2.0 * p)) * third_body.inverse_square);
        let (inverse_square, inverse_cube) =
            (third_body.inverse_square * square, third_body.inverse_cube * cube);
        let x = rotate_back(&snapshot.rotation[body], &(p - r));
        let AttractedBody { mass, extended, .. } = &mut self.bodies[body];
        let strength = -self.mu * *mass;
        let moved = extended
            .as_mut()
            .map(|attraction| attraction.by_change(change, *mass, &x, inverse_square, inverse_cube));
        moved.map_or([Vec3::zeros(); 2], |moved| moved.map(|v| v * strength))
    }
}

/// The detail of the error for a place at which the acceleration of the barycentre has no bound.
const AT_BARYCENTRE: &str = "it comes as near to the barycentre as the largest body is wide; expected a path that stays outside the \
     system";

#[cold]
fn failed(name: &str, time: f64, detail: &str) -> Error {
    Error::ForceFailed { force: name.to_owned(), time, detail: detail.to_owned(), answer: None }
}

#[cold]
pub(super) fn inside(name: &str, time: f64, body: &str) -> Error {
    failed(name, time, &format!("it comes inside {body}"))
}

/// Functions of 1 + q.
pub(super) struct BattinFactors {
    /// (1 + q)^(3/2) - 1, without its cancellation.
    pub f: f64,
    /// 1 / (1 + q).
    pub square: f64,
    /// 1 / (1 + q)^(3/2).
    pub cube: f64,
}

impl BattinFactors {
    #[inline(always)]
    pub fn of(q: f64) -> Self {
        // A third body is far from most systems; the series to the third power are then as accurate as the
        // formulas. They are written as sums of two terms, so that neither waits for the other.
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
