//! What sunlight does over many turns: a torque on one body (YORP), and a force on a synchronous secondary (BYORP).
//!
//! Both are means over a rotation and over an orbit round the Sun: D. P. Rubincam (2000), Icarus 148, 2, for the torque along and
//! across the spin as functions of the obliquity; M. Cuk & J. A. Burns (2005), Icarus 176, 418, and J. McMahon & D. Scheeres (2010),
//! Icarus 209, 494, for the force along the secondary's motion.

use super::scene::{Load, Scene, Switch, place_to_turn, two_places};
use super::{LoadSlopes, Triple};
use crate::error::{Error, Result, require_finite};
use crate::math::matrix::times_cross;
use crate::math::rotation::turned_back;
use crate::math::spline::Spline;
use crate::math::{Mat3, Vec3};
use crate::shape::Body;
use serde::{Deserialize, Serialize};

/// Sine of the angle between spin and pole below which they count as parallel.
const PARALLEL: f64 = 1e-9;

/// The mean torque of radiation on a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Yorp {
    /// Its name.
    pub name: String,
    /// The body.
    pub on: String,
    /// Normal of the orbit round the Sun, from which the obliquity counts.
    pub pole: [f64; 3],
    /// Obliquities of a table, in rad; none for torques that do not depend on it.
    pub obliquity: Vec<f64>,
    /// Torques along the spin: one, or one at each obliquity.
    pub along: Vec<f64>,
    /// Torques across it that raise the obliquity.
    pub across: Vec<f64>,
}

impl Yorp {
    pub(super) fn ready(&self, of: usize, bodies: &[Body]) -> Result<Turning> {
        let name = &self.name;
        let on = place_to_turn(name, "on", &self.on, bodies)?;
        require_finite(&format!("pole of {name}"), &self.pole)?;
        let pole = Vec3::from(self.pole).try_normalize(0.0).ok_or_else(|| {
            Error::invalid(format!("pole of {name}"), "[0, 0, 0]", "a vector of non-zero length")
        })?;
        let counts = (self.obliquity.len().max(1), self.along.len(), self.across.len());
        if counts.0 != counts.1 || counts.0 != counts.2 {
            let found =
                format!("{} obliquities, {} along, {} across", self.obliquity.len(), counts.1, counts.2);
            return Err(Error::invalid(format!("the torques of {name}"), found, "as many of each"));
        }
        require_finite(&format!("along of {name}"), &self.along)?;
        require_finite(&format!("across of {name}"), &self.across)?;
        let torque = if self.obliquity.is_empty() {
            Torque::Constant([self.along[0], self.across[0]])
        } else {
            let rows: Vec<_> = self.along.iter().zip(&self.across).map(|(a, b)| [*a, *b]).collect();
            let spline = Spline::new(&format!("obliquities of {name}"), &self.obliquity, &rows)?;
            let (first, last) = spline.range();
            // A table in degrees that were turned into rad may end a rounding off pi.
            if first.abs() > 1e-9 || (last - std::f64::consts::PI).abs() > 1e-9 {
                let expected = "0 to pi rad";
                return Err(Error::invalid(
                    format!("range of the obliquities of {name}"),
                    format!("{first} to {last} rad"),
                    expected,
                ));
            }
            Torque::Table(spline)
        };
        Ok(Turning {
            on,
            body: bodies[on].name.clone(),
            inertia: bodies[on].inertia(),
            pole,
            torque,
            loads: [Load::none(of, on, true)],
        })
    }
}

#[derive(Debug, Clone)]
enum Torque {
    Constant([f64; 2]),
    Table(Spline<2>),
}

/// A torque of radiation ready for computing.
#[derive(Debug, Clone)]
pub(super) struct Turning {
    pub on: usize,
    body: String,
    inertia: Vec3,
    pole: Vec3,
    torque: Torque,
    pub loads: [Load; 1],
}

