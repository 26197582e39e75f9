//! The map of tangent vectors across the switch of a force, whose matrix is called the saltation matrix.
//!
//! At a switch the rates of change jump from f to f + j. A neighbouring motion with the tangent vector delta
//! passes the zero of the function g earlier by the time g'(delta) / g'(f), which may be negative. During
//! this time only one of the two motions has the jump, so that the tangent vector after the switch is
//!
//!   delta + j g'(delta) / g'(f).
//!
//! The derivative with respect to a parameter changes in the same way, where the derivative of g with respect
//! to the parameter is added to g'(delta).

use super::{Variations, per_inertia};
use crate::dynamics::Parameter;
use crate::forces::SwitchJump;
use crate::math::Vec3;

impl Variations {
    /// Maps tangent vectors across a switch, whose function has the rate `rate` before it.
    pub fn jump(&self, jump: &SwitchJump, rate: f64, gravitational_constant: f64, columns: &mut [f64]) {
        let (width, half, gradient) = (self.width(), self.half(), &jump.gradient);
        let mut gradient_entries: Vec<(usize, f64)> = Vec::new();
        let mut add = |row: Option<usize>, slope: &Vec3, sign: f64| {
            if let Some(row) = row {
                gradient_entries.extend((0..3).map(|c| (row + c, sign * slope[c])));
            }
        };
        for (body, sign) in [(jump.on, 1.0), (jump.about, -1.0)] {
            add(self.position_row(body), &gradient.by_position, sign);
            add(self.position_row(body).map(|row| half + row), &gradient.by_velocity, sign);
        }
        add(Some(self.rotation_row(jump.on)), &gradient.by_rotation, 1.0);
        add(Some(half + self.rotation_row(jump.on)), &gradient.by_spin, 1.0);
        let acceleration = jump.force / self.masses[jump.on];
        let mut jump_entries: Vec<(usize, f64)> = Vec::new();
        let mut put =
            |row: usize, change: Vec3| jump_entries.extend((0..3).map(|c| (half + row + c, change[c])));
        match self.position_row(jump.on) {
            Some(row) => put(row, acceleration),
            None => (1..self.bodies).for_each(|other| put(3 * (other - 1), -acceleration)),
        }
        if let Some(row) = self.barycentre() {
            put(row, acceleration * self.share[jump.on]);
        }
        put(self.rotation_row(jump.on), per_inertia(&jump.torque, &self.inertia[jump.on]));
        for column in 0..width {
            let mut change: f64 =
                gradient_entries.iter().map(|(row, slope)| slope * columns[row * width + column]).sum();
            if column >= self.initial {
                change += self.margin_by(column - self.initial, jump, gravitational_constant);
            }
            for (row, rates) in &jump_entries {
                columns[row * width + column] += rates * change / rate;
            }
        }
    }

    /// Returns the derivative of a switch's function with respect to a parameter, with the motion held fixed.
    fn margin_by(&self, parameter: usize, jump: &SwitchJump, g: f64) -> f64 {
        let parameter_kind = self.parameters[parameter];
        let pair = [jump.on, jump.about];
        let mass: f64 = pair.iter().map(|body| self.masses[*body]).sum();
        let by_mass: f64 = pair.iter().map(|body| parameter_kind.mass_derivative(*body)).sum();
        let by_g = if parameter_kind == Parameter::GravitationalConstant { 1.0 / g } else { 0.0 };
        jump.gradient.by_mu * (by_mass / mass + by_g)
            + jump.gradient.by_inertia.dot(&self.by_inertia(parameter, jump.on))
    }
}
