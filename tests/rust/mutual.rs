//! The interaction of a pair against the laws of mechanics, by every method; its rules and refusals.

use crate::support::*;
use fullbody::error::{Error, Result};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::lanes::VectorPath;
use fullbody::math::{Mat3, Vec3};
use fullbody::mutual::{Interaction, Method, Pair, PartGravity, Pose};
use fullbody::quadrature::Order;
use fullbody::shape::Shape;
use proptest::prelude::*;
use std::fmt::Display;
use std::sync::Arc;

/// Two ellipsoids.
#[derive(Debug, Clone, Copy)]
pub struct Bodies {
    pub a: [f64; 3],
    pub b: [f64; 3],
}

/// One evaluation.
#[derive(Debug, Clone)]
pub struct Outcome {
    pub f: Interaction,
    pub energy: f64,
    pub integrated: usize,
    pub nodes: usize,
}

pub fn pose(separation: Vec3, rotation_first: Mat3, rotation_second: Mat3) -> Pose {
    Pose { separation, rotation_first, rotation_second }
}

impl Bodies {
    pub fn axes(&self) -> [[f64; 3]; 2] {
        [self.a, self.b]
    }

    /// The largest semi-axis: the lever of a torque.
    pub fn size(&self) -> f64 {
        self.a.into_iter().chain(self.b).fold(0.0, f64::max)
    }

    /// One, and the largest semi-axis of either body.
    pub fn levers(&self) -> [f64; 3] {
        let longest = |axes: [f64; 3]| axes.into_iter().fold(0.0, f64::max);
        [1.0, longest(self.a), longest(self.b)]
    }

    pub fn shapes(&self) -> [Shape; 2] {
        self.axes().map(|axes| Shape::ellipsoid(axes).unwrap())
    }

    /// The pose with its separation scaled to `factor` times that of contact.
    pub fn apart(&self, pose: &Pose, factor: f64) -> Pose {
        let [a, b] = self.shapes();
        let f = contact_function(&a, &b, &pose.separation, &pose.rotation_first, &pose.rotation_second);
        Pose { separation: pose.separation * (factor / f.sqrt()), ..*pose }
    }

    pub fn evaluate(&self, method: Method, tolerance: f64, path: VectorPath, pose: &Pose) -> Result<Outcome> {
        run(self.shapes(), method, tolerance, None, path, pose)
    }

    pub fn fixed(&self, method: Method, order: Order, pose: &Pose) -> Outcome {
        run(self.shapes(), method, 1e-15, Some(order), VectorPath::Auto, pose).unwrap()
    }

    pub fn best(&self, method: Method, pose: &Pose) -> Outcome {
        self.evaluate(method, 1e-15, VectorPath::Auto, pose).unwrap()
    }
}

pub fn pair(
    shapes: [Shape; 2],
    method: Method,
    tolerance: f64,
    order: Option<Order>,
    path: VectorPath,
) -> Pair {
    let ([a, b], store) = (shapes, Arc::default());
    let (a, b) = (PartGravity::new("Alpha", &a, &store), PartGravity::new("Beta", &b, &store));
    Pair::new(a, b, method, tolerance, order, path.arch().unwrap())
}

pub fn run(
    shapes: [Shape; 2],
    method: Method,
    tolerance: f64,
    order: Option<Order>,
    path: VectorPath,
    pose: &Pose,
) -> Result<Outcome> {
    let mut pair = pair(shapes, method, tolerance, order, path);
    pair.prepare(pose, 0.0, &mut InterruptCheck::never())?;
    let (integrated, nodes) = pair.rule().map_or((0, 0), |rule| (rule.integrated, rule.nodes()));
    Ok(Outcome { f: pair.interaction(pose), energy: pair.potential_energy(pose), integrated, nodes })
}

/// Differences of two evaluations: the force relative to its size, the torques relative to the lever's share
/// of it.
#[track_caller]
pub fn same(actual: &Outcome, expected: &Outcome, lever: f64, tolerance: f64, what: &str) {
    let force = expected.f.force_on_first.norm();
    within(
        (actual.f.force_on_first - expected.f.force_on_first).norm() / force,
        tolerance,
        format!("force, {what}"),
    );
    let share = force * lever;
    within(
        (actual.f.torque_first - expected.f.torque_first).norm() / share,
        tolerance,
        format!("torque on A, {what}"),
    );
    within(
        (actual.f.torque_second - expected.f.torque_second).norm() / share,
        tolerance,
        format!("torque on B, {what}"),
    );
    within((actual.energy / expected.energy - 1.0).abs(), tolerance, format!("energy, {what}"));
}

