//! The recorded run.

use super::{Dense, Occurrence};
use crate::dynamics::{Invariants, State};

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StopReason {
    /// It has not: there was an error, or nothing has been run.
    #[default]
    Unfinished,
    /// It reached the time asked for.
    End,
    /// A terminal event, by its place in the list.
    Event(usize),
    /// The caller's hook asked to stop.
    Interrupted,
}

/// Samples of a run, flat and in C order: vectors are (K, N, 3), attitudes (K, N, 4).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trajectory {
    /// Number of bodies.
    pub bodies: usize,
    /// The conserved quantities at the start of the first run into this record.
    pub start: Option<Invariants>,
    /// Times (K,).
    pub time: Vec<f64>,
    /// Positions.
    pub position: Vec<f64>,
    /// Velocities.
    pub velocity: Vec<f64>,
    /// Attitudes.
    pub attitude: Vec<f64>,
    /// Spins, body frames.
    pub spin: Vec<f64>,
    /// Energies (K, 4): total, translational, rotational, potential.
    pub energy: Vec<f64>,
    /// Total angular momenta (K, 3).
    pub angular_momentum: Vec<f64>,
    /// Books of the forces from outside at the start of the first run into this record.
    pub start_books: Option<Vec<f64>>,
    /// The same (K, F, 7) since then: work, impulse, angular impulse of each force.
    pub books: Vec<f64>,
    /// How often each force was switched off in the runs into this record, for those that can be; being off at its start counts.
    pub switched_off: Vec<Option<u64>>,
    /// Transition matrices (K, 12 N, 12 N) from the start of the last run into this record, where they were asked for.
    pub transition: Vec<f64>,
    /// The same of the sensitivities (K, P, 12 N) to parameters.
    pub sensitivity: Vec<f64>,
    /// Indicators of chaos (K, 3) since then: the mean of MEGNO, the Lyapunov exponent, the fast Lyapunov indicator.
    pub chaos: Vec<f64>,
    /// Events in order of the run.
    pub events: Vec<Occurrence>,
    /// The continuous solution, where it was asked for.
    pub dense: Option<Dense>,
    /// Why the last run into this record ended.
    pub stop_reason: StopReason,
}

impl Trajectory {
    /// An empty record.
    pub fn new(bodies: usize) -> Self {
        Self { bodies, ..Self::default() }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether nothing has been recorded.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Adds a sample, with the books of the forces since the simulation's start.
    pub fn push(&mut self, state: &State, conserved: &Invariants, books: &[f64]) {
        let start = self.start_books.get_or_insert_with(|| books.to_vec());
        self.books.extend(books.iter().zip(start).map(|(now, then)| now - *then));
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
