//! The record of a run.

use super::{Dense, Occurrence};
use crate::dynamics::{Energy, Invariants, State};
use crate::error::{Error, Result};
use crate::forces::WORK_AND_IMPULSE;
use crate::math::Vec3;

/// The reason why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum StopReason {
    /// The run has not ended: there was an error, or nothing has been run.
    #[default]
    Unfinished,
    /// The run reached its end time.
    End,
    /// A terminal event ended the run; the number is its index in the list of events.
    Event(usize),
    /// The caller's hook asked to stop.
    Interrupted,
}

/// Samples of a run, flat and in C order: vectors are (K, N, 3), attitudes (K, N, 4).
///
/// The methods [`Self::state`], [`Self::position`] and so on give the numbers of one sample and one body; the
/// lists are for programs that need all of them at once.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Trajectory {
    /// The number of bodies.
    pub bodies: usize,
    /// The conserved quantities at the start of the first run into this record.
    pub start: Option<Invariants>,
    /// Times of the samples (K,).
    pub time: Vec<f64>,
    /// Positions (K, N, 3), inertial frame.
    pub position: Vec<f64>,
    /// Velocities (K, N, 3), inertial frame.
    pub velocity: Vec<f64>,
    /// Attitudes (K, N, 4).
    pub attitude: Vec<f64>,
    /// Spins (K, N, 3), body frames.
    pub spin: Vec<f64>,
    /// Energies (K, 4): total, translational, rotational, potential.
    pub energy: Vec<f64>,
    /// Total angular momenta (K, 3).
    pub angular_momentum: Vec<f64>,
    /// Work and impulse of the external forces at the start of the first run into this record.
    pub start_work_and_impulse: Option<Vec<f64>>,
    /// Work, impulse and angular impulse (K, F, 7) of each force since that start.
    pub work_and_impulse: Vec<f64>,
    /// How often each force was switched off in the runs into this record; `None` for forces that cannot be.
    /// A force that does not act at the start counts as switched off once.
    pub switched_off: Vec<Option<u64>>,
    /// Transition matrices (K, 12 N, 12 N) from the start of the last run into this record; empty where they
    /// were not requested. Row i and column j hold the derivative of number i of the sample with respect to
    /// number j of the start. Each body has twelve numbers in turn: position (3) and velocity (3) in the
    /// inertial frame, a rotation vector (3) and the spin (3) in its own frame.
    pub transition: Vec<f64>,
    /// Sensitivities (K, P, 12 N) to parameters: derivatives of the same numbers of the sample with respect
    /// to each parameter.
    pub sensitivity: Vec<f64>,
    /// Indicators of chaos (K, 3) since that start: the mean of MEGNO, the Lyapunov exponent, the fast
    /// Lyapunov indicator.
    pub chaos: Vec<f64>,
    /// Events in the order of the run.
    pub events: Vec<Occurrence>,
    /// The continuous solution, where it was requested.
    pub dense: Option<Dense>,
    /// The reason why the last run into this record ended.
    pub stop_reason: StopReason,
}

impl Trajectory {
    /// Makes an empty record.
    pub fn new(bodies: usize) -> Self {
        Self { bodies, ..Self::default() }
    }

    /// Returns an error for a record that is not one of this many bodies, or whose arrays have lengths that do
    /// not belong together.
    pub(super) fn check(&self, bodies: usize) -> Result<()> {
        if self.bodies != bodies {
            let expected = format!("{bodies}, as in the system");
            return Err(Error::invalid("number of bodies of the record", self.bodies, expected));
        }
        let rows = [
            ("position", self.position.len(), 3 * bodies),
            ("velocity", self.velocity.len(), 3 * bodies),
            ("attitude", self.attitude.len(), 4 * bodies),
            ("spin", self.spin.len(), 3 * bodies),
            ("energy", self.energy.len(), 4),
            ("angular_momentum", self.angular_momentum.len(), 3),
        ];
        for (what, count, row) in rows {
            if count != row * self.len() {
                let expected = format!("{}, as of {} samples", row * self.len(), self.len());
                return Err(Error::invalid(format!("numbers of {what} in the record"), count, expected));
            }
        }
        Ok(())
    }

