//! The mean force of heat on a secondary that does not rotate synchronously (the binary Yarkovsky effect).
//!
//! The primary's shadow darkens the secondary once in each revolution, and the primary's light and heat warm the side
//! that faces it. What the surface stores of both it radiates later, turned by the rotation relative to the orbit, so
//! that the recoil has a mean along the motion: W.-H. Zhou et al. (2024), Astrophys. J. Lett. 968, L3.
//!
//! The temperature is that of the linear theory of a sphere with a plane surface (D. Vokrouhlicky 1998, Astron.
//! Astrophys. 335, 1093): a periodic heat of angular frequency nu is radiated with the factor 1 / (1 + (1 + i) Theta / 2)
//! and Theta = sqrt(|nu| T), where T is the square of the thermal inertia over emissivity times sigma times the cube of
//! the subsolar temperature. In the frame of the orbit the variation with the mean motion n counts; for a point of the
//! surface its frequency is nu = n - omega, with omega the component of the spin along the orbit's normal. With the
//! pressure P of sunlight, the radii s and p of secondary and primary, the albedo A and the emissivity e of both, and
//! the distance r, the mean force along the motion is
//!
//! F = (4/9) (1 - A) P s^2 [S p/r - (8 / 3 pi) (A + e) (p/r)^2] sgn(nu) (Theta/2) / (1 + Theta + Theta^2/2).
//!
//! The first term is the shadow, a cylinder in which the Sun's light is missing within arcsin(p/r) of the line of
//! centres; the second one is the light that a Lambertian primary reflects and radiates in the plane of the orbit.
//! The factor S is one if the orbit lies in that round the Sun. At a sine t of the angle between both it is the mean of
//! sqrt(1 - (t r/p)^2 sin^2 l) over the longitude l of the Sun, a complete elliptic integral, for which a series is
//! taken. The argument of the complex factor is the lag angle d of the heat, from 0 to 45 degrees: the last factor is
//! sin d (cos d - sin d).

use super::evaluator::Evaluator;
use super::snapshot::{Load, MotionSnapshot, two_indices};
use super::{BodyBlock, LoadJacobian};
use crate::error::{Error, Result, require_finite, require_positive};
use crate::math::matrix::{times, times_cross};
use crate::math::{Mat3, Vec3};
use crate::shape::Body;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_4, PI};

/// The largest eccentricity of the orbit.
const ECCENTRICITY: f64 = 0.1;
/// The largest sine of the angle between the orbits round the primary and round the Sun, in units of the sine p/r at
/// which an eclipse in each revolution just occurs. The series for the mean shadow is exact to 3e-4 up to it.
const TILT: f64 = 0.7;
/// The coefficients of the series of 2 E(k) / pi in k^2.
const SHADOW: [f64; 5] = [1.0, -1.0 / 4.0, -3.0 / 64.0, -5.0 / 256.0, -175.0 / 16384.0];
/// The least cosine of the angle between the spin and the orbit's normal: that of 30 degrees.
const MIN_SPIN_COSINE: f64 = 0.866;
/// The least difference between spin and mean motion, in units of the latter.
const ASYNCHRONOUS: f64 = 0.1;

/// The mean force of heat on a secondary that does not rotate synchronously.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BinaryYarkovsky {
    /// The name of the force.
    pub name: String,
    /// The name of the secondary.
    pub on: String,
    /// The name of the body about which it moves.
    pub about: String,
    /// The mean pressure of sunlight.
    pub pressure: f64,
    /// The Bond albedo of both bodies.
    pub albedo: f64,
    /// The emissivity of both bodies.
    pub emissivity: f64,
    /// The radius of the secondary.
    pub radius: f64,
    /// The radius of the body about which it moves.
    pub primary_radius: f64,
    /// The normal of the orbit round the Sun.
    pub pole: [f64; 3],
    /// The square of the thermal inertia over that of emissivity times sigma times the cube of the subsolar
    /// temperature, a time; either this or the lag is given.
    #[serde(default)]
    pub thermal_time: Option<f64>,
    /// The lag angle of the heat, constant.
    #[serde(default)]
    pub lag: Option<f64>,
}

