//! The parameters by which the motions of a system can be differentiated.

use super::system::System;
use crate::error::{Error, Result};
use crate::forces::{Force, ForceModel, ForceParameter};
use crate::math::Vec3;
use crate::mutual::{Interaction, ShapeDerivatives};
use crate::shape::{Body, Part, PartDerivative, PartNumber, Shape, StokesCoefficients, StokesNumber};

/// A parameter of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Parameter {
    /// The gravitational constant.
    GravitationalConstant,
    /// The mass of a body, at a fixed shape.
    Mass(usize),
    /// The density of a body, at a fixed shape; the number is the body's volume, by which the derivative with
    /// respect to the mass is multiplied.
    Density(usize, f64),
    /// A semi-axis of an ellipsoid, at a fixed mass.
    SemiAxis(usize, usize),
    /// A factor of all lengths of a polyhedron at a fixed mass; its value is one.
    Scale(usize),
    /// A parameter of a part of a composite, with the indices of the body and the part: the mass of the part,
    /// or a coordinate of its position in the working frame.
    Part(usize, usize, PartNumber),
    /// A number of a body that is given by Stokes coefficients.
    Stokes(usize, StokesNumber),
    /// A parameter of a force, with the index of the force.
    Force(usize, ForceParameter),
}

/// The derivatives with respect to a parameter of the interaction of two bodies, as factors of force and
/// torques per unit G m m.
#[derive(Debug, Clone, Copy)]
pub(in crate::dynamics) struct PairFactors {
    /// The factors for the acceleration of either body.
    pub acceleration: [f64; 2],
    /// The factors for the torque on either body over its moments of inertia.
    pub torque: [f64; 2],
}

impl Parameter {
    /// Returns the parameters of bodies and forces with their names, also those of parts without derivatives.
    fn candidates(bodies: &[Body], forces: &[Force]) -> Vec<(String, Self)> {
        let mut all = vec![("G".to_owned(), Self::GravitationalConstant)];
        for (k, body) in bodies.iter().enumerate() {
            all.push((format!("mass of {}", body.name), Self::Mass(k)));
            // The parts of a composite may overlap and have densities of their own, so that the body has
            // none.
            if body.volume() > 0.0 && !body.is_composite() {
                all.push((format!("density of {}", body.name), Self::Density(k, body.volume())));
            }
            if let [Part { shape: Shape::Ellipsoid(_), placement: None, .. }] = body.parts() {
                let axes = ["a", "b", "c"].iter().enumerate();
                all.extend(axes.map(|(axis, letter)| {
                    (format!("semi-axis {letter} of {}", body.name), Self::SemiAxis(k, axis))
                }));
            }
            let numbers = [
                ("mass", PartNumber::Mass),
                ("position x", PartNumber::Position(0)),
                ("position y", PartNumber::Position(1)),
                ("position z", PartNumber::Position(2)),
            ];
            for part in 0..body.input_parts().len() {
                all.extend(numbers.iter().map(|(what, number)| {
                    (format!("{what} of part {part} of {}", body.name), Self::Part(k, part, *number))
                }));
            }
            if let [Part { shape: Shape::Polyhedron(_), placement: None, .. }] = body.parts() {
                all.push((format!("scale of {}", body.name), Self::Scale(k)));
            }
            if let Some(stokes) = stokes(body) {
                all.extend(
                    stokes
                        .numbers()
                        .map(|(what, number)| (format!("{what} of {}", body.name), Self::Stokes(k, number))),
                );
            }
        }
        for (k, force) in forces.iter().enumerate() {
            let numbers = force.parameters().into_iter();
            all.extend(
                numbers.map(|(what, number)| (format!("{what} of {}", force.name()), Self::Force(k, number))),
            );
        }
        all
    }

    /// Returns the parameters by which a system can be differentiated, with their names.
    pub fn all_of(system: &System) -> Vec<(String, Self)> {
        let all = Self::candidates(system.bodies(), system.forces());
        all.into_iter().filter(|(_, parameter)| parameter.part_derivative(system.bodies()).is_ok()).collect()
    }

