//! Bodies of several parts: their gravity by links between the parts, contact, descriptions in JSON, and
//! errors.

use crate::support::*;
use fullbody::gravity::BodyAttraction;
use fullbody::interrupt::InterruptCheck;
use fullbody::math::lanes::VectorPath;
use fullbody::math::{Mat3, Vec3};
use fullbody::mutual::{Interaction, Link, Method, Pose, PredictedMotion};
use fullbody::shape::{Body, InputPart, Proximity, Shape};
use proptest::prelude::*;
use std::sync::Arc;

const NO_ROTATION: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

fn part(axes: [f64; 3], mass: f64, position: [f64; 3]) -> InputPart {
    InputPart { shape: Shape::ellipsoid(axes).unwrap(), mass, position, attitude: NO_ROTATION }
}

/// Returns a ball with a thin arm, whose end is far from the centre of mass.
fn club() -> Body {
    let parts = vec![part([1.0; 3], 5.0, [0.0; 3]), part([0.4, 0.2, 0.1], 0.05, [3.0, 0.0, 0.0])];
    Body::composite("club", parts).unwrap()
}

fn links(bodies: [&Body; 2], method: Method) -> Vec<Link> {
    let [first, second] = Link::parts_of(bodies, method);
    let arch = VectorPath::Auto.arch().unwrap();
    let parts = (0..first).flat_map(|a| (0..second).map(move |b| [a, b]));
    parts.map(|parts| Link::new(bodies, parts, method, 1e-14, None, arch, &Arc::default())).collect()
}

fn about_z(angle: f64) -> Mat3 {
    rotation_about(&Vec3::z(), angle)
}

/// A quadrature rule is valid down to a distance of the parts, which changes with the rotation of the bodies.
#[test]
fn whether_a_rule_holds_is_asked_of_the_parts() {
    let stone = Body::with_mass("stone", Shape::ellipsoid([0.5, 0.3, 0.2]).unwrap(), 0.3).unwrap();
    let (club, unrotated) = (club(), Mat3::identity());
    let at = |angle| Pose {
        separation: Vec3::new(0.0, 4.2, 0.0),
        rotation_first: about_z(angle),
        rotation_second: unrotated,
    };
    let predicted =
        |angle| PredictedMotion { reach: 4.2, rotation_angles: [angle, 0.0], growth: f64::INFINITY };
    let mut arm = links([&club, &stone], Method::Focal).swap_remove(1);
    arm.prepare(&at(-0.3), Some(&predicted(0.0)), &mut InterruptCheck::never()).unwrap();
    assert!(arm.too_near(&at(-0.3)).is_none());
    // At this angle the distance from the arm's end to the stone is 1.2 instead of more than 4.9.
    let near = arm.too_near(&at(1.5)).unwrap();
    close(
        near.separation,
        (at(1.5).separation - about_z(1.5) * Vec3::x() * club.parts()[1].position().x).norm(),
        1e-12,
    );
    assert!(near.separation < near.valid_from);
    // The rule is valid over the whole rotation that was predicted when it was chosen.
    arm.prepare(&at(0.3), Some(&predicted(0.7)), &mut InterruptCheck::never()).unwrap();
    for angle in [0.3, 0.5, 0.8, 1.0] {
        assert!(arm.too_near(&at(angle)).is_none(), "{angle}");
    }
}

/// Returns the sums of the interactions and of the energies over all links.
fn total(links: &mut [Link], pose: &Pose) -> (Interaction, f64) {
    let zero = Interaction {
        force_on_first: Vec3::zeros(),
        torque_first: Vec3::zeros(),
        torque_second: Vec3::zeros(),
    };
    links.iter_mut().fold((zero, 0.0), |(sum, energy), link| {
        link.prepare(pose, None, &mut InterruptCheck::never()).unwrap();
        let f = link.interaction(pose);
        let sum = Interaction {
            force_on_first: sum.force_on_first + f.force_on_first,
            torque_first: sum.torque_first + f.torque_first,
            torque_second: sum.torque_second + f.torque_second,
        };
        (sum, energy + link.potential_energy(pose))
    })
}

