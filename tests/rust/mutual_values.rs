//! The interaction of a pair agrees with independent values: integrals in arbitrary precision, MacMillan's
//! potential of a spheroid, MacCullagh's formula, and the theoretical error of the multipole series.

use crate::gravity::paper_oblate;
use crate::mutual::{
    Bodies, Outcome, any_bodies, any_pose, attitude_of, pose, run, same, same_by_own_levers,
};
use crate::support::*;
use fullbody::math::lanes::VectorPath;
use fullbody::math::{Mat3, Vec3};
use fullbody::mutual::{Interaction, Method, Pose};
use fullbody::quadrature::Order;
use fullbody::shape::Shape;
use proptest::prelude::*;
use serde_json::Value;

fn vector(value: &Value) -> Vec3 {
    Vec3::from(triple(value))
}

#[test]
fn reference_values() {
    for case in data("mutual_forces.json").as_array().unwrap() {
        let bodies = Bodies { a: triple(&case["axes_a"]), b: triple(&case["axes_b"]) };
        let pose =
            pose(vector(&case["separation"]), attitude(&case["angles_a"]), attitude(&case["angles_b"]));
        for path in VectorPath::available() {
            for method in [Method::Surface, Method::Focal] {
                let Outcome { f, energy, .. } = bodies.evaluate(method, 1e-15, path, &pose).unwrap();
                let name = format!("{} by {method}, {path:?}", case["name"]);
                let force = vector(&case["force_on_a_inertial"]);
                within(relative(&f.force_on_first, &force), 3e-15, format!("force of {name}"));
                within(
                    (energy / number(&case["potential_energy"]) - 1.0).abs(),
                    2e-15,
                    format!("energy of {name}"),
                );
                for (torque, key) in
                    [(f.torque_first, "torque_on_a_body"), (f.torque_second, "torque_on_b_body")]
                {
                    let expected = vector(&case[key]);
                    // The terms of a torque are of the size of lever times force, which may be much larger
                    // than the torque; their rounding limits its precision.
                    let (lever_times_force, error) =
                        (force.norm() * bodies.size(), (torque - expected).norm());
                    let rounding = 0.5 * f64::EPSILON * lever_times_force / expected.norm();
                    within(error / expected.norm(), 1e-12 + rounding, format!("{key} of {name}"));
                    within(error / lever_times_force, 1e-15, format!("{key} of {name} in lever times force"));
                }
            }
        }
    }
}

#[test]
fn thin_and_tiny_bodies() {
    // tests/data/make_thin_forces.py computes the values with 40 digits. The force across a thin body is a
    // small difference of pressures, and the torque on a small body is a small fraction of the force times
    // the distance of the centres.
    for case in data("thin_forces.json").as_array().unwrap() {
        let bodies = Bodies { a: triple(&case["axes_a"]), b: triple(&case["axes_b"]) };
        let pose =
            pose(vector(&case["separation"]), attitude(&case["angles_a"]), attitude(&case["angles_b"]));
        let f = Interaction {
            force_on_first: vector(&case["force_on_a_inertial"]),
            torque_first: vector(&case["torque_on_a_body"]),
            torque_second: vector(&case["torque_on_b_body"]),
        };
        let expected = Outcome { f, energy: number(&case["potential_energy"]), integrated: 0, nodes: 0 };
        for path in VectorPath::available() {
            for method in [Method::Surface, Method::Focal] {
                let actual = bodies.evaluate(method, 1e-14, path, &pose).unwrap();
                same_by_own_levers(&actual, &expected, &bodies, 1e-14, format!("{}, {method}", case["name"]));
            }
        }
    }
}

#[test]
fn hard_shapes_by_both_rules() {
    let (sphere, needle, disc, blade) = ([0.7; 3], [0.02, 1.0, 0.02], [1.0, 0.02, 1.0], [1.0, 0.3, 0.02]);
    let almost_sphere = [1.0, 1.0 - 2e-13, 1.0 - 1e-13];
    let unit_pose =
        pose(Vec3::new(0.6, -0.48, 0.64), attitude_of([0.3, -0.4, 1.2]), attitude_of([-0.9, 0.2, 2.0]));
    for (a, b) in [
        (needle, disc),
        (needle, needle),
        (disc, disc),
        (blade, needle),
        (disc, sphere),
        (sphere, blade),
        (almost_sphere, disc),
        (almost_sphere, sphere),
        (almost_sphere, almost_sphere),
    ] {
        let bodies = Bodies { a, b };
        for factor in [1.5, 3.0, 30.0, 1e6] {
            let pose = bodies.apart(&unit_pose, factor);
            // Only crossed needles and rims that are three thicknesses apart may fail to converge at the
            // default tolerance.
            let refused = |error| assert!(pose.separation.norm() < bodies.size(), "{a:?} and {b:?}: {error}");
            let best = bodies.fixed(Method::Focal, Order::focal([400; 2]), &pose);
            for (method, tolerance) in [(Method::Focal, 1e-14), (Method::Surface, 3e-14)] {
                // The surface rule's forces are differences of pressures on faces fifty times too large.
                match bodies.evaluate(method, 1e-14, VectorPath::Auto, &pose) {
                    Ok(o) => {
                        same(&o, &best, 1.0, tolerance, &format!("{method}, {a:?} and {b:?} at {factor}"))
                    }
                    Err(error) => refused(error),
                }
            }
        }
    }
}

