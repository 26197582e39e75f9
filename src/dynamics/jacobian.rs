//! The derivatives of a system's loads and rates at one state.

use super::layout::vector;
use super::{BarycentricFrame, DEPARTURE, Parameter, Rejected, State, System, Variations};
use crate::error::{Error, Result};
use crate::patience::Patience;

/// Derivatives with respect to where the bodies are, how they move, and parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct SystemJacobian {
    /// The rates of the 12 N numbers of a departure along the motion: velocity, acceleration, spin and its rate.
    pub flow: Vec<f64>,
    /// Of forces (inertial) and torques (body frames), body after body, with positions and rotation vectors (body frames): 6 N rows.
    pub loads: Vec<f64>,
    /// Of the rates of the 12 N numbers of a departure with these numbers: 12 N rows.
    pub rates: Vec<f64>,
    /// Of these rates with the parameters: P rows.
    pub by_parameters: Vec<f64>,
}

impl System {
    /// The derivatives at a state.
    pub fn jacobian(
        &self,
        state: &State,
        parameters: &[Parameter],
        patience: &mut Patience,
    ) -> Result<SystemJacobian> {
        self.check(state, patience)?;
        let (frame, y, _) = BarycentricFrame::new(self.layout(), &self.masses(), state);
        let mut dynamics = self.dynamics(&frame, patience)?;
        dynamics.check_outside(state.time, state.time, &y)?;
        dynamics.prepare(state.time, &y, 0.0, patience)?;
        dynamics.prepare_variations(state.time, patience)?;
        let mut variations = Variations::new(&dynamics, parameters.to_vec())?;
        patience.spend(variations.work(&dynamics), state.time)?;
        variations.look(&mut dynamics, state.time, &y)?;
        let (loads, rates, by_parameters) =
            (variations.loads().to_vec(), variations.absolute_rates(), variations.absolute_forcing());
        let mut rate = vec![0.0; y.len()];
        for part in 0..dynamics.parts() {
            patience.spend(dynamics.work(), state.time)?;
            dynamics.derivative(part, state.time, &y, &mut rate).map_err(|rejected| match rejected {
                Rejected::Failed(error) => *error,
                other => {
                    Error::invalid("state", other.reason(), "one at which the equations can be evaluated")
                }
            })?;
        }
        let centre = dynamics.barycentre_acceleration();
        let of_body = |body: usize| {
            let acceleration = vector(&rate, self.layout().velocity(body)) + centre;
            [state.velocity[body], acceleration, state.spin[body], vector(&rate, self.layout().spin(body))]
        };
        let flow: Vec<f64> = (0..state.bodies()).flat_map(of_body).flat_map(|v| [v.x, v.y, v.z]).collect();
        if rates.iter().chain(&by_parameters).all(|number| number.is_finite()) {
            return Ok(SystemJacobian { flow, loads, rates, by_parameters });
        }
        let expected = "a finite number; choose units that keep the numbers in range";
        Err(Error::invalid("derivatives", "infinite", expected))
    }
}

impl Variations {
    /// Derivatives of the loads with places.
    fn loads(&self) -> &[f64] {
        &self.slopes.by_place
    }

    /// Derivatives of the rates of all bodies' own numbers.
    fn absolute_rates(&self) -> Vec<f64> {
        let (n, size) = (self.bodies, DEPARTURE * self.bodies);
        let mut rates = vec![0.0; size * size];
        for body in 0..n {
            let (first, spin, inertia) = (DEPARTURE * body, &self.spin[body], &self.inertia[body]);
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
                    for (part, slopes) in [(0, &self.slopes.by_place), (3, &self.slopes.by_motion)] {
                        let line = slopes.chunks_exact(6 * n).nth(6 * body + from).unwrap_or(&[]);
                        for (column, slope) in line.iter().enumerate() {
                            let (other, c) = (column / 6, column % 6);
                            let at = DEPARTURE * other + part + if c < 3 { c } else { 3 + c };
                            rates[(first + row + i) * size + at] += factor * slope;
                        }
                    }
                }
            }
        }
        rates
    }

    /// The same with the parameters.
    fn absolute_forcing(&self) -> Vec<f64> {
        let zero = [0.0; 3];
        let of = |[acceleration, turning]: &[crate::math::Vec3; 2]| {
            [zero, [acceleration.x, acceleration.y, acceleration.z], zero, [turning.x, turning.y, turning.z]]
        };
        self.forcing.iter().flat_map(|forcing| of(forcing).concat()).collect()
    }
}