    /// Returns the state of a sample.
    ///
    /// # Panics
    /// This method and those below panic for a sample that the record does not have, as an index of a slice
    /// does.
    pub fn state(&self, sample: usize) -> State {
        let bodies = 0..self.bodies;
        State {
            time: self.time[sample],
            position: bodies.clone().map(|body| self.position(sample, body)).collect(),
            velocity: bodies.clone().map(|body| self.velocity(sample, body)).collect(),
            attitude: bodies.clone().map(|body| self.attitude(sample, body)).collect(),
            spin: bodies.map(|body| self.spin(sample, body)).collect(),
        }
    }

    /// Returns the position of the centre of a body in a sample, inertial frame.
    pub fn position(&self, sample: usize, body: usize) -> Vec3 {
        self.vector(&self.position, sample, body)
    }

    /// Returns the velocity of the centre of a body in a sample, inertial frame.
    pub fn velocity(&self, sample: usize, body: usize) -> Vec3 {
        self.vector(&self.velocity, sample, body)
    }

    /// Returns the attitude of a body in a sample: a unit quaternion `[w, x, y, z]`, body frame to inertial
    /// frame.
    ///
    /// # Panics
    /// As [`Self::state`].
    pub fn attitude(&self, sample: usize, body: usize) -> [f64; 4] {
        assert!(body < self.bodies, "body {body} of {}", self.bodies);
        let first = 4 * (self.bodies * sample + body);
        [0, 1, 2, 3].map(|k| self.attitude[first + k])
    }

    /// Returns the angular velocity of a body in a sample, body frame.
    pub fn spin(&self, sample: usize, body: usize) -> Vec3 {
        self.vector(&self.spin, sample, body)
    }

    /// Returns the energy of the system in a sample.
    pub fn energy(&self, sample: usize) -> Energy {
        let [total, translational, rotational, potential] = [0, 1, 2, 3].map(|k| self.energy[4 * sample + k]);
        Energy { total, translational, rotational, potential }
    }

    /// Returns the total energy in a sample without the work of the external forces since the start of the
    /// record: the quantity that an exact integrator would conserve.
    pub fn conserved_energy(&self, sample: usize) -> f64 {
        let row = self.work_and_impulse.len() / self.len();
        let work = self.work_and_impulse[row * sample..][..row].iter().step_by(WORK_AND_IMPULSE);
        self.energy[4 * sample] - work.sum::<f64>()
    }

    /// Returns the states of all samples in the order of the run.
    pub fn states(&self) -> impl DoubleEndedIterator<Item = State> + ExactSizeIterator + '_ {
        (0..self.len()).map(|sample| self.state(sample))
    }

    /// Returns the state of the last sample, if there is one.
    pub fn last(&self) -> Option<State> {
        self.states().next_back()
    }

    /// Returns the total angular momentum of the bodies in a sample, inertial frame.
    pub fn angular_momentum(&self, sample: usize) -> Vec3 {
        Vec3::from_column_slice(&self.angular_momentum[3 * sample..][..3])
    }

    fn vector(&self, all: &[f64], sample: usize, body: usize) -> Vec3 {
        assert!(body < self.bodies, "body {body} of {}", self.bodies);
        Vec3::from_column_slice(&all[3 * (self.bodies * sample + body)..][..3])
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Returns whether nothing has been recorded.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Appends a sample, with work and impulse of the forces since the simulation's start.
    pub fn push(&mut self, state: &State, conserved: &Invariants, work_and_impulse: &[f64]) {
        let start = self.start_work_and_impulse.get_or_insert_with(|| work_and_impulse.to_vec());
        self.work_and_impulse.extend(work_and_impulse.iter().zip(start).map(|(now, then)| now - *then));
        self.time.push(state.time);
        for body in 0..self.bodies {
            self.position.extend_from_slice(state.position[body].as_slice());
            self.velocity.extend_from_slice(state.velocity[body].as_slice());
            self.attitude.extend_from_slice(&state.attitude[body]);
            self.spin.extend_from_slice(state.spin[body].as_slice());
        }
        let energy = &conserved.energy;
        self.energy.extend([energy.total, energy.translational, energy.rotational, energy.potential]);
        self.angular_momentum.extend_from_slice(conserved.angular_momentum.as_slice());
    }
}
