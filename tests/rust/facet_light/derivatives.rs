//! Derivatives of the light of facets, by differences and by the closed forms of ellipsoids.

use super::{Scene, axis, body, facets, irregular, pair, photometer, product, rotated, solid};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::{Mat3, Vec3, rotation};
use fullbody::photometry::Law;
use fullbody::shape::{Body, InputPart, Shape};

/// Differences of fourth order with two steps; the nearer one counts, since the derivatives jump where facets
/// turn away.
fn assert_slope(of: impl Fn(f64) -> Vec<f64>, found: &[f64], what: &str) {
    let slope = |h: f64| {
        let [a, b, c, d] = [h, -h, 2.0 * h, -2.0 * h].map(&of);
        (0..a.len()).map(|i| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h)).collect::<Vec<_>>()
    };
    let all = [3e-4, 3e-5, 4e-6].map(slope);
    for (body, found) in found.iter().enumerate() {
        let error = all.iter().map(|s| (s[body] - found).abs()).fold(f64::INFINITY, f64::min);
        assert!(error < 3e-8, "{what}, body {body}: {} {found}", all[1][body]);
    }
}

fn assert_derivatives(bodies: &[Body], scene: &Scene, law: Law) {
    let partials = photometer(bodies, law).partials(&scene.view(), &mut InterruptCheck::never()).unwrap();
    let whole = scene.brightness(bodies, law);
    for ((value, _), whole) in partials.iter().zip(whole) {
        assert!((value - whole).abs() < 1e-14);
    }
    for k in 0..3 {
        let unit = axis(k);
        for other in 0..bodies.len() {
            let moved = |by: f64| {
                let mut scene = scene.clone();
                scene.position[other] += unit * by;
                scene.brightness(bodies, law)
            };
            let found: Vec<f64> = partials.iter().map(|(_, p)| p.by_body[other].position[k]).collect();
            assert_slope(moved, &found, "position");
            let rotated = |by: f64| {
                let mut scene = scene.clone();
                scene.attitude[other] = rotated(scene.attitude[other], unit * by);
                scene.brightness(bodies, law)
            };
            let found: Vec<f64> = partials.iter().map(|(_, p)| p.by_body[other].rotation[k]).collect();
            assert_slope(rotated, &found, "rotation");
        }
        for light in 0..2 {
            let direction = scene.directions[light];
            let across = unit - direction * direction.dot(&unit);
            let toward = |by: f64| {
                let mut scene = scene.clone();
                scene.directions[light] += across * by;
                scene.brightness(bodies, law)
            };
            let found: Vec<f64> = partials.iter().map(|(_, p)| p.by_direction[light].dot(&across)).collect();
            assert_slope(toward, &found, "direction");
        }
    }
}

#[test]
fn derivatives_of_facets_with_shadows_are_those_of_differences() {
    for step in [1, 3, 4] {
        let (bodies, scene) = pair(step);
        for law in [Law::LOMMEL_SEELIGER, Law::Sum([0.3, 0.7])] {
            assert_derivatives(&bodies, &scene, law);
        }
    }
    // Two parts that overlap hide what is within the other one.
    let part = |phase: f64, place: [f64; 3]| {
        let shape = Shape::Polyhedron(irregular(3, 0.1, phase));
        InputPart { shape, mass: 1.0, position: place, attitude: [1.0, 0.0, 0.0, 0.0] }
    };
    let parts = vec![part(0.2, [0.0; 3]), part(0.9, [0.8, 0.3, -0.2])];
    let composite = Body::composite("pieces", parts).unwrap();
    let (_, scene) = pair(2);
    let scene = Scene { position: vec![Vec3::zeros()], attitude: scene.attitude[..1].to_vec(), ..scene };
    assert_derivatives(&[composite], &scene, Law::LOMMEL_SEELIGER);
}