/// The same with each torque relative to the force times its own body's largest semi-axis, be the other body
/// ever so large.
#[track_caller]
pub fn same_by_own_levers(
    actual: &Outcome,
    expected: &Outcome,
    bodies: &Bodies,
    tolerance: f64,
    what: impl Display,
) {
    let force = expected.f.force_on_first.norm();
    let [a, b] = bodies.axes().map(|axes| axes.into_iter().fold(0.0, f64::max));
    for (quantity, difference, scale) in [
        ("force", actual.f.force_on_first - expected.f.force_on_first, force),
        ("torque on A", actual.f.torque_first - expected.f.torque_first, force * a),
        ("torque on B", actual.f.torque_second - expected.f.torque_second, force * b),
    ] {
        within(difference.norm() / scale, tolerance, format!("{quantity}, {what}"));
    }
    within((actual.energy / expected.energy - 1.0).abs(), tolerance, format!("energy, {what}"));
}

/// Discs, needles, blades, and spheres, down to a ratio of the axes of 1e-7 and a ratio of the sizes of 1e-6.
pub fn thin_bodies() -> impl Strategy<Value = Bodies> {
    let shape = || {
        (0.0..7.0f64, 0.0..1.0f64, 0..5usize).prop_map(|(thin, share, kind)| {
            let (c, b) = (10f64.powf(-thin), 10f64.powf(-thin * share));
            [[1.0, 1.0, c], [c, 1.0, c], [b, c, 1.0], [1.0, c, 1.0 - 0.5 * b], [1.0; 3]][kind]
        })
    };
    (shape(), shape(), -6.0..0.0f64, prop::bool::ANY).prop_map(|(a, b, size, swapped)| {
        let b = b.map(|v| v * 10f64.powf(size));
        if swapped { Bodies { a: b, b: a } } else { Bodies { a, b } }
    })
}

pub fn any_bodies(flattest: f64) -> impl Strategy<Value = Bodies> {
    (semi_axes(flattest), semi_axes(flattest), 0.1..1.0f64)
        .prop_map(|(a, b, size)| Bodies { a, b: b.map(|v| v * size) })
}

