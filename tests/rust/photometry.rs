//! Brightness of bodies, by arbitrary-precision values, closed forms and symmetries.

use crate::support::{data, number, triple};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::{Vec3, rotation};
use fullbody::photometry::{Hapke, Law, Photometer, Surface, View};
use fullbody::shape::{Body, Shape};
use std::f64::consts::{PI, TAU};

const LAWS: [Law; 2] = [Law::LOMMEL_SEELIGER, Law::LAMBERT];

/// Two bodies of the reference data.
struct Pair {
    axes: [[f64; 3]; 2],
    position: Vec<Vec3>,
    attitude: Vec<[f64; 4]>,
    to_observer: Vec3,
    to_sun: Vec3,
}

impl Pair {
    fn of(case: &serde_json::Value) -> Self {
        Self {
            axes: [0, 1].map(|k| triple(&case["axes"][k])),
            position: (0..2).map(|k| Vec3::from(triple(&case["position"][k]))).collect(),
            attitude: (0..2).map(|k| [0, 1, 2, 3].map(|i| number(&case["attitude"][k][i]))).collect(),
            to_observer: Vec3::from(triple(&case["to_observer"])),
            to_sun: Vec3::from(triple(&case["to_sun"])),
        }
    }

    fn bodies(&self) -> Vec<Body> {
        let body = |(axes, name): (&[f64; 3], &str)| {
            Body::with_mass(name, Shape::ellipsoid(*axes).unwrap(), 1.0).unwrap()
        };
        self.axes.iter().zip(["a", "b"]).map(body).collect()
    }

    fn view(&self) -> View<'_> {
        View {
            time: 0.0,
            position: &self.position,
            attitude: &self.attitude,
            velocity: &[],
            to_observer: self.to_observer,
            to_sun: self.to_sun,
            distant: true,
        }
    }

    fn photometer(&self, law: Law, mutual: bool) -> Photometer {
        let surfaces = vec![Surface { law, albedo: vec![1.0] }; 2];
        Photometer::new(self.bodies(), surfaces, mutual, 0.0).unwrap()
    }

    fn brightness(&self, law: Law, mutual: bool) -> Vec<f64> {
        self.photometer(law, mutual).brightness(&self.view(), &mut InterruptCheck::never()).unwrap()
    }
}

fn cases() -> Vec<(Pair, serde_json::Value)> {
    let all = data("light.json");
    all["cases"].as_array().unwrap().iter().map(|case| (Pair::of(case), case.clone())).collect()
}

#[test]
fn two_ellipsoids_in_each_others_light_are_as_bright_as_by_the_reference() {
    for (index, (pair, case)) in cases().iter().enumerate() {
        for (k, law) in LAWS.into_iter().enumerate() {
            for (mutual, suffix) in [(false, "_unobstructed"), (true, "")] {
                let found = pair.brightness(law, mutual);
                for (body, name) in ["a", "b"].into_iter().enumerate() {
                    let expected = number(&case[&format!("{name}{suffix}")][k]);
                    let alone = number(&case[&format!("{name}_unobstructed")][k]);
                    let error = (found[body] - expected).abs() / alone;
                    assert!(
                        error < 1e-12,
                        "case {index}, {name}{suffix}, {law:?}: {} {expected}, {error:e}",
                        found[body]
                    );
                }
            }
        }
    }
}

/// The brightness of body `of` with one of the 24 numbers of the view shifted: positions, rotation vectors
/// and semi-axes of both bodies, the directions.
fn shifted(pair: &Pair, law: Law, of: usize, which: usize, by: f64) -> f64 {
    let mut moved = Pair {
        axes: pair.axes,
        position: pair.position.clone(),
        attitude: pair.attitude.clone(),
        to_observer: pair.to_observer,
        to_sun: pair.to_sun,
    };
    let i = which % 3;
    let mut unit = Vec3::zeros();
    unit[i] = by;
    match which / 3 {
        k @ (0 | 3) => moved.position[k / 3][i] += by,
        k @ (1 | 4) => {
            let half = (0.5 * by).sin();
            let turn = [(0.5 * by).cos(), unit.x / by * half, unit.y / by * half, unit.z / by * half];
            moved.attitude[k / 3] = rotation::product(pair.attitude[k / 3], turn);
        }
        k @ (2 | 5) => moved.axes[k / 3][i] += by,
        6 => moved.to_observer += unit - pair.to_observer * pair.to_observer[i] * by,
        _ => moved.to_sun += unit - pair.to_sun * pair.to_sun[i] * by,
    }
    moved.brightness(law, true)[of]
}

