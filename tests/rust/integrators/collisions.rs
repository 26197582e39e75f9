//! Bodies that meet: found however short the overlap and however long the step, told with the time, and none
//! where there is none.

use super::systems::*;
use crate::polyhedron::cuboid;
use crate::support::{cases, contact_function, direction, semi_axes};
use fullbody::dynamics::{AttitudeChart, Settings, State, System};
use fullbody::error::Error;
use fullbody::integrate::{Scheme, Tolerance};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::{Vec3, rotation};
use fullbody::mutual::Method;
use fullbody::shape::{Body, InputPart, Proximity, Shape};
use fullbody::trajectory::{
    Condition, Event, Integrator, Output, Run, Simulation, StopReason, TangentOptions, Trajectory,
};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;

const STILL: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

fn system(shapes: &[Shape], g: f64) -> System {
    let names = ["A", "B", "C"];
    let body = |(shape, name): (&Shape, &&str)| Body::with_mass(*name, shape.clone(), 1.0).unwrap();
    System::new(shapes.iter().zip(&names).map(body).collect(), g, Settings::default()).unwrap()
}

fn sphere(radius: f64) -> Shape {
    Shape::sphere(radius).unwrap()
}

/// Runs, and gives the record and how it ended.
fn attempt(
    simulation: &mut Simulation,
    until: f64,
    output: &Output,
    events: &mut [Event],
    dense: bool,
) -> (Trajectory, Result<(), Error>) {
    let mut record = Trajectory::new(simulation.system().bodies().len());
    let run = Run { output, events, dense, tangent_options: &TangentOptions::default() };
    let outcome = simulation.run(until, run, &mut record, &mut |_, _| ControlFlow::Continue(()));
    (record, outcome)
}

/// Names and time of an overlap.
#[track_caller]
fn overlap(outcome: Result<(), Error>) -> (String, f64) {
    match outcome {
        Err(Error::BodiesOverlap { first, second, time }) => (format!("{first}{second}"), time),
        other => panic!("{other:?}"),
    }
}

/// Two unit spheres on parallel lines at speed 10, `aside` apart there; nearest at time 10 (or -10, run
/// backwards).
fn passing(aside: f64, sign: f64) -> State {
    let position = vec![Vec3::new(-100.0 * sign, 0.5 * aside, 0.0), Vec3::new(0.0, -0.5 * aside, 0.0)];
    let velocity = vec![Vec3::new(10.0, 0.0, 0.0), Vec3::zeros()];
    State::new(0.0, position, velocity, vec![STILL; 2], vec![Vec3::zeros(); 2]).unwrap()
}

/// Without gravity every step is as long as the run, and the time of contact is that of straight lines:
/// however shallow.
#[test]
fn spheres_on_straight_lines() {
    let system = system(&[sphere(1.0), sphere(1.0)], 0.0);
    for sign in [1.0, -1.0] {
        for integrator in all(1e-6, 3.0) {
            for depth in [2.0, 1.0, 1e-3, 1e-6, 1e-9, 1e-12] {
                let aside = 2.0 - depth;
                let mut simulation = Simulation::new(&system, &passing(aside, sign), integrator).unwrap();
                let output = Output::Spacing(0.25);
                let (record, outcome) = attempt(&mut simulation, 20.0 * sign, &output, &mut [], false);
                let (names, time) = overlap(outcome);
                let expected = sign * (10.0 - 0.1 * (4.0 - aside * aside).sqrt());
                // Half the digits of a depth are those of the time.
                let allowed = 2e-12 + 1e-15 / (depth * (4.0 - depth)).sqrt();
                assert!((time - expected).abs() < allowed, "{integrator:?} {depth:e}: {time} {expected}");
                assert_eq!(names, "AB");
                // All samples due before it, none inside, and the simulation where it was accepted last.
                assert_eq!(record.stop_reason, StopReason::Unfinished);
                assert_eq!(record.len(), (time.abs() / 0.25).ceil() as usize, "{integrator:?}");
                assert!(simulation.time() * sign <= time * sign);
                let state = simulation.state();
                assert!((state.position()[1] - state.position()[0]).norm() >= 2.0 - 1e-13);
            }
            for gap in [1e-12, 1e-9, 1e-3] {
                let mut simulation = Simulation::new(&system, &passing(2.0 + gap, sign), integrator).unwrap();
                let (_, outcome) = attempt(&mut simulation, 20.0 * sign, &Output::Steps, &mut [], false);
                outcome.unwrap();
            }
        }
    }
}