/// The response of the surface to sunlight that varies with a frequency.
#[derive(Debug, Clone, Copy)]
enum Response {
    ThermalTime(f64),
    Constant(f64),
}

impl BinaryYarkovsky {
    /// Returns an error for numbers that no such force has, whatever system it acts in.
    pub(super) fn check(&self) -> Result<()> {
        let name = &self.name;
        require_positive(&format!("pressure of {name}"), self.pressure)?;
        require_positive(&format!("radius of {name}"), self.radius)?;
        require_positive(&format!("primary_radius of {name}"), self.primary_radius)?;
        require_finite(&format!("pole of {name}"), &self.pole)?;
        if self.pole == [0.0; 3] {
            return Err(Error::invalid(
                format!("pole of {name}"),
                "[0, 0, 0]",
                "a vector of non-zero length",
            ));
        }
        for (role, value) in [("albedo", self.albedo), ("emissivity", self.emissivity)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(Error::invalid(format!("{role} of {name}"), value, "a number from 0 to 1"));
            }
        }
        self.response().map(drop)
    }

    fn response(&self) -> Result<Response> {
        let name = &self.name;
        match (self.thermal_time, self.lag) {
            (Some(time), None) => {
                require_positive(&format!("thermal time of {name}"), time)?;
                Ok(Response::ThermalTime(time))
            }
            (None, Some(lag)) if lag > 0.0 && lag < FRAC_PI_4 => {
                Ok(Response::Constant(lag.sin() * (lag.cos() - lag.sin())))
            }
            (None, Some(lag)) => {
                Err(Error::invalid(format!("lag of {name}"), lag, "an angle above 0 and below pi/4 rad"))
            }
            (time, lag) => Err(Error::invalid(
                format!("thermal time and lag of {name}"),
                format!("{time:?} and {lag:?}"),
                "one of the two",
            )),
        }
    }

    /// Returns the evaluator of the force, which has this index among the external forces.
    pub(super) fn prepared(
        &self,
        of: usize,
        bodies: &[Body],
        gravitational_constant: f64,
    ) -> Result<BinaryYarkovskyForce> {
        let (on, about) = two_indices(&self.name, ["on", "about"], [&self.on, &self.about], bodies)?;
        self.check()?;
        if self.radius > self.primary_radius {
            let expected =
                format!("at most the primary_radius, {}: a secondary within the shadow", self.primary_radius);
            return Err(Error::invalid(format!("radius of {}", self.name), self.radius, expected));
        }
        Ok(BinaryYarkovskyForce {
            on,
            about,
            mu: gravitational_constant * (bodies[on].mass + bodies[about].mass),
            light_scale: 4.0 / 9.0 * (1.0 - self.albedo) * self.pressure * self.radius * self.radius,
            primary_radius: self.primary_radius,
            radiated: 8.0 / (3.0 * PI) * (self.albedo + self.emissivity),
            pole: Vec3::from(self.pole).normalize(),
            response: self.response()?,
            loads: [Load::none(of, on, false)],
        })
    }
}

/// The evaluator of the binary Yarkovsky force.
#[derive(Debug, Clone)]
pub(super) struct BinaryYarkovskyForce {
    on: usize,
    about: usize,
    /// G times the mass of both bodies.
    mu: f64,
    /// The factor (4/9) (1 - A) P s^2.
    light_scale: f64,
    primary_radius: f64,
    /// The factor (8 / 3 pi) (A + e).
    radiated: f64,
    pole: Vec3,
    response: Response,
    loads: [Load; 1],
}