    /// Returns the parameter with this name.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] lists the names of the system's parameters, or says why the system has no
    /// derivative with respect to this one.
    pub fn named(name: &str, system: &System) -> Result<Self> {
        let all = Self::candidates(system.bodies(), system.forces());
        let Some((_, parameter)) = all.iter().find(|(listed, _)| listed == name) else {
            let names: Vec<_> = Self::all_of(system).iter().map(|(name, _)| format!("{name:?}")).collect();
            let expected = format!("one of {}", names.join(", "));
            return Err(Error::invalid("parameter", format!("{name:?}"), expected));
        };
        parameter.part_derivative(system.bodies()).map(|_| *parameter)
    }

    /// Returns the body and its derivatives, where the parameter belongs to a part of a composite.
    pub(in crate::dynamics) fn part_derivative(
        self,
        bodies: &[Body],
    ) -> Result<Option<(usize, PartDerivative)>> {
        let Self::Part(body, part, number) = self else { return Ok(None) };
        bodies[body].by_part(part, number).map(|derivative| Some((body, derivative)))
    }

    /// Returns an error for a parameter that [`Self::all_of`] does not list for the system.
    pub(in crate::dynamics) fn check(self, system: &System) -> Result<()> {
        let all = Self::candidates(system.bodies(), system.forces());
        if all.iter().any(|(_, listed)| *listed == self) {
            return Ok(());
        }
        let expected = "one of those that Parameter::all_of lists for the system";
        Err(Error::invalid("parameter", format!("{self:?}"), expected))
    }

    /// Returns whether the parameter changes a mass.
    pub fn is_mass(self) -> bool {
        matches!(self, Self::Mass(_) | Self::Density(..) | Self::Part(.., PartNumber::Mass))
    }

    /// Returns the body and the index of its semi-axis, for such a parameter.
    pub fn semi_axis(self) -> Option<(usize, usize)> {
        match self {
            Self::SemiAxis(body, axis) => Some((body, axis)),
            _ => None,
        }
    }

    /// Returns, for a parameter that changes one harmonic moment of a body, the body, the index of the moment, and its
    /// derivative.
    pub(in crate::dynamics) fn moment_derivative(self, bodies: &[Body]) -> Option<(usize, usize, f64)> {
        let Self::Stokes(body, StokesNumber::Coefficient(index)) = self else { return None };
        let stokes = stokes(&bodies[body])?;
        Some((body, index, stokes.moment_by_coefficient(index, stokes.input().reference_radius)))
    }

    /// Returns the body whose semi-axis or scale the parameter is.
    pub(in crate::dynamics) fn shape_body(self) -> Option<usize> {
        match self {
            Self::SemiAxis(body, _) | Self::Scale(body) => Some(body),
            _ => None,
        }
    }

    /// Returns the derivative of the interaction of two bodies, where the parameter is a length of one.
    pub(in crate::dynamics) fn shape_derivative(
        self,
        bodies: [usize; 2],
        derivatives: &ShapeDerivatives,
    ) -> Option<Interaction> {
        let which = bodies.iter().position(|other| Some(*other) == self.shape_body())?;
        match self {
            Self::SemiAxis(_, axis) => Some(derivatives.axes[which][axis]),
            _ => Some(derivatives.scale[which]),
        }
    }

    /// Returns the body whose moments of inertia change with the parameter at a fixed mass, and their
    /// derivatives: I_1 = m (a_2^2 + a_3^2) / 5 for an ellipsoid.
    pub(in crate::dynamics) fn inertia_derivatives(self, bodies: &[Body]) -> Option<(usize, Vec3)> {
        if let Self::Scale(body) = self {
            return Some((body, 2.0 * bodies[body].inertia()));
        }
        if let Self::Stokes(body, number) = self {
            let by = stokes(&bodies[body])?.inertia_by(number);
            return Some((body, by * bodies[body].mass));
        }
        if let Ok(Some((body, derivative))) = self.part_derivative(bodies) {
            return Some((body, derivative.inertia));
        }
        let (body, axis) = self.semi_axis()?;
        let mut inertia = Vec3::repeat(0.4 * bodies[body].mass * bodies[body].semi_axes()[axis]);
        inertia[axis] = 0.0;
        Some((body, inertia))
    }

