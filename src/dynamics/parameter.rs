//! The parameters of a system that motions are differentiated by.

use super::System;
use crate::environment::{Environment, Force};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mutual::{AxisSlopes, Interaction, Method};
use crate::shape::{Body, Part, Shape};

/// A number that the motion depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Parameter {
    /// The gravitational constant.
    GravitationalConstant,
    /// The mass of a body, whose shape stays.
    Mass(usize),
    /// The density of a body, whose shape stays: the derivative by the mass times this volume.
    Density(usize, f64),
    /// A semi-axis of an ellipsoid, whose mass stays.
    SemiAxis(usize, usize),
    /// A number that the loads of a force are in proportion to, with its value.
    OfForce(usize, f64),
}

/// How a parameter acts on what two bodies do to each other: factors of the force and the torques per unit G m m.
#[derive(Debug, Clone, Copy)]
pub(super) struct OfPair {
    /// Of the acceleration of either body.
    pub acceleration: [f64; 2],
    /// Of the torque on either body over its moments of inertia.
    pub torque: [f64; 2],
}

impl Parameter {
    /// The parameters by their names.
    fn all(bodies: &[Body], forces: &[Force]) -> Vec<(String, Self)> {
        let mut all = vec![("G".to_owned(), Self::GravitationalConstant)];
        for (k, body) in bodies.iter().enumerate() {
            all.push((format!("mass of {}", body.name), Self::Mass(k)));
            // The parts of a composite may overlap, and have densities of their own.
            if body.volume() > 0.0 && !body.is_composite() {
                all.push((format!("density of {}", body.name), Self::Density(k, body.volume())));
            }
            if let [Part { shape: Shape::Ellipsoid(_), place: None, .. }] = body.parts() {
                let axes = ["a", "b", "c"].iter().enumerate();
                all.extend(axes.map(|(axis, letter)| {
                    (format!("semi-axis {letter} of {}", body.name), Self::SemiAxis(k, axis))
                }));
            }
        }
        for (k, force) in forces.iter().enumerate() {
            let factors = match force {
                Force::ThirdBody(body) => vec![("mu", body.mu)],
                Force::Tide(tide) => vec![("k2", tide.k2), ("lag", tide.lag)],
                Force::Byorp(push) => vec![("force", push.force)],
                Force::Yorp(_) | Force::Function(_) => Vec::new(),
            };
            // The derivative by a factor that is zero is not that of loads which vanish with it.
            let factors = factors.into_iter().filter(|(_, value)| *value != 0.0);
            all.extend(
                factors.map(|(what, value)| (format!("{what} of {}", force.name()), Self::OfForce(k, value))),
            );
        }
        all
    }

    /// Those that a system can be differentiated by, with their names.
    pub fn of(system: &System) -> Vec<(String, Self)> {
        let all = Self::all(system.bodies(), system.forces());
        all.into_iter().filter(|(name, parameter)| parameter.refusal(name, system).is_none()).collect()
    }

    /// The parameter of a name, refused where the system has no derivative by it.
    pub fn named(name: &str, system: &System) -> Result<Self> {
        let all = Self::all(system.bodies(), system.forces());
        let Some((_, parameter)) = all.iter().find(|(known, _)| known == name) else {
            let known: Vec<_> = Self::of(system).iter().map(|(name, _)| format!("{name:?}")).collect();
            let expected = format!("one of {}", known.join(", "));
            return Err(Error::invalid("parameter", format!("{name:?}"), expected));
        };
        parameter.refusal(name, system).map_or(Ok(*parameter), Err)
    }

    /// Why a system has no derivative by it.
    fn refusal(self, name: &str, system: &System) -> Option<Error> {
        let method = system.settings().gravity;
        let refused = self.semi_axis().is_some() && matches!(method, Method::Multipole(_));
        let found = || format!("by the {name} with gravity=\"{method}\"");
        refused.then(|| Error::invalid("derivatives", found(), "gravity=\"focal\" or \"surface\" for it"))
    }

    /// Whether it changes a mass.
    pub fn is_mass(self) -> bool {
        matches!(self, Self::Mass(_) | Self::Density(..))
    }

    /// The body and its semi-axis that it is.
    pub fn semi_axis(self) -> Option<(usize, usize)> {
        match self {
            Self::SemiAxis(body, axis) => Some((body, axis)),
            _ => None,
        }
    }

    /// The part of what two bodies do to each other, where it is a semi-axis of one.
    pub(super) fn slopes(self, bodies: [usize; 2], slopes: &AxisSlopes) -> Option<Interaction> {
        let (body, axis) = self.semi_axis()?;
        let which = bodies.iter().position(|other| *other == body)?;
        Some(slopes[which][axis])
    }

    /// The body whose moments of inertia change with it, where it is a semi-axis, and their derivatives: I_1 = m (a_2^2 + a_3^2) / 5.
    pub(super) fn of_inertia(self, bodies: &[Body]) -> Option<(usize, Vec3)> {
        let (body, axis) = self.semi_axis()?;
        let mut inertia = Vec3::repeat(0.4 * bodies[body].mass * bodies[body].semi_axes()[axis]);
        inertia[axis] = 0.0;
        Some((body, inertia))
    }

    /// The relative change of what the loads of a force do to a body: the loads' own less that of its mass or moments.
    pub(super) fn of_rates(
        self,
        force: usize,
        on: usize,
        outside: &Environment,
        g: f64,
        masses: &[f64],
    ) -> f64 {
        match self {
            Self::GravitationalConstant if g != 0.0 => outside.powers(force, on, on)[0] / g,
            Self::OfForce(k, value) if k == force => 1.0 / value,
            Self::Mass(k) | Self::Density(k, _) => {
                let own = if k == on { 1.0 } else { 0.0 };
                self.of_mass(k) * (outside.powers(force, k, on)[1] - own) / masses[k]
            }
            _ => 0.0,
        }
    }

    /// Derivative of a body's mass.
    pub fn of_mass(self, body: usize) -> f64 {
        match self {
            Self::Mass(k) if k == body => 1.0,
            Self::Density(k, volume) if k == body => volume,
            _ => 0.0,
        }
    }

    /// How it acts between two bodies.
    pub(super) fn of_pair(self, bodies: [usize; 2], g: f64, masses: [f64; 2]) -> OfPair {
        if self == Self::GravitationalConstant {
            return OfPair { acceleration: [masses[1], masses[0]], torque: [masses[0] * masses[1]; 2] };
        }
        // A body's own mass stands in its torque and in its moments alike.
        let by = bodies.map(|body| self.of_mass(body));
        OfPair {
            acceleration: [g * by[1], g * by[0]],
            torque: [g * masses[0] * by[1], g * masses[1] * by[0]],
        }
    }
}
