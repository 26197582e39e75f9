//! Radar echoes: closed forms of a sphere, sums of bins, refusals, interruptions.

use crate::polyhedron::cuboid;
use fullbody::error::Error;
use fullbody::interrupt::InterruptCheck;
use fullbody::math::{Vec3, rotation};
use fullbody::photometry::View;
use fullbody::radar::{Bins, BodyEcho, EchoView, Law, Radar};
use fullbody::shape::{Body, Shape};
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;

const POSITION: [Vec3; 1] = [Vec3::new(0.0, 0.0, 0.0)];
const ATTITUDE: [[f64; 4]; 1] = [[0.5, 0.5, 0.5, 0.5]];
/// The frequency is y and the delay is -2 x.
const ECHO: [BodyEcho; 1] =
    [BodyEcho { at_centre: [0.0, 0.0], gradients: [Vec3::new(0.0, 1.0, 0.0), Vec3::new(-2.0, 0.0, 0.0)] }];

fn view<'a>(to_sun: Vec3) -> EchoView<'a> {
    let (position, attitude, to_observer) = (&POSITION, &ATTITUDE, Vec3::x());
    let view = View { time: 3.0, position, attitude, velocity: &[], to_observer, to_sun, distant: true };
    EchoView { view, echoes: &ECHO }
}

fn radar(axes: [f64; 3], law: Law) -> Radar {
    let body = Body::with_mass("Alpha", Shape::ellipsoid(axes).unwrap(), 1.0).unwrap();
    Radar::new(vec![body], vec![law], true).unwrap()
}

fn edges(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..=count).map(|k| low + (high - low) * k as f64 / count as f64).collect()
}

#[test]
fn a_sphere_has_the_echo_of_its_law_up_to_each_delay_and_frequency() {
    // The law 2 cos^2 has 4/3 pi (1 - cos^3) at incidences up to that of the cosine, and a spectrum in proportion to
    // 1 - y^2.
    let radar = radar([1.0; 3], Law::cosine(1.0, 1.0).unwrap());
    let (frequencies, delays) = (edges(-1.0, 1.0, 20), edges(-2.0, 0.0, 10));
    let bins = Bins::new(&frequencies, &delays).unwrap();
    let power = radar.echo(&[view(Vec3::x())], &bins, &mut InterruptCheck::never()).unwrap();
    for (k, row) in power.chunks(20).enumerate() {
        let cube = |k: usize| (1.0 - 0.1 * k as f64).powi(3);
        let expected = 4.0 / 3.0 * PI * (cube(k) - cube(k + 1));
        assert!((row.iter().sum::<f64>() - expected).abs() < 1e-11, "{k}");
    }
    for k in 0..20 {
        let column: f64 = power.iter().skip(k).step_by(20).sum();
        let below = |y: f64| PI * (y - y * y * y / 3.0);
        assert!((column - (below(frequencies[k + 1]) - below(frequencies[k]))).abs() < 1e-11, "{k}");
    }
}

