//! Quantities of a system at one state: forces, energies and momenta.

use super::invariants::{self, Energy};
use super::layout::BarycentricFrame;
use super::state::State;
use super::system::System;
use crate::error::{Error, Result};
use crate::forces::Load;
use crate::interrupt::InterruptCheck;
use crate::math::{Vec3, rotation};

/// Forces (inertial), torques (body frames) and the potential energy at a state.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyInteraction {
    /// The force on every body, inertial.
    pub force: Vec<Vec3>,
    /// The torque on every body about its own centre, in its frame.
    pub torque: Vec<Vec3>,
    /// The potential energy, negative.
    pub potential_energy: f64,
    /// The truncation error of a series of a fixed degree, the size of its next two degrees, or the bound of the
    /// error of a sum over fragments: relative to the force between two bodies, for the pair for which it is
    /// largest; zero for the other rules.
    pub truncation_error: f64,
}

impl System {
    /// Returns forces, torques and the potential energy.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] if the state does not belong to the system, [`Error::BodiesOverlap`] if two
    /// bodies overlap, and [`Error::NotConverged`] if a quadrature reaches its limit.
    pub fn interactions(&self, state: &State) -> Result<BodyInteraction> {
        self.interactions_with(state, &mut InterruptCheck::never())
    }

    /// Evaluates [`Self::interactions`] with interrupt checks.
    ///
    /// # Errors
    /// Returns the errors of [`Self::interactions`], and [`Error::Interrupted`].
    pub fn interactions_with(
        &self,
        state: &State,
        interrupt: &mut InterruptCheck,
    ) -> Result<BodyInteraction> {
        let n = self.bodies.len();
        let mut result = BodyInteraction {
            force: vec![Vec3::zeros(); n],
            torque: vec![Vec3::zeros(); n],
            potential_energy: 0.0,
            truncation_error: 0.0,
        };
        // The pair whose parts are being added, with its force and the truncation error.
        let (mut last, mut between, mut error) = ([0; 2], Vec3::zeros(), 0.0);
        self.for_each_link(state, interrupt, |link, [i, j], pose, interrupt| {
            if last != [i, j] {
                result.truncation_error = result.truncation_error.max(error / between.norm());
                (last, between, error) = ([i, j], Vec3::zeros(), 0.0);
            }
            let strength = self.strength(i, j);
            let pieces = link.pair.pieces();
            let work = link.pair.work() / pieces.len() as u64;
            for nodes in pieces {
                interrupt.charge(work, state.time)?;
                let f = link.interaction_of(pose, nodes);
                between += f.force_on_first;
                result.force[i] += strength * f.force_on_first;
                result.force[j] -= strength * f.force_on_first;
                result.torque[i] += strength * f.torque_first;
                result.torque[j] += strength * f.torque_second;
            }
            link.add_energy(pose, strength, &mut result.potential_energy, state.time, interrupt)?;
            error += link.truncation_error(pose).unwrap_or(0.0);
            Ok(())
        })?;
        result.truncation_error = result.truncation_error.max(error / between.norm());
        for (body, (force, torque)) in self.bodies.iter().zip(result.force.iter().zip(&result.torque)) {
            in_range(&format!("force on {}", body.name), force.as_slice())?;
            in_range(&format!("torque on {}", body.name), torque.as_slice())?;
        }
        in_range("potential energy", &[result.potential_energy])?;
        Ok(result)
    }

    /// Returns the loads of each external force on the bodies on which it acts. The barycentre of the state
    /// counts as the nominal one.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] and [`Error::BodiesOverlap`] as [`Self::interactions`], and
    /// [`Error::ForceFailed`] if a force cannot be evaluated at the state or is not finite.
    pub fn external_loads(&self, state: &State) -> Result<Vec<Load>> {
        self.external_loads_with(state, &mut InterruptCheck::never())
    }