pub fn any_pose() -> impl Strategy<Value = Pose> {
    (direction(), turn(), turn()).prop_map(|(u, a, b)| pose(u, a, b))
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn surface_and_focal_agree_from_contact_to_a_million_radii(
        bodies in any_bodies(0.2), pose in any_pose(), power in -1.7..6.0f64,
    ) {
        let pose = bodies.apart(&pose, 1.0 + 10f64.powf(power));
        let (surface, focal) = (bodies.best(Method::Surface, &pose), bodies.best(Method::Focal, &pose));
        // Next to contact the surface rule adds up tens of thousands of terms.
        let tolerance = if power < 0.0 { 1e-13 } else { 1e-14 };
        same(&surface, &focal, bodies.size(), tolerance, &format!("distance 1 + 1e{power}"));
        // Far away the torques are smaller than lever times force by size / r. The body that is integrated
        // over has its torque as the difference of attractions on either side, with their round-off; by the
        // focal rule the other one loses nothing.
        let r = pose.separation.norm();
        if r > 30.0 * bodies.size() {
            let series = bodies.best(Method::Multipole(16), &pose);
            same(&focal, &series, bodies.size(), 1e-14, "focal and series");
            let torque = |o: &Outcome| [o.f.torque_first, o.f.torque_second][1 - focal.integrated];
            let share = series.f.force_on_first.norm() * bodies.size() * (bodies.size() / r);
            within((torque(&focal) - torque(&series)).norm() / share, 1e-14, "torque on the field body");
        }
    }

    #[test]
    fn torques_and_force_balance(bodies in any_bodies(0.05), pose in any_pose(), power in -1.5..6.0f64) {
        let pose = bodies.apart(&pose, 1.0 + 10f64.powf(power));
        for method in [Method::Focal, Method::Multipole(6), Method::Multipole(2)] {
            let Outcome { f, .. } = bodies.best(method, &pose);
            let torques = pose.rotation_first * f.torque_first + pose.rotation_second * f.torque_second;
            // M_A + M_B + r x F_B = 0; the last term is the difference of two large numbers.
            let arm = pose.separation.norm() * f.force_on_first.norm();
            within(
                (torques - pose.separation.cross(&f.force_on_first)).norm() / arm,
                1e-14,
                format!("{method}"),
            );
        }
    }

    #[test]
    fn swapped_bodies_feel_the_opposite(
        bodies in any_bodies(0.1), there in any_pose(), power in -1.0..4.0f64,
    ) {
        let there = bodies.apart(&there, 1.0 + 10f64.powf(power));
        let back = pose(-there.separation, there.rotation_second, there.rotation_first);
        let swapped = Bodies { a: bodies.b, b: bodies.a };
        for method in [Method::Focal, Method::Surface, Method::Multipole(8), Method::Point] {
            let (first, mut second) = (bodies.best(method, &there), swapped.best(method, &back));
            let f = &mut second.f;
            f.force_on_first = -f.force_on_first;
            std::mem::swap(&mut f.torque_first, &mut f.torque_second);
            same(&second, &first, bodies.size(), 1e-14, &format!("{method}"));
        }
    }

    #[test]
    fn turning_everything_turns_the_force_alone(
        bodies in any_bodies(0.1), pose in any_pose(), frame in turn(), power in -1.0..4.0f64,
    ) {
        let pose = bodies.apart(&pose, 1.0 + 10f64.powf(power));
        let turned = Pose {
            separation: frame * pose.separation,
            rotation_first: frame * pose.rotation_first,
            rotation_second: frame * pose.rotation_second,
        };
        for method in [Method::Focal, Method::Surface, Method::Multipole(8)] {
            let (mut expected, actual) = (bodies.best(method, &pose), bodies.best(method, &turned));
            expected.f.force_on_first = frame * expected.f.force_on_first;
            same(&actual, &expected, bodies.size(), 1e-14, &format!("{method}"));
        }
    }

    #[test]
    fn lengths_scale_out(
        bodies in any_bodies(0.1), pose in any_pose(), power in -1.0..3.0f64, scale in -20..20i32,
    ) {
        let pose = bodies.apart(&pose, 1.0 + 10f64.powf(power));
        let scale = 10f64.powi(scale);
        let large = Bodies { a: bodies.a.map(|v| v * scale), b: bodies.b.map(|v| v * scale) };
        let far = Pose { separation: pose.separation * scale, ..pose };
        for method in [Method::Focal, Method::Surface, Method::Multipole(4)] {
            let (expected, mut actual) = (bodies.best(method, &pose), large.best(method, &far));
            actual.f.force_on_first *= scale * scale;
            actual.f.torque_first *= scale;
            actual.f.torque_second *= scale;
            actual.energy *= scale;
            same(&actual, &expected, bodies.size(), 1e-14, &format!("{method}"));
        }
    }

    #[test]
    fn nearly_equal_axes_are_the_limit_of_equal_ones(
        c in 0.1..1.0f64, long in prop::bool::ANY, pose in any_pose(), power in -1.0..3.0f64,
    ) {
        // The spheroid (1, 1, c) or (c, c, 1), and the triaxial body beside it.
        let spheroid = if long { [c, c, 1.0] } else { [1.0, 1.0, c] };
        let other = [0.4, 0.3, 0.35];
        let triaxial = [spheroid[0] * (1.0 + 1e-13), spheroid[1], spheroid[2]];
        let pose = Bodies { a: spheroid, b: other }.apart(&pose, 1.0 + 10f64.powf(power));
        for method in [Method::Focal, Method::Surface] {
            let exact = Bodies { a: spheroid, b: other }.best(method, &pose);
            let limit = Bodies { a: triaxial, b: other }.best(method, &pose);
            same(&limit, &exact, 1.0, 2e-13, &format!("{method}"));
        }
    }

    #[test]
    fn force_and_torques_are_the_slopes_of_the_energy(
        bodies in any_bodies(0.1), pose in any_pose(), distance in 1.4..4.0f64,
    ) {
        let pose = bodies.apart(&pose, distance);
        // Eighth-order differences of small moves, with the rule held fixed.
        const WEIGHTS: [f64; 4] = [0.8, -0.2, 4.0 / 105.0, -1.0 / 280.0];
        let r = pose.separation.norm();
        for method in [Method::Focal, Method::Surface] {
            let mut pair = pair(bodies.shapes(), method, 1e-15, None, VectorPath::Auto);
            pair.prepare(&pose, 0.1, &mut InterruptCheck::never()).unwrap();
            let slope = |move_by: &dyn Fn(f64) -> Pose, h: f64| {
                let energy = |s: f64| pair.potential_energy(&move_by(s));
                (1..=4)
                    .zip(WEIGHTS)
                    .map(|(k, w)| w * (energy(f64::from(k) * h) - energy(-f64::from(k) * h)) / h)
                    .sum::<f64>()
            };
            let f = pair.interaction(&pose);
            let (h, force) = (0.01 * (distance - 1.0) * r / distance, f.force_on_first.norm());
            let unit = [Vec3::x(), Vec3::y(), Vec3::z()];
            // Moving the second body away by s: dE/ds = -F_B = F_A.
            let moved = |s: Vec3| Pose { separation: pose.separation + s, ..pose };
            let gradient = Vec3::from(unit.map(|e| slope(&|s| moved(s * e), h)));
            let energy = pair.potential_energy(&pose).abs();
            let tolerance = 1e-11 + 3e-15 * energy / (h * force);
            within((gradient - f.force_on_first).norm() / force, tolerance, format!("force, {method}"));
            // Turning a body about its own axis e: dE/ds = -M . e.
            let h = 0.02 * (distance - 1.0).min(1.0);
            let first = |s: f64, e: &Vec3| Pose {
                rotation_first: pose.rotation_first * rotation_about(e, s),
                ..pose
            };
            let second = |s: f64, e: &Vec3| Pose {
                rotation_second: pose.rotation_second * rotation_about(e, s),
                ..pose
            };
            let on_first = Vec3::from(unit.map(|e| -slope(&|s| first(s, &e), h)));
            let on_second = Vec3::from(unit.map(|e| -slope(&|s| second(s, &e), h)));
            let tolerance = 1e-11 * force * bodies.size() + 3e-15 * energy / h;
            within((on_first - f.torque_first).norm() / tolerance, 1.0, format!("torque on A, {method}"));
            within((on_second - f.torque_second).norm() / tolerance, 1.0, format!("torque on B, {method}"));
        }
    }

}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn surface_and_focal_agree_for_thin_and_tiny_bodies(
        bodies in thin_bodies(), pose in any_pose(), power in -3.0..5.0f64,
    ) {
        let pose = bodies.apart(&pose, 1.0 + 10f64.powf(power));
        let what = format!("{bodies:?} at 1 + 1e{power}");
        let outcome = |method| bodies.evaluate(method, 1e-14, VectorPath::Auto, &pose);
        match [outcome(Method::Surface), outcome(Method::Focal)] {
            [Ok(surface), Ok(focal)] => same_by_own_levers(&surface, &focal, &bodies, 3e-14, &what),
            // Sharp rims and tips within each other's reach may be refused; nothing else.
            outcomes => prop_assert!(pose.separation.norm() < 2.0 * bodies.size(), "{what}: {outcomes:?}"),
        }
    }
}

