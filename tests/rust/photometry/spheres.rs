//! Brightness of two spheres that hide each other, by closed forms and sums over circles.

use super::Pair;
use fullbody::interrupt::InterruptCheck;
use fullbody::math::Vec3;
use fullbody::photometry::{Law, Photometer, Surface};
use std::f64::consts::{PI, TAU};

/// Two spheres, the second one before the first along x, with its centre aside.
pub(super) fn spheres(radii: [f64; 2], aside: [f64; 2], to_sun: Vec3) -> Pair {
    Pair {
        axes: radii.map(|r| [r; 3]),
        position: vec![Vec3::zeros(), Vec3::new(5.0, aside[0], aside[1])],
        attitude: vec![[1.0, 0.0, 0.0, 0.0]; 2],
        to_observer: Vec3::x(),
        to_sun,
    }
}

/// The common area of two circles whose centres are d apart.
pub(super) fn overlap([r, s]: [f64; 2], d: f64) -> f64 {
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
