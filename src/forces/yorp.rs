//! The mean torque of sunlight on a body (YORP).
//!
//! It is the mean over a rotation and over an orbit round the Sun. The torques along and across the spin are
//! functions of the obliquity as in D. P. Rubincam (2000), Icarus 148, 2.

use super::evaluator::Evaluator;
use super::snapshot::{Load, MotionSnapshot, index_of_extended};
use super::{BodyBlock, ForceParameter, LoadJacobian};
use crate::error::{Error, Result, require_finite};
use crate::math::matrix::times_cross;
use crate::math::rotation::rotate_back;
use crate::math::spline::Spline;
use crate::math::{Mat3, Vec3};
use crate::shape::Body;
use serde::{Deserialize, Serialize};

/// The sine of the angle between spin and pole below which they count as parallel.
const PARALLEL: f64 = 1e-9;

/// The rounding error of a table of torques, relative to its largest torque.
const ROUNDING: f64 = 1e-12;

/// The mean torque of radiation on a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Yorp {
    /// The name of the force.
    pub name: String,
    /// The name of the body.
    pub on: String,
    /// The normal of the orbit round the Sun, from which the obliquity is measured.
    pub pole: [f64; 3],
    /// The obliquities of a table, in radians; empty for torques that do not depend on the obliquity.
    pub obliquity: Vec<f64>,
    /// The torques along the spin: one, or one at each obliquity.
    pub along: Vec<f64>,
    /// The torques across the spin, positive where they raise the obliquity.
    pub across: Vec<f64>,
}

impl Yorp {
    /// Returns an error for numbers that no such torque has, whatever system it acts in.
    pub(super) fn check(&self) -> Result<()> {
        self.pole_and_torque().map(drop)
    }

    fn pole_and_torque(&self) -> Result<(Vec3, TorqueTable)> {
        let name = &self.name;
        require_finite(&format!("pole of {name}"), &self.pole)?;
        let pole = Vec3::from(self.pole).try_normalize(0.0).ok_or_else(|| {
            Error::invalid(format!("pole of {name}"), "[0, 0, 0]", "a vector of non-zero length")
        })?;
        let counts = (self.obliquity.len().max(1), self.along.len(), self.across.len());
        if counts.0 != counts.1 || counts.0 != counts.2 {
            let counts_text =
                format!("{} obliquities, {} along, {} across", self.obliquity.len(), counts.1, counts.2);
            return Err(Error::invalid(format!("the torques of {name}"), counts_text, "as many of each"));
        }
        require_finite(&format!("along of {name}"), &self.along)?;
        require_finite(&format!("across of {name}"), &self.across)?;
        let torque = if self.obliquity.is_empty() {
            TorqueTable::Constant([self.along[0], self.across[0]])
        } else {
            let rows: Vec<_> = self.along.iter().zip(&self.across).map(|(a, b)| [*a, *b]).collect();
            let spline = Spline::new(&format!("obliquities of {name}"), &self.obliquity, &rows)?;
            let (first, last) = spline.range();
            // A table in degrees that was converted to rad may end a rounding error away from pi.
            if first.abs() > 1e-9 || (last - std::f64::consts::PI).abs() > 1e-9 {
                let expected = "0 to pi rad";
                return Err(Error::invalid(
                    format!("range of the obliquities of {name}"),
                    format!("{first} to {last} rad"),
                    expected,
                ));
            }
            TorqueTable::Table(spline)
        };
        Ok((pole, torque))
    }

    pub(super) fn prepared(&self, of: usize, bodies: &[Body]) -> Result<YorpTorque> {
        let name = &self.name;
        let on = index_of_extended(name, "on", &self.on, bodies)?;
        let (pole, torque) = self.pole_and_torque()?;
        Ok(YorpTorque {
            on,
            body: bodies[on].name.clone(),
            inertia: bodies[on].inertia(),
            pole,
            torque,
            largest: self.across.iter().fold(0.0, |largest, across| across.abs().max(largest)),
            loads: [Load::none(of, on, true)],
        })
    }
}

#[derive(Debug, Clone)]
enum TorqueTable {
    Constant([f64; 2]),
    Table(Spline<2>),
}

/// The evaluator of a torque of radiation.
#[derive(Debug, Clone)]
pub(super) struct YorpTorque {
    pub on: usize,
    body: String,
    inertia: Vec3,
    pole: Vec3,
    torque: TorqueTable,
    /// The size of the largest torque across the spin.
    largest: f64,
    loads: [Load; 1],
}

