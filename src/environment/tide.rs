//! The tide of constant time lag: F. Mignard (1979), Moon and Planets 20, 301; P. Hut (1981), Astron. Astrophys. 99, 126.
//!
//! With r from the deformed body to the raiser of mass m, v its rate and omega the deformed body's inertial spin, the force on the
//! raiser is
//!
//! F = -(3 k2 G m^2 R^5 tau / r^10) [2 r (r.v) + r^2 (r x omega + v)],
//!
//! the opposite acts on the deformed body, and its torque is -r x F. Only what the lag adds is here: the figure is rigid, so that
//! the bulges of the tide and of the rotation are part of it.

use super::scene::{Load, Scene, place_to_turn, two_places};
use super::{LoadSlopes, Triple};
use crate::error::{Error, Result, require_positive};
use crate::math::matrix::{times, times_cross};
use crate::math::rotation::turned_back;
use crate::math::{Mat3, Vec3};
use crate::shape::Body;
use serde::{Deserialize, Serialize};

/// The tide that one body raises on another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tide {
    /// Its name.
    pub name: String,
    /// The body that is deformed.
    pub on: String,
    /// The body that raises the tide.
    pub by: String,
    /// Love's number of degree two.
    pub k2: f64,
    /// The time lag.
    pub lag: f64,
    /// Radius of the deformed body.
    pub radius: f64,
}

impl Tide {
    pub(super) fn ready(&self, of: usize, bodies: &[Body], gravitational_constant: f64) -> Result<Lagging> {
        let name = &self.name;
        let (on, by) = two_places(name, ["on", "by"], [&self.on, &self.by], bodies)?;
        place_to_turn(name, "on", &self.on, bodies)?;
        if !(0.0..=1.5).contains(&self.k2) {
            return Err(Error::invalid(format!("k2 of {name}"), self.k2, "a number from 0 to 1.5"));
        }
        if !(self.lag >= 0.0 && self.lag.is_finite()) {
            let expected = "a finite time, zero or above";
            return Err(Error::invalid(format!("lag of {name}"), self.lag, expected));
        }
        require_positive(&format!("radius of {name}"), self.radius)?;
        let mass = bodies[by].mass;
        let strength = 3.0 * self.k2 * gravitational_constant * mass * mass * self.radius.powi(5) * self.lag;
        Ok(Lagging { on, by, strength, loads: [Load::none(of, on, true), Load::none(of, by, false)] })
    }
}

/// A tide ready for computing.
#[derive(Debug, Clone)]
pub(super) struct Lagging {
    pub on: usize,
    pub by: usize,
    /// 3 k2 G m^2 R^5 tau.
    strength: f64,
    pub loads: [Load; 2],
}

impl Lagging {
    #[inline(always)]
    pub fn load(&mut self, scene: Scene) {
        let (r, v) = scene.relative(self.by, self.on);
        let spin = scene.inertial_spin(self.on);
        let inverse = 1.0 / r.norm_squared();
        // Of 1/r^10 one factor 1/r^2 stands in the bracket, which then has the size of v.
        let bracket: Vec3 = r * (2.0 * r.dot(&v) * inverse) + (r.cross(&spin) + v);
        let force = bracket * -(self.strength * (inverse * inverse) * (inverse * inverse));
        self.loads[0].force = -force;
        self.loads[0].torque = turned_back(&scene.rotation[self.on], &force.cross(&r));
        self.loads[1].force = force;
    }

    /// With b the bracket and k = strength / r^8, so that F = -k b, and the torque M = -R^T (r x F) in the body frame.
    pub fn slopes(&self, scene: Scene, slopes: &mut LoadSlopes) {
        let (r, v) = scene.relative(self.by, self.on);
        let (spin, rotation) = (scene.inertial_spin(self.on), &scene.rotation[self.on]);
        let inverse = 1.0 / r.norm_squared();
        let along = r * inverse;
        let strength = self.strength * (inverse * inverse) * (inverse * inverse);
        let rate = r.dot(&v) * inverse;
        let force = (r * (2.0 * rate) + r.cross(&spin) + v) * -strength;
        // db/dr = 2 (r.v)/r^2 + 2 r (v - 2 r (r.v)/r^2)^T / r^2 - [spin]x.
        let outer = along * (v - r * (2.0 * rate)).transpose() * 2.0;
        let by_place = (outer + Mat3::from_diagonal_element(2.0 * rate) - spin.cross_matrix()) * -strength
            - force * along.transpose() * 8.0;
        let by_velocity = (along * r.transpose() * 2.0 + Mat3::identity()) * -strength;
        // d(R spin) = -R [spin]x theta + R dspin.
        let by_spin = times(&r.cross_matrix(), rotation) * -strength;
        let by_turn = -times_cross(&by_spin, &Vec3::from(scene.spin[self.on]));
        let to_body = -times(&rotation.transpose(), &r.cross_matrix());
        let torque = turned_back(rotation, &-r.cross(&force));
        // By the raiser's place and velocity, and by the opposite of the deformed body's.
        let moved = times(&rotation.transpose(), &force.cross_matrix());
        for (body, sign) in [(self.by, 1.0), (self.on, -1.0)] {
            for (row, sign) in [(self.by, sign), (self.on, -sign)] {
                slopes.add(Triple::centre(row), Triple::centre(body), &by_place, sign);
                slopes.add_by_motion(Triple::centre(row), Triple::centre(body), &by_velocity, sign);
            }
            let by_place = times(&to_body, &by_place) + moved;
            slopes.add(Triple::turn(self.on), Triple::centre(body), &by_place, sign);
            slopes.add_by_motion(
                Triple::turn(self.on),
                Triple::centre(body),
                &times(&to_body, &by_velocity),
                sign,
            );
        }
        for (row, sign) in [(self.by, 1.0), (self.on, -1.0)] {
            slopes.add(Triple::centre(row), Triple::turn(self.on), &by_turn, sign);
            slopes.add_by_motion(Triple::centre(row), Triple::turn(self.on), &by_spin, sign);
        }
        // The body frame turns: d(R^T m) = [R^T m]x theta.
        let by_turn = times(&to_body, &by_turn) + torque.cross_matrix();
        slopes.add(Triple::turn(self.on), Triple::turn(self.on), &by_turn, 1.0);
        slopes.add_by_motion(Triple::turn(self.on), Triple::turn(self.on), &times(&to_body, &by_spin), 1.0);
    }
}
