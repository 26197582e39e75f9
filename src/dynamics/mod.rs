//! Bodies in motion: state, equations of motion, invariants.
//!
//! Takes bodies, a gravitational constant and a method; gives rates of change, energies and momenta. The equations are the
//! paper's: Newton's for the centres, Euler's (`eq:DiffEq_phidott` to `eq:DiffEq_psidott`) in the body frames, and either
//! quaternions or the paper's Tait-Bryan kinematics (`eq:DiffEq_phi` to `eq:DiffEq_psi`) for the attitudes.

mod actions;
mod at_a_state;
mod collocation;
mod departure;
mod discrete_rotor;
mod equations;
mod invariants;
mod jacobi;
mod jacobian;
mod layout;
mod outside;
mod parameter;
mod products;
mod quadrature;
mod rejected;
mod rotor;
mod rules;
mod split_variations;
mod splitting;
mod state;
mod sweeps;
mod system;
mod tops;
mod variations;
mod vector;
mod view;

pub use at_a_state::BodyInteraction;
pub use collocation::Collocation;
pub use departure::DEPARTURE;
pub use discrete_rotor::variational_rotation;
pub use equations::Dynamics;
pub use invariants::{Energy, Invariants};
pub use jacobian::SystemJacobian;
pub use layout::{AttitudeChart, BarycentricFrame, Layout};
pub use parameter::Parameter;
pub use quadrature::{Quadrature, QuadratureRule};
pub use rejected::Rejected;
pub use splitting::{Parts, Splitting};
pub use state::State;
pub use system::{Settings, System};
pub use tops::{FARTHEST, Top, farthest_turn};
pub use variations::Variations;