proptest! {
    #![proptest_config(cases(24))]

    /// The force is the energy's gradient, and both torques balance the force's lever, by every method.
    #[test]
    fn force_torque_and_energy_belong_together(
        a in turn(), b in turn(), direction in direction(), distance in 5.5..40.0f64,
    ) {
        let two =
            vec![part([0.9, 0.7, 0.5], 1.0, [0.7, 0.1, 0.0]), part([0.3, 0.2, 0.2], -0.1, [0.5, 0.1, 0.0])];
        let bodies = [club(), Body::composite("two", two).unwrap()];
        let pose = Pose { separation: direction * distance, rotation_first: a, rotation_second: b };
        for method in [Method::Focal, Method::Surface, Method::Multipole(6)] {
            let mut links = links([&bodies[0], &bodies[1]], method);
            prop_assert_eq!(links.len(), 4);
            let (f, _) = total(&mut links, &pose);
            let size = f.force_on_first.norm();
            let balance = a * f.torque_first + b * f.torque_second - pose.separation.cross(&f.force_on_first);
            prop_assert!(balance.norm() < 1e-13 * size * distance, "{method}: {balance}");
            let step = 1e-4 * distance;
            let energy = |steps: f64, axis: Vec3| {
                let moved = Pose { separation: pose.separation + axis * (steps * step), ..pose };
                links.iter().map(|link| link.potential_energy(&moved)).sum::<f64>()
            };
            for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
                let slope = (8.0 * (energy(1.0, axis) - energy(-1.0, axis))
                    - (energy(2.0, axis) - energy(-2.0, axis)))
                    / (12.0 * step);
                prop_assert!((slope - f.force_on_first.dot(&axis)).abs() < 1e-9 * size, "{method}: {slope}");
            }
        }
    }

    /// The scale factor at which two bodies touch is the smallest one of all pairs of parts, hidden ones
    /// included.
    #[test]
    fn contact_is_of_the_nearest_parts(
        a in turn(), b in turn(), direction in direction(), distance in 1.0..12.0f64,
    ) {
        let mut parts =
            vec![part([1.0, 0.6, 0.4], 2.0, [1.3, 0.0, 0.0]), part([0.8, 0.7, 0.6], 1.0, [-1.0, 0.3, 0.2])];
        parts.push(part([0.1, 0.2, 0.1], -0.01, [1.2, 0.1, 0.0]));
        let body = Body::composite("body", parts).unwrap();
        prop_assert_eq!(body.outer_parts().count(), 2);
        let separation = direction * distance;
        let proximity =
            Proximity::compute([&body, &body], &separation, [&a, &b], 0.0, &mut InterruptCheck::never()).unwrap();
        let mut least = f64::INFINITY;
        for first in body.parts() {
            for second in body.parts() {
                let r = separation + b * second.position() - a * first.position();
                least = least.min(
                    growth(
                        &first.shape,
                        &second.shape,
                        &r,
                        &(a * first.rotation()),
                        &(b * second.rotation()),
                    )
                    .factor,
                );
            }
        }
        prop_assert_eq!(proximity.overlap, least < 1.0);
        if proximity.factor < 2.0 {
            close(proximity.factor, least, 1e-12);
        } else {
            prop_assert!(proximity.factor <= least * (1.0 + 1e-12) && least > 1.0);
        }
        prop_assert!(distance < 2.0 * body.circumradius() || !proximity.overlap);
    }

    /// The attraction agrees with the exterior field minus that of a point, at distances where the difference
    /// is accurate.
    #[test]
    fn the_pull_of_a_composite(direction in direction(), distance in 4.0..60.0f64) {
        let body = club();
        let field = FieldOf::new(&body, 1.0 / body.mass());
        let mut attraction = BodyAttraction::new(&body).unwrap();
        let x = direction * distance;
        let g = field.field(&x).unwrap();
        let (perturbation, moment) = attraction.at(&x, distance.powi(-2), distance.powi(-3), 1.0).unwrap();
        prop_assert!((perturbation - (g + x / distance.powi(3))).norm() < 2e-15 * g.norm());
        prop_assert!((moment - x.cross(&g)).norm() < 3e-15 * g.norm() * distance);
    }
}