/// Two spheres fall from rest under gravity, in steps of a hundredth to more than the whole of the fall.
#[test]
fn spheres_that_fall_touch_at_the_time_of_the_closed_form() {
    let system = system(&[sphere(0.2), sphere(0.1)], 0.5);
    let state = relative(Vec3::new(0.6, 0.0, 0.8), Vec3::zeros(), 0.5);
    // From distance 1 with mu = 1: t = (acos sqrt x + sqrt(x (1 - x))) / sqrt 2 at x = 0.3.
    let x: f64 = 0.3;
    let expected = (x.sqrt().acos() + (x * (1.0 - x)).sqrt()) / 2.0_f64.sqrt();
    let fixed = |step| {
        [Scheme::Leapfrog, Scheme::Aba864, Scheme::Aba1064]
            .map(|scheme| Integrator::SymplecticSplitting { step, scheme })
    };
    let pairs = |tolerance| all(tolerance, 1.0).into_iter().take(5);
    let cases = [(1e-3, 0.1), (1e-8, 1e-5), (1e-13, 1e-11)];
    let cases =
        cases.into_iter().flat_map(|(tolerance, error)| pairs(tolerance).map(move |pair| (pair, error)));
    // The splitting's drift is the very motion.
    let cases =
        cases.chain([0.01, 0.3, 0.97].into_iter().flat_map(fixed).map(|integrator| (integrator, 1e-11)));
    for (integrator, error) in cases {
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let (record, outcome) = attempt(&mut simulation, 3.0, &Output::Steps, &mut [], false);
        let (_, time) = overlap(outcome);
        assert!((time - expected).abs() < error, "{integrator:?}: {:e}", time - expected);
        assert_eq!(simulation.time(), *record.time.last().unwrap());
        assert_eq!(simulation.statistics().steps as usize + 1, record.len());
        // Step by step it is the same.
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let outcome = loop {
            let before = simulation.state();
            if let Err(error) = simulation.step(3.0) {
                assert_eq!(simulation.state(), before);
                break Err(error);
            }
        };
        assert_eq!(overlap(outcome).1, time);
        // From there it goes back to where it came from.
        attempt(&mut simulation, 0.0, &Output::Steps, &mut [], false).1.unwrap();
    }
}

/// A step of nearly a whole revolution ends where it began, and slowly: nothing but the bend of its path
/// tells of the periapsis.
#[test]
#[allow(clippy::approx_constant)] // A step that is no whole revolution.
fn a_revolution_within_a_step() {
    let system = system(&[sphere(0.02), sphere(0.02)], 0.5);
    // At apoapsis of an orbit with a = 1 and mu = 1, whose periapsis is a quarter of the sum of the radii.
    let e: f64 = 0.99;
    let speed = ((1.0 - e) / (1.0 + e)).sqrt();
    let state = relative(Vec3::new(1.0 + e, 0.0, 0.0), Vec3::new(0.0, speed, 0.0), 0.5);
    // At r = 1 - e cos E = 0.04, by Kepler's equation.
    let anomaly = (0.96 / e).acos();
    let expected = PI - (anomaly - e * anomaly.sin());
    for scheme in [Scheme::Leapfrog, Scheme::Aba864, Scheme::Aba1064] {
        let integrator = Integrator::SymplecticSplitting { step: 6.28, scheme };
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let (_, outcome) = attempt(&mut simulation, 6.28, &Output::Steps, &mut [], false);
        let (_, time) = overlap(outcome);
        assert!((time - expected).abs() < 1e-10, "{scheme:?}: {time} {expected}");
    }
}