fn hapke(roughness: f64) -> Law {
    Law::Hapke(Hapke {
        single_scattering_albedo: 0.3,
        opposition_amplitude: 1.0,
        opposition_width: 0.05,
        asymmetry: -0.3,
        roughness,
    })
}

#[test]
fn derivatives_are_those_of_differences() {
    let hapke = hapke(0.0);
    for (index, (pair, _)) in cases().iter().enumerate() {
        for law in [Law::LOMMEL_SEELIGER, Law::LAMBERT, Law::Sum([1.0, 0.3]), hapke] {
            if law != Law::LOMMEL_SEELIGER && index != 13 {
                continue;
            }
            let photometer = pair.photometer(law, true);
            let alone = pair.brightness(law, false);
            let partials = photometer.partials(&pair.view(), &mut InterruptCheck::never()).unwrap();
            let plain = pair.brightness(law, true);
            for (body, (value, found)) in partials.iter().enumerate() {
                assert!((value - plain[body]).abs() < 1e-12 * alone[body], "{value} {}", plain[body]);
                let [first, second] = [found.by_body[0], found.by_body[1]];
                let all = [
                    first.position,
                    first.rotation,
                    first.semi_axes,
                    second.position,
                    second.rotation,
                    second.semi_axes,
                    found.by_direction[0],
                    found.by_direction[1],
                ];
                for which in 0..24 {
                    let h = 1e-5;
                    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| shifted(pair, law, body, which, k * h));
                    let difference = (a - 8.0 * b + 8.0 * c - d) / (12.0 * h);
                    let analytic = all[which / 3][which % 3];
                    let error = (difference - analytic).abs() / alone[body];
                    assert!(
                        error < 1e-7,
                        "case {index}, body {body}, {law:?}, {which}: {analytic} {difference} {error:e}"
                    );
                }
            }
        }
    }
}

/// The facets of an ellipsoid as a polyhedron: an octahedron's faces divided, on the unit sphere, stretched.
fn polyhedron(axes: [f64; 3], divisions: usize) -> Shape {
    let mut vertices: Vec<Vec3> = Vec::new();
    let mut faces = Vec::new();
    let mut index = |v: Vec3| {
        let found = vertices.iter().position(|other| (other - v).norm() < 1e-9);
        found.unwrap_or_else(|| {
            vertices.push(v);
            vertices.len() - 1
        }) as u32
    };
    let n = divisions;
    for signs in 0..8 {
        let sign = [0, 1, 2].map(|k| if signs >> k & 1 == 1 { -1.0 } else { 1.0 });
        let mirrored = sign.iter().product::<f64>() < 0.0;
        let mut at = |i: usize, j: usize| {
            let k = n - i - j;
            let v = Vec3::new(sign[0] * i as f64, sign[1] * j as f64, sign[2] * k as f64).normalize();
            index(v)
        };
        let mut add = |mut face: [u32; 3]| {
            if mirrored {
                face.swap(1, 2);
            }
            faces.push(face);
        };
        for i in 0..n {
            for j in 0..n - i {
                let [a, b, c] = [at(i, j), at(i + 1, j), at(i, j + 1)];
                add([a, b, c]);
                if i + j + 1 < n {
                    add([b, at(i + 1, j + 1), c]);
                }
            }
        }
    }
    let vertices: Vec<Vec3> = vertices.iter().map(|v| v.component_mul(&Vec3::from(axes))).collect();
    Shape::Polyhedron(
        fullbody::shape::Polyhedron::new(&vertices, &faces, &mut InterruptCheck::never()).unwrap(),
    )
}

#[test]
fn polyhedra_of_ellipsoids_are_as_bright_in_the_limit_of_small_facets() {
    let mut seen = 0;
    for (pair, case) in cases().iter().step_by(4) {
        for (k, law) in LAWS.into_iter().enumerate() {
            let errors = [12, 24].map(|divisions| {
                let names = ["a", "b"];
                let shape = |axes: &[f64; 3]| polyhedron(*axes, divisions);
                let body = |(axes, name): (&[f64; 3], &str)| Body::with_mass(name, shape(axes), 1.0).unwrap();
                let bodies = pair.axes.iter().zip(names).map(body).collect();
                let photometer =
                    Photometer::new(bodies, vec![Surface { law, albedo: vec![1.0] }; 2], true, 0.0).unwrap();
                let found = photometer.brightness(&pair.view(), &mut InterruptCheck::never()).unwrap();
                names
                    .iter()
                    .zip(found)
                    .map(|(name, found)| found - number(&case[*name][k]))
                    .map(f64::abs)
                    .sum::<f64>()
            });
            let order = (errors[0] / errors[1]).log2();
            assert!((1.5..2.6).contains(&order), "{errors:?}, {order}");
            seen += 1;
        }
    }
    assert!(seen > 8);
}

