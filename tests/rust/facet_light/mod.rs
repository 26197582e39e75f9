//! Tests of the brightness of polyhedra that hide parts of themselves and of each other from the observer and the
//! Sun: against ray tracing, closed forms and finite differences.

mod derivatives;

use crate::polyhedron::cuboid;
use crate::support::refusal;
use fullbody::dynamics::{Settings, System};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::{Vec3, rotation};
use fullbody::photometry::{Law, Photometer, Surface, View, recoil};
use fullbody::shape::{Body, Facets, InputPart, Polyhedron, Shape};

/// The poses of bodies, and the directions to the observer and to the Sun.
#[derive(Clone)]
struct Scene {
    position: Vec<Vec3>,
    attitude: Vec<[f64; 4]>,
    directions: [Vec3; 2],
}

impl Scene {
    fn view(&self) -> View<'_> {
        let Self { position, attitude, directions: [to_observer, to_sun] } = self;
        let (to_observer, to_sun) = (*to_observer, *to_sun);
        View { time: 0.0, position, attitude, velocity: &[], to_observer, to_sun, distant: true }
    }

    fn brightness(&self, bodies: &[Body], law: Law) -> Vec<f64> {
        photometer(bodies, law).brightness(&self.view(), &mut InterruptCheck::never()).unwrap()
    }
}

fn photometer(bodies: &[Body], law: Law) -> Photometer {
    let surfaces = vec![Surface { law, albedo: vec![1.0] }; bodies.len()];
    Photometer::new(bodies.to_vec(), surfaces, true, 0.0).unwrap()
}

fn solid(vertices: &[Vec3], faces: &[[u32; 3]]) -> Polyhedron {
    Polyhedron::new(vertices, faces, &mut InterruptCheck::never()).unwrap()
}

fn body(polyhedron: &Polyhedron) -> Body {
    Body::with_mass("body", Shape::Polyhedron(polyhedron.clone()), 1.0).unwrap()
}