/// The end of a turning needle sweeps through a point's place for a moment: at (d cos u)^2 / a^2 + (d sin
/// u)^2 / b^2 = 1 for an angle u between the needle and the point.
#[test]
fn a_needle_sweeps_by() {
    let shapes = [Shape::ellipsoid([1.0, 0.1, 0.1]).unwrap(), Shape::Point];
    for chart in [AttitudeChart::Quaternion, AttitudeChart::TaitBryan] {
        let settings = Settings { attitude_chart: chart, ..Settings::default() };
        let system = System::new(system(&shapes, 0.0).bodies().to_vec(), 0.0, settings).unwrap();
        for (integrator, error) in
            all(1e-7, 0.9).into_iter().zip([1e-6; 5].into_iter().chain([0.3, 1e-9, 1e-9, 1e-9]))
        {
            for (d, meets) in [(0.5, true), (1.0 - 1e-6, true), (1.0 - 1e-11, true), (1.0 + 1e-11, false)] {
                let position = vec![Vec3::zeros(), Vec3::new(d, 0.0, 0.0)];
                let spin = vec![Vec3::z(), Vec3::zeros()];
                let attitude = vec![rotation::from_tait_bryan([0.0, 0.0, -FRAC_PI_2]), STILL];
                let state = State::new(0.0, position, vec![Vec3::zeros(); 2], attitude, spin).unwrap();
                let Ok(mut simulation) = Simulation::new(&system, &state, integrator) else {
                    assert_eq!(chart, AttitudeChart::TaitBryan);
                    continue;
                };
                let (_, outcome) = attempt(&mut simulation, 3.0, &Output::Steps, &mut [], false);
                if !meets {
                    outcome.unwrap();
                    continue;
                }
                let (_, time) = overlap(outcome);
                let sine: f64 = ((1.0 / (d * d) - 1.0) / 99.0).sqrt();
                let expected = FRAC_PI_2 - sine.asin();
                assert!((time - expected).abs() < error, "{integrator:?} {d}: {time} {expected}");
            }
        }
    }
}

/// The place where an ellipsoid's outward normal is n, from its centre.
fn place(axes: [f64; 3], q: [f64; 4], n: &Vec3) -> Vec3 {
    let turn = rotation::matrix(q);
    let along = Vec3::from(axes).component_mul(&(turn.transpose() * n));
    turn * Vec3::from(axes).component_mul(&along) / along.norm()
}

