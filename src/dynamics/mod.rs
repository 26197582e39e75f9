//! Bodies in motion: state, equations of motion, invariants.
//!
//! Takes bodies, a gravitational constant and a method; gives rates of change, energies and momenta. The
//! equations are the paper's: Newton's for the centres, Euler's (`eq:DiffEq_phidott` to `eq:DiffEq_psidott`)
//! in the body frames, and either quaternions or the paper's Tait-Bryan kinematics (`eq:DiffEq_phi` to
//! `eq:DiffEq_psi`) for the attitudes.

mod external_loads;
mod evaluation;
mod collocation;
mod tangent;
mod discrete_rotor;
mod equations;
mod invariants;
mod jacobi;
mod jacobian;
mod layout;
mod external_forces;
mod parameter;
mod plausibility;
mod products;
mod quadrature;
mod rejected;
mod rotor;
mod rules;
mod split_variations;
mod splitting;
mod state;
mod sweeps;
mod switching;
mod system;
mod free_rotors;
mod variations;
mod vector;
mod snapshot_buffer;

#[doc(hidden)]
pub use collocation::Collocation;
#[doc(hidden)]
pub use discrete_rotor::variational_rotation;
#[doc(hidden)]
pub use equations::Dynamics;
pub use evaluation::BodyInteraction;
#[doc(hidden)]
pub use free_rotors::{FARTHEST, FreeRotor, farthest_turn};
pub use invariants::{Energy, Invariants};
pub use jacobian::SystemJacobian;
pub use layout::AttitudeChart;
#[doc(hidden)]
pub use layout::{BarycentricFrame, Layout};
pub use parameter::Parameter;
#[doc(hidden)]
pub use plausibility::{FAR, FAST, FarFromBarycentre, Unbound};
#[doc(hidden)]
pub use quadrature::{Quadrature, QuadratureRule};
#[doc(hidden)]
pub use rejected::Rejected;
#[doc(hidden)]
pub use splitting::{DriftKind, Splitting};
pub use state::State;
pub use system::{Settings, System};
#[doc(hidden)]
pub use tangent::TANGENT_SIZE;
#[doc(hidden)]
pub use variations::Variations;
