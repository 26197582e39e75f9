//! Bodies in motion: state, equations of motion, invariants.
//!
//! Takes bodies, a gravitational constant and a method; gives rates of change, energies and momenta. The
//! equations are the paper's: Newton's for the centres, Euler's (`eq:DiffEq_phidott` to `eq:DiffEq_psidott`)
//! in the body frames, and either quaternions or the paper's Tait-Bryan kinematics (`eq:DiffEq_phi` to
//! `eq:DiffEq_psi`) for the attitudes. Each folder uses only those above it:
//!
//! - `rotation`: the free rotation of rigid bodies in closed form, and the discrete free rotation.
//! - `equations`: systems, states and the integrator's vector; the equations of motion over it, also as two
//!   flows for symplectic integrators; conserved quantities.
//! - `external`: external forces in the equations of motion, with their work, impulse and switches.
//! - `variations`: the variational equations, and their solution over a step.

mod rotation;
mod equations;
mod external;
mod variations;

pub use equations::changes::ParameterChanges;
pub use equations::evaluation::BodyInteraction;
pub use equations::invariants::{Energy, Invariants};
pub use equations::layout::AttitudeChart;
pub use equations::parameter::Parameter;
pub use equations::state::State;
pub use equations::system::{Settings, System};
#[doc(hidden)]
pub use equations::{
    Dynamics,
    layout::{BarycentricFrame, Layout},
    plausibility::{FAR, FAST, FarFromBarycentre, Unbound},
    quadrature::{Quadrature, QuadratureRule},
    rejected::Rejected,
    splitting::{DriftKind, Splitting},
};
#[doc(hidden)]
pub use rotation::{
    discrete_rotor::variational_rotation,
    free_rotors::{FreeRotor, MAX_ROTATION_ANGLE, rotation_angle_bound},
    steady_rotation::SteadyRotation,
};
pub use variations::jacobian::SystemJacobian;
#[doc(hidden)]
pub use variations::{Variations, collocation::Collocation, nominal::NominalChange, tangent::TANGENT_SIZE};