/// The motion of the secondary about the primary, relative to its own rotation.
struct Geometry {
    /// The distance, and the length of the angular momentum per mass.
    distance: f64,
    momentum: f64,
    /// Unit vectors outwards, along the orbit's normal and along the motion.
    outwards: Vec3,
    normal: Vec3,
    along_track: Vec3,
    spin: Vec3,
    velocity: Vec3,
    /// The mean motion and the frequency nu.
    motion: f64,
    frequency: f64,
    /// The sine squared of the angle between the orbit and the one round the Sun.
    tilt: f64,
}

impl BinaryYarkovskyForce {
    #[inline(always)]
    fn geometry(&self, snapshot: MotionSnapshot) -> Geometry {
        let (r, velocity) = snapshot.relative(self.on, self.about);
        let (distance, momentum) = (r.norm(), r.cross(&velocity));
        let length = momentum.norm();
        let (outwards, normal) = (r / distance, momentum / length);
        let spin = snapshot.inertial_spin(self.on);
        let motion = length / (distance * distance);
        let frequency = motion - spin.dot(&normal);
        let along_track = normal.cross(&outwards);
        let tilt = normal.cross(&self.pole).norm_squared();
        Geometry {
            distance,
            momentum: length,
            outwards,
            normal,
            along_track,
            spin,
            velocity,
            motion,
            frequency,
            tilt,
        }
    }

    /// Returns the force along the motion with its derivatives with respect to the distance, to the frequency and to
    /// the sine squared of the tilt.
    #[inline(always)]
    fn force_along_track(&self, geometry: &Geometry) -> [f64; 4] {
        let nearness = self.primary_radius / geometry.distance;
        let square = geometry.tilt / (nearness * nearness);
        let [mut shadow, mut by_square] = [0.0; 2];
        for coefficient in SHADOW.into_iter().rev() {
            by_square = by_square * square + shadow;
            shadow = shadow * square + coefficient;
        }
        let light = self.light_scale * nearness * (shadow - self.radiated * nearness);
        let by_nearness = shadow - 2.0 * by_square * square - 2.0 * self.radiated * nearness;
        let by_distance = -self.light_scale * nearness / geometry.distance * by_nearness;
        let by_tilt = self.light_scale * by_square / nearness;
        let (factor, by_frequency) = match self.response {
            Response::Constant(factor) => (factor, 0.0),
            Response::ThermalTime(time) => {
                let frequency = geometry.frequency.abs();
                let theta = (frequency * time).sqrt();
                let inverse = (1.0 + theta + 0.5 * theta * theta).recip();
                let slope = 0.5 * (1.0 - 0.5 * theta * theta) * inverse * inverse;
                (0.5 * theta * inverse, 0.5 * slope * theta / frequency)
            }
        };
        let factor = factor.copysign(geometry.frequency);
        [light * factor, by_distance * factor, light * by_frequency, by_tilt * factor]
    }

    /// Returns an error for a motion out of the range in which the mean force is known.
    fn check(&self, name: &str, snapshot: MotionSnapshot) -> Result<()> {
        let geometry = self.geometry(snapshot);
        let Geometry { distance, momentum, outwards, velocity, normal, .. } = &geometry;
        let eccentricity = (velocity.cross(&(normal * *momentum)) / self.mu - outwards).norm();
        let tilt = geometry.tilt.sqrt();
        let max_tilt = TILT * self.primary_radius / distance;
        let spin_cosine = geometry.spin.dot(normal).abs() / geometry.spin.norm();
        let asynchrony = (geometry.frequency / geometry.motion).abs();
        // A number that is NaN, in a motion without angular momentum, is out of the range; that of a spin of zero is not.
        let (circular, coplanar, asynchronous) =
            (eccentricity <= ECCENTRICITY, tilt <= max_tilt, asynchrony >= ASYNCHRONOUS);
        let wrong = if !circular {
            format!("the orbit has the eccentricity {eccentricity:.3}; expected at most {ECCENTRICITY}")
        } else if !coplanar {
            format!(
                "the orbit is inclined to the orbit round the Sun by an angle of the sine {tilt:.3}; expected at max_tilt \
                 {max_tilt:.3}, well within the range of an eclipse in each revolution"
            )
        } else if !asynchronous {
            format!(
                "the spin differs from the mean motion by {asynchrony:.3} of it; expected at least {ASYNCHRONOUS}, a \
                 secondary that is not synchronous"
            )
        } else if spin_cosine < MIN_SPIN_COSINE {
            format!(
                "the spin is inclined to the orbit's normal by an angle of the cosine {spin_cosine:.3}; expected at least \
                 {MIN_SPIN_COSINE}"
            )
        } else {
            return Ok(());
        };
        let detail = format!("it is out of its range: {wrong}");
        Err(Error::ForceFailed { force: name.to_owned(), time: snapshot.time, detail, answer: None })
    }
}

