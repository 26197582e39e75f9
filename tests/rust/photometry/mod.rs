//! Brightness of bodies, by arbitrary-precision values, closed forms and symmetries.

mod derivatives;
mod scenes;
mod spheres;
mod views;

use crate::support::{data, number, triple};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::{Vec3, rotation};
use fullbody::photometry::{Hapke, Law, Photometer, Surface, View};
use fullbody::shape::{Body, Shape};
use std::f64::consts::PI;

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

fn hapke(roughness: f64) -> Law {
    Law::Hapke(Hapke {
        single_scattering_albedo: 0.3,
        opposition_amplitude: 1.0,
        opposition_width: 0.05,
        asymmetry: -0.3,
        roughness,
    })
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

/// Returns the light of an ellipsoid in the axes' frame and its first moments, summed over its surface.
fn surface_sums(axes: [f64; 3], directions: [Vec3; 2], law: impl Fn(f64, f64) -> f64) -> (f64, Vec3) {
    const COUNT: usize = 400;
    let axes = Vec3::from(axes);
    let (mut light, mut moment) = (0.0, Vec3::zeros());
    for i in 0..COUNT {
        let z = (2 * i + 1) as f64 / COUNT as f64 - 1.0;
        for k in 0..2 * COUNT {
            let (sin, cos) = (PI * (k as f64 + 0.5) / COUNT as f64).sin_cos();
            let u = Vec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            // The area of an element of the sphere, stretched, and its normal.
            let area = u.component_div(&axes) * axes.product() * (2.0 * PI / (COUNT * COUNT) as f64);
            let [mu, mu0] = directions.map(|direction| direction.dot(&area.normalize()));
            if mu > 0.0 && mu0 > 0.0 {
                let share = law(mu, mu0) * area.norm();
                light += share;
                moment += u.component_mul(&axes) * share;
            }
        }
    }
    (light, moment)
}

#[test]
fn first_moments_are_sums_over_the_surface() {
    let axes = [1.0, 0.8, 0.6];
    let directions = [Vec3::new(0.6, 0.48, 0.64), Vec3::new(-0.36, 0.8, 0.48)];
    let pair = Pair {
        axes: [axes; 2],
        position: vec![Vec3::zeros(), Vec3::new(50.0, 0.0, 0.0)],
        attitude: vec![[1.0, 0.0, 0.0, 0.0]; 2],
        to_observer: directions[0],
        to_sun: directions[1],
    };
    for law in LAWS {
        let function = |mu: f64, mu0: f64| mu * mu0 / if law == Law::LAMBERT { 1.0 } else { mu + mu0 };
        let photometer = pair.photometer(law, false);
        let (light, moment) = photometer.moments_in(&[pair.view()], &mut InterruptCheck::never()).unwrap()[0];
        let (expected, sums) = surface_sums(axes, directions, function);
        assert!((light - expected).abs() < 1e-4 * expected, "{law:?}: {light} {expected}");
        assert!((moment - sums).norm() < 1e-4 * expected, "{law:?}: {moment} {sums}");
    }
}

#[test]
fn first_moments_of_an_ellipsoid_lose_to_facets_what_they_lose_to_an_ellipsoid() {
    let law = Law::LOMMEL_SEELIGER;
    let mut hidden = 0;
    for (pair, _) in cases().iter().step_by(3) {
        let moments = |photometer: Photometer| {
            photometer.moments_in(&[pair.view()], &mut InterruptCheck::never()).unwrap()[0]
        };
        let bodies =
            vec![pair.bodies()[0].clone(), Body::with_mass("b", polyhedron(pair.axes[1], 24), 1.0).unwrap()];
        let surfaces = vec![Surface { law, albedo: vec![1.0] }; 2];
        let (light, moment) = moments(Photometer::new(bodies, surfaces, true, 0.0).unwrap());
        let (expected, sums) = moments(pair.photometer(law, true));
        let (alone, _) = moments(pair.photometer(law, false));
        // The light and the moment of what is hidden are those of a body of facets, which is a little smaller.
        let (size, lost) = (Vec3::from(pair.axes[0]).max(), alone - expected);
        assert!((light - expected).abs() < 4e-3 * lost + 1e-12 * alone, "{light} {expected} {alone}");
        assert!((moment - sums).norm() < size * (1e-2 * lost + 1e-9 * alone), "{moment} {sums}");
        hidden += usize::from(lost > 1e-3 * alone && light > 1e-3 * alone);
    }
    assert!(hidden > 3, "{hidden}");
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