#[test]
fn long_rules_lose_no_digits() {
    // In a plain sum of tens of thousands of nearly equal terms all rounding errors would have the same sign.
    let unit_pose =
        pose(Vec3::new(0.6, -0.48, 0.64), attitude_of([0.3, -0.4, 1.2]), attitude_of([-0.9, 0.2, 2.0]));
    for (a, b) in [([1.0, 0.8, 0.5], [0.9, 0.6, 0.55]), ([1.0, 0.02, 1.0], [0.02, 1.0, 0.02])] {
        let bodies = Bodies { a, b };
        for factor in [3.0, 30.0] {
            let pose = bodies.apart(&unit_pose, factor);
            for (method, order) in
                [(Method::Focal, Order::focal([400; 2])), (Method::Surface, Order::surface(240))]
            {
                let short = bodies.best(method, &pose);
                for path in VectorPath::available() {
                    let long = run(bodies.shapes(), method, 1e-15, Some(order), path, &pose).unwrap();
                    assert!(long.nodes > 25_000 && short.nodes < 5_000, "{} and {}", long.nodes, short.nodes);
                    same(
                        &long,
                        &short,
                        1.0,
                        4e-15,
                        &format!("{method} {path:?}, {a:?} and {b:?} at {factor}"),
                    );
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn degree_two_is_maccullagh(bodies in any_bodies(0.2), pose in any_pose(), power in 0.0..4.0f64) {
        let pose = bodies.apart(&pose, 1.0 + 10f64.powf(power));
        let expected = maccullagh(&bodies, &pose);
        let actual = bodies.best(Method::Multipole(2), &pose);
        same(&actual, &expected, bodies.size().powi(2) / pose.separation.norm(), 1e-14, "MacCullagh");
    }
}

/// Returns MacCullagh's approximation: the energy is -1/r minus the sum over both bodies of
/// [tr I - 3 n.I n] / (2 r^3), with I the inertia tensor of unit mass. Force and torques are its derivatives.
fn maccullagh(bodies: &Bodies, pose: &Pose) -> Outcome {
    let r = pose.separation.norm();
    let n = pose.separation / r;
    let (mut energy, mut force) = (-1.0 / r, n / (r * r));
    let mut torques = [Vec3::zeros(); 2];
    for (k, rotation) in [pose.rotation_first, pose.rotation_second].into_iter().enumerate() {
        let [a, b, c] = bodies.axes()[k].map(|v| v * v);
        let inertia =
            rotation * Mat3::from_diagonal(&(Vec3::new(b + c, c + a, a + b) / 5.0)) * rotation.transpose();
        let (trace, along) = (inertia.trace(), n.dot(&(inertia * n)));
        energy -= (trace - 3.0 * along) / (2.0 * r.powi(3));
        // The force on the first body is towards the second.
        force += (1.5 * (trace - 5.0 * along) * n + 3.0 * (inertia * n)) / r.powi(4);
        torques[k] = rotation.transpose() * (3.0 / r.powi(3) * n.cross(&(inertia * n)));
    }
    let f = Interaction { force_on_first: force, torque_first: torques[0], torque_second: torques[1] };
    Outcome { f, energy, integrated: 0, nodes: 0 }
}

#[test]
fn error_of_the_series_falls_as_theory_says() {
    let bodies = Bodies { a: [1.0, 0.8, 0.5], b: [0.9, 0.6, 0.55] };
    let unit_pose =
        pose(Vec3::new(0.6, -0.48, 0.64), attitude_of([0.3, -0.4, 1.2]), attitude_of([-0.9, 0.2, 2.0]));
    for degree in [2, 4, 6, 8] {
        let error = |r: f64| {
            let pose = Pose { separation: unit_pose.separation * r, ..unit_pose };
            let (exact, series) =
                (bodies.best(Method::Focal, &pose), bodies.best(Method::Multipole(degree), &pose));
            let torque = (series.f.torque_first - exact.f.torque_first).norm() / exact.f.torque_first.norm();
            [
                relative(&series.f.force_on_first, &exact.f.force_on_first),
                torque,
                (series.energy / exact.energy - 1.0).abs(),
            ]
        };
        // These distances are so large that the first omitted term dominates the error, and so small that the
        // error is above round-off.
        let (near, far): (f64, f64) = if degree < 6 { (12.0, 24.0) } else { (7.0, 11.0) };
        let slopes = [0, 1, 2].map(|i| (error(near)[i] / error(far)[i]).ln() / (far / near).ln());
        let n = degree as f64;
        // The torque begins with degree 2, so that its relative error falls by two powers less.
        for (slope, expected) in slopes.into_iter().zip([n + 2.0, n, n + 2.0]) {
            assert!((slope - expected).abs() < 0.3, "degree {degree}: {slopes:?}, expected {expected}");
        }
    }
}

#[test]
fn highest_degree_reaches_round_off() {
    let bodies = Bodies { a: [1.0, 0.8, 0.5], b: [0.9, 0.6, 0.55] };
    let pose = pose(Vec3::new(6.0, -4.8, 6.4), attitude_of([0.3, -0.4, 1.2]), attitude_of([-0.9, 0.2, 2.0]));
    same(
        &bodies.best(Method::Multipole(16), &pose),
        &bodies.best(Method::Focal, &pose),
        0.1,
        1e-14,
        "degree 16",
    );
}

#[test]
fn spheres_and_points_pull_like_points() {
    let separation = Vec3::new(3.0, -1.0, 2.5);
    let r = separation.norm();
    let pose = pose(separation, attitude_of([0.3, 1.1, -2.0]), attitude_of([1.3, -0.1, 0.4]));
    let (large, small) = (Shape::sphere(2.0).unwrap(), Shape::sphere(0.3).unwrap());
    for shapes in [
        [&large, &small],
        [&small, &large],
        [&large, &Shape::Point],
        [&Shape::Point, &small],
        [&Shape::Point, &Shape::Point],
    ] {
        for method in [Method::Surface, Method::Focal, Method::Multipole(4), Method::Point] {
            let Outcome { f, energy, .. } =
                run(shapes.map(Shape::clone), method, 1e-15, None, VectorPath::Auto, &pose).unwrap();
            close_vector(&f.force_on_first, &(separation / (r * r * r)), 4e-15);
            close(energy, -1.0 / r, 2e-15);
            for torque in [f.torque_first, f.torque_second] {
                within(torque.norm() * r * r, 4e-15, format!("torque of {shapes:?} by {method}"));
            }
        }
    }
}

#[test]
fn the_papers_own_check_a_point_masss_potential_over_a_spheroid() {
    // The potential of a point mass, integrated over the surface of the spheroid, has to give MacMillan's
    // field and potential at the point: appendix of Ho et al. (2021).
    let (a, c) = (1.0, 0.4);
    let spheroid = Shape::ellipsoid([a, a, c]).unwrap();
    for x in [[1.3, 0.4, 0.7], [0.0, 0.0, 0.9], [1.5, 0.0, 0.0], [-0.7, 0.9, -0.8], [4.0, -3.0, 2.0]] {
        let x = Vec3::from(x);
        let rotation = attitude_of([0.4, 0.9, -1.3]);
        let (potential, field) = paper_oblate([a, c], &x);
        let pose = pose(rotation * -x, Mat3::identity(), rotation);
        for (method, tolerance) in [(Method::Surface, 3e-14), (Method::Focal, 3e-14)] {
            // The first body is the point, of unit mass: the force on it is the field of the spheroid.
            let Outcome { f, energy, nodes, .. } =
                run([Shape::Point, spheroid.clone()], method, 1e-15, None, VectorPath::Auto, &pose).unwrap();
            assert!(nodes > 20 || method == Method::Focal, "an integral over {nodes} nodes");
            close_vector(&f.force_on_first, &(rotation * field), tolerance);
            close(energy, -potential, tolerance);
            within(f.torque_first.norm() / field.norm(), 1e-14, "torque on a point");
            // The torque on the spheroid, in its body frame, is that of the opposite force at x.
            within(
                (f.torque_second + x.cross(&field)).norm() / (x.norm() * field.norm()),
                tolerance,
                "torque",
            );
        }
    }
}