impl Turning {
    /// Refuses a spin of zero, and a step in which the torque along the spin brings it to a stop: there is no spin for it to be
    /// along, and it would turn over at every step.
    pub fn check(&self, name: &str, scene: Scene, step: f64) -> Result<()> {
        let spin = Vec3::from(scene.spin[self.on]);
        let [along, across] = self.torques(&scene.inertial_spin(self.on));
        let failed = |detail| {
            Err(Error::ForceFailed { force: name.to_owned(), time: scene.time, detail, answer: None })
        };
        if spin == Vec3::zeros() {
            return if along == 0.0 && across == 0.0 {
                Ok(())
            } else {
                failed(format!("{} does not spin, and the torque has no direction", self.body))
            };
        }
        let axis = spin.normalize();
        let rate = along / axis.dot(&self.inertia.component_mul(&axis));
        let stop = -spin.norm() / rate;
        if rate != 0.0 && stop * step > 0.0 && step.abs() >= stop.abs() {
            return failed(format!(
                "it brings the spin of {} to a stop by time {}",
                self.body,
                scene.time + stop
            ));
        }
        Ok(())
    }

    /// Along an inertial spin and across it.
    fn torques(&self, spin: &Vec3) -> [f64; 2] {
        match &self.torque {
            Torque::Constant(torque) => *torque,
            Torque::Table(spline) => spline.at(spin.cross(&self.pole).norm().atan2(spin.dot(&self.pole))).0,
        }
    }

    pub fn load(&mut self, scene: Scene) {
        let spin = scene.inertial_spin(self.on);
        let Some(axis) = spin.try_normalize(0.0) else {
            self.loads[0].torque = Vec3::zeros();
            return;
        };
        let aside = axis.cross(&self.pole);
        let sine = aside.norm();
        let [along, across] = self.torques(&axis);
        // From the pole to the spin, across the spin: there is no such direction where they are parallel.
        let outwards = if sine > 0.0 { aside.cross(&axis) * (-1.0 / sine) } else { Vec3::zeros() };
        let torque = axis * along + outwards * across;
        self.loads[0].torque = turned_back(&scene.rotation[self.on], &torque);
    }
}

impl Turning {
    /// The derivatives of the torque in the body frame, M = A a + B u: a along the spin w, k the pole there, c = a.k, s = |a x k|,
    /// u = (c a - k) / s and A, B functions of the obliquity.
    pub fn slopes(&self, name: &str, scene: Scene, slopes: &mut LoadSlopes) -> Result<()> {
        let own = Vec3::from(scene.spin[self.on]);
        let spin = own.norm();
        if spin == 0.0 {
            return Ok(());
        }
        let (a, k) = (own / spin, turned_back(&scene.rotation[self.on], &self.pole));
        let (cosine, sine) = (a.dot(&k), a.cross(&k).norm());
        let ([along, across], [along_rate, across_rate]) = match &self.torque {
            Torque::Constant(torque) => (*torque, [0.0; 2]),
            Torque::Table(spline) => spline.at(sine.atan2(cosine)),
        };
        let aside = [across, along_rate, across_rate] != [0.0; 3];
        if aside && sine < PARALLEL {
            let expected =
                "a spin that is not parallel to the pole, where the torque across it has no direction";
            return Err(Error::invalid(
                format!("derivatives of the force {name}"),
                format!("sine {sine:e}"),
                expected,
            ));
        }
        let (across, u, inverse) = if aside {
            (across / sine, (a * cosine - k) / sine, 1.0 / sine)
        } else {
            (0.0, Vec3::zeros(), 0.0)
        };
        // Of a change of c alone, with a change of the obliquity of -dc/s.
        let by_cosine =
            a * across - (a * along_rate + u * across_rate) * inverse + u * (across * cosine * inverse);
        let one = Mat3::identity();
        let by_axis = one * (along + across * cosine) + by_cosine * k.transpose();
        let by_pole = by_cosine * a.transpose() - one * across;
        let turn = Triple::turn(self.on);
        slopes.add_by_motion(turn, turn, &(by_axis * (one - a * a.transpose())), 1.0 / spin);
        slopes.add(turn, turn, &times_cross(&by_pole, &k), 1.0);
        Ok(())
    }
}

/// The mean force of radiation on a synchronous secondary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Byorp {
    /// Its name.
    pub name: String,
    /// The secondary.
    pub on: String,
    /// The body that it moves about.
    pub about: String,
    /// The force along the secondary's motion, in the plane of its orbit and across the line to the other body.
    pub force: f64,
}