    /// Returns the relative derivatives of the effects of a force on a body: of the body's acceleration, and
    /// of the rate of its spin at constant moments of inertia. They are the relative derivative of the loads
    /// minus that of the body's mass.
    pub(in crate::dynamics) fn rate_factors(
        self,
        force: usize,
        on: usize,
        external_forces: &ForceModel,
        g: f64,
        masses: &[f64],
    ) -> [f64; 2] {
        match self {
            Self::GravitationalConstant if g != 0.0 => [external_forces.powers(force, on, on)[0] / g; 2],
            Self::Mass(k) | Self::Density(k, _) | Self::Part(k, _, PartNumber::Mass) => {
                let is_own = if k == on { 1.0 } else { 0.0 };
                let (by, power) =
                    (self.mass_derivative(k) / masses[k], external_forces.powers(force, k, on)[1]);
                // The moments of a composite are accounted for by `inertia_derivatives`.
                let moments = if let Self::Part(..) = self { 0.0 } else { is_own };
                [by * (power - is_own), by * (power - moments)]
            }
            _ => [0.0; 2],
        }
    }

    /// Returns the derivative of G times the mass of all bodies, which the orbits of third bodies contain.
    pub(in crate::dynamics) fn total_mu_derivative(self, g: f64, masses: &[f64]) -> f64 {
        let by_mass = |body: usize| g * self.mass_derivative(body);
        match self {
            Self::GravitationalConstant => masses.iter().sum(),
            _ => (0..masses.len()).map(by_mass).sum(),
        }
    }

    /// Returns the derivative of a body's mass.
    pub fn mass_derivative(self, body: usize) -> f64 {
        match self {
            Self::Mass(k) if k == body => 1.0,
            Self::Density(k, volume) if k == body => volume,
            Self::Part(k, _, PartNumber::Mass) if k == body => 1.0,
            _ => 0.0,
        }
    }

    /// Returns the derivatives of the interaction of two bodies.
    pub(in crate::dynamics) fn pair_factors(
        self,
        bodies: [usize; 2],
        g: f64,
        masses: [f64; 2],
    ) -> PairFactors {
        if self == Self::GravitationalConstant {
            return PairFactors { acceleration: [masses[1], masses[0]], torque: [masses[0] * masses[1]; 2] };
        }
        // The loads of a part depend on its position as well, and their derivatives are computed elsewhere.
        if let Self::Part(..) = self {
            return PairFactors { acceleration: [0.0; 2], torque: [0.0; 2] };
        }
        // A body's own mass is a factor of both its torque and its moments, and cancels.
        let by = bodies.map(|body| self.mass_derivative(body));
        PairFactors {
            acceleration: [g * by[1], g * by[0]],
            torque: [g * masses[0] * by[1], g * masses[1] * by[0]],
        }
    }

    /// Returns the body whose surface moves with the parameter.
    #[doc(hidden)]
    pub fn moves_surface(self) -> Option<usize> {
        match self {
            Self::SemiAxis(body, _) | Self::Scale(body) | Self::Part(body, ..) => Some(body),
            _ => None,
        }
    }

    /// Returns whether the parameter moves the third body with this index among the forces along its orbit.
    #[doc(hidden)]
    pub fn moves_third_body(self, force: usize) -> bool {
        match self {
            Self::Force(other, _) => other == force,
            _ => self.is_mass() || self == Self::GravitationalConstant,
        }
    }