pub fn attitude_of(angles: [f64; 3]) -> Mat3 {
    fullbody::math::rotation::tait_bryan_matrix(angles)
}

#[test]
fn contact_of_two_discs_edge_to_edge_does_not_converge_quietly() {
    let bodies = Bodies { a: [1.0, 1.0, 0.02], b: [1.0, 1.0, 0.02] };
    let edge = pose(Vec3::new(2.0001, 0.0, 0.0), Mat3::identity(), Mat3::identity());
    for method in [Method::Surface, Method::Focal] {
        match bodies.evaluate(method, 1e-15, VectorPath::Auto, &edge) {
            Err(Error::NotConverged { what, detail }) => {
                assert!(
                    what.contains("Alpha") && what.contains("Beta") && what.contains(&method.to_string()),
                    "{what}"
                );
                assert!(detail.contains("2.0001") && detail.contains("order="), "{detail}");
            }
            other => panic!("{method}: {other:?}"),
        }
    }
}

#[test]
fn close_bodies_without_a_torque_are_not_refused() {
    // By symmetry there is none, as in every system locked in its long axes: only its round-off is left to
    // compare.
    let bodies = Bodies { a: [1.0, 0.8, 0.5], b: [0.5, 0.4, 0.3] };
    for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
        for gap in [0.05, 0.2, 0.5, 1.0] {
            let pose = bodies.apart(&pose(axis, Mat3::identity(), Mat3::identity()), 1.0 + gap);
            let focal = bodies.evaluate(Method::Focal, 1e-15, VectorPath::Auto, &pose).unwrap();
            let surface = bodies.evaluate(Method::Surface, 1e-12, VectorPath::Auto, &pose).unwrap();
            same(&surface, &focal, 1.0, 2e-12, &format!("gap {gap} along {axis:?}"));
            for torque in [focal.f.torque_first, focal.f.torque_second] {
                within(torque.norm() / focal.f.force_on_first.norm(), 2e-15, "torque");
            }
        }
    }
}