#[test]
fn derivatives_with_respect_to_vertices_are_those_of_differences() {
    let (bodies, scene) = pair(3);
    let law = Law::LOMMEL_SEELIGER;
    let partials = photometer(&bodies, law).partials(&scene.view(), &mut InterruptCheck::never()).unwrap();
    for other in 0..2 {
        let Shape::Polyhedron(polyhedron) = &bodies[other].parts()[0].shape else { unreachable!() };
        let vertices: Vec<Vec3> = polyhedron.vertices().collect();
        for trial in 0..6 {
            let motion = |v: usize| {
                let phase = (1 + v * (2 * trial + 3)) as f64;
                Vec3::new((0.7 * phase).sin(), (1.3 * phase).cos(), (2.1 * phase).sin())
            };
            let moved = |by: f64| {
                let at: Vec<Vec3> = vertices.iter().enumerate().map(|(v, at)| at + motion(v) * by).collect();
                let polyhedron = solid(&at, polyhedron.faces());
                // The frame in which the vertices are given keeps its pose.
                let frame = polyhedron.working_frame();
                let [w, x, y, z] = frame.attitude;
                let back: Mat3 = rotation::matrix(scene.attitude[other]) * rotation::matrix([w, -x, -y, -z]);
                let mut scene = scene.clone();
                scene.position[other] -= back * frame.position;
                scene.attitude[other] = product(scene.attitude[other], [w, -x, -y, -z]);
                let mut bodies = bodies.clone();
                bodies[other] = body(&polyhedron);
                scene.brightness(&bodies, law)
            };
            let slope = |by: &[Vec3]| by.iter().enumerate().map(|(v, by)| by.dot(&motion(v))).sum();
            let found: Vec<f64> = partials.iter().map(|(_, p)| slope(&p.by_vertex[other])).collect();
            assert_slope(moved, &found, "vertices");
        }
    }
}

/// An ellipsoid.
fn ellipsoid(semi_axes: Vec3) -> Body {
    Body::with_mass("ellipsoid", Shape::ellipsoid(semi_axes.into()).unwrap(), 1.0).unwrap()
}

#[test]
fn derivatives_of_facets_hidden_by_an_ellipsoid_are_those_of_differences() {
    let (law, semi_axes) = (Law::LOMMEL_SEELIGER, Vec3::new(0.5, 0.42, 0.38));
    for step in [3, 4] {
        let (mut bodies, scene) = pair(step);
        bodies[1] = ellipsoid(semi_axes);
        assert_derivatives(&bodies, &scene, law);
        let partials =
            photometer(&bodies, law).partials(&scene.view(), &mut InterruptCheck::never()).unwrap();
        for k in 0..3 {
            let grown = |by: f64| {
                let mut bodies = bodies.clone();
                bodies[1] = ellipsoid(semi_axes + axis(k) * by);
                scene.brightness(&bodies, law)
            };
            let computed: Vec<f64> = partials.iter().map(|(_, p)| p.by_body[1].semi_axes[k]).collect();
            assert!(computed[0].abs() > 1e-3);
            assert_slope(grown, &computed, "semi-axis");
        }
    }
}

#[test]
fn derivatives_of_an_ellipsoid_beside_facets_are_nearly_those_of_two_ellipsoids() {
    let semi_axes = [Vec3::new(1.0, 0.9, 0.75), Vec3::new(0.5, 0.42, 0.38)];
    let law = Law::LOMMEL_SEELIGER;
    let of = |bodies: &[Body], scene: &Scene| {
        let all = photometer(bodies, law).partials(&scene.view(), &mut InterruptCheck::never()).unwrap();
        let rows = all.into_iter().map(|(_, partials)| {
            let [first, second] = [0, 1].map(|k| partials.by_body[k]);
            // The hidden ellipsoid has semi-axes; those of the facets are none.
            let body = [first.position, first.rotation, first.semi_axes, second.position, second.rotation];
            body.into_iter().chain(partials.by_direction).collect::<Vec<Vec3>>()
        });
        rows.collect::<Vec<_>>()
    };
    for step in [2, 3, 4] {
        let (_, scene) = pair(step);
        let exact = of(&semi_axes.map(ellipsoid), &scene);
        let sphere = irregular(24, 0.0, 0.0);
        let vertices: Vec<Vec3> = sphere.vertices().map(|v| v.component_mul(&semi_axes[1])).collect();
        let faceted = of(&[ellipsoid(semi_axes[0]), body(&solid(&vertices, sphere.faces()))], &scene);
        let largest = exact[0].iter().map(|v| v.norm()).fold(0.0, f64::max);
        for (computed, expected) in faceted[0].iter().zip(&exact[0]) {
            assert!((computed - expected).norm() < 0.01 * largest, "{step}: {computed} {expected}");
        }
    }
}

