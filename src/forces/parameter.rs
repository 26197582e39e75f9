//! The parameters of forces by which motions are differentiated, and the derivatives of the loads with
//! respect to them.
//!
//! Where loads are proportional to a parameter, their derivative is the loads with that parameter set to one.
//! The loads of a third body depend on its orbit through its position p. The derivatives dp/dq with respect
//! to the elements have closed forms, as has the derivative of the acceleration of a point along dp. The
//! contribution of a body's extent is differentiated by a difference of eighth order, which loses no digits
//! at any distance, because that contribution is computed by itself. The positions of a composite's parts and
//! the scale of a polyhedron are treated in the same way.

use super::third_body::{BattinFactors, ThirdBodyAttraction, inside};
use super::{Force, ForceParameter, Load, MotionSnapshot, Path, ThirdBody};
use crate::error::Result;
use crate::gravity::BodyChange;
use crate::math::Vec3;
use crate::math::difference::{STEP, steps};
use crate::math::rotation::{rotate, rotate_back};
use crate::orbit::OrbitPosition;

/// The names of the parameters of an orbit, in the order of [`crate::orbit::OrbitPath::derivatives`].
const ELEMENTS: [&str; 7] = ["a", "e", "i", "Omega", "omega", "M", "time"];

impl Force {
    /// Returns the parameters by which motions are differentiated, with their names.
    pub fn parameters(&self) -> Vec<(&'static str, ForceParameter)> {
        use ForceParameter as P;
        match self {
            Self::ThirdBody(body) => {
                let mut all = vec![if body.mass.is_some() { ("mass", P::Mass) } else { ("mu", P::Mu) }];
                if let Path::Orbit { .. } = body.path {
                    all.extend(ELEMENTS.iter().enumerate().map(|(k, name)| (*name, P::Element(k))));
                }
                all
            }
            Self::Tide(_) => vec![("k2", P::K2), ("lag", P::Lag)],
            Self::Yorp(yorp) if yorp.obliquity.is_empty() => vec![("along", P::Along), ("across", P::Across)],
            Self::Yorp(_) | Self::BinaryYarkovsky(_) => vec![("factor", P::Factor)],
            Self::Byorp(_) => vec![("force", P::AlongMotion)],
            Self::Function(_) => Vec::new(),
        }
    }

    /// Returns the value of a parameter; that of a factor is one. The gravitational constant relates the mass
    /// of a third body to its mu.
    pub fn parameter_value(&self, parameter: ForceParameter, gravitational_constant: f64) -> f64 {
        match (self, parameter) {
            (Self::ThirdBody(body), ForceParameter::Mass) if gravitational_constant > 0.0 => {
                body.mu / gravitational_constant
            }
            (_, ForceParameter::Factor) => 1.0,
            _ => self.clone().numbers(parameter).first().map_or(0.0, |number| **number),
        }
    }

    /// Returns the change of a parameter from this force to another one of its kind.
    pub fn parameter_change(&self, other: &Self, parameter: ForceParameter, g: [f64; 2]) -> f64 {
        if parameter != ForceParameter::Factor {
            return other.parameter_value(parameter, g[1]) - self.parameter_value(parameter, g[0]);
        }
        let [reference, changed] = [self, other].map(|force| {
            let mut force = force.clone();
            force.numbers(parameter).iter().fold(0.0, |length: f64, torque| length.hypot(**torque))
        });
        if reference > 0.0 { changed / reference - 1.0 } else { 0.0 }
    }

    /// Returns a natural size of the changes of a parameter.
    pub fn parameter_size(&self, parameter: ForceParameter, gravitational_constant: f64) -> f64 {
        let nonzero = |value: f64| if value == 0.0 { 1.0 } else { value.abs() };
        match (self, parameter) {
            (Self::ThirdBody(body), ForceParameter::Element(which @ 1..)) => match (&body.path, which) {
                (Path::Orbit { elements, .. }, 1) => {
                    nonzero(elements.eccentricity.min((1.0 - elements.eccentricity).abs()))
                }
                (Path::Orbit { elements, .. }, 6) => {
                    elements.mean_motion(body.mu).map_or(1.0, |motion| 1.0 / motion)
                }
                _ => 1.0,
            },
            _ => nonzero(self.parameter_value(parameter, gravitational_constant)),
        }
    }

    /// Returns the force with a parameter changed by `by`.
    pub fn with_parameter(&self, parameter: ForceParameter, by: f64, gravitational_constant: f64) -> Self {
        let mut force = self.clone();
        let is_factor = parameter == ForceParameter::Factor;
        force
            .numbers(parameter)
            .into_iter()
            .for_each(|number| if is_factor { *number *= 1.0 + by } else { *number += by });
        if let (Self::ThirdBody(body), ForceParameter::Mass) = (&mut force, parameter) {
            body.mu += gravitational_constant * by;
        }
        force
    }