#[test]
fn ellipsoid_beside_a_polyhedron_loses_what_it_loses_to_an_ellipsoid() {
    for (pair, case) in cases().iter().step_by(3) {
        let bodies =
            vec![pair.bodies()[0].clone(), Body::with_mass("b", polyhedron(pair.axes[1], 24), 1.0).unwrap()];
        let law = Law::LOMMEL_SEELIGER;
        let photometer =
            Photometer::new(bodies, vec![Surface { law, albedo: vec![1.0] }; 2], true, 0.0).unwrap();
        let found = photometer.brightness(&pair.view(), &mut InterruptCheck::never()).unwrap()[0];
        let [expected, alone] = ["a", "a_unobstructed"].map(|name| number(&case[name][0]));
        assert!(
            (found - expected).abs() < 4e-3 * (alone - expected) + 1e-12 * alone,
            "{found} {expected} {alone}"
        );
    }
}

/// Two spheres, the second one before the first along x, with its centre aside.
fn spheres(radii: [f64; 2], aside: [f64; 2], to_sun: Vec3) -> Pair {
    Pair {
        axes: radii.map(|r| [r; 3]),
        position: vec![Vec3::zeros(), Vec3::new(5.0, aside[0], aside[1])],
        attitude: vec![[1.0, 0.0, 0.0, 0.0]; 2],
        to_observer: Vec3::x(),
        to_sun,
    }
}

/// The common area of two circles whose centres are d apart.
fn overlap([r, s]: [f64; 2], d: f64) -> f64 {
    if d >= r + s {
        return 0.0;
    }
    if d <= (r - s).abs() {
        return PI * r.min(s).powi(2);
    }
    let half = 0.5 * ((r + s - d) * (d + r - s) * (d - r + s) * (d + r + s)).sqrt() / d;
    let [x, y] = [(r, s), (s, r)].map(|(a, b)| (d * d + (a - b) * (a + b)) / (2.0 * d));
    let segment = |r: f64, x: f64| r * r * half.atan2(x) - x * half;
    segment(r, x) + segment(s, y)
}