#[test]
fn an_order_fixes_the_nodes() {
    let bodies = Bodies { a: [1.0, 0.8, 0.5], b: [0.5, 0.4, 0.3] };
    for d in [1.6, 3.0, 1e3] {
        let pose = pose(Vec3::x() * d, Mat3::identity(), Mat3::identity());
        for method in [Method::Surface, Method::Focal] {
            assert_eq!(bodies.fixed(method, Order { gauss: 9, angles: 14 }, &pose).nodes, 126);
        }
        assert_eq!(bodies.best(Method::Multipole(4), &pose).nodes, 0);
    }
}

#[test]
fn a_rule_is_kept_while_it_covers_and_renewed_closer_in() {
    let bodies = Bodies { a: [1.0, 0.8, 0.5], b: [0.5, 0.4, 0.3] };
    let mut pair = pair(bodies.shapes(), Method::Focal, 1e-15, None, VectorPath::Auto);
    let at = |d: f64| pose(Vec3::new(0.6, 0.64, 0.48) * d, attitude_of([0.3, -0.4, 1.2]), Mat3::identity());
    pair.prepare(&at(5.0), 0.05, &mut InterruptCheck::never()).unwrap();
    assert!(pair.covers(5.0) && pair.covers(4.8) && !pair.covers(2.0) && pair.covers(1e3));
    for d in [1e3, 60.0, 11.0, 4.0, 2.2, 1.7, 2.2, 4.0, 11.0, 60.0, 1e3] {
        // The history may choose another rule, not another result.
        pair.prepare(&at(d), 0.0, &mut InterruptCheck::never()).unwrap();
        let (f, energy) = (pair.interaction(&at(d)), pair.potential_energy(&at(d)));
        let visited = Outcome { f, energy, integrated: 0, nodes: 0 };
        same(&visited, &bodies.best(Method::Focal, &at(d)), 1.0, 1e-14, &format!("after a way to {d}"));
    }
    pair.reset();
    assert!(pair.rule().is_none());
}

#[test]
fn every_path_gives_the_same_interaction() {
    let bodies = Bodies { a: [0.5, 1.0, 0.8], b: [0.4, 0.3, 0.5] };
    for d in [1.8, 3.0, 40.0] {
        let pose =
            pose(Vec3::new(0.6, 0.64, 0.48) * d, attitude_of([0.3, -0.4, 1.2]), attitude_of([2.0, 0.1, 0.7]));
        for method in [Method::Surface, Method::Focal] {
            let portable = bodies.evaluate(method, 1e-15, VectorPath::Portable, &pose).unwrap();
            for path in VectorPath::available() {
                let other = bodies.evaluate(method, 1e-15, path, &pose).unwrap();
                same(&other, &portable, 1.0, 4e-15, &format!("{method} {path:?}"));
                let again = bodies.evaluate(method, 1e-15, path, &pose).unwrap();
                assert_eq!((again.f, again.energy), (other.f, other.energy));
            }
        }
    }
}

#[test]
fn methods_by_name() {
    for (text, method) in [
        ("surface", Method::Surface),
        ("focal", Method::Focal),
        ("harmonic", Method::Harmonic),
        ("multipole:2", Method::Multipole(2)),
        ("multipole:3", Method::Multipole(3)),
        ("multipole:60", Method::Multipole(60)),
        ("point", Method::Point),
    ] {
        assert_eq!(text.parse::<Method>().unwrap(), method);
        assert_eq!(method.to_string(), text);
    }
    for text in [
        "",
        "Surface",
        "multipole",
        "multipole:",
        "multipole:1",
        "multipole:0",
        "multipole:61",
        "multipole:-2",
        "multipole:2.0",
        "points",
    ] {
        let message = refusal(text.parse::<Method>());
        assert!(message.starts_with(&format!("gravity is {text:?}; expected \"surface\"")), "{message}");
    }
}
