//! The trait of the evaluators of forces: loads at a snapshot, their derivatives, and what happens at steps.

use super::{ForceParameter, Load, LoadJacobian, MotionSnapshot};
use crate::error::Result;
use pulp::Simd;

/// The evaluator of a force: a force prepared for a system. The name is that of the force, for errors.
pub(super) trait Evaluator: Sized {
    /// Returns the loads at the last snapshot on the bodies on which the force acts.
    fn loads(&self) -> &[Load];

    /// Computes the loads of a force that has them at every snapshot. Allocates nothing.
    fn compute(&mut self, _snapshot: MotionSnapshot) {}

    /// Computes the loads at a snapshot. Allocates nothing. Components that the force never has stay zero.
    #[inline(always)]
    fn load<S: Simd>(&mut self, _simd: S, _name: &str, snapshot: MotionSnapshot) -> Result<()> {
        self.compute(snapshot);
        Ok(())
    }

    /// Adds the derivatives of the loads at the snapshot for which [`Self::load`] was called last. Allocates
    /// nothing.
    fn add_jacobian(
        &mut self,
        name: &str,
        snapshot: MotionSnapshot,
        jacobian: &mut LoadJacobian,
    ) -> Result<()>;

    /// Returns the force of which a parameter is one and the other parameters beside it are zero; `None` where
    /// the parameter is a factor of the present loads. The loads are linear in all of them.
    fn unit(&self, _parameter: ForceParameter) -> Option<Self> {
        None
    }

    /// Passes the derivative of the loads with respect to a parameter to the sink, at the snapshot of the
    /// last [`Self::load`]. Allocates nothing.
    fn by_parameter(
        &mut self,
        _name: &str,
        snapshot: MotionSnapshot,
        parameter: ForceParameter,
        _gravitational_constant: f64,
        to: &mut impl FnMut(&Load, f64),
    ) -> Result<()> {
        let mut unit = self.unit(parameter);
        if let Some(unit) = &mut unit {
            unit.compute(snapshot);
        }
        unit.as_ref().unwrap_or(self).loads().iter().for_each(|load| to(load, 1.0));
        Ok(())
    }

    /// Returns the units of work of an evaluation, for [`crate::interrupt::InterruptCheck`].
    fn work(&self) -> u64 {
        4
    }

    /// Returns the powers of G and of a body's mass to which the loads on another body are proportional, at a
    /// fixed path of a third body.
    fn powers(&self, _mass_of: usize, _on: usize) -> [f64; 2] {
        [0.0; 2]
    }

    /// Begins a step. Returns an error for a step in which the force loses its meaning.
    fn begin_step(&mut self, _name: &str, _snapshot: MotionSnapshot, _step: f64) -> Result<()> {
        Ok(())
    }
}
