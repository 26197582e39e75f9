//! Tests of particular views: degenerate geometry, a near observer, light time between bodies, albedos of faces, and
//! invalid input.

use super::scenes::Random;
use super::spheres::{overlap, spheres};
use super::{Pair, cases, hapke, polyhedron};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::Vec3;
use fullbody::photometry::{Law, Photometer, Surface, View};
use fullbody::shape::{Body, Shape};
use std::f64::consts::PI;

#[test]
fn two_occulting_bodies_hide_the_union_of_their_outlines() {
    // Two equal spheres in front of a large one: side by side they hide twice as much as one, one behind the
    // other as much as one, and in between less by the overlap of their outlines.
    let body = |name: &str, r: f64| Body::with_mass(name, Shape::sphere(r).unwrap(), 1.0).unwrap();
    let bodies = vec![body("large", 1.0), body("first", 0.2), body("second", 0.2)];
    let surfaces = vec![Surface { law: Law::LOMMEL_SEELIGER, albedo: vec![0.5] }; 3];
    let photometer = Photometer::new(bodies, surfaces, true, 0.0).unwrap();
    let loss = |second: Vec3| {
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
    assert!((loss(Vec3::new(4.0, -0.3, 0.2)) - 2.0 * one).abs() < 1e-13);
    assert!((loss(Vec3::new(7.0, 0.3, 0.1)) - one).abs() < 1e-13);
    let part = 0.25 * overlap([0.2, 0.2], 0.15);
    assert!((loss(Vec3::new(7.0, 0.3, 0.25)) - (2.0 * one - part)).abs() < 1e-13);
}

#[test]
fn brightness_and_derivatives_are_finite_in_degenerate_views() {
    // The light is along an axis, silhouettes are concentric or tangent from outside or inside, or the Sun is
    // behind the bodies.
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
fn the_body_in_front_need_not_have_the_nearer_centre() {
    // The centre of a tilted plate is farther from the observer than that of a ball, but where the plate covers
    // the ball it is nearer.
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
fn an_occulting_body_hides_more_from_a_near_observer() {
    // A sphere of this radius is at distance 3 from an observer, in front of one of radius 1 at distance 8. Projected
    // from the observer onto the plane through the centre of the farther one, its outline is 8/3 times as large.
    let lost_fraction = |radius: f64, distant: bool| {
        let pair = spheres([1.0, radius], [0.0, 0.0], Vec3::x() * 1e7);
        let view = View { to_observer: Vec3::x() * 8.0, distant, ..pair.view() };
        let [hidden, alone] = [true, false].map(|mutual| {
            let photometer = pair.photometer(Law::LOMMEL_SEELIGER, mutual);
            photometer.brightness(&view, &mut InterruptCheck::never()).unwrap()
        });
        assert!((hidden[1] / alone[1] - 1.0).abs() < 1e-12, "{hidden:?} {alone:?}");
        1.0 - hidden[0] / alone[0]
    };
    for radius in [0.1_f64, 0.3, 0.35] {
        assert!((lost_fraction(radius, true) - radius.powi(2)).abs() < 1e-9);
        assert!((lost_fraction(radius, false) - (radius * 8.0 / 3.0).powi(2)).abs() < 1e-5);
    }
    assert!((lost_fraction(0.4, false) - 1.0).abs() < 1e-9);
}

#[test]
fn invalid_surfaces_and_views_are_refused_with_the_name_of_the_input() {
    let (pair, _) = &cases()[1];
    let surface = Surface { law: Law::LAMBERT, albedo: vec![1.0] };
    let photometer = |surface: &Surface, sun_radius| {
        Photometer::new(pair.bodies(), vec![surface.clone(), surface.clone()], true, sun_radius)
    };
    let refusal = |surface: &Surface, sun| photometer(surface, sun).unwrap_err().to_string();
    assert!(refusal(&Surface { albedo: vec![-1.0], ..surface.clone() }, 0.0).contains("albedo of a is -1"));
    assert!(refusal(&Surface { albedo: vec![f64::NAN], ..surface.clone() }, 0.0).contains("albedo of a"));
    assert!(
        refusal(&Surface { law: Law::Sum([1.0, f64::NAN]), ..surface.clone() }, 0.0)
            .contains("Lambert's law of the scattering law of a")
    );
    assert!(refusal(&surface, -0.1).contains("sun_radius is -0.1"));
    let photometer = photometer(&surface, 0.0).unwrap();
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
fn eclipses_allow_for_the_light_time_between_bodies() {
    // Body j moves fast across the sunlight of body i. The light that i scatters to the observer passed j earlier
    // than the light of j that arrives with it left j, by (x_j - x_i).(e + s)/c: the shadow is that of j there.
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
fn each_face_of_a_polyhedron_has_its_own_albedo() {
    let (shape, e, s) = (polyhedron([1.0, 0.8, 0.6], 3), Vec3::new(0.3, 0.5, 0.8), Vec3::new(0.9, 0.2, 0.3));
    let Shape::Polyhedron(mesh) = &shape else { unreachable!() };
    let body = Body::with_mass("spotted", shape.clone(), 1.0).unwrap();
    let mut random = Random(7);
    let albedo: Vec<f64> = mesh.faces().iter().map(|_| random.next()).collect();
    let photometer = |albedo: Vec<f64>| {
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
    let found =
        photometer(albedo.clone()).unwrap().brightness(&view, &mut InterruptCheck::never()).unwrap()[0];
    // The body is convex, so that no face hides another one.
    let (e, s) = (e.normalize(), s.normalize());
    let face_brightness = |(face, albedo): (usize, &f64)| {
        let [a, b, c] = mesh.corners(face);
        let twice_area = (b - a).cross(&(c - a));
        let [mu, mu0] = [e, s].map(|d| twice_area.normalize().dot(&d));
        if mu > 0.0 && mu0 > 0.0 { albedo * 0.5 * twice_area.norm() * mu * mu0 / (mu + mu0) } else { 0.0 }
    };
    let expected: f64 = albedo.iter().enumerate().map(face_brightness).sum();
    assert!((found - expected).abs() < 1e-13, "{found} {expected}");
    let text = photometer(albedo[1..].to_vec()).unwrap_err().to_string();
    assert!(text.contains("number of values of albedo of spotted is 71"), "{text}");
    assert!(text.contains("one, or 72, one for each face"), "{text}");
}

#[test]
fn near_a_phase_angle_of_pi_a_rough_sphere_fades_as_the_fourth_power() {
    // The power is that of pi minus the phase angle; the second sphere is out of the way.
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