/// An irregular body: a unit sphere of 8 n^2 faces whose radius is multiplied by one plus `amplitude` times sines
/// of the coordinates, which are shifted by `phase`.
fn irregular(n: usize, amplitude: f64, phase: f64) -> Polyhedron {
    let (mut vertices, mut faces): (Vec<Vec3>, Vec<[u32; 3]>) = (Vec::new(), Vec::new());
    let mut index = |v: Vec3| {
        let found = vertices.iter().position(|w| (w - v).norm() < 1e-9);
        found.unwrap_or_else(|| {
            vertices.push(v);
            vertices.len() - 1
        }) as u32
    };
    for octant in 0..8 {
        let signs = Vec3::from_fn(|i, _| if octant >> i & 1 == 0 { 1.0 } else { -1.0 });
        let point = |i: usize, j: usize| {
            signs.component_mul(&Vec3::new((n - i - j) as f64, i as f64, j as f64)).normalize()
        };
        let mut add = |corners: [Vec3; 3]| {
            let [a, b, c] = corners.map(&mut index);
            faces.push(if signs.product() > 0.0 { [a, b, c] } else { [a, c, b] });
        };
        for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
            add([point(i, j), point(i + 1, j), point(i, j + 1)]);
            if i + j + 1 < n {
                add([point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
            }
        }
    }
    let radius = |v: &Vec3| {
        1.0 + amplitude
            * ((5.0 * v.x + phase).sin() * (4.0 * v.y - phase).cos() + (6.0 * v.z + 2.0 * phase).sin())
    };
    let vertices: Vec<Vec3> = vertices.iter().map(|v| v * radius(v)).collect();
    solid(&vertices, &faces)
}

/// Two bodies, the second of which crosses the first one with growing `step`, followed by its shadow.
fn pair(step: usize) -> (Vec<Body>, Scene) {
    let bodies = vec![body(&irregular(5, 0.15, 0.3)), body(&irregular(4, 0.15, 1.1).scaled(0.45))];
    let y = -1.1 + 0.37 * step as f64;
    let unit = |q: [f64; 4]| q.map(|x| x / q.iter().map(|x| x * x).sum::<f64>().sqrt());
    let scene = Scene {
        position: vec![Vec3::new(0.02, 0.0, 0.01), Vec3::new(2.4, y, 0.21)],
        attitude: vec![
            unit([0.9, 0.1 * step as f64, 0.3, -0.2]),
            unit([0.4, -0.3, 0.1 + 0.2 * step as f64, 0.5]),
        ],
        directions: [Vec3::new(1.0, 0.1, -0.2).normalize(), Vec3::new(0.8, 0.5, 0.35).normalize()],
    };
    (bodies, scene)
}

/// The faces of each polyhedron in the inertial frame.
fn inertial_faces(bodies: &[Body], scene: &Scene) -> Vec<Vec<[Vec3; 3]>> {
    let of = |(k, body): (usize, &Body)| {
        let Shape::Polyhedron(polyhedron) = &body.parts()[0].shape else { unreachable!() };
        let rotation = rotation::matrix(scene.attitude[k]);
        (0..polyhedron.faces().len())
            .map(|face| polyhedron.corners(face).map(|v| scene.position[k] + rotation * v))
            .collect()
    };
    bodies.iter().enumerate().map(of).collect()
}

/// Whether a ray from a point intersects a triangle (Moeller & Trumbore 1997).
fn intersects([a, b, c]: &[Vec3; 3], from: &Vec3, direction: &Vec3) -> bool {
    let (u, v) = (b - a, c - a);
    let p = direction.cross(&v);
    let determinant = u.dot(&p);
    let offset = from - a;
    let q = offset.cross(&u);
    let [x, y, t] = [offset.dot(&p), direction.dot(&q), v.dot(&q)].map(|value| value / determinant);
    x >= 0.0 && y >= 0.0 && x + y <= 1.0 && t > 1e-9
}

#[test]
fn irregular_bodies_are_as_bright_as_by_ray_tracing() {
    const POINTS: usize = 9;
    let (mut lost, mut compared) = (0.0, 0);
    for step in 0..7 {
        let (bodies, scene) = pair(step);
        let all = inertial_faces(&bodies, &scene);
        let found = scene.brightness(&bodies, Law::LOMMEL_SEELIGER);
        for (own, found) in all.iter().zip(found) {
            let (mut expected, mut whole) = (0.0, 0.0);
            for (face, [a, b, c]) in own.iter().enumerate() {
                let twice_area = (b - a).cross(&(c - a));
                let [mu, mu0] = scene.directions.map(|d| d.dot(&twice_area.normalize()));
                if mu <= 0.0 || mu0 <= 0.0 {
                    continue;
                }
                let bright = 0.5 * twice_area.norm() * mu * mu0 / (mu + mu0);
                // A ray starts at the centre of each of POINTS^2 equal triangles of the face.
                let cells = (0..POINTS).flat_map(|i| (0..POINTS - i).map(move |j| (i, j, 1.0 / 3.0)));
                let upper = (0..POINTS - 1).flat_map(|i| (0..POINTS - 1 - i).map(move |j| (i, j, 2.0 / 3.0)));
                for (i, j, within) in cells.chain(upper) {
                    let [u, v] = [i, j].map(|k| (k as f64 + within) / POINTS as f64);
                    let from = a + (b - a) * u + (c - a) * v;
                    let hides = |triangle: &[Vec3; 3], d: &Vec3| intersects(triangle, &from, d);
                    let hidden = all.iter().any(|other| {
                        let same_body = std::ptr::eq(other, own);
                        let others = other.iter().enumerate().filter(|(k, _)| !(same_body && *k == face));
                        others.into_iter().any(|(_, t)| scene.directions.iter().any(|d| hides(t, d)))
                    });
                    whole += bright / (POINTS * POINTS) as f64;
                    expected += if hidden { 0.0 } else { bright / (POINTS * POINTS) as f64 };
                }
            }
            lost += 1.0 - expected / whole;
            compared += 1;
            assert!((found - expected).abs() < 2e-3 * whole, "step {step}: {found} {expected} {whole}");
        }
    }
    // A tenth of the light or more is hidden on average.
    assert!(compared == 14 && lost > 1.4, "{compared} {lost}");
}

/// A flat irregular body perpendicular to the x axis, and its attitude when it is rotated about x by an angle.
fn flat_body(angle: f64) -> (Body, [f64; 4]) {
    let round = irregular(6, 0.15, 1.1);
    let vertices: Vec<Vec3> = round.vertices().map(|v| v.component_mul(&Vec3::new(0.12, 0.6, 0.6))).collect();
    let flat = solid(&vertices, round.faces());
    let [w, x, y, z] = flat.working_frame().attitude;
    (body(&flat), product([(0.5 * angle).cos(), (0.5 * angle).sin(), 0.0, 0.0], [w, -x, -y, -z]))
}

#[test]
fn the_light_that_a_body_hides_does_not_depend_on_its_distance() {
    // At opposition shadow and silhouette coincide. The bounding sphere of a near flat body reaches behind faces
    // that the body hides; that of a far one is in front of all faces.
    let composite = {
        let part = |phase: f64, place: [f64; 3]| {
            let shape = Shape::Polyhedron(irregular(3, 0.1, phase));
            InputPart { shape, mass: 1.0, position: place, attitude: [1.0, 0.0, 0.0, 0.0] }
        };
        Body::composite("composite", vec![part(0.2, [0.0; 3]), part(0.9, [0.8, 0.3, -0.2])]).unwrap()
    };
    let behind = [body(&irregular(5, 0.15, 0.3)), body(&step_block(3.0, 0.7, 1.8)), composite];
    let mut partly_hidden = 0;
    for (step, body) in behind.iter().cycle().take(30).enumerate() {
        let phase = step as f64;
        let (flat, attitude) = flat_body(phase);
        let own = Vec3::new(phase.sin(), (2.0 * phase).sin(), (3.0 * phase).cos());
        let aside = Vec3::new(0.0, (1.7 * phase).sin(), (2.3 * phase).cos()) * (0.05 * phase);
        let bodies = [body.clone(), flat];
        let light = |distance: f64| {
            let scene = Scene {
                position: vec![Vec3::zeros(), axis(0) * (body.circumradius() + distance) + aside],
                attitude: vec![rotated([1.0, 0.0, 0.0, 0.0], own), attitude],
                directions: [axis(0); 2],
            };
            let found = photometer(&bodies, Law::LOMMEL_SEELIGER)
                .partials(&scene.view(), &mut InterruptCheck::never())
                .unwrap();
            let (brightness, partials) = &found[0];
            assert!((brightness - scene.brightness(&bodies, Law::LOMMEL_SEELIGER)[0]).abs() < 1e-14);
            let mut all = vec![*brightness];
            for by in &partials.by_body {
                all.extend(by.position.iter().chain(by.rotation.iter()));
            }
            all
        };
        let [near, far, farthest] = [0.2, 7.0, 1e3].map(light);
        for (k, ((near, far), farthest)) in near.iter().zip(&far).zip(&farthest).enumerate() {
            assert!((near - far).abs() < 1e-11, "step {step}, number {k}: {near} {far}");
            assert!((near - farthest).abs() < 1e-9, "step {step}, number {k}: {near} {farthest}");
        }
        let alone = Scene {
            position: vec![Vec3::zeros()],
            attitude: vec![rotated([1.0, 0.0, 0.0, 0.0], own)],
            directions: [axis(0); 2],
        };
        let whole = alone.brightness(&bodies[..1], Law::LOMMEL_SEELIGER)[0];
        partly_hidden += usize::from(near[0] < 0.98 * whole);
    }
    assert!(partly_hidden > 20, "{partly_hidden}");
}

/// A block with a step, `depth` long in y. Its profile in x and z is the rectangle from (0, 0) to (2, 1) below the
/// one from (0, 1) to (`width`, `height`).
pub fn step_block(depth: f64, width: f64, height: f64) -> Polyhedron {
    let profile = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (width, 1.0), (width, height), (0.0, height)];
    let vertices: Vec<Vec3> =
        [0.0, depth].iter().flat_map(|y| profile.map(|(x, z)| Vec3::new(x, *y, z))).collect();
    let mut faces: Vec<[u32; 3]> = (0..6)
        .flat_map(|k: u32| {
            let (a, b) = (k, (k + 1) % 6);
            [[a, a + 6, b], [b, a + 6, b + 6]]
        })
        .collect();
    faces.extend([[3, 0, 1], [3, 1, 2], [3, 4, 5], [3, 5, 0]]);
    faces.extend([[9, 7, 6], [9, 8, 7], [9, 11, 10], [9, 6, 11]]);
    let outward: f64 =
        faces.iter().map(|f| f.map(|v| vertices[v as usize])).map(|[a, b, c]| a.dot(&b.cross(&c))).sum();
    if outward < 0.0 {
        faces.iter_mut().for_each(|face| face.swap(1, 2));
    }
    solid(&vertices, &faces)
}

