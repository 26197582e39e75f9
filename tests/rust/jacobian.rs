//! The derivatives of a pair's force and torques: against arbitrary precision, and against differences of the
//! loads themselves.

use crate::mutual::{Bodies, any_bodies, any_pose, pair, pose};
use crate::support::*;
use fullbody::dynamics::{BarycentricFrame, Collocation, Parameter, Settings, State, System, Variations};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::lanes::VectorPath;
use fullbody::math::{Mat3, Vec3};
use fullbody::mutual::{Jacobian, Method, Pose};
use fullbody::shape::Body;
use proptest::prelude::*;

fn jacobian(bodies: &Bodies, method: Method, path: VectorPath, pose: &Pose) -> Jacobian {
    let mut pair = pair(bodies.shapes(), method, 1e-15, None, path);
    pair.prepare(pose, 0.0, &mut InterruptCheck::never()).unwrap();
    let endless = &mut InterruptCheck::never();
    pair.prepare_jacobian(pose, false, endless).unwrap();
    pair.jacobian(pose, endless).unwrap()
}

type Block = [[f64; 3]; 3];

fn block(rows: &[[f64; 9]; 9], i: usize, j: usize) -> Block {
    [0, 1, 2].map(|k| [0, 1, 2].map(|l| rows[3 * i + k][3 * j + l]))
}

fn size(block: &Block) -> f64 {
    block.iter().flatten().map(|x| x * x).sum::<f64>().sqrt()
}

/// Fails unless every 3 x 3 block is within a tolerance of its own size, or of a share of what the force's
/// block by these levers has.
#[track_caller]
fn same(actual: &[[f64; 9]; 9], expected: &[[f64; 9]; 9], levers: [f64; 3], tolerance: f64, what: &str) {
    let force = size(&block(expected, 0, 0));
    for i in 0..3 {
        for j in 0..3 {
            let (a, e) = (block(actual, i, j), block(expected, i, j));
            let difference: Block = [0, 1, 2].map(|k| [0, 1, 2].map(|l| a[k][l] - e[k][l]));
            let scale = size(&e).max(1e-3 * force * levers[i] * levers[j]);
            within(size(&difference) / scale, tolerance, format!("block {i} {j}, {what}"));
        }
    }
}