proptest! {
    #![proptest_config(cases(60))]

    /// Ellipsoids that do not turn: on the line along a common normal they touch where the places with that
    /// normal meet; across it they overlap as soon as their lines are nearer than that.
    #[test]
    fn ellipsoids_on_straight_lines(
        a in semi_axes(0.05), b in semi_axes(0.05), n in direction(), other in direction(),
        p in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0, -1.0..1.0],
        q in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0, -1.0..1.0], depth in -9.0..-1.0f64,
    ) {
        prop_assume!(n.cross(&other).norm() > 0.1);
        let (p, q) = (rotation::normalised(p), rotation::normalised(q));
        let bodies =
            system(&[Shape::ellipsoid(a).unwrap(), Shape::ellipsoid(b).unwrap()], 0.0).bodies().to_vec();
        // The series to degree two: quadratures do not converge between sharp rims in contact.
        let settings = Settings { gravity: Method::Multipole(2), ..Settings::default() };
        let system = System::new(bodies, 0.0, settings).unwrap();
        let start = |r: Vec3, v: Vec3| {
            State::new(
                0.0,
                vec![-0.5 * r, 0.5 * r],
                vec![-0.5 * v, 0.5 * v],
                vec![p, q],
                vec![Vec3::zeros(); 2],
            )
            .unwrap()
        };
        let touching = place(a, p, &n) + place(b, q, &n);
        let across = n.cross(&other).normalize();
        let tolerance = Tolerance::new(1e-3, 1e-3).unwrap();
        let integrators = [
            Integrator::DormandPrince54(tolerance),
            Integrator::Verner98(tolerance),
            Integrator::LieGroupVariational { step: 0.02 },
            Integrator::SymplecticSplitting { step: 0.02, scheme: Scheme::Leapfrog },
        ];
        for integrator in integrators {
            let run = |state: State| {
                let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
                attempt(&mut simulation, 30.0, &Output::Times(vec![]), &mut [], false).1
            };
            let (_, time) = overlap(run(start(touching + 12.0 * n, -n)));
            prop_assert!((time - 12.0).abs() < 1e-11, "{integrator:?}: {time}");
            let depth = 10.0_f64.powf(depth);
            let beside = |depth: f64| start(touching * (1.0 - depth) - 12.0 * across, across);
            overlap(run(beside(depth)));
            prop_assert!(run(beside(-depth)).is_ok());
        }
    }

    /// Fast and slow passages of heavy spheres and ellipsoids: what is found without looking into the steps
    /// is what is found on the continuous solution, and where nothing is found that solution stays outside.
    #[test]
    fn passages_are_judged_as_on_the_continuous_solution(
        aside in 0.0..4.0f64, speed in -1.0..1.5f64, g in -3.0..1.0f64, flat in 0.3..1.0f64,
        spin in direction(), which in 0..9usize, tolerance in 3.0..13.0f64, method in 0..3usize,
    ) {
        let shapes = [Shape::ellipsoid([1.0, 0.5 + 0.5 * flat, flat]).unwrap(), sphere(0.5)];
        let settings = Settings {
            gravity: [Method::Focal, Method::Surface, Method::Multipole(4)][method],
            ..Settings::default()
        };
        let bodies = system(&shapes, 0.0).bodies().to_vec();
        let system = System::new(bodies, 10.0_f64.powf(g), settings).unwrap();
        let speed = 10.0_f64.powf(speed);
        let state = relative(Vec3::new(-8.0, aside, 0.0), Vec3::new(speed, 0.0, 0.0), 0.5);
        let state = replaced(state, |[.., spins]| spins[0] = spin * 0.3 * speed);
        let until = 16.0 / speed;
        let integrator = all(10.0_f64.powf(-tolerance), 0.3 / speed)[which];
        let run = |dense: bool| {
            let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
            attempt(&mut simulation, until, &Output::Times(vec![]), &mut [], dense)
        };
        let ((_, plain), (record, dense)) = (run(false), run(true));
        // What is between the ends of fixed steps depends at round-off on what was looked at before.
        match (&plain, &dense) {
            (Err(Error::BodiesOverlap { time, .. }), Err(Error::BodiesOverlap { time: other, .. })) => {
                prop_assert!((time - other).abs() < 1e-13 * until, "{integrator:?}: {time} {other}");
            }
            _ => prop_assert_eq!(&plain, &dense, "{:?}", integrator),
        }
        if let Some(solution) = &record.dense {
            let (from, to) = solution.range();
            for k in 0..=400 {
                let at = solution.state((from + (to - from) * f64::from(k) / 400.0).min(to)).unwrap();
                let r = at.position()[1] - at.position()[0];
                let square = contact_function(
                    &shapes[0],
                    &shapes[1],
                    &r,
                    &rotation::matrix(at.attitude()[0]),
                    &rotation::matrix(at.attitude()[1]),
                );
                prop_assert!(square > 1.0 - 1e-9, "{integrator:?} at {} of {to}: {square}", at.time());
            }
        }
    }

    /// Needles, discs, cubes and pairs of spheres that spin fast pass each other within long steps: nowhere on
    /// the continuous solution do they overlap before the contact that is reported, or at all if none is.
    #[test]
    fn spinning_bodies_that_are_proved_apart_stay_apart(
        kinds in [0..4usize, 0..4usize], aside in 0.0..2.6f64, speed in -1.0..1.0f64,
        spins in [direction(), direction()], turns in [-1.5..1.5f64, -1.5..1.5f64], tolerance in 2.0..10.0f64,
    ) {
        let body = |kind: usize, name: &str| {
            let ball = |x: f64| InputPart {
                shape: sphere(0.4), mass: 0.5, position: [x, 0.0, 0.0], attitude: STILL,
            };
            match kind {
                0 => Body::with_mass(name, Shape::ellipsoid([1.2, 0.1, 0.05]).unwrap(), 1.0),
                1 => Body::with_mass(name, Shape::ellipsoid([1.0, 0.9, 0.05]).unwrap(), 1.0),
                2 => Body::with_mass(name, Shape::Polyhedron(cuboid([-0.5; 3], [1.0; 3])), 1.0),
                _ => Body::composite(name, vec![ball(-0.7), ball(0.7)]),
            }
        };
        let bodies = vec![body(kinds[0], "A").unwrap(), body(kinds[1], "B").unwrap()];
        let settings = Settings { gravity: Method::Point, ..Settings::default() };
        let system = System::new(bodies.clone(), 1e-30, settings).unwrap();
        let speed = 10.0_f64.powf(speed);
        let state = relative(Vec3::new(-6.0, aside, 0.1), Vec3::new(speed, 0.0, 0.0), 0.5);
        let rate = |k: usize| spins[k] * 10.0_f64.powf(turns[k]) * speed;
        let state = replaced(state, |[.., spin]| (0..2).for_each(|k| spin[k] = rate(k)));
        let integrator = verner98(10.0_f64.powf(-tolerance));
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let (record, outcome) =
            attempt(&mut simulation, 12.0 / speed, &Output::Times(vec![]), &mut [], true);
        prop_assert!(matches!(outcome, Ok(()) | Err(Error::BodiesOverlap { .. })), "{outcome:?}");
        let solution = record.dense.unwrap();
        let (_, end) = solution.range();
        let factor = |time: f64| {
            let at = solution.state(time.clamp(0.0, end)).unwrap();
            let r = at.position()[1] - at.position()[0];
            let turns = [0, 1].map(|k| rotation::matrix(at.attitude()[k]));
            let never = &mut InterruptCheck::never();
            Proximity::compute([&bodies[0], &bodies[1]], &r, [&turns[0], &turns[1]], time, never).unwrap().factor
        };
        const COUNT: usize = 3000;
        let step = end / COUNT as f64;
        let all: Vec<f64> = (0..=COUNT).map(|k| factor(step * k as f64)).collect();
        for k in (1..COUNT).filter(|k| all[*k] < 1.2 && all[*k] <= all[k - 1].min(all[k + 1])) {
            for fine in -20..=20 {
                let time = step * (k as f64 + f64::from(fine) / 20.0);
                let found = factor(time);
                prop_assert!(found > 1.0 - 1e-9, "{found} at {time} of {end}: {outcome:?}");
            }
        }
        let touching = (factor(end) - 1.0).abs() < 1e-9;
        prop_assert!(outcome.is_ok() || touching, "{} at {end}: {outcome:?}", factor(end));
    }
}