#[test]
fn the_shadow_of_a_step_has_the_area_of_a_clipped_parallelogram() {
    let (depth, width, height) = (3.0, 0.7, 1.8);
    let polyhedron = step_block(depth, width, height);
    let block = body(&polyhedron);
    let frame = polyhedron.working_frame();
    // The attitude undoes the rotation to the principal axes: the block stands as it was given.
    let [w, x, y, z] = frame.attitude;
    let mut shadowed = 0;
    for azimuth in 0..9 {
        for elevation in 1..7 {
            let (azimuth, elevation) = (-0.9 + 0.2 * f64::from(azimuth), 0.2 * f64::from(elevation));
            let s =
                Vec3::new(-azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin());
            let e = Vec3::new(0.3, 0.1 * azimuth.signum(), 1.0).normalize();
            let scene =
                Scene { position: vec![Vec3::zeros()], attitude: vec![[w, -x, -y, -z]], directions: [e, s] };
            // The shadow of the upper edge lies `reach` from the wall, and is displaced along it by `slope` per unit
            // of that distance.
            let reach = (height - 1.0) * -s.x / s.z;
            let slope = s.y.abs() / -s.x;
            let extent = reach.min(2.0 - width).min(depth / slope.max(1e-9));
            let hidden = depth * extent - 0.5 * slope * extent * extent;
            let bright = |mu: f64, mu0: f64| if mu > 0.0 && mu0 > 0.0 { mu * mu0 / (mu + mu0) } else { 0.0 };
            let profile = 2.0 + width * (height - 1.0);
            let expected =
                (2.0 * depth - hidden) * bright(e.z, s.z) + profile * (bright(e.y, s.y) + bright(-e.y, -s.y));
            let found = scene.brightness(std::slice::from_ref(&block), Law::LOMMEL_SEELIGER)[0];
            shadowed += usize::from(hidden > 0.1);
            assert!((found - expected).abs() < 1e-12, "{azimuth} {elevation}: {found} {expected}");
        }
    }
    assert!(shadowed > 40);
}