#[test]
fn spheres_at_zero_phase_lose_the_overlap_of_two_circles() {
    for radii in [[1.0, 0.4], [1.0, 1.0], [0.3, 1.0]] {
        let [r, s]: [f64; 2] = radii;
        let tangent = [r + s, (r - s).abs()];
        let distances = (0..60).map(|k| 0.0371 * k as f64).chain(tangent);
        let near = tangent.into_iter().flat_map(|d| [d - 1e-7, d + 1e-7, d - 1e-13, d + 1e-13]);
        for d in distances.chain(near.filter(|d| *d >= 0.0)) {
            for angle in [0.0, 1.0, 0.5 * PI] {
                let pair = spheres(radii, [d * f64::cos(angle), d * f64::sin(angle)], Vec3::x());
                let found = pair.brightness(Law::LOMMEL_SEELIGER, true);
                // mu mu0 / (mu + mu0) dS is half of the projected area.
                let expected = 0.5 * (PI * r * r - overlap(radii, d));
                assert!(
                    (found[0] - expected).abs() < 1e-12 * r * r,
                    "{radii:?} {d} {angle}: {} {expected}",
                    found[0]
                );
                assert!((found[1] - 0.5 * PI * s * s).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn first_moments_at_zero_phase_lose_those_of_the_disc_that_is_hidden() {
    let [large, small] = [2.0, 0.7];
    for aside in [[0.0, 0.0], [0.8, -0.5]] {
        let pair = spheres([large, small], aside, Vec3::x());
        let photometer = pair.photometer(Law::LOMMEL_SEELIGER, true);
        let views = [pair.view()];
        let found = photometer.moments_in(&views, &mut InterruptCheck::never()).unwrap();
        // The light of an element is half of its projected area.
        let (brightness, moment) = found[0];
        assert!((brightness - 0.5 * PI * (large * large - small * small)).abs() < 1e-9);
        for (component, distance) in [moment.y, moment.z].into_iter().zip(aside) {
            assert!((component + 0.5 * PI * small * small * distance).abs() < 1e-9, "{component}");
        }
        if aside == [0.0, 0.0] {
            let left = PI / 3.0 * (large * large - small * small).powf(1.5);
            assert!((moment.x - left).abs() < 1e-9, "{}", moment.x);
        }
        let (brightness, moment) = found[1];
        assert!((brightness - 0.5 * PI * small * small).abs() < 1e-12);
        assert!((moment - Vec3::x() * (PI / 3.0 * small.powi(3))).norm() < 1e-12);
    }
}

#[test]
fn lambert_spheres_at_zero_phase_lose_what_a_sum_over_circles_has() {
    let radii = [1.0, 0.6];
    for d in [0.1, 0.4, 0.55, 0.9, 1.3, 1.55] {
        let found = spheres(radii, [0.0, d], Vec3::x()).brightness(Law::LAMBERT, true)[0];
        // Of the circle of radius r the other sphere leaves an arc of this length; mu^2 dS = sqrt(1 - r^2)
        // dA. The substitution is smooth at the ends of the interval where the arc is partly covered.
        let left = |r: f64| {
            let cos = (r * r + d * d - 0.36) / (2.0 * r * d);
            TAU * r - 2.0 * r * cos.clamp(-1.0, 1.0).acos()
        };
        let edges = [0.0, (d - 0.6f64).abs(), (d + 0.6).min(1.0), 1.0];
        let count = 4000;
        let mut expected = 0.0;
        for pair in edges.windows(2) {
            let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
            for k in 0..count {
                let t = PI * (k as f64 + 0.5) / count as f64;
                let r = middle - half * t.cos();
                let arc = if r + d <= 0.6 { 0.0 } else { left(r) };
                expected += PI / count as f64 * half * t.sin() * arc * (1.0 - r * r).max(0.0).sqrt();
            }
        }
        assert!((found - expected).abs() < 3e-7, "{d}: {found} {expected}");
    }
}

#[test]
fn turning_scaling_and_reordering_change_nothing() {
    let turn = [0.3, -0.5, 0.7, 0.2];
    let rotation = rotation::matrix(turn);
    for (pair, _) in cases() {
        for law in LAWS {
            let plain = pair.brightness(law, true);
            let alone = pair.brightness(law, false);
            let scale = 1234.5;
            let moved = Pair {
                axes: [1, 0].map(|k: usize| pair.axes[k].map(|a| a * scale)),
                position: [1, 0]
                    .iter()
                    .map(|&k: &usize| rotation * pair.position[k] * scale + Vec3::repeat(7.0))
                    .collect(),
                attitude: [1, 0].iter().map(|&k: &usize| rotation::product(turn, pair.attitude[k])).collect(),
                to_observer: rotation * pair.to_observer * 3.0,
                to_sun: rotation * pair.to_sun * 1e8,
            };
            let found = moved.brightness(law, true);
            for k in 0..2 {
                let error = (found[1 - k] / (scale * scale) - plain[k]).abs() / alone[k];
                assert!(error < 1e-12, "{law:?}: {error:e}");
            }
        }
    }
}

/// Random numbers from 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn pick<const N: usize>(&mut self, all: [f64; N]) -> f64 {
        all[(self.next() * N as f64) as usize]
    }

    fn unit(&mut self) -> Vec3 {
        let (z, angle) = (2.0 * self.next() - 1.0, TAU * self.next());
        let rho = (1.0 - z * z).sqrt();
        Vec3::new(rho * angle.cos(), rho * angle.sin(), z)
    }
}

/// Two to four bodies of all forms, which hide each other or touch each other's outlines, at any phase angle.
struct Scene {
    axes: Vec<[f64; 3]>,
    position: Vec<Vec3>,
    attitude: Vec<[f64; 4]>,
    directions: [Vec3; 2],
}

impl Scene {
    fn new(seed: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(0x9e3779b97f4a7c15));
        random.next();
        let e = random.unit();
        let across = e.cross(&random.unit()).normalize();
        let any = 3.0 * random.next();
        let phase = random.pick([0.0, 1e-8, 1e-3, 0.5 * PI, 3.1, any, any, any]);
        let s = e * phase.cos() + across * phase.sin();
        let count = 2 + (3.0 * random.next()) as usize;
        let (mut axes, mut position, mut attitude) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..count {
            let size = if k == 0 { 1.0 } else { 10f64.powf(1.8 * random.next() - 1.3) };
            let [b, c] = [(1.0, 1.0), (1.0, 0.7), (0.9, 0.1), (0.2, 0.15), (0.8, 0.6)].map(<[f64; 2]>::from)
                [(5.0 * random.next()) as usize];
            axes.push([size, size * b, size * c]);
            let (u, half) = (random.unit(), PI * random.next());
            attitude.push([half.cos(), u.x * half.sin(), u.y * half.sin(), u.z * half.sin()]);
            if k == 0 {
                position.push(Vec3::zeros());
                continue;
            }
            let toward = if random.next() < 0.5 { e } else { s };
            let share = random.next();
            let aside =
                random.pick([0.0, 1.0 + size, (1.0 - size).abs(), share * (1.0 + size), share, share]);
            let beside = toward.cross(&random.unit()).normalize();
            position.push(toward * ((1.0 + size) * (1.0 + 20.0 * random.next().powi(3))) + beside * aside);
        }
        if count > 2 && random.next() < 0.2 {
            // The same body once more, right before itself.
            (axes[2], attitude[2]) = (axes[1], attitude[1]);
            position[2] = position[1] + e * (3.0 * axes[1][0]);
        }
        Self { axes, position, attitude, directions: [e, s] }
    }

    /// The brightness of each body, or `None` where bodies overlap, with the bodies in this order.
    fn brightness(&self, order: &[usize], law: Law, mutual: bool) -> Option<Vec<f64>> {
        let body = |k: &usize| Body::with_mass("", Shape::ellipsoid(self.axes[*k]).unwrap(), 1.0).unwrap();
        let surfaces = vec![Surface { law, albedo: vec![1.0] }; order.len()];
        let photometer = Photometer::new(order.iter().map(body).collect(), surfaces, mutual, 0.0).unwrap();
        let view = View {
            time: 0.0,
            position: &order.iter().map(|&k| self.position[k]).collect::<Vec<_>>(),
            attitude: &order.iter().map(|&k| self.attitude[k]).collect::<Vec<_>>(),
            velocity: &[],
            to_observer: self.directions[0],
            to_sun: self.directions[1],
            distant: true,
        };
        photometer.brightness(&view, &mut InterruptCheck::never()).ok()
    }

    /// The brightness of a body as a sum over points of the unit sphere, from each of which rays go to the
    /// observer and the Sun.
    fn summed(&self, body: usize, law: Law, count: usize) -> f64 {
        let turns: Vec<_> =
            self.attitude.iter().map(|&q| rotation::matrix(rotation::normalised(q))).collect();
        let axes: Vec<Vec3> = self.axes.iter().map(|&a| Vec3::from(a)).collect();
        let [p, q] = self.directions.map(|d| turns[body].tr_mul(&d).component_div(&axes[body]));
        let mut total = 0.0;
        for k in 0..count {
            let z = 1.0 - (2 * k + 1) as f64 / count as f64;
            let (sin, cos) = (k as f64 * 2.399963229728653).sin_cos();
            let u = Vec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            let (sight, light) = (p.dot(&u), q.dot(&u));
            let x = self.position[body] + turns[body] * u.component_mul(&axes[body]);
            let blocked = |d: &Vec3| {
                (0..axes.len()).filter(|other| *other != body).any(|other| {
                    let [y, w] = [x - self.position[other], *d]
                        .map(|v| turns[other].tr_mul(&v).component_div(&axes[other]));
                    y.dot(&w) < 0.0 && y.dot(&w).powi(2) > w.norm_squared() * (y.norm_squared() - 1.0)
                })
            };
            if sight > 0.0 && light > 0.0 && !self.directions.iter().any(blocked) {
                let n = u.component_div(&axes[body]).norm();
                let Law::Sum([first, second]) = law else { unreachable!() };
                total += sight * light / (sight + light) * (first + second * (sight + light) / n);
            }
        }
        total * axes[body].product() * 2.0 * TAU / count as f64
    }
}

#[test]
fn random_scenes_are_as_bright_as_rays_tell_in_any_order_of_the_bodies() {
    let mut hidden = 0;
    for seed in 0..400 {
        let scene = Scene::new(seed);
        let forward: Vec<usize> = (0..scene.axes.len()).collect();
        let back: Vec<usize> = forward.iter().rev().copied().collect();
        for law in LAWS.into_iter().take(if seed % 8 == 0 { 2 } else { 1 }) {
            let Some(found) = scene.brightness(&forward, law, true) else { continue };
            let other = scene.brightness(&back, law, true).unwrap();
            let alone = scene.brightness(&forward, law, false).unwrap();
            for body in forward.iter().copied() {
                let error = (found[body] - other[back.len() - 1 - body]).abs() / alone[body];
                assert!(error < 1e-11, "seed {seed}, body {body}, {law:?}: {error:e}");
                let partly = found[body] < 0.999 * alone[body];
                hidden += usize::from(partly);
                // Near 180 degrees few points are left.
                if partly && scene.directions[0].dot(&scene.directions[1]) > -0.9 {
                    let expected = scene.summed(body, law, 40_000);
                    let error = (found[body] - expected).abs() / alone[body];
                    assert!(error < 4e-3, "seed {seed}, body {body}, {law:?}: {} {expected}", found[body]);
                }
            }
        }
    }
    assert!(hidden > 200, "{hidden}");
}

#[test]
fn derivatives_by_the_direction_to_a_disc_of_the_sun_are_those_of_differences() {
    let (pair, _) = &cases()[5];
    let surfaces = vec![Surface { law: Law::LOMMEL_SEELIGER, albedo: vec![1.0] }; 2];
    let photometer = Photometer::new(pair.bodies(), surfaces, true, 0.2).unwrap();
    let partials = photometer.partials(&pair.view(), &mut InterruptCheck::never()).unwrap();
    let unit = pair.to_sun.normalize();
    for k in 0..3 {
        let mut shift = -unit * unit[k];
        shift[k] += 1.0;
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|step| {
            let view = View { to_sun: unit + shift * (step * 1e-4), ..pair.view() };
            photometer.brightness(&view, &mut InterruptCheck::never()).unwrap()
        });
        for body in 0..2 {
            let difference = (a[body] - 8.0 * b[body] + 8.0 * c[body] - d[body]) / 12e-4;
            let found = partials[body].1.by_direction[1][k];
            let size = pair.brightness(Law::LOMMEL_SEELIGER, false)[body];
            assert!((difference - found).abs() < 1e-6 * size, "{body} {k}: {difference} {found}");
        }
    }
}

#[test]
fn three_bodies_hide_parts_of_the_same_one() {
    // Two equal spheres before a large one, apart and then one behind the other: they hide twice as much as
    // one, or as much.
    let body = |name: &str, r: f64| Body::with_mass(name, Shape::sphere(r).unwrap(), 1.0).unwrap();
    let bodies = vec![body("large", 1.0), body("first", 0.2), body("second", 0.2)];
    let surfaces = vec![Surface { law: Law::LOMMEL_SEELIGER, albedo: vec![0.5] }; 3];
    let photometer = Photometer::new(bodies, surfaces, true, 0.0).unwrap();
    let lost = |second: Vec3| {
        let view = View {
            time: 0.0,
            position: &[Vec3::zeros(), Vec3::new(5.0, 0.3, 0.1), second],
            attitude: &[[1.0, 0.0, 0.0, 0.0]; 3],
            velocity: &[],
            to_observer: Vec3::x(),
            to_sun: Vec3::x(),
            distant: true,
        };
        0.25 * PI - photometer.brightness(&view, &mut InterruptCheck::never()).unwrap()[0]
    };
    let one = 0.25 * PI * 0.04;
    assert!((lost(Vec3::new(4.0, -0.3, 0.2)) - 2.0 * one).abs() < 1e-13);
    assert!((lost(Vec3::new(7.0, 0.3, 0.1)) - one).abs() < 1e-13);
    let part = 0.25 * overlap([0.2, 0.2], 0.15);
    assert!((lost(Vec3::new(7.0, 0.3, 0.25)) - (2.0 * one - part)).abs() < 1e-13);
}

#[test]
fn no_view_is_without_a_number() {
    // Axes along the light, silhouettes tangent from outside and from inside, concentric, the Sun behind.
    let suns = [Vec3::x(), Vec3::y(), -Vec3::x(), Vec3::new(1.0, 1e-9, 0.0), Vec3::new(-1.0, 0.0, 1e-9)];
    let asides = [[0.0, 0.0], [0.0, 1.4], [0.6, 0.0], [0.0, 0.6], [1.4, 0.0], [0.0, 1.0]];
    for sun in suns {
        for aside in asides {
            for law in [Law::LOMMEL_SEELIGER, Law::LAMBERT] {
                let pair = spheres([1.0, 0.4], aside, sun);
                let partials =
                    pair.photometer(law, true).partials(&pair.view(), &mut InterruptCheck::never()).unwrap();
                for (value, found) in partials {
                    let all = found.by_body.iter().flat_map(|by| [by.position, by.rotation, by.semi_axes]);
                    let mut all = all.chain(found.by_direction);
                    assert!((0.0..2.1).contains(&value), "{sun:?} {aside:?} {law:?} {value}");
                    assert!(all.all(|v| v.iter().all(|x| x.is_finite())), "{sun:?} {aside:?} {law:?}");
                }
            }
        }
    }
}

#[test]
fn nearness_of_centres_does_not_tell_which_body_is_in_front() {
    // A tilted plate whose centre is behind that of a ball, but which stands before it at the place of the
    // ball.
    let half = (0.125 * PI).sin_cos();
    let pair = Pair {
        axes: [[4.0, 4.0, 0.05], [0.3; 3]],
        position: vec![Vec3::zeros(), Vec3::new(2.4, 0.0, 1.6)],
        attitude: vec![[half.1, 0.0, -half.0, 0.0], [1.0, 0.0, 0.0, 0.0]],
        to_observer: Vec3::z(),
        to_sun: Vec3::z(),
    };
    let [plate, ball] = pair.brightness(Law::LOMMEL_SEELIGER, true)[..] else { panic!() };
    let alone = pair.brightness(Law::LOMMEL_SEELIGER, false);
    assert!(ball < 1e-14, "{ball}");
    assert!((plate - alone[0]).abs() < 1e-13, "{plate} {}", alone[0]);
}

#[test]
fn penumbra_is_the_mean_over_the_suns_disc() {
    // The shadow of the second sphere at the limb of the first; a spiral of places on the disc as the other
    // rule.
    let radius = 0.01;
    for aside in [0.7, 1.0, 1.35] {
        let to_sun = Vec3::new(1.0, 0.2, 0.0).normalize();
        let pair = spheres([1.0, 0.4], [1.0 + 0.2 * aside, aside], to_sun);
        let surfaces = vec![Surface { law: Law::LOMMEL_SEELIGER, albedo: vec![1.0] }; 2];
        let photometer = Photometer::new(pair.bodies(), surfaces, true, radius).unwrap();
        let found = photometer.brightness(&pair.view(), &mut InterruptCheck::never()).unwrap();
        let count = 4000;
        let (mut mean, across) = ([0.0; 2], [Vec3::new(-0.2, 1.0, 0.0).normalize(), Vec3::z()]);
        for k in 0..count {
            let place = radius.tan() * ((k as f64 + 0.5) / count as f64).sqrt();
            let (sin, cos) = (k as f64 * 2.399963229728653).sin_cos();
            let sun = to_sun + (across[0] * cos + across[1] * sin) * place;
            let part =
                Pair { to_sun: sun.normalize(), ..spheres([1.0, 0.4], [1.0 + 0.2 * aside, aside], sun) };
            let part = part.brightness(Law::LOMMEL_SEELIGER, true);
            (0..2).for_each(|b| mean[b] += part[b] / count as f64);
        }
        for b in 0..2 {
            assert!((found[b] - mean[b]).abs() < 2e-6, "{aside}, {b}: {:e}", found[b] - mean[b]);
        }
    }
}

#[test]
fn what_describes_nothing_is_refused_by_name() {
    let (pair, _) = &cases()[1];
    let surface = Surface { law: Law::LAMBERT, albedo: vec![1.0] };
    let with = |surface: &Surface, sun| {
        Photometer::new(pair.bodies(), vec![surface.clone(), surface.clone()], true, sun)
    };
    let text = |surface: &Surface, sun| with(surface, sun).unwrap_err().to_string();
    assert!(text(&Surface { albedo: vec![-1.0], ..surface.clone() }, 0.0).contains("albedo of a is -1"));
    assert!(text(&Surface { albedo: vec![f64::NAN], ..surface.clone() }, 0.0).contains("albedo of a"));
    assert!(
        text(&Surface { law: Law::Sum([1.0, f64::NAN]), ..surface.clone() }, 0.0)
            .contains("Lambert's law of the scattering law of a")
    );
    assert!(text(&surface, -0.1).contains("sun_radius is -0.1"));
    let photometer = with(&surface, 0.0).unwrap();
    let error =
        |view: View<'_>| photometer.brightness(&view, &mut InterruptCheck::never()).unwrap_err().to_string();
    assert!(error(View { to_sun: Vec3::zeros(), ..pair.view() }).contains("to_sun is zero"));
    assert!(
        error(View { to_observer: Vec3::repeat(f64::NAN), ..pair.view() })
            .contains("to_observer, component 0")
    );
    let position = [Vec3::zeros(), Vec3::repeat(0.1)];
    assert!(error(View { position: &position, ..pair.view() }).contains("a and b overlap"));
    assert!(error(View { position: &position[..1], ..pair.view() }).contains("number of positions is 1"));
}

#[test]
fn shadows_are_those_of_bodies_at_earlier_times() {
    // A body that crosses the sunlight of another one, fast: the shadow is where the body was when the light
    // passed it, by (x_j - x_i).(e + s) / c before the observer's light left it.
    let (e, s) = (Vec3::new(0.6, 0.8, 0.0), Vec3::x());
    let velocity = [Vec3::zeros(), Vec3::new(0.0, 0.0, 0.02)];
    let pair = Pair { to_observer: e, ..spheres([1.0, 0.4], [0.0, 0.9], s) };
    let photometer = pair.photometer(Law::LOMMEL_SEELIGER, true);
    let light = |pair: &Pair, velocity: &[Vec3]| {
        let view = View { velocity, ..pair.view() };
        photometer.brightness(&view, &mut InterruptCheck::never()).unwrap()[0]
    };
    let mut moved = Pair { to_observer: e, ..spheres([1.0, 0.4], [0.0, 0.9], s) };
    moved.position[1].z -= 0.02 * pair.position[1].dot(&(e + s));
    let [found, expected, neglected] = [light(&pair, &velocity), light(&moved, &[]), light(&pair, &[])];
    assert!((found - expected).abs() < 1e-13, "{found} {expected}");
    assert!((found - neglected).abs() > 1e-2, "{found} {neglected}");
}

#[test]
fn faces_have_albedos_of_their_own() {
    let (shape, e, s) = (polyhedron([1.0, 0.8, 0.6], 3), Vec3::new(0.3, 0.5, 0.8), Vec3::new(0.9, 0.2, 0.3));
    let Shape::Polyhedron(mesh) = &shape else { unreachable!() };
    let body = Body::with_mass("spotted", shape.clone(), 1.0).unwrap();
    let mut random = Random(7);
    let albedo: Vec<f64> = mesh.faces().iter().map(|_| random.next()).collect();
    let of = |albedo: Vec<f64>| {
        let surface = Surface { law: Law::LOMMEL_SEELIGER, albedo };
        Photometer::new(vec![body.clone()], vec![surface], true, 0.0)
    };
    let view = View {
        time: 0.0,
        position: &[Vec3::zeros()],
        attitude: &[[1.0, 0.0, 0.0, 0.0]],
        velocity: &[],
        to_observer: e,
        to_sun: s,
        distant: true,
    };
    let found = of(albedo.clone()).unwrap().brightness(&view, &mut InterruptCheck::never()).unwrap()[0];
    // The body is convex, so that no face hides another one.
    let (e, s) = (e.normalize(), s.normalize());
    let one = |(face, albedo): (usize, &f64)| {
        let [a, b, c] = mesh.corners(face);
        let across = (b - a).cross(&(c - a));
        let [mu, mu0] = [e, s].map(|d| across.normalize().dot(&d));
        if mu > 0.0 && mu0 > 0.0 { albedo * 0.5 * across.norm() * mu * mu0 / (mu + mu0) } else { 0.0 }
    };
    let expected: f64 = albedo.iter().enumerate().map(one).sum();
    assert!((found - expected).abs() < 1e-13, "{found} {expected}");
    let text = of(albedo[1..].to_vec()).unwrap_err().to_string();
    assert!(text.contains("number of values of albedo of spotted is 71"), "{text}");
    assert!(text.contains("one, or 72, one for each face"), "{text}");
}

#[test]
fn a_rough_surface_near_opposition_to_the_sun_comes_to_an_end() {
    // The brightness falls with the fourth power of the angle to 180 degrees.
    let law = hapke(0.5);
    let light = |angle: f64| {
        let pair = spheres([1.0, 0.1], [0.0, 9.0], Vec3::new(-angle.cos(), angle.sin(), 0.0));
        pair.brightness(law, true)[0]
    };
    for angle in [1e-5, 3e-6, 1e-6, 1e-7] {
        let ratio = light(angle) / light(1e-4);
        assert!((ratio / (angle / 1e-4).powi(4) - 1.0).abs() < 2e-3, "{angle} {ratio}");
    }
}