    /// Returns the numbers that a parameter changes.
    fn numbers(&mut self, parameter: ForceParameter) -> Vec<&mut f64> {
        use ForceParameter as P;
        match (self, parameter) {
            (Self::ThirdBody(body), P::Mu) => vec![&mut body.mu],
            (Self::ThirdBody(body), P::Mass) => body.mass.iter_mut().collect(),
            (Self::ThirdBody(ThirdBody { path: Path::Orbit { elements, time }, .. }), P::Element(which)) => {
                let elements = [
                    &mut elements.semi_major_axis,
                    &mut elements.eccentricity,
                    &mut elements.inclination,
                    &mut elements.longitude_of_node,
                    &mut elements.argument_of_periapsis,
                    &mut elements.mean_anomaly,
                    time,
                ];
                elements.into_iter().skip(which).take(1).collect()
            }
            (Self::Tide(tide), P::K2) => vec![&mut tide.k2],
            (Self::Tide(tide), P::Lag) => vec![&mut tide.lag],
            (Self::Yorp(yorp), P::Along) => yorp.along.iter_mut().collect(),
            (Self::Yorp(yorp), P::Across) => yorp.across.iter_mut().collect(),
            (Self::Yorp(yorp), P::Factor) => yorp.along.iter_mut().chain(&mut yorp.across).collect(),
            (Self::Byorp(byorp), P::AlongMotion) => vec![&mut byorp.force[1]],
            (Self::BinaryYarkovsky(force), P::Factor) => vec![&mut force.pressure],
            _ => Vec::new(),
        }
    }
}

impl ThirdBodyAttraction {
    /// Computes the derivatives of the loads on every body at a snapshot along a change of the third body's
    /// position. Allocates nothing.
    ///
    /// In the notation of [`super::third_body`] the acceleration K |d|^-3 (r + f p) changes with |d|^-3 by
    /// 3 |d|^-5 (p - r).dp, with f by 3/2 sqrt(1 + q) dq, where dq = -2 (r.dp + q p.dp)/|p|^2, and with p.
    pub fn along(
        &mut self,
        name: &str,
        snapshot: MotionSnapshot,
        position: Vec3,
        change: &Vec3,
    ) -> Result<&[Load]> {
        let OrbitPosition { position: p, inverse_square, inverse_cube } = OrbitPosition::from(position);
        for (index, (body, load)) in self.bodies.iter_mut().zip(&mut self.changes).enumerate() {
            let r = snapshot.position_from_barycentre(index);
            let from = p - r;
            let q = r.dot(&(r - 2.0 * p)) * inverse_square;
            let BattinFactors { f, square, cube } = BattinFactors::of(q);
            let by_f = -3.0 * (1.0 + q).sqrt() * (r.dot(change) + q * p.dot(change)) * inverse_square;
            let by_distance = -3.0 * from.dot(change) * (inverse_square * square);
            let strength = -self.mu * body.mass;
            load.force =
                ((r + f * p) * by_distance + p * by_f + f * change) * (inverse_cube * cube * strength);
            load.torque = Vec3::zeros();
            let length = change.norm();
            if let Some(extended) = body.extended.as_mut().filter(|_| length > 0.0) {
                let rotation = &snapshot.rotation[index];
                let (x, along) = (rotate_back(rotation, &from), rotate_back(rotation, change));
                for (by, weight) in steps(STEP * from.norm() / length) {
                    let OrbitPosition { position, inverse_square, inverse_cube } =
                        OrbitPosition::from(x + along * by);
                    let attracted = extended.at(&position, inverse_square, inverse_cube, strength);
                    let (perturbation, moment) =
                        attracted.ok_or_else(|| inside(name, snapshot.time, &body.name))?;
                    load.force += rotate(rotation, &perturbation) * weight;
                    load.torque += moment * weight;
                }
            }
        }
        Ok(&self.changes)
    }

    /// Returns the position with its derivatives with respect to the elements of the orbit and to mu; the
    /// derivatives are zero for a table.
    pub fn path_derivatives(&mut self, time: f64) -> Result<(Vec3, [Vec3; 8])> {
        if let Some((_, path_derivatives)) = self.path_derivatives.filter(|(at, _)| *at == time) {
            return Ok(path_derivatives);
        }
        let path_derivatives = match self.orbit() {
            Some((orbit, epoch)) => orbit.derivatives(time - epoch)?,
            None => (self.position_and_velocity(time)?.0, [Vec3::zeros(); 8]),
        };
        self.path_derivatives = Some((time, path_derivatives));
        Ok(path_derivatives)
    }

    /// Returns the derivatives of force (inertial) and torque (body frame) on a body whose own field changes
    /// while its mass stays the same.
    pub fn by_change(
        &mut self,
        snapshot: MotionSnapshot,
        body: usize,
        change: &BodyChange,
    ) -> Result<[Vec3; 2]> {
        let (position, _) = self.path_derivatives(snapshot.time)?;
        let [force, torque] =
            self.perturbation_by_change(snapshot, body, change, &OrbitPosition::from(position));
        Ok([rotate(&snapshot.rotation[body], &force), torque])
    }
}