/// The attitude after a rotation by a rotation vector in the body frame.
fn rotated(attitude: [f64; 4], by: Vec3) -> [f64; 4] {
    let (sin, cos) = (0.5 * by.norm()).sin_cos();
    let v = if by.norm() > 0.0 { by * (sin / by.norm()) } else { by };
    let (w, u) = (attitude[0], Vec3::new(attitude[1], attitude[2], attitude[3]));
    let vector = v * w + u * cos + u.cross(&v);
    [w * cos - u.dot(&v), vector.x, vector.y, vector.z]
}

fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let [u, v] = [a, b].map(|q| Vec3::new(q[1], q[2], q[3]));
    let vector = v * a[0] + u * b[0] + u.cross(&v);
    [a[0] * b[0] - u.dot(&v), vector.x, vector.y, vector.z]
}

fn axis(k: usize) -> Vec3 {
    Vec3::from_fn(|i, _| f64::from(u8::from(i == k)))
}

#[test]
fn coincident_surfaces_of_overlapping_parts_count_once() {
    // Two boxes of length 2 overlap by 1: together they are one box of length 3, whose brightness has a closed form.
    let cuboid = |length: f64| {
        let corner = |k: usize| Vec3::from_fn(|i, _| f64::from(u8::from(k >> i & 1 == 1)) - 0.5);
        let vertices: Vec<Vec3> =
            (0..8).map(|k| corner(k).component_mul(&Vec3::new(length, 1.0, 1.0))).collect();
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces: Vec<[u32; 3]> =
            sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        solid(&vertices, &faces)
    };
    let part = |x: f64| InputPart {
        shape: Shape::Polyhedron(cuboid(2.0)),
        mass: 1.0,
        position: [x, 0.0, 0.0],
        attitude: [1.0, 0.0, 0.0, 0.0],
    };
    let bodies = [Body::composite("boxes", vec![part(-0.5), part(0.5)]).unwrap()];
    let directions = [Vec3::new(0.3, 0.5, 0.9).normalize(), Vec3::new(0.6, 0.2, 0.4).normalize()];
    let scene = Scene { position: vec![Vec3::zeros()], attitude: vec![[1.0, 0.0, 0.0, 0.0]], directions };
    let bright = |k: usize| directions[0][k] * directions[1][k] / (directions[0][k] + directions[1][k]);
    let expected = bright(0) + 3.0 * (bright(1) + bright(2));
    let found = scene.brightness(&bodies, Law::LOMMEL_SEELIGER)[0];
    assert!((found - expected).abs() < 1e-9, "{found} {expected}");
}

