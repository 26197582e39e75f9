//! Brightness of random scenes of up to four bodies, by rays.

use super::LAWS;
use fullbody::interrupt::InterruptCheck;
use fullbody::math::{Vec3, rotation};
use fullbody::photometry::{Law, Photometer, Surface, View};
use fullbody::shape::{Body, Shape};
use std::f64::consts::{PI, TAU};

/// Random numbers from 0 to 1.
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(super) fn pick<const N: usize>(&mut self, all: [f64; N]) -> f64 {
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
