//! The tide of constant time lag: F. Mignard (1979), Moon and Planets 20, 301; P. Hut (1981), Astron.
//! Astrophys. 99, 126.
//!
//! Let r be the position of the raiser, of mass m, relative to the deformed body, v its rate, and omega the
//! deformed body's inertial spin. The force on the raiser is
//!
//! F = -(3 k2 G m^2 R^5 tau / r^10) [2 r (r.v) + r^2 (r x omega + v)],
//!
//! the opposite force acts on the deformed body, and its torque is -r x F. Only the effect of the lag is
//! included: the figure is rigid, so that the conservative bulges of tide and rotation are part of it.

use super::evaluator::Evaluator;
use super::snapshot::{Load, MotionSnapshot, index_of_extended, two_indices};
use super::{BodyBlock, ForceParameter, LoadJacobian};
use crate::error::{Error, Result, require_positive};
use crate::math::matrix::{times, times_cross};
use crate::math::rotation::rotate_back;
use crate::math::{Mat3, Vec3};
use crate::shape::Body;
use serde::{Deserialize, Serialize};

/// The tide that one body raises on another.
///
/// ```
/// use fullbody::dynamics::{Settings, State, System};
/// use fullbody::forces::{Force, Tide};
/// use fullbody::math::Vec3;
/// use fullbody::shape::{Body, Shape};
///
/// let ball = |name, mass| Body::with_mass(name, Shape::ellipsoid([1.0, 1.0, 1.0])?, mass);
/// let (on, by) = ("Large".to_owned(), "Small".to_owned());
/// let tide = Tide { name: "tide".into(), on, by, k2: 0.1, lag: 0.01, radius: 1.0 };
/// let system = System::new(vec![ball("Large", 1.0)?, ball("Small", 0.1)?], 1.0, Settings::default())?
///     .with_forces(vec![Force::Tide(tide)])?;
/// let (rest, upright) = (vec![Vec3::zeros(); 2], vec![[1.0, 0.0, 0.0, 0.0]; 2]);
/// let position = vec![Vec3::zeros(), 3.0 * Vec3::x()];
/// let spin = vec![0.5 * Vec3::z(), Vec3::zeros()];
/// let loads = system.external_loads(&State::new(0.0, position, rest, upright, spin)?)?;
/// // The large body turns faster than the small one moves, which slows its rotation.
/// assert!(loads.iter().any(|load| load.on == 0 && load.torque.z < 0.0));
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tide {
    /// The name of the force.
    pub name: String,
    /// The body that is deformed.
    pub on: String,
    /// The body that raises the tide.
    pub by: String,
    /// The Love number k2 of degree two.
    pub k2: f64,
    /// The time lag.
    pub lag: f64,
    /// The radius of the deformed body.
    pub radius: f64,
}

impl Tide {
    /// Returns an error for numbers that no tide has, whatever system it acts in.
    pub(super) fn check(&self) -> Result<()> {
        let name = &self.name;
        if !(0.0..=1.5).contains(&self.k2) {
            return Err(Error::invalid(format!("k2 of {name}"), self.k2, "a number from 0 to 1.5"));
        }
        if !(self.lag >= 0.0 && self.lag.is_finite()) {
            let expected = "a finite time, zero or above";
            return Err(Error::invalid(format!("lag of {name}"), self.lag, expected));
        }
        require_positive(&format!("radius of {name}"), self.radius)
    }

    pub(super) fn prepared(
        &self,
        of: usize,
        bodies: &[Body],
        gravitational_constant: f64,
    ) -> Result<TidalForce> {
        let name = &self.name;
        let (on, by) = two_indices(name, ["on", "by"], [&self.on, &self.by], bodies)?;
        index_of_extended(name, "on", &self.on, bodies)?;
        self.check()?;
        let mass = bodies[by].mass;
        let unit = 3.0 * gravitational_constant * mass * mass * self.radius.powi(5);
        Ok(TidalForce {
            on,
            by,
            strength: unit * self.k2 * self.lag,
            by_parameters: [unit * self.lag, unit * self.k2],
            loads: [Load::none(of, on, true), Load::none(of, by, false)],
        })
    }
}

/// The evaluator of a tide.
#[derive(Debug, Clone)]
pub(super) struct TidalForce {
    on: usize,
    by: usize,
    /// The factor 3 k2 G m^2 R^5 tau.
    strength: f64,
    /// The derivatives of the tide's factor with respect to k2 and to the lag; the factor contains only their
    /// product.
    by_parameters: [f64; 2],
    loads: [Load; 2],
}

impl Evaluator for TidalForce {
    #[inline(always)]
    fn loads(&self) -> &[Load] {
        &self.loads
    }

