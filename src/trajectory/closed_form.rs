//! Runs in closed form: a single body that rotates about a principal axis, freely or under a constant torque along
//! its spin. Runs of decades take one step.

use super::Simulation;
use super::recorder::Run;
use crate::dynamics::{AttitudeChart, Parameter, State, SteadyRotation};
use crate::forces::{Force, ForceParameter, WORK_AND_IMPULSE};

impl Simulation {
    /// Returns the closed form of the motion until a time, if it has one. Runs with steps of fixed size,
    /// Tait-Bryan angles, events, indicators of chaos or derivatives by a torque across the spin are integrated
    /// in steps.
    pub(super) fn closed_form(&self, until: f64, run: &Run) -> Option<SteadyRotation> {
        let [body] = self.system().bodies() else { return None };
        // A torque across the spin moves the axis away from that of the body.
        let across = |parameter: &Parameter| matches!(parameter, Parameter::Force(_, ForceParameter::Across));
        let derivatives = run.tangent_options.derivatives.as_deref().unwrap_or_default();
        let stepwise = derivatives.iter().any(across)
            || self.propagator.fixed().is_some()
            || self.frame().layout.chart != AttitudeChart::Quaternion
            || !run.events.is_empty()
            || run.tangent_options.chaos;
        if stepwise || until == self.time() || !until.is_finite() {
            return None;
        }
        let torque = constant_torques(self.system().forces())?.iter().sum();
        SteadyRotation::new(body.inertia(), &self.state(), torque, until)
    }

    /// Returns the integrator's vector of a state in closed form, with work and impulse of the torques since
    /// the present state.
    pub(super) fn closed_form_vector(&self, rotation: &SteadyRotation, state: &State) -> Vec<f64> {
        let (layout, mut y) = (self.frame().layout, self.propagator.vector().0.to_vec());
        layout.write_rotation(state, &mut y);
        let elapsed = state.time - rotation.start().time;
        let angle = rotation.angle(state.time).abs().copysign(elapsed);
        let torques = constant_torques(self.system().forces()).unwrap_or_default();
        for (force, torque) in torques.into_iter().enumerate() {
            let at = layout.work_and_impulse_index(force);
            y[at] += torque * angle;
            let impulse = rotation.direction() * (torque * elapsed);
            (0..3).for_each(|c| y[at + WORK_AND_IMPULSE - 3 + c] += impulse[c]);
        }
        y
    }
}

/// Returns the torques along the spin of forces that have no other effect, or `None` for other forces.
fn constant_torques(forces: &[Force]) -> Option<Vec<f64>> {
    let torque = |force: &Force| match force {
        Force::Yorp(yorp) if yorp.obliquity.is_empty() && yorp.across == [0.0] => Some(yorp.along[0]),
        _ => None,
    };
    forces.iter().map(torque).collect()
}
