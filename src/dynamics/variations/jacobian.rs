//! The derivatives of a system's loads and rates of change at one state.

use super::Variations;
use super::tangent::TANGENT_SIZE;
use crate::dynamics::equations::layout::vector;
use crate::dynamics::{BarycentricFrame, Dynamics, Parameter, Rejected, State, System};
use crate::error::{Error, Result};
use crate::interrupt::InterruptCheck;

/// The derivatives of a system's loads and rates with respect to positions and attitudes, velocities and
/// spins, and parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct SystemJacobian {
    /// The rates of change of the state, 12 N numbers: velocity, acceleration, spin and rate of the spin for
    /// each body.
    pub flow: Vec<f64>,
    /// The derivatives of forces (inertial) and torques (body frames), body by body, by positions and
    /// rotation vectors (body frames): 6 N rows.
    pub loads: Vec<f64>,
    /// The derivatives of the rates of a tangent vector with respect to its 12 N numbers: 12 N rows.
    pub rates: Vec<f64>,
    /// The derivatives of the rates of a tangent vector with respect to the parameters: P rows.
    pub by_parameters: Vec<f64>,
}

impl System {
    /// Returns the derivatives at a state.
    ///
    /// # Errors
    /// Returns the errors of [`Self::interactions`], [`Error::ForceFailed`] if an external force fails, and
    /// [`Error::InvalidInput`] for a parameter or a force without derivatives.
    pub fn jacobian(
        &self,
        state: &State,
        parameters: &[Parameter],
        interrupt: &mut InterruptCheck,
    ) -> Result<SystemJacobian> {
        self.check(state, interrupt)?;
        let (frame, y, _) = BarycentricFrame::new(self.layout(), &self.masses(), state);
        let mut dynamics = self.dynamics(&frame, interrupt)?;
        dynamics.check_external_forces(state.time, state.time, &y)?;
        dynamics.prepare(state.time, &y, 0.0, interrupt)?;
        let mut variations = Variations::new(&dynamics, parameters.to_vec())?;
        dynamics.prepare_variations(&variations, state.time, &y, interrupt)?;
        interrupt.charge(variations.work(&dynamics), state.time)?;
        variations.evaluate(&mut dynamics, state.time, &y, interrupt)?;
        let (loads, rates, by_parameters) =
            (variations.loads().to_vec(), variations.absolute_rates(), variations.absolute_forcing());
        let flow = dynamics.flow(state, &y, interrupt)?;
        if rates.iter().chain(&by_parameters).all(|number| number.is_finite()) {
            return Ok(SystemJacobian { flow, loads, rates, by_parameters });
        }
        let expected = "a finite number; choose units that keep the numbers in range";
        Err(Error::invalid("derivatives", "infinite", expected))
    }
}

impl Dynamics {
    /// Returns the rates of change of a state (12 N), given as a vector too: velocity, acceleration, spin and
    /// its rate for each body.
    pub fn flow(&mut self, state: &State, y: &[f64], interrupt: &mut InterruptCheck) -> Result<Vec<f64>> {
        let (layout, mut rate) = (self.layout(), vec![0.0; y.len()]);
        for part in 0..self.parts() {
            interrupt.charge(self.work(), state.time)?;
            self.derivative(part, state.time, y, &mut rate).map_err(|rejected| match rejected {
                Rejected::Failed(error) => *error,
                other => {
                    Error::invalid("state", other.reason(), "one at which the equations can be evaluated")
                }
            })?;
        }
        let centre = self.barycentre_acceleration();
        let body_rates = |body: usize| {
            let acceleration = vector(&rate, layout.velocity(body)) + centre;
            [state.velocity[body], acceleration, state.spin[body], vector(&rate, layout.spin(body))]
        };
        Ok((0..state.bodies()).flat_map(body_rates).flat_map(|v| [v.x, v.y, v.z]).collect())
    }
}

impl Variations {
    /// Returns the derivatives of the loads with respect to positions and rotations.
    fn loads(&self) -> &[f64] {
        &self.jacobian.by_pose
    }

    /// Returns the derivatives of the rates of all bodies' own numbers.
    fn absolute_rates(&self) -> Vec<f64> {
        let (n, size) = (self.bodies, TANGENT_SIZE * self.bodies);
        let mut rates = vec![0.0; size * size];
        for body in 0..n {
            let (first, spin, inertia) = (TANGENT_SIZE * body, &self.spin[body], &self.inertia[body]);
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let mut put = |row: usize, column: usize, value: f64| {
                    rates[(first + row + i) * size + first + column] += value;
                };
                put(0, 3 + i, 1.0);
                put(6, 9 + i, 1.0);
                put(6, 6 + j, spin[k]);
                put(6, 6 + k, -spin[j]);
                let ratio = if inertia[i] > 0.0 { (inertia[k] - inertia[j]) / inertia[i] } else { 0.0 };
                put(9, 9 + j, -ratio * spin[k]);
                put(9, 9 + k, -ratio * spin[j]);
                let per_inertia = if inertia[i] > 0.0 { 1.0 / inertia[i] } else { 0.0 };
                for (row, from, factor) in [(3, i, 1.0 / self.masses[body]), (9, 3 + i, per_inertia)] {
                    for (part, derivatives) in [(0, &self.jacobian.by_pose), (3, &self.jacobian.by_rate)] {
                        let line = derivatives.chunks_exact(6 * n).nth(6 * body + from).unwrap_or(&[]);
                        for (column, slope) in line.iter().enumerate() {
                            let (other, c) = (column / 6, column % 6);
                            let at = TANGENT_SIZE * other + part + if c < 3 { c } else { 3 + c };
                            rates[(first + row + i) * size + at] += factor * slope;
                        }
                    }
                }
            }
        }
        rates
    }

    /// Returns the derivatives of the rates with respect to the parameters.
    fn absolute_forcing(&self) -> Vec<f64> {
        let zero = [0.0; 3];
        let rows = |[acceleration, angular_acceleration]: &[crate::math::Vec3; 2]| {
            [
                zero,
                [acceleration.x, acceleration.y, acceleration.z],
                zero,
                [angular_acceleration.x, angular_acceleration.y, angular_acceleration.z],
            ]
        };
        self.forcing.iter().flat_map(|forcing| rows(forcing).concat()).collect()
    }
}