impl Byorp {
    pub(super) fn ready(&self, of: usize, bodies: &[Body], gravitational_constant: f64) -> Result<Pushing> {
        let name = &self.name;
        let (on, about) = two_places(name, ["on", "about"], [&self.on, &self.about], bodies)?;
        require_finite(&format!("force of {name}"), &[self.force])?;
        let inertia = bodies[on].inertia();
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| inertia[i].total_cmp(&inertia[j]));
        let [long, middle, short] = order;
        if inertia[middle] <= inertia[long] {
            let found = format!("{:?}", bodies[on].semi_axes());
            let expected = format!("one longest, which {name} can keep towards {}", bodies[about].name);
            return Err(Error::invalid(format!("semi-axes of {}", bodies[on].name), found, expected));
        }
        Ok(Pushing {
            on,
            about,
            force: self.force,
            long,
            short,
            elongation: 3.0 * (inertia[middle] - inertia[long]) / inertia[short],
            mu: gravitational_constant * (bodies[on].mass + bodies[about].mass),
            state: Switch { on: true, times: 0 },
            loads: [Load::none(of, on, false)],
        })
    }
}

/// A force of radiation ready for computing.
#[derive(Debug, Clone)]
pub(super) struct Pushing {
    pub on: usize,
    about: usize,
    force: f64,
    /// Body axes of the smallest and the largest moment of inertia.
    long: usize,
    short: usize,
    /// 3 (B - A) / C.
    elongation: f64,
    mu: f64,
    /// Whether the secondary is locked, and how often it was lost.
    pub state: Switch,
    pub loads: [Load; 1],
}

impl Pushing {
    /// Switches the force off while the secondary is not locked.
    pub fn switch(&mut self, scene: Scene) {
        let locked = self.locked(scene);
        self.state.times += u64::from(self.state.on && !locked);
        self.state.on = locked;
    }

    /// Whether the secondary librates: its short axis is within 45 degrees of the orbit's normal, and the angle psi between its long
    /// axis and the line to the other body is that of a pendulum that does not turn over, psi'^2 + w^2 sin^2 psi < w^2 with
    /// w^2 = 3 (B - A)/C mu/r^3.
    fn locked(&self, scene: Scene) -> bool {
        let (r, v) = scene.relative(self.on, self.about);
        let (distance, momentum) = (r.norm(), r.cross(&v));
        let Some(normal) = momentum.try_normalize(0.0) else { return false };
        let turn = &scene.rotation[self.on];
        let (long, short) = (turn.column(self.long), turn.column(self.short));
        if short.dot(&normal).abs() < std::f64::consts::FRAC_1_SQRT_2 {
            return false;
        }
        let line = r / distance;
        let (cosine, sine) = (long.dot(&line), long.dot(&normal.cross(&line)));
        let share = sine * sine / (sine * sine + cosine * cosine);
        let rate = scene.inertial_spin(self.on).dot(&normal) - momentum.norm() / (distance * distance);
        let frequency = self.elongation * self.mu / (distance * distance * distance);
        rate * rate + frequency * share < frequency
    }

    #[inline(always)]
    pub fn load(&mut self, scene: Scene) {
        let (r, v) = scene.relative(self.on, self.about);
        let forwards = v * r.norm_squared() - r * r.dot(&v);
        // Root and quotient side by side: neither waits for the other.
        let square = forwards.norm_squared();
        let acts = self.state.on && square > 0.0;
        self.loads[0].force = forwards * if acts { square.sqrt() * (self.force / square) } else { 0.0 };
    }

    /// The derivatives of the force f t, with t along w = v - r (r.v) / r^2.
    pub fn slopes(&self, scene: Scene, slopes: &mut LoadSlopes) {
        let (r, v) = scene.relative(self.on, self.about);
        let square = r.norm_squared();
        let rate = r.dot(&v) / square;
        let across = v - r * rate;
        let length = across.norm();
        if !self.state.on || length == 0.0 {
            return;
        }
        let t = across / length;
        let one = Mat3::identity();
        let projected = (one - t * t.transpose()) * (self.force / length);
        let by_velocity = projected * (one - r * r.transpose() / square);
        let by_place = projected * -(one * rate + r * (v - r * (2.0 * rate)).transpose() / square);
        for (body, sign) in [(self.on, 1.0), (self.about, -1.0)] {
            slopes.add(Triple::centre(self.on), Triple::centre(body), &by_place, sign);
            slopes.add_by_motion(Triple::centre(self.on), Triple::centre(body), &by_velocity, sign);
        }
    }
}
