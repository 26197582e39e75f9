//! What a system is asked at one state: forces, energies and momenta.

use super::system::pose;
use super::{BarycentricFrame, Energy, State, System, invariants};
use crate::environment::Load;
use crate::error::{Error, Result};
use crate::math::{Vec3, rotation};
use crate::patience::Patience;

/// Units of work of making a pair with its rule, for [`Patience`].
const NEW_PAIR: u64 = 500;

/// Forces (inertial), torques (body frames) and the potential energy of a state.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyInteraction {
    /// Force on every body.
    pub force: Vec<Vec3>,
    /// Torque on every body about its own centre, in its frame.
    pub torque: Vec<Vec3>,
    /// Potential energy, negative.
    pub potential_energy: f64,
    /// Of a series the first two degrees that it leaves out, relative to the force between the two bodies for which that is most; zero
    /// of the other methods.
    pub left_out: f64,
}

impl System {
    /// Forces, torques and potential energy.
    pub fn interactions(&self, state: &State, patience: &mut Patience) -> Result<BodyInteraction> {
        self.check(state, patience)?;
        self.polyhedra(patience).map_err(|error| error.at(state.time))?;
        let n = self.bodies.len();
        let mut result = BodyInteraction {
            force: vec![Vec3::zeros(); n],
            torque: vec![Vec3::zeros(); n],
            potential_energy: 0.0,
            left_out: 0.0,
        };
        for (i, j) in self.pairs() {
            let pose = pose(state, i, j);
            let strength = self.strength(i, j);
            let (mut between, mut left_out) = (Vec3::zeros(), 0.0);
            for mut link in self.links(i, j) {
                patience.spend(NEW_PAIR, state.time)?;
                link.prepare(&pose, None, patience).map_err(|error| error.at(state.time))?;
                let pieces = link.pair.pieces();
                let work = link.pair.work() / pieces.len() as u64;
                for nodes in pieces {
                    patience.spend(work, state.time)?;
                    let f = link.interaction_of(&pose, nodes);
                    between += f.force_on_first;
                    result.force[i] += strength * f.force_on_first;
                    result.force[j] -= strength * f.force_on_first;
                    result.torque[i] += strength * f.torque_first;
                    result.torque[j] += strength * f.torque_second;
                }
                for nodes in link.energy_pieces(&pose, patience)? {
                    patience.spend(work, state.time)?;
                    result.potential_energy += strength * link.potential_energy_of(&pose, nodes);
                }
                left_out += link.left_out(&pose).unwrap_or(0.0);
            }
            result.left_out = result.left_out.max(left_out / between.norm());
        }
        for (body, (force, torque)) in self.bodies.iter().zip(result.force.iter().zip(&result.torque)) {
            in_range(&format!("force on {}", body.name), force.as_slice())?;
            in_range(&format!("torque on {}", body.name), torque.as_slice())?;
        }
        in_range("potential energy", &[result.potential_energy])?;
        Ok(result)
    }

    /// What each force from outside does to the bodies that it acts on. The state's own barycentre is the nominal one.
    pub fn outside(&self, state: &State, patience: &mut Patience) -> Result<Vec<Load>> {
        self.check(state, patience)?;
        let mut environment = self.environment()?;
        let (frame, y, _) = BarycentricFrame::new(self.layout(), &self.masses(), state);
        let rotation: Vec<_> = state.attitude.iter().map(|attitude| rotation::matrix(*attitude)).collect();
        let scene = frame.scene(state.time, &y, &rotation, &state.attitude);
        environment.check(scene, state.time)?;
        environment.switch(scene, 0.0)?;
        environment.load(pulp::Scalar, scene, &mut ())?;
        let infinite = |load: &&Load| !load.force.iter().chain(&load.torque).all(|value| value.is_finite());
        if let Some(load) = environment.loads().find(infinite) {
            let detail = "it is not finite in this state".to_owned();
            let force = self.forces()[load.of].name().to_owned();
            return Err(Error::ForceFailed { force, time: state.time, detail, answer: None });
        }
        Ok(environment.loads().copied().collect())
    }

    /// Energy in its parts.
    pub fn energy(&self, state: &State, patience: &mut Patience) -> Result<Energy> {
        self.check(state, patience)?;
        self.polyhedra(patience).map_err(|error| error.at(state.time))?;
        let mut potential = 0.0;
        for (i, j) in self.pairs() {
            let pose = pose(state, i, j);
            for mut link in self.links(i, j) {
                patience.spend(NEW_PAIR, state.time)?;
                link.prepare(&pose, None, patience).map_err(|error| error.at(state.time))?;
                let pieces = link.energy_pieces(&pose, patience)?;
                let work = link.pair.work() / pieces.len() as u64;
                for nodes in pieces {
                    patience.spend(work, state.time)?;
                    potential += self.strength(i, j) * link.potential_energy_of(&pose, nodes);
                }
            }
        }
        let energy = invariants::energy(&self.bodies, state, potential);
        self.check_range(&energy)?;
        Ok(energy)
    }

    /// Refuses energies that have left the range of doubles.
    pub fn check_range(&self, energy: &Energy) -> Result<()> {
        in_range("energy", &[energy.translational, energy.rotational, energy.potential, energy.total])
    }

    /// Total linear momentum, inertial.
    pub fn momentum(&self, state: &State, patience: &mut Patience) -> Result<Vec3> {
        self.check(state, patience)?;
        let momentum = invariants::momentum(&self.bodies, state);
        in_range("momentum", momentum.as_slice())?;
        Ok(momentum)
    }

    /// Total angular momentum about the origin, inertial.
    pub fn angular_momentum(&self, state: &State, patience: &mut Patience) -> Result<Vec3> {
        self.check(state, patience)?;
        let momentum = invariants::angular_momentum(&self.bodies, state);
        in_range("angular momentum", momentum.as_slice())?;
        Ok(momentum)
    }
}

/// Refuses results that have left the range of doubles.
fn in_range(what: &str, values: &[f64]) -> Result<()> {
    match values.iter().find(|v| !v.is_finite()) {
        None => Ok(()),
        Some(value) => {
            Err(Error::invalid(what, value, "a finite number; choose units that keep the numbers in range"))
        }
    }
}
