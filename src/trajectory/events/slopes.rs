//! The derivatives of a condition's function at a state.
//!
//! The functions are of many kinds, a caller's among them. They are smooth there, and their differences of eighth order have
//! some thirteen digits.

use super::Condition;
use super::condition::Place;
use crate::dynamics::{BarycentricFrame, DEPARTURE, State, System};
use crate::error::{Error, Result};
use crate::math::{Vec3, rotation};
use crate::patience::Patience;

/// Steps of the differences in natural sizes of the numbers, and weights of the differences of one to four of them.
const STEP: f64 = 2e-3;
const WEIGHTS: [f64; 4] = [0.8, -0.2, 4.0 / 105.0, -1.0 / 280.0];

impl Condition<'_> {
    /// Derivatives with the 12 N numbers of a departure from a state, and with the time.
    pub fn slopes(
        &mut self,
        system: &System,
        state: &State,
        patience: &mut Patience,
    ) -> Result<(Vec<f64>, f64)> {
        system.check(state, patience)?;
        let (frame, y, _) = BarycentricFrame::new(system.layout(), &system.masses(), state);
        let dynamics = system.dynamics(&frame, patience)?;
        self.check(&dynamics)?;
        let mut sizes = vec![[0.0; 3]; state.bodies()];
        dynamics.scales(&y, &mut sizes);
        let mut slope = |size: f64, moved: &dyn Fn(f64) -> State| -> Result<f64> {
            let mut sum = 0.0;
            for (k, weight) in (1..).zip(WEIGHTS) {
                let by = f64::from(k) * STEP * size;
                let [above, below] = [
                    self.of_state(system, &moved(by), patience)?,
                    self.of_state(system, &moved(-by), patience)?,
                ];
                sum += weight * (above - below);
            }
            let slope = sum / (STEP * size);
            if slope.is_finite() {
                return Ok(slope);
            }
            Err(Error::invalid("derivative of an event's function", slope, "a function that is smooth there"))
        };
        let mut slopes = Vec::with_capacity(DEPARTURE * state.bodies());
        for (body, [length, speed, spin]) in sizes.iter().enumerate() {
            for (kind, size) in [*length, *speed, 1.0, *spin].into_iter().enumerate() {
                for axis in 0..3 {
                    slopes.push(slope(size, &|by| moved(state, body, kind, axis, by))?);
                }
            }
        }
        let [length, speed, _] = sizes[0];
        let by_time = slope(length / speed, &|by| State { time: state.time + by, ..state.clone() })?;
        Ok((slopes, by_time))
    }

    fn of_state(&mut self, system: &System, state: &State, patience: &mut Patience) -> Result<f64> {
        let (frame, y, zeros) = BarycentricFrame::new(system.layout(), &system.masses(), state);
        let equations = &system.dynamics(&frame, patience)?;
        let zeros = &vec![0.0; zeros.len()];
        self.value(&Place { equations, time: state.time, y: &y, zeros })
    }
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