impl YorpTorque {
    /// Returns an error for a spin of zero, for a step in which the torque along the spin brings it to a
    /// stop, and for one in which the torque across the spin brings it to the pole: there the torque has no
    /// direction, and would change its sign at every step.
    fn check(&self, name: &str, snapshot: MotionSnapshot, step: f64) -> Result<()> {
        let spin = Vec3::from(snapshot.spin[self.on]);
        let [along, across] = self.torques(&snapshot.inertial_spin(self.on));
        let failed = |detail| {
            Err(Error::ForceFailed { force: name.to_owned(), time: snapshot.time, detail, answer: None })
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
                snapshot.time + stop
            ));
        }
        let pole = rotate_back(&snapshot.rotation[self.on], &self.pole);
        let (cosine, sine) = (axis.dot(&pole), axis.cross(&pole).norm());
        let across = self.across_at_pole(cosine);
        if across == 0.0 || sine == 0.0 {
            return Ok(());
        }
        // The spin's direction moves by the torque across it and by free nutation, which may carry it past
        // the pole.
        let outwards = (axis * cosine - pole) / sine;
        let over = |torque: Vec3| torque.component_div(&self.inertia) / spin.norm();
        let rate = over(outwards * across).dot(&outwards) * cosine.signum();
        let nutation = over(self.inertia.component_mul(&spin).cross(&spin));
        let driven = rate.abs() > (nutation - axis * axis.dot(&nutation)).norm();
        let (angle, towards) = (sine.atan2(cosine.abs()), rate * step < 0.0);
        if driven && towards && (angle <= PARALLEL || (rate * step).abs() >= angle) {
            return failed(format!(
                "it brings the spin of {}, at an obliquity of {} rad, to the pole by time {}, where the \
                 torque across the spin has no \
                 direction; expected torques across the spin that vanish at obliquities of 0 and pi: a \
                 table of them",
                self.body,
                sine.atan2(cosine),
                snapshot.time + (angle / rate).abs().copysign(step)
            ));
        }
        Ok(())
    }

    /// Returns the limit of the torque across the spin at the nearer pole. The rounding errors of a table
    /// count as zero.
    fn across_at_pole(&self, cosine: f64) -> f64 {
        match &self.torque {
            TorqueTable::Constant([_, across]) => *across,
            TorqueTable::Table(spline) => {
                let ([_, across], _) = spline.at(if cosine > 0.0 { 0.0 } else { std::f64::consts::PI });
                if across.abs() > ROUNDING * self.largest { across } else { 0.0 }
            }
        }
    }

    /// Returns the torques along and across an inertial spin.
    fn torques(&self, spin: &Vec3) -> [f64; 2] {
        match &self.torque {
            TorqueTable::Constant(torque) => *torque,
            TorqueTable::Table(spline) => {
                spline.at(spin.cross(&self.pole).norm().atan2(spin.dot(&self.pole))).0
            }
        }
    }
}

impl Evaluator for YorpTorque {
    #[inline(always)]
    fn loads(&self) -> &[Load] {
        &self.loads
    }

    fn compute(&mut self, snapshot: MotionSnapshot) {
        let spin = snapshot.inertial_spin(self.on);
        let Some(axis) = spin.try_normalize(0.0) else {
            self.loads[0].torque = Vec3::zeros();
            return;
        };
        let aside = axis.cross(&self.pole);
        let sine = aside.norm();
        let [along, across] = self.torques(&axis);
        // This direction lies from the pole to the spin, across the spin; it is undefined where both are
        // parallel.
        let outwards = if sine > 0.0 { aside.cross(&axis) * (-1.0 / sine) } else { Vec3::zeros() };
        let torque = axis * along + outwards * across;
        self.loads[0].torque = rotate_back(&snapshot.rotation[self.on], &torque);
    }

    fn begin_step(&mut self, name: &str, snapshot: MotionSnapshot, step: f64) -> Result<()> {
        self.check(name, snapshot, step)
    }

    /// Takes a torque or a factor of a table's torques for the parameter.
    fn unit(&self, parameter: ForceParameter) -> Option<Self> {
        let unit = match parameter {
            ForceParameter::Along => [1.0, 0.0],
            ForceParameter::Across => [0.0, 1.0],
            _ => return None,
        };
        Some(Self { torque: TorqueTable::Constant(unit), body: String::new(), ..*self })
    }

    /// Adds the derivatives of the torque in the body frame, M = A a + B u. Here a is the direction of the
    /// spin w, k the pole in the body frame, c = a.k, s = |a x k|, u = (c a - k) / s, and A and B are
    /// functions of the obliquity.
    fn add_jacobian(
        &mut self,
        name: &str,
        snapshot: MotionSnapshot,
        jacobian: &mut LoadJacobian,
    ) -> Result<()> {
        let spin_vector = Vec3::from(snapshot.spin[self.on]);
        let spin = spin_vector.norm();
        if spin == 0.0 {
            return Ok(());
        }
        let (a, k) = (spin_vector / spin, rotate_back(&snapshot.rotation[self.on], &self.pole));
        let (cosine, sine) = (a.dot(&k), a.cross(&k).norm());
        let ([along, across], [along_rate, across_rate]) = match &self.torque {
            TorqueTable::Constant(torque) => (*torque, [0.0; 2]),
            TorqueTable::Table(spline) => spline.at(sine.atan2(cosine)),
        };
        let aside = [across, along_rate, across_rate] != [0.0; 3];
        if aside && sine < PARALLEL {
            let detail = format!(
                "the spin of {}, at an obliquity of {} rad, is parallel to the pole, where the torque \
                 across the spin has no derivatives",
                self.body,
                sine.atan2(cosine)
            );
            return Err(Error::ForceFailed {
                force: name.to_owned(),
                time: snapshot.time,
                detail,
                answer: None,
            });
        }
        let (across, u, inverse) = if aside {
            (across / sine, (a * cosine - k) / sine, 1.0 / sine)
        } else {
            (0.0, Vec3::zeros(), 0.0)
        };
        // This is the derivative with respect to c alone, where the obliquity changes by -dc/s.
        let by_cosine =
            a * across - (a * along_rate + u * across_rate) * inverse + u * (across * cosine * inverse);
        let identity = Mat3::identity();
        let by_axis = identity * (along + across * cosine) + by_cosine * k.transpose();
        let by_pole = by_cosine * a.transpose() - identity * across;
        let block = BodyBlock::rotation(self.on);
        jacobian.add_by_rate(block, block, &(by_axis * (identity - a * a.transpose())), 1.0 / spin);
        jacobian.add(block, block, &times_cross(&by_pole, &k), 1.0);
        Ok(())
    }
}