#[test]
fn sharp_peaks_are_not_missed() {
    // A sphere of radius one has the cross section 2 pi R (C + 1) / (2 C + 1).
    let (frequencies, to_sun) = (edges(-1.1, 1.1, 2), Vec3::x());
    let bins = Bins::new(&frequencies, &[]).unwrap();
    for c in [3.3, 30.0, 1e3, 1e5] {
        let radar = radar([1.0; 3], Law::cosine(c, 0.3).unwrap());
        let power = radar.echo(&[view(to_sun)], &bins, &mut InterruptCheck::never()).unwrap();
        let expected = 0.6 * PI * (c + 1.0) / (2.0 * c + 1.0);
        assert!((power.iter().sum::<f64>() / expected - 1.0).abs() < 1e-12 + 1e-14 * c, "{c}");
    }
    // The sum of a spectrum does not depend on the direction in which the frequency changes.
    for law in
        [Law::gaussian(3e3, 0.3, FRAC_PI_2), Law::hagfors(1e3, 0.3, FRAC_PI_2), Law::cosine(300.5, 0.3)]
    {
        let radar = radar([1.0, 0.8, 0.1], law.unwrap());
        let total = |angle: f64| {
            let gradients = [Vec3::new(0.0, angle.cos(), angle.sin()), ECHO[0].gradients[1]];
            let echoes = [BodyEcho { at_centre: [0.0, 0.0], gradients }];
            let view = EchoView { echoes: &echoes, ..view(to_sun) };
            radar.echo(&[view], &bins, &mut InterruptCheck::never()).unwrap().iter().sum::<f64>()
        };
        assert!((total(0.3) / total(1.4) - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_body_hidden_by_its_equal_has_no_echo() {
    let body = |name: &str| Body::with_mass(name, Shape::ellipsoid([1.0; 3]).unwrap(), 1.0).unwrap();
    let law = Law::cosine(1.6, 1.0).unwrap();
    let radar = Radar::new(vec![body("Alpha"), body("Beta")], vec![law, law], true).unwrap();
    let position = [Vec3::zeros(), Vec3::new(5.0, 0.0, 0.0)];
    let attitude = [ATTITUDE[0], ATTITUDE[0]];
    let one = view(Vec3::x());
    let view = View { position: &position, attitude: &attitude, ..one.view };
    let frequencies = edges(-1.1, 1.1, 11);
    let bins = Bins::new(&frequencies, &[]).unwrap();
    let echoes = [ECHO[0], ECHO[0]];
    let power =
        radar.echo(&[EchoView { view, echoes: &echoes }], &bins, &mut InterruptCheck::never()).unwrap();
    let [behind, before] = [&power[..11], &power[11..]].map(|power| power.iter().sum::<f64>());
    assert!(behind < 1e-9 * before, "{behind}");
    assert!((before / (2.0 * PI * 2.6 / 4.2) - 1.0).abs() < 1e-11);
}

/// Two spheres of the radii 1 and 0.6, the smaller one in front and aside.
#[test]
fn a_sphere_loses_to_one_in_front_what_arcs_of_circles_tell() {
    let body = |name, radius| Body::with_mass(name, Shape::ellipsoid([radius; 3]).unwrap(), 1.0).unwrap();
    let law = Law::cosine(1.0, 1.0).unwrap();
    let radar = Radar::new(vec![body("Alpha", 1.0), body("Beta", 0.6)], vec![law, law], true).unwrap();
    let (frequencies, delays) = (edges(-1.1, 1.1, 11), edges(-2.0, 0.0, 8));
    for d in [0.1, 0.5, 0.9, 1.3, 1.7] {
        let position = [Vec3::zeros(), Vec3::new(5.0, 0.8 * d, -0.6 * d)];
        let view = View { position: &position, attitude: &[ATTITUDE[0]; 2], ..view(Vec3::x()).view };
        let echo = |delays: &[f64]| {
            let bins = Bins::new(&frequencies, delays).unwrap();
            let views = [EchoView { view, echoes: &[ECHO[0]; 2] }];
            radar.echo(&views, &bins, &mut InterruptCheck::never()).unwrap()
        };
        let (image, spectrum) = (echo(&delays), echo(&[]));
        // The echo 2 cos^2 dS of a ring of the radius r is 2 sqrt(1 - r^2) times its length, of which the disc in
        // front leaves this, times dr. With the cosine x it is 2 x^2 dx times the angle.
        let angle = |r: f64| {
            let cos = (r * r + d * d - 0.36) / (2.0 * r * d);
            2.0 * (PI - cos.clamp(-1.0, 1.0).acos())
        };
        for (k, row) in image[..88].chunks(11).enumerate() {
            let (low, count) = (1.0 - 0.125 * (k + 1) as f64, 20_000);
            let expected: f64 = (0..count)
                .map(|i| low + 0.125 * (f64::from(i) + 0.5) / f64::from(count))
                .map(|x| 0.125 / f64::from(count) * 2.0 * x * x * angle((1.0 - x * x).sqrt()))
                .sum();
            let found: f64 = row.iter().sum();
            assert!((found - expected).abs() < 1e-6, "{d}, {k}: {found} {expected}");
        }
        for k in 0..11 {
            let column: f64 = image[..88].iter().skip(k).step_by(11).sum();
            assert!((column - spectrum[k]).abs() < 1e-9, "{d}, {k}: {column} {}", spectrum[k]);
        }
    }
}

#[test]
fn facets_have_the_echo_of_points_on_them() {
    const COUNT: usize = 240;
    let cuboid = Shape::Polyhedron(cuboid([-0.5, -0.4, -0.3], [1.0, 0.8, 0.6]));
    let body = Body::with_mass("Alpha", cuboid, 1.0).unwrap();
    let radar = Radar::new(vec![body.clone()], vec![Law::cosine(1.0, 1.0).unwrap()], true).unwrap();
    let attitude = [[0.8, 0.2, -0.4, 0.4]];
    let (frequencies, delays) = (edges(-0.8, 0.8, 8), edges(-1.6, 1.6, 16));
    let bins = Bins::new(&frequencies, &delays).unwrap();
    let one = view(Vec3::x());
    let views = [EchoView { view: View { attitude: &attitude, ..one.view }, ..one }];
    let power = radar.echo(&views, &bins, &mut InterruptCheck::never()).unwrap();
    let (mut expected, mut total) = (vec![0.0; 128], 0.0);
    let Shape::Polyhedron(polyhedron) = &body.parts()[0].shape else { unreachable!() };
    for face in 0..polyhedron.faces().len() {
        let [a, b, c] = polyhedron.corners(face).map(|v| rotation::matrix(attitude[0]) * v);
        let normal = (b - a).cross(&(c - a));
        let cosine = normal.normalize().x.max(0.0);
        let cell = cosine * cosine * normal.norm() / (COUNT * COUNT) as f64;
        // The centres of equal triangles.
        let lower = (0..COUNT).flat_map(|i| (0..COUNT - i).map(move |j| (i, j, 1.0 / 3.0)));
        let upper = (0..COUNT - 1).flat_map(|i| (0..COUNT - 1 - i).map(move |j| (i, j, 2.0 / 3.0)));
        for (i, j, within) in lower.chain(upper) {
            let [u, v] = [i, j].map(|k| (k as f64 + within) / COUNT as f64);
            let x = a + (b - a) * u + (c - a) * v;
            let [column, row] = [(x.y + 0.8) / 0.2, (1.6 - 2.0 * x.x) / 0.2].map(|place| place as usize);
            expected[8 * row + column] += cell;
            total += cell;
        }
    }
    assert!(power.iter().filter(|power| **power > 1e-3).count() > 10);
    for (found, expected) in power.iter().zip(&expected) {
        assert!((found - expected).abs() < 2e-3 * total, "{found} {expected}");
    }
}

#[test]
fn many_spectra_are_those_of_each_alone() {
    let radar = radar([1.0, 0.7, 0.5], Law::hagfors(20.0, 0.3, 1.2).unwrap());
    let frequencies = edges(-1.0, 1.0, 30);
    let bins = Bins::new(&frequencies, &[]).unwrap();
    let views: Vec<_> = (0..50).map(|k| view(Vec3::new(1.0, 0.02 * f64::from(k), 0.1))).collect();
    let all = radar.echo(&views, &bins, &mut InterruptCheck::never()).unwrap();
    for (view, row) in views.iter().zip(all.chunks(30)) {
        let alone = radar.echo(&[*view], &bins, &mut InterruptCheck::never()).unwrap();
        assert_eq!(alone, row);
    }
}

#[test]
fn edges_laws_and_antennas_that_cannot_be_are_refused_by_name() {
    let told = |error: Error| error.to_string();
    let refused = |frequencies: &[f64], delays: &[f64]| told(Bins::new(frequencies, delays).unwrap_err());
    assert!(refused(&[0.0], &[]).contains("number of frequencies is 1"));
    assert!(refused(&[0.0, 2.0, 1.0], &[]).contains("edge 2 of frequencies is 1 after 2"));
    assert!(refused(&[0.0, 1.0], &[1.0, 1.0]).contains("edge 1 of delays"));
    assert!(refused(&[0.0, f64::NAN], &[]).contains("frequencies, component 1"));
    assert!(refused(&vec![0.0; 100_001], &[]).contains("at most 100000"));
    assert!(told(Law::cosine(-1.0, 1.0).unwrap_err()).starts_with("C is -1"));
    assert!(told(Law::gaussian(1.0, 1.0, 2.0).unwrap_err()).starts_with("cutoff is 2"));
    assert!(told(Law::hagfors(0.0, 1.0, FRAC_PI_2).unwrap_err()).starts_with("C is 0"));
    let radar = radar([1.0; 3], Law::cosine(1.0, 1.0).unwrap());
    let bins = Bins::new(&[0.0, 1.0], &[]).unwrap();
    let error = radar.echo(&[view(-Vec3::x())], &bins, &mut InterruptCheck::never()).unwrap_err();
    assert!(told(error).contains("transmitter as seen from Alpha"));
}

#[test]
fn long_images_and_spectra_can_be_interrupted() {
    let radar = radar([1.0, 0.7, 0.5], Law::gaussian(300.0, 0.3, FRAC_PI_2).unwrap());
    let (frequencies, delays) = (edges(-1.0, 1.0, 64), edges(-2.0, 0.0, 2000));
    for delays in [&delays[..], &[]] {
        let bins = Bins::new(&frequencies, delays).unwrap();
        let views = vec![view(Vec3::x()); if delays.is_empty() { 20_000 } else { 1 }];
        let mut stop = || ControlFlow::Break(());
        let answer = radar.echo(&views, &bins, &mut InterruptCheck::new(&mut stop));
        assert_eq!(answer, Err(Error::Interrupted { time: 3.0 }));
    }
}