#[test]
fn a_description_makes_the_same_body() {
    let text = serde_json::to_string(&club()).unwrap();
    assert_eq!(serde_json::from_str::<Body>(&text).unwrap(), club());
    assert!(
        text.starts_with(r#"{"name":"club","parts":[{"semi_axes":[1.0,1.0,1.0],"mass":5.0,"position":[0.0"#),
        "{text}"
    );
    let ordinary = Body::with_mass("ball", Shape::sphere(2.0).unwrap(), 3.0).unwrap();
    let text = serde_json::to_string(&ordinary).unwrap();
    assert_eq!(text, r#"{"name":"ball","semi_axes":[2.0,2.0,2.0],"mass":3.0}"#);
    assert_eq!(serde_json::from_str::<Body>(&text).unwrap(), ordinary);
    for damaged in [
        r#"{"name":"club","parts":[]}"#,
        r#"{"name":"club"}"#,
        r#"{"name":"club","mass":3.0}"#,
        r#"{"name":"club","parts":[{"semi_axes":null,"mass":1.0,"position":[0,0,0],"attitude":[1,0,0,0]}],"mass":3.0}"#,
        r#"{"name":"club","parts":[{"semi_axes":[1,1,1],"mass":-1.0,"position":[0,0,0],"attitude":[1,0,0,0]}]}"#,
        r#"{"name":"club","parts":[{"semi_axes":[1,1,1],"mass":1.0,"position":[0,0,0],"attitude":[0,0,0,0]}]}"#,
        r#"{"name":"club","semi_axes":[1,1,1],"mass":-1.0}"#,
    ] {
        assert!(serde_json::from_str::<Body>(damaged).is_err(), "{damaged}");
    }
}

#[test]
fn numbers_that_make_no_body() {
    let body = |parts| refusal(Body::composite("B", parts));
    let ball = |mass, x| part([1.0; 3], mass, [x, 0.0, 0.0]);
    for (text, parts) in [
        ("number of parts of B is 0", vec![]),
        ("mass of part 1 of B is 0", vec![ball(1.0, 0.0), ball(0.0, 0.0)]),
        ("mass of part 0 of B is NaN", vec![ball(f64::NAN, 0.0)]),
        ("position of part 0 of B, component 0, is inf", vec![ball(1.0, f64::INFINITY)]),
        ("mass of B, the sum of its parts', is -1", vec![ball(1.0, 0.0), ball(-2.0, 0.0)]),
        ("moments of inertia of B is [-", vec![ball(1.0, 0.0), part([2.0; 3], -0.9, [0.0; 3])]),
        // A disc with a needle-shaped void has a larger moment about z than about x and y together.
        (
            "none above the sum of the other two",
            vec![part([2.0, 2.0, 0.1], 2.0, [0.0; 3]), part([0.1, 0.1, 2.0], -0.3, [0.0; 3])],
        ),
    ] {
        let message = body(parts);
        assert!(message.contains(text), "{message}");
    }
}

/// Of 8,000 spheres the outer ones are determined without comparing all pairs.
#[test]
fn hidden_parts_of_a_heap() {
    let side = 20;
    let spheres = |k: usize| {
        let position = [k % side, k / side % side, k / side / side].map(|c| 2.0 * c as f64);
        // Of the two spheres at each position the smaller one is inside the other, in either order.
        let ball = |radius: f64, mass| InputPart {
            shape: Shape::sphere(radius).unwrap(),
            mass,
            position,
            attitude: [1.0, 0.0, 0.0, 0.0],
        };
        if k.is_multiple_of(2) { [ball(1.0, 1.0), ball(0.4, 0.5)] } else { [ball(0.4, 0.5), ball(1.0, 1.0)] }
    };
    let parts: Vec<InputPart> = (0..side * side * side / 2).flat_map(spheres).collect();
    let count = parts.len() / 2;
    let body = Body::composite("heap", parts).unwrap();
    assert_eq!(body.outer_parts().count(), count);
    assert!(body.outer_parts().all(|part| part.shape == Shape::sphere(1.0).unwrap()));
    // The first of two parts that coincide is an outer one, and so is a part that protrudes from another one.
    let part = |axes, x| InputPart {
        shape: Shape::ellipsoid(axes).unwrap(),
        mass: 1.0,
        position: [x, 0.0, 0.0],
        attitude: [1.0, 0.0, 0.0, 0.0],
    };
    let parts = vec![part([2.0, 1.0, 1.0], 0.0), part([2.0, 1.0, 1.0], 0.0), part([1.0, 0.5, 0.5], 1.5)];
    assert_eq!(Body::composite("lobes", parts).unwrap().outer_parts().count(), 2);
}