#[test]
fn only_nonconvex_polyhedra_have_horizons() {
    let horizons =
        |polyhedron: &Polyhedron| polyhedron.horizons(&mut InterruptCheck::never()).unwrap().is_some();
    assert!(!horizons(&irregular(6, 0.0, 0.0)));
    assert!(horizons(&irregular(6, 0.1, 0.0)));
    assert!(horizons(&step_block(3.0, 0.7, 1.8)));
}

#[test]
fn the_brightness_of_a_partly_hidden_body_is_the_sum_over_its_faces() {
    let (bodies, scene) = pair(3);
    let Shape::Polyhedron(polyhedron) = &bodies[0].parts()[0].shape else { unreachable!() };
    let brightness = |albedo: Vec<f64>| {
        let law = Law::LOMMEL_SEELIGER;
        let surfaces = vec![Surface { law, albedo }, Surface { law, albedo: vec![1.0] }];
        let photometer = Photometer::new(bodies.clone(), surfaces, true, 0.0).unwrap();
        photometer.brightness(&scene.view(), &mut InterruptCheck::never()).unwrap()[0]
    };
    let count = polyhedron.faces().len();
    let single = |face: usize| brightness((0..count).map(|k| f64::from(u8::from(k == face))).collect());
    let sum: f64 = (0..count).map(single).sum();
    assert!((sum / brightness(vec![1.0]) - 1.0).abs() < 1e-13);
}

/// Two unit cubes are one unit apart in x, and the Sun stands above +x: the face of the shadowed cube towards the
/// other one is lit in a strip whose height is the tangent of the elevation.
#[test]
fn the_recoil_of_a_partly_shadowed_face_acts_at_the_centroid_of_its_lit_strip() {
    let cube = cuboid([-0.5; 3], [1.0; 3]);
    let part = |x: f64| InputPart {
        shape: Shape::Polyhedron(cube.clone()),
        mass: 1.0,
        position: [x, 0.0, 0.0],
        attitude: [1.0, 0.0, 0.0, 0.0],
    };
    let cubes = Body::composite("cubes", vec![part(-1.0), part(1.0)]).unwrap();
    for elevation in [0.1_f64, 0.4, 0.7] {
        let s = Vec3::new(elevation.cos(), 0.0, elevation.sin());
        let loads = recoil(&cubes, &[], &[s * 3.0], &mut InterruptCheck::never()).unwrap();
        let strip = elevation.tan();
        let lit = [
            (Vec3::z(), 1.0, Vec3::new(1.0, 0.0, 0.5)),
            (Vec3::z(), 1.0, Vec3::new(-1.0, 0.0, 0.5)),
            (Vec3::x(), 1.0, Vec3::new(1.5, 0.0, 0.0)),
            (Vec3::x(), strip, Vec3::new(-0.5, 0.0, 0.5 - 0.5 * strip)),
        ];
        let (mut force, mut torque) = (Vec3::zeros(), Vec3::zeros());
        for (normal, area, centre) in lit {
            let push = (s + normal * (2.0 / 3.0)) * (-area * normal.dot(&s));
            force += push;
            torque += centre.cross(&push);
        }
        assert!((loads[0][0] - force).norm() < 1e-12 && (loads[0][1] - torque).norm() < 1e-12);
    }
}

