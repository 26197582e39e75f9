//! Forces that are switched at zeros of a function of the motion: where the next switch is, and the map of
//! tangent vectors across it.
//!
//! At a switch the rates of change jump from f to f + j. A neighbouring motion with the tangent vector delta
//! passes the zero of the function g earlier by the time g'(delta) / g'(f), which may be negative. During
//! this time only one of the two motions has the jump, so that the tangent vector after the switch is
//!
//!   delta + j g'(delta) / g'(f),
//! The derivative with respect to a parameter changes in the same way, where the derivative of g with respect
//! to the parameter is added to g'(delta). The matrix of this map is called the saltation matrix.

use super::layout::vector;
use super::{Dynamics, Variations};
use crate::error::{Error, Result};
use crate::forces::SwitchJump;
use crate::math::Vec3;

impl Dynamics {
    /// Returns how far a vector is from the next switch of a force; negative beyond it.
    pub fn switch_margin(&mut self, force: usize, time: f64, y: &[f64]) -> f64 {
        self.turn(y);
        self.external_forces.switch_margin(force, self.view.show(time, y))
    }

    /// Returns a force whose next switch a vector has passed.
    pub fn overdue_switch(&mut self, time: f64, y: &[f64]) -> Option<usize> {
        let switched: Vec<usize> = self.external_forces.switched().collect();
        switched.into_iter().find(|force| self.switch_margin(*force, time, y) < 0.0)
    }

    /// Returns the jump at the switch of a force at a vector, with the rate of its function before the
    /// switch. Returns an error for a switch that would be undone at once, where the motion leads to the
    /// switch both with the force and without it.
    pub fn switch_jump(&mut self, force: usize, time: f64, y: &[f64]) -> Result<(SwitchJump, f64)> {
        let failed = |dynamics: &Self, detail: &str| Error::ForceFailed {
            force: dynamics.external_forces.name(force).to_owned(),
            time,
            detail: detail.to_owned(),
            answer: None,
        };
        let mut rate = vec![0.0; y.len()];
        for part in 0..self.parts() {
            if let Err(rejected) = self.derivative(part, time, y, &mut rate) {
                return Err(failed(self, rejected.reason()));
            }
        }
        let Some(jump) = self.external_forces.switch_jump(force, self.view.shown(time, y)) else {
            return Err(failed(self, "the lock is lost where the orbit has no plane"));
        };
        let relative =
            |index: &dyn Fn(usize) -> usize| vector(&rate, index(jump.on)) - vector(&rate, index(jump.about));
        let layout = self.layout;
        let gradient = &jump.gradient;
        let before = gradient.by_position.dot(&relative(&|body| layout.position(body)))
            + gradient.by_velocity.dot(&relative(&|body| layout.velocity(body)))
            + gradient.by_rotation.dot(&vector(y, layout.spin(jump.on)))
            + gradient.by_spin.dot(&vector(&rate, layout.spin(jump.on)));
        let after = before + gradient.by_velocity.dot(&jump.force) / self.system.bodies()[jump.on].mass;
        // If the function's rate changes its sign, the function returns to its zero.
        if before == 0.0 || before * after < 0.0 {
            let name = &self.system.bodies()[jump.on].name;
            let detail = format!(
                "the lock of {name} neither lasts nor ends: the force, which acts while it is locked, takes \
                 it out of the lock, and without the force it comes back at once; expected a weaker force, \
                 whose effect in an orbit is small"
            );
            return Err(failed(self, &detail));
        }
        Ok((jump, before))
    }

    /// Switches a force.
    pub fn switch(&mut self, force: usize) {
        self.external_forces.switch(force);
    }
}

impl Variations {
    /// Maps tangent vectors across a switch, whose function has the rate `rate` before it.
    pub fn jump(&self, jump: &SwitchJump, rate: f64, gravitational_constant: f64, columns: &mut [f64]) {
        let (width, half, gradient) = (self.width(), self.half(), &jump.gradient);
        let mut of: Vec<(usize, f64)> = Vec::new();
        let mut add = |row: Option<usize>, slope: &Vec3, sign: f64| {
            if let Some(row) = row {
                of.extend((0..3).map(|c| (row + c, sign * slope[c])));
            }
        };
        for (body, sign) in [(jump.on, 1.0), (jump.about, -1.0)] {
            add(self.place(body), &gradient.by_position, sign);
            add(self.place(body).map(|row| half + row), &gradient.by_velocity, sign);
        }
        add(Some(self.turn(jump.on)), &gradient.by_rotation, 1.0);
        add(Some(half + self.turn(jump.on)), &gradient.by_spin, 1.0);
        let acceleration = jump.force / self.masses[jump.on];
        let mut to: Vec<(usize, f64)> = Vec::new();
        let mut put =
            |row: usize, factor: f64| to.extend((0..3).map(|c| (half + row + c, factor * acceleration[c])));
        match self.place(jump.on) {
            Some(row) => put(row, 1.0),
            None => (1..self.bodies).for_each(|other| put(3 * (other - 1), -1.0)),
        }
        if let Some(row) = self.barycentre() {
            put(row, self.share[jump.on]);
        }
        for column in 0..width {
            let mut change: f64 = of.iter().map(|(row, slope)| slope * columns[row * width + column]).sum();
            if column >= self.initial {
                change += self.margin_by(column - self.initial, jump, gravitational_constant);
            }
            for (row, acceleration) in &to {
                columns[row * width + column] += acceleration * change / rate;
            }
        }
    }

    /// Returns the derivative of a switch's function with respect to a parameter, with the motion held fixed.
    fn margin_by(&self, parameter: usize, jump: &SwitchJump, g: f64) -> f64 {
        let of = self.parameters[parameter];
        let pair = [jump.on, jump.about];
        let mass: f64 = pair.iter().map(|body| self.masses[*body]).sum();
        let by_mass: f64 = pair.iter().map(|body| of.of_mass(*body)).sum();
        let by_g = if of == super::Parameter::GravitationalConstant { 1.0 / g } else { 0.0 };
        jump.gradient.by_mu * (by_mass / mass + by_g)
            + jump.gradient.by_inertia.dot(&self.by_inertia(parameter, jump.on))
    }
}