#[test]
fn composites_with_ellipsoids_have_derivatives_but_no_semi_axes() {
    let part = |shape: Shape, position: [f64; 3]| InputPart {
        shape,
        mass: 1.0,
        position,
        attitude: [0.8, 0.0, 0.6, 0.0],
    };
    let parts = vec![
        part(Shape::ellipsoid([0.9, 0.7, 0.6]).unwrap(), [0.0; 3]),
        part(Shape::Polyhedron(irregular(4, 0.1, 0.2).scaled(0.5)), [0.7, 0.1, 0.3]),
    ];
    let composite = Body::composite("pieces", parts).unwrap();
    let (_, scene) = pair(2);
    let scene = Scene { position: vec![Vec3::zeros()], attitude: scene.attitude[..1].to_vec(), ..scene };
    let bodies = [composite];
    let photometer = photometer(&bodies, Law::LOMMEL_SEELIGER);
    let partials = photometer.partials(&scene.view(), &mut InterruptCheck::never()).unwrap();
    let by_body = partials[0].1.by_body[0];
    assert_eq!(by_body.semi_axes, Vec3::zeros());
    // A rotation of the body is one of the directions the other way round.
    let inverse = rotation::matrix(scene.attitude[0]).transpose();
    let by_light = (0..2).map(|k| (inverse * partials[0].1.by_direction[k], inverse * scene.directions[k]));
    let expected: Vec3 = by_light.map(|(by, direction)| by.cross(&direction)).sum();
    assert!((by_body.rotation - expected).norm() < 1e-9 * expected.norm(), "{} {expected}", by_body.rotation);
    for k in 0..3 {
        let value = |by: f64| {
            let attitude = vec![rotated(scene.attitude[0], axis(k) * by)];
            Scene { attitude, ..scene.clone() }.brightness(&bodies, Law::LOMMEL_SEELIGER)[0]
        };
        let slope = (value(0.02) - value(-0.02)) / 0.04;
        assert!((slope - by_body.rotation[k]).abs() < 0.02 * by_body.rotation.norm(), "{slope} {by_body:?}");
    }
}

#[test]
fn the_light_of_facets_is_linear_in_their_areas_and_its_derivatives_are_those_of_differences() {
    let (bodies, scene) = facets();
    for law in [Law::LOMMEL_SEELIGER, Law::Sum([1.0, 0.2])] {
        let mut interrupt = InterruptCheck::never();
        let (value, partials) =
            photometer(&bodies, law).partials(&scene.view(), &mut interrupt).unwrap().remove(0);
        let areas = bodies[0].facets().unwrap().areas();
        let sum: f64 = partials.by_area[0].iter().zip(areas).map(|(by, area)| by * area).sum();
        assert!((sum - value).abs() < 1e-14 * value);
        for k in 0..3 {
            let rotated = |by: f64| {
                let attitude = vec![rotated(scene.attitude[0], axis(k) * by)];
                Scene { attitude, ..scene.clone() }.brightness(&bodies, law)
            };
            assert_slope(rotated, &[partials.by_body[0].rotation[k]], "rotation");
        }
    }
}