/// Of several contacts in one step the first counts, whatever the bodies' order; points only among each other
/// do not overlap.
#[test]
fn the_first_of_three() {
    let shapes = [sphere(1.0), Shape::Point, sphere(0.5)];
    let system = system(&shapes, 0.0);
    // A stays; C touches it at 8.5 / 2, B at 9 / 3; B and C never meet.
    let position = vec![Vec3::zeros(), Vec3::new(0.0, 10.0, 0.0), Vec3::new(10.0, 0.0, 0.0)];
    let velocity = vec![Vec3::zeros(), Vec3::new(0.0, -3.0, 0.0), Vec3::new(-2.0, 0.0, 0.0)];
    let state = |velocity: Vec<Vec3>| {
        State::new(0.0, position.clone(), velocity, vec![STILL; 3], vec![Vec3::zeros(); 3]).unwrap()
    };
    let swapped = vec![velocity[0], velocity[1] / 3.0, velocity[2]];
    for integrator in all(1e-6, 5.0) {
        for (velocity, pair, expected) in [(velocity.clone(), "AB", 3.0), (swapped.clone(), "AC", 4.25)] {
            let mut simulation = Simulation::new(&system, &state(velocity), integrator).unwrap();
            let (names, time) = overlap(attempt(&mut simulation, 20.0, &Output::Steps, &mut [], false).1);
            assert_eq!(names, pair, "{integrator:?}");
            assert!((time - expected).abs() < 1e-13, "{integrator:?}: {time}");
        }
    }
}

