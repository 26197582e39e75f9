//! The derivatives of a condition's function at a state.
//!
//! The functions are of many kinds, a caller's among them. They are smooth there, and their differences of eighth order have
//! some thirteen digits.

use super::Condition;
use super::condition::Place;
use crate::dynamics::{BarycentricFrame, DEPARTURE, Parameter, State, System};
use crate::error::{Error, Result};
use crate::math::{Vec3, rotation};
use crate::patience::Patience;
use crate::shape::{Body, Shape};

/// Steps of the differences in natural sizes of the numbers, and weights of the differences of one to four of them.
const STEP: f64 = 2e-3;
const WEIGHTS: [f64; 4] = [0.8, -0.2, 4.0 / 105.0, -1.0 / 280.0];

/// The derivatives of a condition's function.
pub struct ConditionSlopes {
    /// With the 12 N numbers of a departure from the state.
    pub by_state: Vec<f64>,
    /// With the time.
    pub by_time: f64,
    /// With parameters of the system, where the state stays.
    pub by_parameters: Vec<f64>,
}

impl Condition<'_> {
    /// Derivatives at a state.
    pub fn slopes(
        &mut self,
        system: &System,
        state: &State,
        parameters: &[Parameter],
        patience: &mut Patience,
    ) -> Result<ConditionSlopes> {
        system.check(state, patience)?;
        let (frame, y, _) = BarycentricFrame::new(system.layout(), &system.masses(), state);
        let dynamics = system.dynamics(&frame, patience)?;
        self.check(&dynamics)?;
        let mut sizes = vec![[0.0; 3]; state.bodies()];
        dynamics.scales(&y, &mut sizes);
        let mut by_state = Vec::with_capacity(DEPARTURE * state.bodies());
        for (body, [length, speed, spin]) in sizes.iter().enumerate() {
            for (kind, size) in [*length, *speed, 1.0, *spin].into_iter().enumerate() {
                for axis in 0..3 {
                    by_state.push(slope(size, |by| {
                        self.of_state(system, &moved(state, body, kind, axis, by), patience)
                    })?);
                }
            }
        }
        let [length, speed, _] = sizes[0];
        let by_time = slope(length / speed, |by| {
            self.of_state(system, &State { time: state.time + by, ..state.clone() }, patience)
        })?;
        let by_parameters = parameters.iter().map(|p| self.by_parameter(*p, system, state, patience));
        Ok(ConditionSlopes { by_state, by_time, by_parameters: by_parameters.collect::<Result<_>>()? })
    }

    /// The derivative with a parameter: that of the surface with a semi-axis, and of mu with G and the masses.
    fn by_parameter(
        &mut self,
        parameter: Parameter,
        system: &System,
        state: &State,
        patience: &mut Patience,
    ) -> Result<f64> {
        let bodies = system.bodies();
        match (&*self, parameter.semi_axis()) {
            (Self::Contact { first, second }, Some((body, axis))) if [*first, *second].contains(&body) => {
                let (name, mass, axes) = (&bodies[body].name, bodies[body].mass, bodies[body].semi_axes());
                slope(axes[axis], |by| {
                    let (mut axes, mut bodies) = (axes, bodies.to_vec());
                    axes[axis] += by;
                    bodies[body] = Body::with_mass(name, Shape::ellipsoid(axes)?, mass)?;
                    let g = system.gravitational_constant();
                    self.of_state(&System::new(bodies, g, *system.settings())?, state, patience)
                })
            }
            (Self::Escape { first, second, distance }, None) => {
                let pair = [*first, *second];
                let mass: f64 = pair.iter().map(|body| bodies[*body].mass).sum();
                let by_mass: f64 = pair.iter().map(|body| parameter.of_mass(*body)).sum();
                let g = system.gravitational_constant();
                let by_g = if parameter == Parameter::GravitationalConstant { mass } else { 0.0 };
                let away = (state.position[*second] - state.position[*first]).norm() / *distance - 1.0;
                let value = self.of_state(system, state, patience)?;
                // The function is that of the energy, or of the distance.
                Ok(if value < away { -(value + 1.0) * (by_g + g * by_mass) / (g * mass) } else { 0.0 })
            }
            _ => Ok(0.0),
        }
    }

    fn of_state(&mut self, system: &System, state: &State, patience: &mut Patience) -> Result<f64> {
        let (frame, y, zeros) = BarycentricFrame::new(system.layout(), &system.masses(), state);
        let equations = &system.dynamics(&frame, patience)?;
        let zeros = &vec![0.0; zeros.len()];
        self.value(&Place { equations, time: state.time, y: &y, zeros })
    }
}

/// The derivative of a function of a change, of a number of this natural size.
fn slope(size: f64, mut function: impl FnMut(f64) -> Result<f64>) -> Result<f64> {
    let mut sum = 0.0;
    for (k, weight) in (1..).zip(WEIGHTS) {
        let by = f64::from(k) * STEP * size;
        sum += weight * (function(by)? - function(-by)?);
    }
    let slope = sum / (STEP * size);
    if slope.is_finite() {
        return Ok(slope);
    }
    Err(Error::invalid("derivative of an event's function", slope, "a function that is smooth there"))
}

/// A state with one of its numbers changed.
fn moved(state: &State, body: usize, kind: usize, axis: usize, by: f64) -> State {
    let mut state = state.clone();
    let mut change = Vec3::zeros();
    change[axis] = by;
    match kind {
        0 => state.position[body] += change,
        1 => state.velocity[body] += change,
        2 => {
            let (sine, cosine) = (0.5 * by).sin_cos();
            let mut turn = [cosine, 0.0, 0.0, 0.0];
            turn[1 + axis] = sine;
            state.attitude[body] = rotation::product(state.attitude[body], turn);
        }
        _ => state.spin[body] += change,
    }
    state
}
