//! The derivatives of a condition's function at a state.
//!
//! They are central differences of eighth order, since the functions are of many kinds, including functions
//! of the caller. A function is smooth at its events, so that the differences are accurate to about thirteen
//! digits.

use super::Condition;
use super::condition::EvaluationPoint;
use crate::dynamics::{BarycentricFrame, Parameter, State, System, TANGENT_SIZE};
use crate::error::{Error, Result};
use crate::interrupt::InterruptCheck;
use crate::math::difference::{STEP, steps};
use crate::math::{Vec3, rotation};
use crate::shape::Shape;

/// The derivatives of a condition's function.
pub struct ConditionDerivatives {
    /// The derivatives with respect to the 12 N components of a tangent vector at the state: for each body
    /// those of position, velocity, rotation (body frame) and spin (body frame).
    pub by_state: Vec<f64>,
    /// The derivative with respect to the time.
    pub by_time: f64,
    /// The derivatives with respect to parameters of the system, at a fixed state.
    pub by_parameters: Vec<f64>,
    /// The names of the condition's own parameters, with the derivatives with respect to them.
    pub by_condition_parameters: Vec<(String, f64)>,
}

impl Condition<'_> {
    /// Returns the derivatives of the condition's function at a state.
    ///
    /// # Errors
    /// [`Error::InvalidInput`](crate::error::Error::InvalidInput) where the function has none, and the errors
    /// of a function of the user.
    pub fn derivatives(
        &mut self,
        system: &System,
        state: &State,
        parameters: &[Parameter],
        interrupt: &mut InterruptCheck,
    ) -> Result<ConditionDerivatives> {
        system.check(state, interrupt)?;
        let (frame, y, _) = BarycentricFrame::new(system.layout(), &system.masses(), state);
        let dynamics = system.dynamics(&frame, interrupt)?;
        self.check(&dynamics)?;
        let mut sizes = vec![[0.0; 3]; state.bodies()];
        dynamics.scales(&y, &mut sizes);
        let (state, fraction) = &self.smooth_at(system, state);
        sizes.iter_mut().flatten().for_each(|size| *size *= fraction);
        let mut by_state = Vec::with_capacity(TANGENT_SIZE * state.bodies());
        for (body, [length, speed, spin]) in sizes.iter().enumerate() {
            for (kind, size) in [*length, *speed, *fraction, *spin].into_iter().enumerate() {
                for axis in 0..3 {
                    by_state.push(central_difference(size, |change| {
                        self.value_at(system, &changed_state(state, body, kind, axis, change), interrupt)
                    })?);
                }
            }
        }
        let [length, speed, _] = sizes[0];
        let by_time = central_difference(fraction * length / speed, |change| {
            self.value_at(system, &State { time: state.time + change, ..state.clone() }, interrupt)
        })?;
        let by_parameters =
            parameters.iter().map(|p| self.by_parameter(*p, *fraction, system, state, interrupt));
        let by_parameters = by_parameters.collect::<Result<_>>()?;
        let by_condition_parameters = self.by_condition_parameters(system, state, interrupt)?;
        Ok(ConditionDerivatives { by_state, by_time, by_parameters, by_condition_parameters })
    }

    /// Returns the state at which the function is differentiated, and the fraction of the natural sizes of
    /// the state's components over which the function is smooth there.
    ///
    /// The distance of a polyhedron has kinks where the nearest edge changes and is not defined where
    /// surfaces overlap: it is differentiated where the gap between the bodies is still a ten-millionth of
    /// the separation. The gap between outlines has kinks where the nearest corner changes.
    fn smooth_at(&self, system: &System, state: &State) -> (State, f64) {
        const GAP: f64 = 1e-7;
        const SMOOTH_FRACTION: f64 = 5e-6;
        let polyhedral = |body: &usize| {
            system.bodies()[*body].parts().iter().any(|part| matches!(part.shape, Shape::Polyhedron(_)))
        };
        let mut state = state.clone();
        match self {
            Self::Contact { first, second } if [first, second].into_iter().any(polyhedral) => {
                let separation = state.position[*second] - state.position[*first];
                state.position[*second] += separation * GAP;
                (state, SMOOTH_FRACTION)
            }
            Self::Occultation { body, by, .. } if [body, by].into_iter().any(polyhedral) => {
                (state, SMOOTH_FRACTION)
            }
            _ => (state, 1.0),
        }
    }

    /// Returns the names of the condition's own parameters, with the derivatives with respect to them.
    fn by_condition_parameters(
        &mut self,
        system: &System,
        state: &State,
        interrupt: &mut InterruptCheck,
    ) -> Result<Vec<(String, f64)>> {
        let name = self.name();
        let distance = |first: usize, second: usize| (state.position[second] - state.position[first]).norm();
        Ok(match *self {
            Self::Separation { .. } => vec![(format!("value of {name}"), -1.0)],
            Self::Escape { first, second, distance: limit } => {
                let ratio = distance(first, second) / limit;
                // The function is the smaller of a function of the energy and a function of the distance.
                let by_energy = self.value_at(system, state, interrupt)? < ratio - 1.0;
                vec![(format!("distance of {name}"), if by_energy { 0.0 } else { -ratio / limit })]
            }
            Self::PlaneCrossing { body, reference, normal } => {
                let origin = reference.map_or_else(Vec3::zeros, |other| state.position[other]);
                let (unit, offset) = (normal.normalize(), state.position[body] - origin);
                let by_normal = (offset - unit * unit.dot(&offset)) / normal.norm();
                let axes = ["x", "y", "z"].into_iter().zip(by_normal.iter());
                axes.map(|(axis, by)| (format!("normal {axis} of {name}"), *by)).collect()
            }
            _ => Vec::new(),
        })
    }

    /// Returns the derivative with respect to a parameter at a fixed state. The function depends only on some
    /// parameters: on shapes for a contact or an occultation, on masses and G for an escape, and on the path
    /// of a third body for its closest approach.
    fn by_parameter(
        &mut self,
        parameter: Parameter,
        fraction: f64,
        system: &System,
        state: &State,
        interrupt: &mut InterruptCheck,
    ) -> Result<f64> {
        let depends = match self {
            Self::Contact { first, second } | Self::Occultation { body: first, by: second, .. } => {
                parameter.moves_surface().is_some_and(|body| body == *first || body == *second)
            }
            Self::Escape { first, second, .. } => {
                let mass = [*first, *second].into_iter().any(|body| parameter.mass_derivative(body) != 0.0);
                mass || parameter == Parameter::GravitationalConstant
            }
            Self::ClosestApproach { force } => parameter.moves_third_body(*force),
            _ => false,
        };
        if !depends {
            return Ok(0.0);
        }
        central_difference(fraction * parameter.size(system), |change| {
            self.value_at(&parameter.changed(system, change)?, state, interrupt)
        })
    }

    /// Returns the value of the condition's function at a state.
    fn value_at(&mut self, system: &System, state: &State, interrupt: &mut InterruptCheck) -> Result<f64> {
        let (frame, y, zeros) = BarycentricFrame::new(system.layout(), &system.masses(), state);
        let equations = &system.dynamics(&frame, interrupt)?;
        let zeros = &vec![0.0; zeros.len()];
        self.value(&EvaluationPoint { equations, time: state.time, y: &y, zeros, pieces: &[] }, interrupt)
    }
}

/// Returns the derivative of a function at zero, by central differences of eighth order. The argument of the
/// function is the change of a number, and `size` the natural size of that number.
fn central_difference(size: f64, mut function: impl FnMut(f64) -> Result<f64>) -> Result<f64> {
    let mut sum = 0.0;
    for (change, weight) in steps(STEP * size) {
        sum += weight * function(change)?;
    }
    if sum.is_finite() {
        return Ok(sum);
    }
    Err(Error::invalid("derivative of an event's function", sum, "a function that is smooth there"))
}

/// Returns a state with a component of a body's position, velocity, rotation or spin changed (`kind` 0 to 3).
fn changed_state(state: &State, body: usize, kind: usize, axis: usize, size: f64) -> State {
    let mut state = state.clone();
    let mut change = Vec3::zeros();
    change[axis] = size;
    match kind {
        0 => state.position[body] += change,
        1 => state.velocity[body] += change,
        2 => {
            let (sine, cosine) = (0.5 * size).sin_cos();
            let mut quaternion = [cosine, 0.0, 0.0, 0.0];
            quaternion[1 + axis] = sine;
            state.attitude[body] = rotation::product(state.attitude[body], quaternion);
        }
        _ => state.spin[body] += change,
    }
    state
}