/// Events up to a contact are kept, and an event of the contact is at its time: a terminal one ends the run
/// without an error.
#[test]
fn events_are_kept_up_to_the_contact() {
    let system = system(&[sphere(1.0), sphere(1.0)], 0.0);
    let contact = || Event::new(Condition::Contact { first: 1, second: 0 });
    let separation = |value| Event::new(Condition::Separation { first: 0, second: 1, value });
    for sign in [1.0, -1.0] {
        let state = passing(2.0 - 1e-7, sign);
        let expected = sign * (10.0 - 0.1 * (4.0_f64 - (2.0_f64 - 1e-7).powi(2)).sqrt());
        for integrator in all(1e-6, 3.0) {
            let go = |events: &mut [Event], dense: bool| {
                let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
                let (record, outcome) =
                    attempt(&mut simulation, 20.0 * sign, &Output::Spacing(0.5), events, dense);
                (simulation, record, outcome)
            };
            let (plain, _, outcome) = go(&mut [], false);
            let (_, time) = overlap(outcome);
            assert!((time - expected).abs() < 1e-11);

            // Recorded, and then the error.
            let (simulation, record, outcome) = go(&mut [contact(), separation(50.0), separation(1.9)], true);
            assert_eq!(overlap(outcome).1, time, "{integrator:?}");
            let happened: Vec<usize> = record.events.iter().map(|e| e.event).collect();
            assert_eq!(happened, [1, 0]);
            assert_eq!(record.events[1].time, time);
            assert_eq!(record.len(), 20);
            assert_eq!(record.dense.unwrap().range(), (0.0, time));
            assert_eq!(simulation.state(), plain.state());

            // Where only the way out is asked for there is no event.
            let way_out = if sign > 0.0 { 1 } else { -1 };
            let (_, record, outcome) = go(&mut [contact().directed(way_out).terminal()], false);
            assert_eq!(overlap(outcome).1, time);
            assert!(record.events.is_empty());

            let (mut simulation, record, outcome) = go(&mut [contact().directed(-way_out).terminal()], false);
            outcome.unwrap();
            assert_eq!(record.stop_reason, StopReason::Event(0));
            assert_eq!((simulation.time(), *record.time.last().unwrap()), (time, time));
            assert_eq!(record.len(), 21);
            // On from there they overlap at once; back they do not.
            let (record, outcome) =
                attempt(&mut simulation, 20.0 * sign, &Output::Steps, &mut [contact()], false);
            let (_, again) = overlap(outcome);
            assert!((again - time).abs() < 1e-9, "{again} {time}");
            assert_eq!((record.len(), simulation.time()), (1, time));
            attempt(&mut simulation, 0.0, &Output::Steps, &mut [], false).1.unwrap();

            // A terminal event before it comes first.
            let (simulation, _, outcome) = go(&mut [contact().terminal(), separation(3.0).terminal()], false);
            outcome.unwrap();
            assert!(simulation.time() * sign < time * sign);
        }
    }
}

/// Two spheres that roll about each other in touch are not overlapping, nor is looking for it endless work.
#[test]
fn spheres_that_roll_in_touch_do_not_overlap() {
    let system = system(&[sphere(1.0), sphere(1.0)], 1.0);
    let state = relative(Vec3::new(2.0 * (1.0 + 1e-12), 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), 0.5);
    let mut simulation = Simulation::new(&system, &state, verner98(1e-14)).unwrap();
    let (record, outcome) = attempt(&mut simulation, 6.0, &Output::Steps, &mut [], false);
    outcome.unwrap();
    println!("{} steps in touch", record.len());
    // At rest beside each other as well.
    let still = crate::integrators::collisions::system(&[sphere(1.0), sphere(1.0)], 0.0);
    let state = relative(Vec3::new(2.0, 0.0, 0.0), Vec3::zeros(), 0.5);
    for integrator in all(1e-6, 1.0) {
        let mut simulation = Simulation::new(&still, &state, integrator).unwrap();
        attempt(&mut simulation, 100.0, &Output::Steps, &mut [], true).1.unwrap();
    }
}

/// A fixed step that takes two bodies nearer to each other than it was prepared for is refused with their
/// names and how near it took them: to where straight lines lead in the middle of a leapfrog's step, and at
/// its end by the Lie group's.
#[test]
fn fixed_steps_that_come_too_close_name_the_bodies() {
    let shapes = [[1.0, 0.9, 0.8], [0.1, 0.09, 0.08], [0.2, 0.15, 0.1]].map(|a| Shape::ellipsoid(a).unwrap());
    let system = system(&shapes, 1e-9);
    // C goes by A, at a distance of 3 after a time of 30; B is far off.
    let position = vec![Vec3::zeros(), Vec3::new(0.0, 90.0, 0.0), Vec3::new(-30.0, 3.0, 0.0)];
    let velocity = vec![Vec3::zeros(), Vec3::zeros(), Vec3::new(1.0, 0.0, 0.0)];
    let state = State::new(2.5, position, velocity, vec![STILL; 3], vec![Vec3::zeros(); 3]).unwrap();
    for integrator in [
        Integrator::SymplecticSplitting { step: 60.0, scheme: Scheme::Leapfrog },
        Integrator::LieGroupVariational { step: 30.0 },
    ] {
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let message = simulation.step(9e9).unwrap_err().to_string();
        for part in ["at time 2.5", "A and C come to a separation of 3.0000", "use a shorter step"] {
            assert!(message.contains(part), "{message}");
        }
        assert_eq!(simulation.state(), state);
    }
}
