//! The numbers of forces by which motions are differentiated, and the derivatives of the loads by them.
//!
//! Where loads are proportional to a number, their derivative is the loads with that number set to one. The
//! loads of a third body act through its position p too, which its orbit gives: dp/dq of each element is in
//! closed form, and the derivative of the loads along dp is a difference of eighth order of the loads
//! themselves, which lose no digits at any distance. The positions of a composite's parts and the scale of a
//! polyhedron are treated in the same way.

use super::third_body::ThirdBodyPull;
use super::{Force, ForceParameter, Load, Path, Snapshot};
use crate::error::Result;
use crate::gravity::BodyChange;
use crate::math::Vec3;
use crate::math::difference::{STEP, WEIGHTS};
use crate::math::rotation::turned;
use crate::orbit::OrbitPosition;

/// The names of the numbers of an orbit, in the order of [`crate::orbit::OrbitPath::derivatives`].
const ELEMENTS: [&str; 7] = ["a", "e", "i", "Omega", "omega", "M", "time"];

impl Force {
    /// Returns the numbers by which motions are differentiated, with their names.
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
            Self::Yorp(turn) if turn.obliquity.is_empty() => vec![("along", P::Along), ("across", P::Across)],
            Self::Yorp(_) => vec![("factor", P::Factor)],
            Self::Byorp(_) => vec![("force", P::Push)],
            Self::Function(_) => Vec::new(),
        }
    }

    /// Returns a natural size of the changes of a number.
    pub fn parameter_size(&self, parameter: ForceParameter, gravitational_constant: f64) -> f64 {
        use ForceParameter as P;
        let or_one = |value: f64| if value == 0.0 { 1.0 } else { value.abs() };
        match (self, parameter) {
            (Self::ThirdBody(body), P::Mu) => body.mu,
            (Self::ThirdBody(body), P::Mass) => body.mu / or_one(gravitational_constant),
            (Self::ThirdBody(body), P::Element(which)) => match (&body.path, which) {
                (Path::Orbit { elements, .. }, 0) => elements.semi_major_axis.abs(),
                (Path::Orbit { elements, .. }, 1) => {
                    or_one(elements.eccentricity.min((1.0 - elements.eccentricity).abs()))
                }
                (Path::Orbit { elements, .. }, 6) => {
                    elements.mean_motion(body.mu).map_or(1.0, |motion| 1.0 / motion)
                }
                _ => 1.0,
            },
            (Self::Tide(tide), P::K2) => or_one(tide.k2),
            (Self::Tide(tide), P::Lag) => or_one(tide.lag),
            (Self::Yorp(turn), P::Along) => or_one(turn.along[0]),
            (Self::Yorp(turn), P::Across) => or_one(turn.across[0]),
            (Self::Byorp(push), _) => or_one(push.force),
            _ => 1.0,
        }
    }

    /// Returns the force with a number changed; the gravitational constant relates the mass of a third body
    /// to its mu.
    pub fn with_parameter(&self, parameter: ForceParameter, by: f64, gravitational_constant: f64) -> Self {
        use ForceParameter as P;
        let mut force = self.clone();
        match (&mut force, parameter) {
            (Self::ThirdBody(body), P::Mu) => body.mu += by,
            (Self::ThirdBody(body), P::Mass) => {
                body.mass = body.mass.map(|mass| mass + by);
                body.mu += gravitational_constant * by;
            }
            (Self::ThirdBody(body), P::Element(which)) => {
                if let Path::Orbit { elements, time } = &mut body.path {
                    let elements = [
                        &mut elements.semi_major_axis,
                        &mut elements.eccentricity,
                        &mut elements.inclination,
                        &mut elements.longitude_of_node,
                        &mut elements.argument_of_periapsis,
                        &mut elements.mean_anomaly,
                        time,
                    ];
                    elements.into_iter().skip(which).take(1).for_each(|element| *element += by);
                }
            }
            (Self::Tide(tide), P::K2) => tide.k2 += by,
            (Self::Tide(tide), P::Lag) => tide.lag += by,
            (Self::Yorp(turn), P::Along) => turn.along.iter_mut().for_each(|torque| *torque += by),
            (Self::Yorp(turn), P::Across) => turn.across.iter_mut().for_each(|torque| *torque += by),
            (Self::Yorp(turn), _) => {
                turn.along.iter_mut().chain(&mut turn.across).for_each(|torque| *torque *= 1.0 + by);
            }
            (Self::Byorp(push), _) => push.force += by,
            _ => {}
        }
        force
    }
}

impl ThirdBodyPull {
    /// Computes the derivative of the loads at a snapshot along a change of the third body's position, one
    /// for every body. Allocates nothing.
    pub fn along(&mut self, name: &str, snapshot: Snapshot, change: &Vec3) -> Result<&[Load]> {
        self.changes.iter_mut().for_each(|load| (load.force, load.torque) = (Vec3::zeros(), Vec3::zeros()));
        let length = change.norm();
        if length > 0.0 {
            let (place, _) = self.place(snapshot.time)?;
            let step = STEP * place.norm() / length;
            for (k, weight) in (1..).zip(WEIGHTS) {
                for sign in [1.0, -1.0] {
                    self.load_from(
                        name,
                        snapshot,
                        OrbitPosition::from(place + change * (sign * f64::from(k) * step)),
                    )?;
                    for (sum, load) in self.changes.iter_mut().zip(&self.loads) {
                        sum.force += load.force * (sign * weight / step);
                        sum.torque += load.torque * (sign * weight / step);
                    }
                }
            }
            self.load_from(name, snapshot, OrbitPosition::from(place))?;
        }
        Ok(&self.changes)
    }

    /// Returns the derivatives of the position by the numbers of the orbit, and by mu; zero for a table.
    pub fn path_derivatives(&self, time: f64) -> Result<[Vec3; 8]> {
        self.orbit().map_or(Ok([Vec3::zeros(); 8]), |(orbit, epoch)| orbit.derivatives(time - epoch))
    }

    /// Returns the derivatives of force (inertial) and torque (in the body's frame) on a body whose own field
    /// changes, at its mass.
    pub fn by_change(&mut self, snapshot: Snapshot, body: usize, change: &BodyChange) -> Result<[Vec3; 2]> {
        let (place, _) = self.place(snapshot.time)?;
        let [force, torque] = self.excess_by_change(snapshot, body, change, &OrbitPosition::from(place));
        Ok([turned(&snapshot.rotation[body], &force), torque])
    }
}
