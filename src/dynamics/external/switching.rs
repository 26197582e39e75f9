//! Forces that are switched at zeros of a function of the motion: the margin to the next switch, and the jump of the
//! rates of change at a switch.

use crate::dynamics::Dynamics;
use crate::dynamics::equations::layout::vector;
use crate::error::{Error, Result};
use crate::forces::SwitchJump;

impl Dynamics {
    /// Returns how far a vector is from the next switch of a force; negative beyond it.
    pub fn switch_margin(&mut self, force: usize, time: f64, y: &[f64]) -> f64 {
        self.update_rotations(y);
        self.external_forces.switch_margin(force, self.view.take_snapshot(time, y))
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
        let Some(jump) = self.external_forces.switch_jump(force, self.view.last_snapshot(time, y)) else {
            return Err(failed(self, "the lock is lost where the orbit has no plane"));
        };
        let relative =
            |index: &dyn Fn(usize) -> usize| vector(&rate, index(jump.on)) - vector(&rate, index(jump.about));
        let layout = self.layout;
        let gradient = &jump.gradient;
        let rate = gradient.by_position.dot(&relative(&|body| layout.position(body)))
            + gradient.by_velocity.dot(&relative(&|body| layout.velocity(body)))
            + gradient.by_rotation.dot(&vector(y, layout.spin(jump.on)))
            + gradient.by_spin.dot(&vector(&rate, layout.spin(jump.on)));
        let body = &self.system.bodies()[jump.on];
        let new_rate = rate
            + gradient.by_velocity.dot(&jump.force) / body.mass
            + gradient.by_spin.dot(&jump.torque.component_div(&body.inertia()));
        // If the function's rate changes its sign, the function returns to its zero.
        if rate == 0.0 || rate * new_rate < 0.0 {
            let detail = format!(
                "the lock of {} neither lasts nor ends: the force, which acts while it is locked, takes \
                 it out of the lock, and without the force it comes back at once; expected a weaker force, \
                 whose effect in an orbit is small",
                body.name
            );
            return Err(failed(self, &detail));
        }
        Ok((jump, rate))
    }

    /// Switches a force.
    pub fn switch(&mut self, force: usize) {
        self.external_forces.switch(force);
    }
}