/// A convex body given by normals and areas of facets: the normals are those of a sphere, and the areas grow with
/// x. The scene holds its attitude.
fn facets() -> (Vec<Body>, Scene) {
    let sphere = irregular(4, 0.0, 0.0);
    let corners = |face: &[u32; 3]| {
        let vertices: Vec<Vec3> = sphere.vertices().collect();
        face.map(|v| vertices[v as usize])
    };
    let area_vectors = sphere.faces().iter().map(|face| {
        let [a, b, c] = corners(face);
        (b - a).cross(&(c - a)) * 0.5
    });
    let area_vectors: Vec<Vec3> =
        area_vectors.map(|area| area * (1.0 + 0.5 * area.x / area.norm())).collect();
    let normals: Vec<Vec3> = area_vectors.iter().map(Vec3::normalize).collect();
    let areas: Vec<f64> = area_vectors.iter().map(Vec3::norm).collect();
    let body = Body::of_facets("facets", Facets::new(&normals, &areas).unwrap(), 1.0).unwrap();
    let directions = [Vec3::new(0.8, -0.5, 0.3), Vec3::new(0.2, 0.9, 0.4)];
    (
        vec![body],
        Scene {
            position: vec![Vec3::zeros()],
            attitude: vec![rotated([1.0, 0.0, 0.0, 0.0], axis(1))],
            directions,
        },
    )
}

#[test]
fn a_convex_polyhedron_is_as_bright_as_a_body_given_by_its_facets() {
    let solid = irregular(4, 0.0, 0.0);
    let vertices: Vec<Vec3> = solid.vertices().collect();
    let area_vectors = solid.faces().iter().map(|face| {
        let [a, b, c] = face.map(|v| vertices[v as usize]);
        (b - a).cross(&(c - a)) * 0.5
    });
    let (normals, areas): (Vec<_>, Vec<_>) = area_vectors.map(|v| (v.normalize(), v.norm())).unzip();
    let given_by_facets = Body::of_facets("facets", Facets::new(&normals, &areas).unwrap(), 1.0).unwrap();
    let (_, scene) = facets();
    for law in [Law::LOMMEL_SEELIGER, Law::LAMBERT] {
        let [of_facets, of_solid] =
            [given_by_facets.clone(), body(&solid)].map(|body| scene.brightness(&[body], law)[0]);
        assert!((of_facets - of_solid).abs() < 1e-13 * of_solid, "{of_facets} {of_solid}");
    }
}

#[test]
fn a_body_given_by_facets_has_equal_moments_of_inertia_and_is_refused_in_pairs() {
    let (bodies, _) = facets();
    let inertia = bodies[0].inertia();
    assert!(inertia.x == inertia.y && inertia.y == inertia.z && inertia.x > 0.0);
    let mut pair = bodies.clone();
    pair.push(Body::with_mass("ball", Shape::sphere(1.0).unwrap(), 1.0).unwrap());
    let system = System::new(pair, 1.0, Settings::default());
    assert!(refusal(system).contains("ConvexShape.polyhedron()"));
    assert!(refusal(bodies[0].require_surface()).contains("given by areas and normals of facets"));
    let text = serde_json::to_string(&bodies[0]).unwrap();
    assert_eq!(serde_json::from_str::<Body>(&text).unwrap(), bodies[0]);
}