#[test]
fn reference_values() {
    for case in data("derivatives.json")["pairs"].as_array().unwrap() {
        let bodies = Bodies { a: triple(&case["axes_a"]), b: triple(&case["axes_b"]) };
        let pose = pose(
            Vec3::from(triple(&case["separation"])),
            attitude(&case["angles_a"]),
            attitude(&case["angles_b"]),
        );
        let expected: [[f64; 9]; 9] =
            std::array::from_fn(|i| std::array::from_fn(|j| number(&case["jacobian"][i][j])));
        for path in VectorPath::available() {
            for method in [Method::Focal, Method::Surface] {
                let rows = jacobian(&bodies, method, path, &pose).rows();
                same(
                    &rows,
                    &expected,
                    bodies.levers(),
                    1e-13,
                    &format!("{} by {method}, {path:?}", case["name"]),
                );
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(40))]

    #[test]
    fn rules_agree_from_near_to_far(
        bodies in any_bodies(0.2), pose in any_pose(), power in -1.0..3.0f64,
    ) {
        let pose = bodies.apart(&pose, 1.0 + 10f64.powf(power));
        let levers = bodies.levers();
        let focal = jacobian(&bodies, Method::Focal, VectorPath::Auto, &pose).rows();
        let surface = jacobian(&bodies, Method::Surface, VectorPath::Auto, &pose).rows();
        same(&surface, &focal, levers, 1e-12, &format!("{bodies:?} at 1 + 1e{power}"));
    }

    #[test]
    fn derivatives_are_those_of_the_loads(
        bodies in any_bodies(0.1), pose in any_pose(), distance in 1.4..4.0f64,
    ) {
        let pose = bodies.apart(&pose, distance);
        // Eighth-order differences of small moves, with the rule held fixed.
        const WEIGHTS: [f64; 4] = [0.8, -0.2, 4.0 / 105.0, -1.0 / 280.0];
        for method in [Method::Focal, Method::Surface] {
            let mut pair = pair(bodies.shapes(), method, 1e-15, None, VectorPath::Auto);
            pair.prepare(&pose, 0.1, &mut InterruptCheck::never()).unwrap();
            pair.prepare_jacobian(&pose, false, &mut InterruptCheck::never()).unwrap();
            let at = |by: [f64; 9]| {
                let turned = |r: &Mat3, v: Vec3| r * *nalgebra::Rotation3::from_scaled_axis(v).matrix();
                let f = pair.interaction(&Pose {
                    separation: pose.separation + Vec3::new(by[0], by[1], by[2]),
                    rotation_first: turned(&pose.rotation_first, Vec3::new(by[3], by[4], by[5])),
                    rotation_second: turned(&pose.rotation_second, Vec3::new(by[6], by[7], by[8])),
                });
                let loads = [f.force_on_first, f.torque_first, f.torque_second];
                let all: [f64; 9] = std::array::from_fn(|i| loads[i / 3][i % 3]);
                all
            };
            let mut expected = [[0.0; 9]; 9];
            let room = (distance - 1.0).min(1.0);
            for j in 0..9 {
                let h = if j < 3 { 0.01 * room * pose.separation.norm() / distance } else { 0.01 * room };
                for (k, weight) in (1..=4).zip(WEIGHTS) {
                    let mut by = [0.0; 9];
                    by[j] = f64::from(k) * h;
                    let plus = at(by);
                    by[j] = -by[j];
                    let minus = at(by);
                    for i in 0..9 {
                        expected[i][j] += weight * (plus[i] - minus[i]) / h;
                    }
                }
            }
            let rows = pair.jacobian(&pose, &mut InterruptCheck::never()).unwrap().rows();
            same(&rows, &expected, bodies.levers(), 1e-8, &format!("{method}, {bodies:?} at {distance}"));
        }
    }
}

#[test]
fn tangent_vectors_allocate_nothing_within_a_step() {
    let bodies = Bodies { a: [1.0, 0.8, 0.6], b: [0.5, 0.4, 0.3] };
    for gravity in [Method::Focal, Method::Surface, Method::Multipole(4), Method::Point] {
        let [a, b] = bodies.shapes();
        let both = vec![Body::with_mass("Alpha", a, 1.0).unwrap(), Body::with_mass("Beta", b, 0.3).unwrap()];
        let system = System::new(both, 1.0, Settings { gravity, ..Settings::default() }).unwrap();
        let zero = Vec3::zeros();
        let place = vec![zero, Vec3::new(2.0, 1.0, 0.5)];
        let turn = vec![[1.0, 0.0, 0.0, 0.0]; 2];
        let state = State::new(0.0, place, vec![zero; 2], turn, vec![Vec3::new(0.1, 0.2, 0.3); 2]).unwrap();
        let (frame, y, _) = BarycentricFrame::new(system.layout(), &system.masses(), &state);
        let endless = &mut InterruptCheck::never();
        let mut dynamics = system.dynamics(&frame, endless).unwrap();
        dynamics.prepare(0.0, &y, 0.1, endless).unwrap();
        let all = Parameter::all_of(&system).into_iter().map(|(_, parameter)| parameter).collect();
        let mut variations = Variations::new(&dynamics, all).unwrap();
        dynamics.prepare_variations(&variations, 0.0, &y, endless).unwrap();
        let columns = variations.start();
        let mut within = columns.clone();
        for mut collocation in [Collocation::new(&variations, 9), Collocation::interior(&variations, 9)] {
            let before = allocations();
            for node in 0..collocation.gauss().nodes.len() {
                variations.evaluate(&mut dynamics, 0.0, &y, endless).unwrap();
                collocation.load(node, &dynamics, &variations, &y);
            }
            collocation.load_ends(&dynamics, &variations, [&y, &y]);
            let solved = collocation.solve(&dynamics, [0.0, 0.1], &columns, false, endless).unwrap();
            if collocation.gauss().nodes.len() > 5 {
                assert!(collocation.is_resolved(0.1));
                collocation.within(&dynamics, (0.5, 0.1), &y, &mut within);
            }
            assert_eq!(allocations() - before, 0, "{gravity}");
            assert!(
                solved && collocation.end_columns().iter().chain(&within).all(|number| number.is_finite())
            );
        }
    }
}