    /// Returns the system with the parameter changed.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] refuses a parameter that the system does not have, and a value that it cannot
    /// have.
    pub fn changed(self, system: &System, by: f64) -> Result<System> {
        self.check(system)?;
        let (mut bodies, mut forces) = (system.bodies().to_vec(), system.forces().to_vec());
        let mut g = system.gravitational_constant();
        match self {
            Self::GravitationalConstant => {
                let previous = g;
                g += by;
                for force in &mut forces {
                    if let Force::ThirdBody(body) = force
                        && body.mass.is_some()
                        && previous > 0.0
                    {
                        body.mu *= g / previous;
                    }
                }
            }
            Self::Mass(k) | Self::Density(k, _) => {
                bodies[k] = bodies[k].with_total_mass(bodies[k].mass + by * self.mass_derivative(k))?;
            }
            Self::SemiAxis(k, axis) => {
                let mut axes = bodies[k].semi_axes();
                axes[axis] += by;
                bodies[k] = bodies[k].with_shape(Shape::ellipsoid(axes)?)?;
            }
            Self::Scale(k) => {
                bodies[k] = bodies[k].with_shape(bodies[k].parts()[0].shape.scaled(1.0 + by))?
            }
            Self::Part(k, part, number) => bodies[k] = bodies[k].with_part(part, number, by)?,
            Self::Stokes(k, number) => {
                if let Some(stokes) = stokes(&bodies[k]) {
                    bodies[k] = bodies[k].with_shape(Shape::Stokes(stokes.with(number, by)?))?;
                }
            }
            Self::Force(k, number) => forces[k] = forces[k].with_parameter(number, by, g),
        }
        System::new(bodies, g, *system.settings())?.with_forces(forces)
    }

    /// Returns the value of the parameter; that of a factor is one.
    pub fn value(self, system: &System) -> f64 {
        let (bodies, g) = (system.bodies(), system.gravitational_constant());
        match self {
            Self::GravitationalConstant => g,
            Self::Mass(k) => bodies[k].mass,
            Self::Density(k, volume) => bodies[k].mass / volume,
            Self::SemiAxis(k, axis) => bodies[k].semi_axes()[axis],
            Self::Scale(_) => 1.0,
            Self::Part(k, part, PartNumber::Mass) => bodies[k].input_parts()[part].mass,
            Self::Part(k, part, PartNumber::Position(axis)) => bodies[k].input_parts()[part].position[axis],
            Self::Stokes(k, number) => stokes(&bodies[k])
                .map_or(f64::NAN, |stokes| stokes.number(number, stokes.input().reference_radius)),
            Self::Force(k, number) => system.forces()[k].parameter_value(number, g),
        }
    }

    /// Returns the change of the parameter from one system to another one that has it too.
    pub(in crate::dynamics) fn change(self, from: &System, to: &System) -> f64 {
        match self {
            Self::Scale(k) => to.bodies()[k].circumradius() / from.bodies()[k].circumradius() - 1.0,
            // The reference radius may change too.
            Self::Stokes(k, number) => match [from, to].map(|system| stokes(&system.bodies()[k])) {
                [Some(from), Some(to)] => {
                    let radius = from.input().reference_radius;
                    to.number(number, radius) - from.number(number, radius)
                }
                _ => f64::NAN,
            },
            Self::Force(k, number) => {
                let constants = [from, to].map(System::gravitational_constant);
                from.forces()[k].parameter_change(&to.forces()[k], number, constants)
            }
            _ => self.value(to) - self.value(from),
        }
    }

    /// Returns a natural size of the parameter's changes.
    #[doc(hidden)]
    pub fn size(self, system: &System) -> f64 {
        match self {
            Self::Part(k, _, PartNumber::Position(_)) => system.bodies()[k].circumradius(),
            // Coefficients of a body of density of one sign are below one.
            Self::Stokes(_, StokesNumber::Coefficient(_)) => 0.1,
            Self::Force(k, number) => {
                system.forces()[k].parameter_size(number, system.gravitational_constant())
            }
            _ => match self.value(system).abs() {
                0.0 => 1.0,
                value => value,
            },
        }
    }
}

/// Returns the Stokes coefficients of a body that is given by them.
fn stokes(body: &Body) -> Option<&StokesCoefficients> {
    match body.parts() {
        [Part { shape: Shape::Stokes(stokes), .. }] => Some(stokes),
        _ => None,
    }
}