    /// Evaluates [`Self::external_loads`] with interrupt checks.
    ///
    /// # Errors
    /// Returns the errors of [`Self::external_loads`], and [`Error::Interrupted`].
    pub fn external_loads_with(&self, state: &State, interrupt: &mut InterruptCheck) -> Result<Vec<Load>> {
        self.check(state, interrupt)?;
        let mut force_model = self.force_model().clone();
        let (frame, y, _) = BarycentricFrame::new(self.layout(), &self.masses(), state);
        let rotation: Vec<_> = state.attitude.iter().map(|attitude| rotation::matrix(*attitude)).collect();
        let snapshot = frame.snapshot(state.time, &y, &rotation, &state.attitude);
        force_model.check(snapshot, state.time)?;
        force_model.begin_step(snapshot, 0.0)?;
        force_model.load(pulp::Scalar, snapshot, &mut ())?;
        let infinite = |load: &&Load| !load.force.iter().chain(&load.torque).all(|value| value.is_finite());
        if let Some(load) = force_model.loads().find(infinite) {
            let detail = "it is not finite in this state".to_owned();
            let force = self.forces()[load.of].name().to_owned();
            return Err(Error::ForceFailed { force, time: state.time, detail, answer: None });
        }
        Ok(force_model.loads().copied().collect())
    }

    /// Returns the energy in its parts.
    ///
    /// # Errors
    /// Returns the errors of [`Self::interactions`], and [`Error::InvalidInput`] if a part of the energy is
    /// too large for a double.
    pub fn energy(&self, state: &State) -> Result<Energy> {
        self.energy_with(state, &mut InterruptCheck::never())
    }

    /// Evaluates [`Self::energy`] with interrupt checks.
    ///
    /// # Errors
    /// Returns the errors of [`Self::energy`], and [`Error::Interrupted`].
    pub fn energy_with(&self, state: &State, interrupt: &mut InterruptCheck) -> Result<Energy> {
        let mut potential = 0.0;
        self.for_each_link(state, interrupt, |link, [i, j], pose, interrupt| {
            link.add_energy(pose, self.strength(i, j), &mut potential, state.time, interrupt)
        })?;
        let energy = invariants::energy(&self.bodies, state, potential);
        self.check_range(&energy)?;
        Ok(energy)
    }

    /// Returns an error for energies that have left the range of doubles.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] names the energy.
    pub fn check_range(&self, energy: &Energy) -> Result<()> {
        in_range("energy", &[energy.translational, energy.rotational, energy.potential, energy.total])
    }

    /// Returns the total linear momentum, inertial.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] or [`Error::BodiesOverlap`] if the state is not one of the system, and
    /// [`Error::InvalidInput`] if the momentum is too large for a double.
    pub fn momentum(&self, state: &State) -> Result<Vec3> {
        self.momentum_with(state, &mut InterruptCheck::never())
    }

    /// Evaluates [`Self::momentum`] with interrupt checks.
    ///
    /// # Errors
    /// Returns the errors of [`Self::momentum`], and [`Error::Interrupted`].
    pub fn momentum_with(&self, state: &State, interrupt: &mut InterruptCheck) -> Result<Vec3> {
        self.check(state, interrupt)?;
        let momentum = invariants::momentum(&self.bodies, state);
        in_range("momentum", momentum.as_slice())?;
        Ok(momentum)
    }

    /// Returns the total angular momentum about the origin, inertial.
    ///
    /// # Errors
    /// Returns the errors of [`Self::momentum`].
    pub fn angular_momentum(&self, state: &State) -> Result<Vec3> {
        self.angular_momentum_with(state, &mut InterruptCheck::never())
    }

    /// Evaluates [`Self::angular_momentum`] with interrupt checks.
    ///
    /// # Errors
    /// Returns the errors of [`Self::angular_momentum`], and [`Error::Interrupted`].
    pub fn angular_momentum_with(&self, state: &State, interrupt: &mut InterruptCheck) -> Result<Vec3> {
        self.check(state, interrupt)?;
        let momentum = invariants::angular_momentum(&self.bodies, state);
        in_range("angular momentum", momentum.as_slice())?;
        Ok(momentum)
    }
}

/// Returns an error for results that have left the range of doubles.
fn in_range(what: &str, values: &[f64]) -> Result<()> {
    match values.iter().find(|v| !v.is_finite()) {
        None => Ok(()),
        Some(value) => {
            Err(Error::invalid(what, value, "a finite number; choose units that keep the numbers in range"))
        }
    }
}