    #[inline(always)]
    fn compute(&mut self, snapshot: MotionSnapshot) {
        let (r, v) = snapshot.relative(self.by, self.on);
        let spin = snapshot.inertial_spin(self.on);
        let inverse = 1.0 / r.norm_squared();
        // One factor 1/r^2 of 1/r^10 is in the bracket, which then has the size of v.
        let bracket: Vec3 = r * (2.0 * r.dot(&v) * inverse) + (r.cross(&spin) + v);
        let force = bracket * -(self.strength * (inverse * inverse) * (inverse * inverse));
        self.loads[0].force = -force;
        self.loads[0].torque = rotate_back(&snapshot.rotation[self.on], &force.cross(&r));
        self.loads[1].force = force;
    }

    /// Takes k2 or the lag for the parameter.
    fn unit(&self, parameter: ForceParameter) -> Option<Self> {
        let [by_k2, by_lag] = self.by_parameters;
        let strength = if parameter == ForceParameter::Lag { by_lag } else { by_k2 };
        Some(Self { strength, ..self.clone() })
    }

    fn powers(&self, mass_of: usize, _: usize) -> [f64; 2] {
        [1.0, if mass_of == self.by { 2.0 } else { 0.0 }]
    }

    /// Adds the derivatives of the loads. With b the bracket and k = strength / r^8, the force is F = -k b,
    /// and the torque is M = -R^T (r x F) in the body frame.
    fn add_jacobian(&mut self, _: &str, snapshot: MotionSnapshot, jacobian: &mut LoadJacobian) -> Result<()> {
        let (r, v) = snapshot.relative(self.by, self.on);
        let (spin, rotation) = (snapshot.inertial_spin(self.on), &snapshot.rotation[self.on]);
        let inverse = 1.0 / r.norm_squared();
        let along = r * inverse;
        let strength = self.strength * (inverse * inverse) * (inverse * inverse);
        let rate = r.dot(&v) * inverse;
        let force = (r * (2.0 * rate) + r.cross(&spin) + v) * -strength;
        // db/dr = 2 (r.v)/r^2 + 2 r (v - 2 r (r.v)/r^2)^T / r^2 - [spin]x.
        let outer = along * (v - r * (2.0 * rate)).transpose() * 2.0;
        let by_position = (outer + Mat3::from_diagonal_element(2.0 * rate) - spin.cross_matrix()) * -strength
            - force * along.transpose() * 8.0;
        let by_velocity = (along * r.transpose() * 2.0 + Mat3::identity()) * -strength;
        // d(R spin) = -R [spin]x theta + R dspin.
        let by_spin = times(&r.cross_matrix(), rotation) * -strength;
        let by_rotation = -times_cross(&by_spin, &Vec3::from(snapshot.spin[self.on]));
        let to_body = -times(&rotation.transpose(), &r.cross_matrix());
        let torque = rotate_back(rotation, &-r.cross(&force));
        // The derivatives with respect to the deformed body's position and velocity are the opposite of those
        // by the raiser's.
        let moved = times(&rotation.transpose(), &force.cross_matrix());
        for (body, sign) in [(self.by, 1.0), (self.on, -1.0)] {
            for (row, sign) in [(self.by, sign), (self.on, -sign)] {
                jacobian.add(BodyBlock::translation(row), BodyBlock::translation(body), &by_position, sign);
                jacobian.add_by_rate(
                    BodyBlock::translation(row),
                    BodyBlock::translation(body),
                    &by_velocity,
                    sign,
                );
            }
            let by_position = times(&to_body, &by_position) + moved;
            jacobian.add(BodyBlock::rotation(self.on), BodyBlock::translation(body), &by_position, sign);
            jacobian.add_by_rate(
                BodyBlock::rotation(self.on),
                BodyBlock::translation(body),
                &times(&to_body, &by_velocity),
                sign,
            );
        }
        for (row, sign) in [(self.by, 1.0), (self.on, -1.0)] {
            jacobian.add(BodyBlock::translation(row), BodyBlock::rotation(self.on), &by_rotation, sign);
            jacobian.add_by_rate(BodyBlock::translation(row), BodyBlock::rotation(self.on), &by_spin, sign);
        }
        // The body frame rotates: d(R^T m) = [R^T m]x theta.
        let by_rotation = times(&to_body, &by_rotation) + torque.cross_matrix();
        jacobian.add(BodyBlock::rotation(self.on), BodyBlock::rotation(self.on), &by_rotation, 1.0);
        jacobian.add_by_rate(
            BodyBlock::rotation(self.on),
            BodyBlock::rotation(self.on),
            &times(&to_body, &by_spin),
            1.0,
        );
        Ok(())
    }
}
