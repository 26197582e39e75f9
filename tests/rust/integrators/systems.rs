//! Systems to run.

use fullbody::dynamics::{AttitudeChart, Settings, State, System};
use fullbody::error::Result;
use fullbody::integrate::{Scheme, Tolerance};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::Vec3;
use fullbody::mutual::Method;
use fullbody::shape::{Body, InputPart, Shape};
use fullbody::trajectory::{Integrator, Output, Run, Simulation, TangentOptions, Trajectory};
use std::ops::ControlFlow;

/// Two points at periapsis of an orbit with a = 1 and mu = 1.
pub fn points(e: f64) -> (System, State) {
    let bodies = ["A", "B"].into_iter().zip([0.7, 0.3]);
    let bodies = bodies.map(|(name, mass)| Body::with_mass(name, Shape::Point, mass).unwrap());
    let settings = Settings { gravity: Method::Point, ..Settings::default() };
    let system = System::new(bodies.collect(), 1.0, settings).unwrap();
    let (r, v) = (1.0 - e, ((1.0 + e) / (1.0 - e)).sqrt());
    (system, relative(Vec3::new(r, 0.0, 0.0), Vec3::new(0.0, v, 0.0), 0.3))
}

/// Two bodies by their relative motion, the barycentre at rest at the origin.
pub fn relative(r: Vec3, v: Vec3, share: f64) -> State {
    let still = vec![[1.0, 0.0, 0.0, 0.0]; 2];
    let position = vec![-share * r, (1.0 - share) * r];
    let velocity = vec![-share * v, (1.0 - share) * v];
    State::new(0.0, position, velocity, still, vec![Vec3::zeros(); 2]).unwrap()
}

/// The same orbit with a first body of two parts and a void.
pub fn contact_binary() -> (System, State) {
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let part = |axes, mass, position| InputPart {
        shape: Shape::ellipsoid(axes).unwrap(),
        mass,
        position,
        attitude: [0.9, 0.1, -0.2, 0.3],
    };
    let parts = vec![
        part([0.3, 0.25, 0.2], 0.6, [0.2, 0.0, 0.0]),
        part([0.2, 0.2, 0.1], 0.25, [-0.2, 0.1, 0.0]),
        part([0.1, 0.1, 0.05], -0.05, [0.2, 0.0, 0.05]),
    ];
    let bodies = vec![Body::composite("A", parts).unwrap(), system.bodies()[1].clone()];
    (System::new(bodies, 1.0, *system.settings()).unwrap(), state)
}

/// Two triaxial bodies on an eccentric orbit, turning about no special axes.
pub fn tumbling(method: Method, chart: AttitudeChart) -> (System, State) {
    let shape = |axes| Shape::ellipsoid(axes).unwrap();
    let bodies = vec![
        Body::with_mass("A", shape([0.4, 0.35, 0.3]), 0.8).unwrap(),
        Body::with_mass("B", shape([0.25, 0.2, 0.15]), 0.2).unwrap(),
    ];
    let settings = Settings { gravity: method, attitude_chart: chart, ..Settings::default() };
    let system = System::new(bodies, 1.0, settings).unwrap();
    let mut state = relative(Vec3::new(1.6, 0.1, 0.2), Vec3::new(0.02, 0.75, 0.1), 0.2);
    let angles = [[0.3, 0.2, 0.1], [-0.2, 0.4, 0.9]];
    let spin = vec![Vec3::new(0.1, -0.2, 1.1), Vec3::new(0.15, 0.1, 0.4)];
    state = State::from_tait_bryan(0.0, state.position().to_vec(), state.velocity().to_vec(), &angles, spin)
        .unwrap();
    (system, state)
}

/// The state with other positions, velocities and spins.
pub fn replaced(state: State, change: impl FnOnce(&mut [Vec<Vec3>; 3])) -> State {
    let mut lists = [state.position(), state.velocity(), state.spin()].map(<[Vec3]>::to_vec);
    change(&mut lists);
    let [position, velocity, spin] = lists;
    State::new(state.time(), position, velocity, state.attitude().to_vec(), spin).unwrap()
}

/// Three bodies: a close pair and a third one further out.
pub fn triple() -> (System, State) {
    let (pair, state) = tumbling(Method::Multipole(4), AttitudeChart::Quaternion);
    let mut bodies = pair.bodies().to_vec();
    bodies.push(Body::with_mass("C", Shape::ellipsoid([0.1, 0.08, 0.07]).unwrap(), 0.05).unwrap());
    let and = |list: &[Vec3], last: [f64; 3]| [list, &[Vec3::from(last)]].concat();
    let state = State::new(
        state.time(),
        and(state.position(), [-6.0, 3.0, 0.5]),
        and(state.velocity(), [-0.15, -0.3, 0.02]),
        [state.attitude(), &[[1.0, 0.0, 0.0, 0.0]]].concat(),
        and(state.spin(), [0.0, 0.3, 0.2]),
    )
    .unwrap();
    (System::new(bodies, 1.0, *pair.settings()).unwrap(), state)
}

pub fn verner98(tolerance: f64) -> Integrator {
    Integrator::Verner98(Tolerance::new(tolerance, tolerance).unwrap())
}

/// Every integrator, with steps and tolerances for systems with times of order one.
pub fn all(tolerance: f64, step: f64) -> Vec<Integrator> {
    let t = Tolerance::new(tolerance, tolerance).unwrap();
    vec![
        Integrator::DormandPrince54(t),
        Integrator::Verner65(t),
        Integrator::Verner76(t),
        Integrator::Verner87(t),
        Integrator::Verner98(t),
        Integrator::LieGroupVariational { step },
        Integrator::SymplecticSplitting { step, scheme: Scheme::Leapfrog },
        Integrator::SymplecticSplitting { step, scheme: Scheme::Aba864 },
        Integrator::SymplecticSplitting { step, scheme: Scheme::Aba1064 },
    ]
}

/// Runs without events.
pub fn integrate(simulation: &mut Simulation, until: f64, output: &Output, dense: bool) -> Trajectory {
    let mut record = Trajectory::new(simulation.system().bodies().len());
    let run = Run { output, events: &mut [], dense, tangent_options: &TangentOptions::default() };
    simulation.run(until, run, &mut record, &mut |_, _| ControlFlow::Continue(())).unwrap();
    record
}

/// Largest difference of positions and velocities.
pub fn difference(a: &State, b: &State) -> f64 {
    let both = a.position().iter().chain(a.velocity()).zip(b.position().iter().chain(b.velocity()));
    both.map(|(x, y)| (x - y).norm()).fold(0.0, f64::max)
}

/// Largest difference of attitudes and spins.
pub fn difference_of_rotation(a: &State, b: &State) -> f64 {
    let attitudes = a.attitude().iter().zip(b.attitude()).flat_map(|(p, q)| p.iter().zip(q));
    let attitudes = attitudes.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    a.spin().iter().zip(b.spin()).map(|(x, y)| (x - y).norm()).fold(attitudes, f64::max)
}

/// The simulation of an archive.
pub fn read(bytes: &[u8]) -> Result<Simulation> {
    Simulation::from_bytes(bytes, &mut InterruptCheck::never())
}