impl Evaluator for BinaryYarkovskyForce {
    #[inline(always)]
    fn loads(&self) -> &[Load] {
        &self.loads
    }

    #[inline(always)]
    fn compute(&mut self, snapshot: MotionSnapshot) {
        let geometry = self.geometry(snapshot);
        let [force, ..] = self.force_along_track(&geometry);
        self.loads[0].force = geometry.along_track * force;
    }

    fn begin_step(&mut self, name: &str, snapshot: MotionSnapshot, _: f64) -> Result<()> {
        self.check(name, snapshot)
    }

    /// Adds the derivatives of the force F t. With h = r x v, the unit vectors o along r, m along h and t = m x o, and
    /// the frequency nu = |h|/r^2 - w.m, the changes are dm = (1 - m m^T) dh / |h|, dt = dm x o + m x do and
    /// dnu = m.dh / r^2 - 2 |h| o.dr / r^3 - m.dw - w.dm. With the pole k the sine squared of the tilt, 1 - (m.k)^2,
    /// changes by -2 (m.k) k.dm.
    fn add_jacobian(&mut self, _: &str, snapshot: MotionSnapshot, jacobian: &mut LoadJacobian) -> Result<()> {
        let geometry = self.geometry(snapshot);
        let [force, by_distance, by_frequency, by_tilt] = self.force_along_track(&geometry);
        let Geometry {
            distance,
            momentum,
            outwards: o,
            normal: m,
            along_track: t,
            spin,
            velocity,
            motion,
            ..
        } = geometry;
        let across = |unit: &Vec3| Mat3::identity() - unit * unit.transpose();
        // By the angular momentum h, and then by the position at a fixed h.
        let normal_by = across(&m) / momentum;
        let frequency_by = m / (distance * distance) - normal_by * spin;
        let tilt_by = normal_by * self.pole * (-2.0 * m.dot(&self.pole));
        let force_by = frequency_by * by_frequency + tilt_by * by_tilt;
        let by_momentum = times(&-o.cross_matrix(), &normal_by) * force + t * force_by.transpose();
        let outwards_by = across(&o) / distance;
        let by_radius_vector = times(&m.cross_matrix(), &outwards_by) * force
            + t * o.transpose() * (by_distance - 2.0 * motion / distance * by_frequency);
        // dh = dr x v + r x dv.
        let by_position = by_radius_vector - times(&by_momentum, &velocity.cross_matrix());
        let by_velocity = times(&by_momentum, &(o * distance).cross_matrix());
        let row = BodyBlock::translation(self.on);
        for (body, sign) in [(self.on, 1.0), (self.about, -1.0)] {
            jacobian.add(row, BodyBlock::translation(body), &by_position, sign);
            jacobian.add_by_rate(row, BodyBlock::translation(body), &by_velocity, sign);
        }
        // d(R spin) = -R [spin]x theta + R dspin.
        let by_spin = times(&(t * m.transpose() * -by_frequency), &snapshot.rotation[self.on]);
        let by_rotation = times_cross(&by_spin, &Vec3::from(snapshot.spin[self.on]));
        let column = BodyBlock::rotation(self.on);
        jacobian.add(row, column, &by_rotation, -1.0);
        jacobian.add_by_rate(row, column, &by_spin, 1.0);
        Ok(())
    }
}
