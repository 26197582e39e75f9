//! Fixed steps: exact flows, orders, reversal, energy without drift.

use super::systems::*;
use crate::support::{cases, direction, semi_axes};
use fullbody::dynamics::{
    AttitudeChart, FreeRotor, Settings, State, System, rotation_angle_bound, variational_rotation,
};
use fullbody::error::{Error, Result};
use fullbody::integrate::Scheme;
use fullbody::interrupt::InterruptCheck;
use fullbody::math::lanes::VectorPath;
use fullbody::math::{Vec3, rotation};
use fullbody::mutual::Method;
use fullbody::names::Named;
use fullbody::orbit::kepler_change;
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{Integrator, Output, Simulation};
use proptest::prelude::*;

/// Jacobi's sn, cn, dn by descending Landen transformations (arithmetic-geometric mean), for modulus squared
/// `m`.
fn jacobi(u: f64, m: f64) -> (f64, f64, f64) {
    let (mut a, mut b) = (vec![1.0], (1.0 - m).sqrt());
    let mut c = vec![m.sqrt()];
    while c[c.len() - 1].abs() > 1e-17 && c.len() < 30 {
        let last = a[a.len() - 1];
        c.push(0.5 * (last - b));
        a.push(0.5 * (last + b));
        b = (last * b).sqrt();
    }
    let mut angle = a[a.len() - 1] * u * 2.0_f64.powi(a.len() as i32 - 1);
    for k in (1..a.len()).rev() {
        angle = 0.5 * (angle + (c[k] / a[k] * angle.sin()).asin());
    }
    let (s, cosine) = angle.sin_cos();
    (s, cosine, (1.0 - m * s * s).sqrt())
}

/// Euler's top against Jacobi's functions (Landau & Lifshitz, Mechanics, section 37), its angular momentum in
/// space, and a reversed turn.
#[test]
fn free_tops_follow_jacobis_functions() {
    let inertia = Vec3::new(1.0, 1.7, 2.4);
    // L^2 > 2 E I_2: about the axis of the largest moment; starting where the second component is zero.
    let start = Vec3::new(0.6, 0.0, 1.1);
    let energy2 = inertia.dot(&start.component_mul(&start));
    let square = inertia.component_mul(&start).norm_squared();
    let [i1, i2, i3] = [inertia.x, inertia.y, inertia.z];
    let rate = ((i3 - i2) * (square - energy2 * i1) / (i1 * i2 * i3)).sqrt();
    let m = (i2 - i1) * (energy2 * i3 - square) / ((i3 - i2) * (square - energy2 * i1));
    let second = ((energy2 * i3 - square) / (i2 * (i3 - i2))).sqrt();
    let q = rotation::normalised([0.3, -0.5, 0.7, 0.2]);
    for time in [0.05, 0.7, 3.0, -11.0] {
        let (turned, change) = FreeRotor::new(inertia).rotate(q, start, time).unwrap();
        let (sn, cn, dn) = jacobi(rate * time, m);
        let spin = start + change;
        let expected = Vec3::new(start.x * cn, second * sn, start.z * dn);
        // The second component's sign: I_2 dw_2/dt = (I_3 - I_1) w_3 w_1 > 0.
        assert!((spin - expected).norm() < 1e-14, "{time}: {spin:?} {expected:?}");
        let p: [f64; 4] = std::array::from_fn(|k| q[k] + turned[k]);
        let length = p.iter().map(|x| x * x).sum::<f64>();
        assert!((length - 1.0).abs() < 4e-15, "{length}");
        let momentum = |q, w: Vec3| rotation::matrix(q) * inertia.component_mul(&w);
        assert!((momentum(p, spin) - momentum(q, start)).norm() < 4e-15);
        let (back, _) = FreeRotor::new(inertia).rotate(p, spin, -time).unwrap();
        let error = (0..4).map(|k| (p[k] + back[k] - q[k]).abs()).fold(0.0, f64::max);
        assert!(error < 4e-15, "{error:e}");
    }
}

/// A needle that tumbles end over end, against Jacobi's functions: no more pieces than its own turning takes,
/// where its angular momentum over its smallest moment is a turn of millions of rad.
#[test]
fn a_needle_that_tumbles_follows_jacobis_functions() {
    let [a, b, c] = [1.0, 1.2e-3, 1e-3_f64];
    let inertia = Vec3::new(b * b + c * c, c * c + a * a, a * a + b * b) / 5.0;
    let start = Vec3::new(0.3, 0.0, 1.1);
    let [i1, i2, i3] = [inertia.x, inertia.y, inertia.z];
    // L^2 - 2 T I_2 and the like without their cancellation.
    let beyond_second = i3 * (i3 - i2) * start.z * start.z - i1 * (i2 - i1) * start.x * start.x;
    let beyond_first = i3 * (i3 - i1) * start.z * start.z;
    let below_third = i1 * (i3 - i1) * start.x * start.x;
    assert!(beyond_second > 0.0);
    let rate = ((i3 - i2) * beyond_first / (i1 * i2 * i3)).sqrt();
    let m = (i2 - i1) * below_third / ((i3 - i2) * beyond_first);
    let second = (below_third / (i2 * (i3 - i2))).sqrt();
    for time in [3.0, -40.0, 300.0] {
        assert!(inertia.component_mul(&start).norm() / i1 * f64::abs(time) > 1e6);
        assert!(rotation_angle_bound(inertia, start, time) < 1.5 * start.norm() * time.abs());
        let (turned, change) = FreeRotor::new(inertia).rotate([1.0, 0.0, 0.0, 0.0], start, time).unwrap();
        let (sn, cn, dn) = jacobi(rate * time, m);
        let expected = Vec3::new(start.x * cn, second * sn, start.z * dn);
        let error = (start + change - expected).norm();
        println!("needle after {time}: {error:.1e}");
        assert!(error < 1e-12 * time.abs(), "{time}: {error:e}");
        let length = turned[1..].iter().chain([&(1.0 + turned[0])]).map(|x| x * x).sum::<f64>();
        assert!((length - 1.0).abs() < 1e-13, "{length}");
    }
}

proptest! {
    #![proptest_config(cases(200))]

    /// The spin of a free body never exceeds its bound, and for some bodies comes near it.
    #[test]
    fn the_spin_stays_below_its_bound(axes in semi_axes(1e-3), along in direction()) {
        let [a, b, c] = axes;
        let inertia = Vec3::new(b * b + c * c, c * c + a * a, a * a + b * b) / 5.0;
        let (mut spin, mut q) = (along, [1.0, 0.0, 0.0, 0.0]);
        // Over so long a time the bound by the energy counts as well.
        let bound = rotation_angle_bound(inertia, along, 1e6) / 1e6;
        for _ in 0..200 {
            let (turned, change) = FreeRotor::new(inertia).rotate(q, spin, 0.37).unwrap();
            (0..4).for_each(|k| q[k] += turned[k]);
            spin += change;
            prop_assert!(spin.norm() <= bound * (1.0 + 1e-12), "{} {bound}", spin.norm());
        }
    }
}

/// The symmetric top's two rotations against the closed form of a body that differs from it by little, for
/// every axis and kind, and for more than a whole turn.
#[test]
fn symmetric_tops_agree_with_nearly_symmetric_ones() {
    for axis in 0..3 {
        for (along, across) in [(2.0, 1.2), (0.7, 1.2), (1.2, 1.2)] {
            let mut inertia = Vec3::repeat(across);
            inertia[axis] = along;
            let mut near = inertia;
            near[(axis + 1) % 3] *= 1.0 + 1e-12;
            near[(axis + 2) % 3] *= 1.0 - 1e-12;
            let spin = Vec3::new(0.4, -0.3, 0.8);
            let q = [0.5, 0.5, -0.5, 0.5];
            for time in [1.3, -4.0, 40.0] {
                let [(a, u), (b, v)] =
                    [inertia, near].map(|moments| FreeRotor::new(moments).rotate(q, spin, time).unwrap());
                let bound = 1e-11 * time.abs();
                assert!((u - v).norm() < bound && (0..4).all(|k| (a[k] - b[k]).abs() < bound));
            }
        }
    }
}

/// A body that does not turn stays as it is, and so does one in no time.
#[test]
fn a_top_at_rest_stays() {
    let (spin, q) = (Vec3::new(0.4, -0.3, 0.8), [0.5, 0.5, -0.5, 0.5]);
    for inertia in [Vec3::new(1.0, 1.7, 2.4), Vec3::new(1.0, 1.0, 2.4), Vec3::zeros()] {
        for (spin, time) in [(Vec3::zeros(), 1.3), (spin, 0.0)] {
            assert_eq!(FreeRotor::new(inertia).rotate(q, spin, time).unwrap(), ([0.0; 4], Vec3::zeros()));
        }
    }
}

/// Bodies of all kinds that turn side by side turn as each does alone, slow ones beside fast ones.
#[test]
fn tops_side_by_side() {
    let axes = |k: usize| match k % 4 {
        0 => [0.3, 0.3, 0.2],
        1 => [0.3, 0.25, 0.2],
        2 => [0.2, 0.3, 0.25],
        _ => [0.2, 0.3, 0.3],
    };
    let bodies: Vec<Body> = (0..23)
        .map(|k| {
            let shape = if k == 7 { Shape::Point } else { Shape::ellipsoid(axes(k)).unwrap() };
            Body::with_mass(format!("{k}"), shape, 1.0 + 0.1 * k as f64).unwrap()
        })
        .collect();
    let start = |k: usize| {
        let (a, speed) = (k as f64, 0.05 * 1.3_f64.powi(k as i32));
        let spin = Vec3::new(a.sin(), (2.0 * a).cos(), (0.7 * a).cos()) * speed;
        (rotation::normalised([1.0, 0.3 * a.cos(), -0.2, 0.5 * a.sin()]), spin)
    };
    let position = (0..23).map(|k| Vec3::new(10.0 * k as f64, 0.0, (k as f64).sin())).collect();
    let (attitude, spin) = (0..23).map(start).unzip();
    let state = State::new(0.0, position, vec![Vec3::zeros(); 23], attitude, spin).unwrap();
    for vector_path in VectorPath::available() {
        // As points they turn freely.
        let settings = Settings { gravity: Method::Point, vector_path, ..Settings::default() };
        let system = System::new(bodies.clone(), 1e-20, settings).unwrap();
        let mut simulation = Simulation::new(&system, &state, splitting(0.5, Scheme::Aba864)).unwrap();
        simulation.step(0.5).unwrap();
        let end = simulation.state();
        for (k, body) in bodies.iter().enumerate() {
            let (q, spin) = start(k);
            let (turned, change) = FreeRotor::new(body.inertia()).rotate(q, spin, 0.5).unwrap();
            let bound = 2e-14 * (1.0 + spin.norm());
            assert!(
                (end.spin()[k] - spin - change).norm() < bound * (1.0 + spin.norm()),
                "{vector_path:?} {k}"
            );
            assert!(
                (0..4).all(|c| (end.attitude()[k][c] - q[c] - turned[c]).abs() < bound),
                "{vector_path:?} {k}"
            );
        }
    }
}

/// The discrete rotation keeps the angular momentum in space to round-off, undoes itself, and is of second
/// order.
#[test]
fn the_discrete_top_keeps_angular_momentum() {
    let (inertia, spin) = (Vec3::new(1.0, 1.7, 2.4), Vec3::new(0.6, 0.2, 1.1));
    let q = [1.0, 0.0, 0.0, 0.0];
    let add = |q: [f64; 4], d: [f64; 4]| std::array::from_fn(|k| q[k] + d[k]);
    let momentum = |q, w: Vec3| rotation::matrix(q) * inertia.component_mul(&w);
    let errors = [0.1, 0.05].map(|h| {
        let (turned, change) = variational_rotation(inertia, q, spin, h).unwrap();
        let p: [f64; 4] = add(q, turned);
        assert!((momentum(p, spin + change) - momentum(q, spin)).norm() < 2e-15);
        let (back, changed) = variational_rotation(inertia, p, spin + change, -h).unwrap();
        assert!((change + changed).norm() < 1e-15);
        assert!((0..4).all(|k| (turned[k] + back[k]).abs() < 1e-15));
        let (exact, _) = FreeRotor::new(inertia).rotate(q, spin, h).unwrap();
        (0..4).map(|k| (turned[k] - exact[k]).abs()).fold(0.0, f64::max)
    });
    let order = (errors[0] / errors[1]).log2() - 1.0;
    println!("discrete rotation: order {order:.2}");
    assert!((order - 2.0).abs() < 0.1);
    assert!(variational_rotation(inertia, q, spin, 10.0).is_none());
}

/// Kepler motion of every kind is that of the elements.
#[test]
fn kepler_motion_is_that_of_the_elements() {
    use fullbody::orbit::KeplerElements;
    let mu = 1.3;
    for (a, e, m0) in [(1.0, 0.0, 0.1), (2.0, 0.3, -1.0), (0.8, 0.95, 0.02), (-1.5, 1.4, -0.7)] {
        let elements = |m| KeplerElements::new(a, e, 0.4, 0.5, 0.6, m).unwrap();
        let rate = (mu / f64::abs(a * a * a)).sqrt();
        let (r, v) = elements(m0).to_cartesian(mu).unwrap();
        for time in [1e-3, 0.3, -2.0, 25.0] {
            let change = kepler_change(&r, &v, mu, time).unwrap();
            let (moved, turned) = (change.position, change.velocity);
            let (x, u) = elements(m0 + rate * time).to_cartesian(mu).unwrap();
            let scale = x.norm().max(r.norm());
            assert!((r + moved - x).norm() < 2e-13 * scale, "{e} {time}: {:e}", (r + moved - x).norm());
            assert!((v + turned - u).norm() < 2e-13 * u.norm().max(v.norm()) / (1.0 - e).abs().min(1.0));
            let attraction = -mu / x.norm().powi(3) * x;
            assert!((change.acceleration - attraction).norm() < 1e-12 * attraction.norm() * scale / x.norm());
        }
    }
    let change = kepler_change(&Vec3::x(), &Vec3::y(), 0.0, 2.0).unwrap();
    assert_eq!((change.position, change.velocity), (2.0 * Vec3::y(), Vec3::zeros()));
    // No time, no change.
    let change = kepler_change(&Vec3::x(), &Vec3::y(), 2.0, 0.0).unwrap();
    assert_eq!((change.position, change.velocity), (Vec3::zeros(), Vec3::zeros()));
    assert_eq!(change.acceleration, -2.0 * Vec3::x());
}

/// Long ways along eccentric orbits and past the focus of hyperbolas, against the elements. Energy and
/// angular momentum tell nothing here: they are those of any place on the orbit.
#[test]
fn kepler_motion_past_the_periapsis() {
    use fullbody::orbit::KeplerElements;
    let mu = 1.3;
    let mut worst = 0.0_f64;
    for (a, e) in [(2.3, 0.5), (2.3, 0.89), (2.3, 0.97), (-1.5, 1.2), (-0.2, 2.0), (-0.01, 3.0)] {
        let elements = |m| KeplerElements::new(a, e, 0.4, 0.5, 0.6, m).unwrap();
        let rate = (mu / f64::abs(a * a * a)).sqrt();
        // In terms of the mean anomaly: all of an ellipse, and hyperbolas to some hundred times their nearest
        // distance.
        let reach = if a > 0.0 { 3.0 } else { 100.0 * e };
        for start in -10..=10 {
            for way in -20..=20 {
                let (from, by) = (reach * f64::from(start) / 10.0, reach * f64::from(way) / 10.0);
                let (r, v) = elements(from).to_cartesian(mu).unwrap();
                let (x, u) = elements(from + by).to_cartesian(mu).unwrap();
                let change = kepler_change(&r, &v, mu, by / rate).unwrap();
                let nearest = f64::abs(a) * (e - 1.0).abs();
                let scale = (x.norm() + r.norm()) * (x.norm() + r.norm()) / nearest;
                worst = worst.max((r + change.position - x).norm() / scale);
                worst = worst.max((v + change.velocity - u).norm() / (v.norm() + u.norm()) * nearest / scale);
            }
        }
    }
    println!("Kepler motion past the periapsis: {worst:.1e}");
    assert!(worst < 1e-13);
}

fn splitting(step: f64, scheme: Scheme) -> Integrator {
    Integrator::SymplecticSplitting { step, scheme }
}

/// Measured orders against a tight run: two for leapfrog and the variational integrator; the others fall at
/// least as fast as their fourth order, and with the square of how little the bodies differ from points.
#[test]
fn integrators_have_their_orders() {
    for (system, state) in [tumbling(Method::Multipole(4), AttitudeChart::Quaternion), triple()] {
        let mut tight = Simulation::new(&system, &state, verner98(1e-14)).unwrap();
        integrate(&mut tight, 4.0, &Output::Times(vec![]), false);
        let error = |integrator| {
            let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
            integrate(&mut simulation, 4.0, &Output::Times(vec![]), false);
            difference(&simulation.state(), &tight.state())
                .max(difference_of_rotation(&simulation.state(), &tight.state()))
        };
        let lie = |step| Integrator::LieGroupVariational { step };
        let measured = |f: &dyn Fn(f64) -> Integrator, h: f64| {
            let (long, short) = (error(f(h)), error(f(0.5 * h)));
            println!("{:?}: {long:.1e} {short:.1e} order {:.2}", f(h), (long / short).log2());
            (long / short).log2()
        };
        assert!((measured(&lie, 0.02) - 2.0).abs() < 0.15);
        assert!((measured(&|h| splitting(h, Scheme::Leapfrog), 0.05) - 2.0).abs() < 0.15);
        for scheme in [Scheme::Aba864, Scheme::Aba1064] {
            let order = measured(&|h| splitting(h, scheme), 0.2);
            assert!(order > 3.7, "{order}");
        }
    }
}

/// Errors of ABA(8,6,4) for A + epsilon B: the first power of epsilon comes with the eighth of the step.
#[test]
fn the_error_is_of_eighth_order_in_near_integrable_problems() {
    use fullbody::integrate::Flows;
    /// A pendulum-like problem in two flows: a rotation by the harmonic oscillator, and kicks of size
    /// epsilon.
    struct Oscillator(f64);
    impl Flows for Oscillator {
        fn prepare(&mut self, _: f64, _: &[f64], _: f64, _: &mut InterruptCheck) -> Result<()> {
            Ok(())
        }
        fn drift(&mut self, h: f64, [y, _]: [&mut [f64]; 2], _: &mut InterruptCheck) -> Result<()> {
            let (s, c) = h.sin_cos();
            (y[0], y[1]) = (c * y[0] + s * y[1], c * y[1] - s * y[0]);
            Ok(())
        }
        fn kick(&mut self, h: f64, [y, _]: [&mut [f64]; 2], _: &mut InterruptCheck) -> Result<u64> {
            y[1] -= h * self.0 * y[0].powi(3);
            Ok(1)
        }
        fn restore(&mut self, _: &mut [f64], _: &mut [f64]) {}
    }
    // Largest error of the energy over many steps: its leading term is epsilon h^n.
    let energy_error = |scheme: Scheme, epsilon: f64, steps: u32| {
        let mut y = [1.0, 0.3];
        let energy = |y: &[f64]| 0.5 * (y[0] * y[0] + y[1] * y[1]) + 0.25 * epsilon * y[0].powi(4);
        let start = energy(&y);
        let h = 10.0 / f64::from(steps);
        (0..4 * steps).fold(0.0, |worst: f64, _| {
            scheme
                .composition()
                .step(&mut Oscillator(epsilon), h, [&mut y, &mut [0.0; 2]], &mut InterruptCheck::never())
                .unwrap();
            worst.max((energy(&y) - start).abs())
        })
    };
    for (scheme, order, steps) in
        [(Scheme::Leapfrog, 2.0, 40), (Scheme::Aba864, 8.0, 8), (Scheme::Aba1064, 10.0, 8)]
    {
        let epsilon = 1e-5;
        let (long, short) =
            (energy_error(scheme, epsilon, steps), energy_error(scheme, epsilon, steps * 3 / 2));
        let measured = (long / short).ln() / 1.5_f64.ln();
        println!("{scheme:?}: {long:.1e} {short:.1e}, order {measured:.2} in epsilon h^n");
        assert!(measured > order - 0.6, "{measured}");
    }
}

/// A run back returns to the start to round-off. And the step's end does not depend on how it is reached.
#[test]
fn runs_back_return_to_the_start() {
    for (system, state) in [tumbling(Method::Focal, AttitudeChart::Quaternion), triple()] {
        for integrator in all(1e-13, 0.05).into_iter().skip(4) {
            let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
            integrate(&mut simulation, 20.0, &Output::Times(vec![]), false);
            integrate(&mut simulation, 0.0, &Output::Times(vec![]), false);
            let back = simulation.state();
            let error = difference(&back, &state).max(difference_of_rotation(&back, &state));
            println!("{integrator:?}: {error:.1e} after {} steps", simulation.statistics().steps);
            assert!(error < 2e-11, "{error:e}");
        }
    }
}

/// The energy's error in the last quarter of a run of 180 orbits is that of the first quarter, up to the
/// orbit's slow changes; a drift would make it seven times as large.
#[test]
fn the_energy_does_not_drift() {
    let (system, state) = tumbling(Method::Multipole(2), AttitudeChart::Quaternion);
    for integrator in all(1e-9, 0.1).into_iter().skip(5) {
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let record = integrate(&mut simulation, 2000.0, &Output::Steps, false);
        let energy: Vec<f64> = record.energy.iter().step_by(4).copied().collect();
        let n = energy.len();
        let worst = |range: &[f64]| range.iter().map(|e| (e / energy[0] - 1.0).abs()).fold(0.0, f64::max);
        let (first, last) = (worst(&energy[..n / 4]), worst(&energy[3 * n / 4..]));
        let momentum = |k: usize| Vec3::from_column_slice(&record.angular_momentum[3 * k..3 * k + 3]);
        let turned = (momentum(n - 1) - momentum(0)).norm() / momentum(0).norm();
        println!(
            "{integrator:?}: energy {first:.1e} then {last:.1e}, angular momentum {turned:.1e}, {} \
             evaluations",
            simulation.statistics().evaluations
        );
        assert!(last < 3.0 * first && turned < 1e-13);
        let length = simulation.state().attitude()[0].iter().map(|x| x * x).sum::<f64>();
        assert!((length - 1.0).abs() < 1e-15);
    }
}

#[test]
fn invalid_integrators_are_refused() {
    let (system, state) = tumbling(Method::Point, AttitudeChart::TaitBryan);
    for integrator in all(1e-9, 0.1).into_iter().skip(5) {
        let refused = Simulation::new(&system, &state, integrator);
        assert!(matches!(refused, Err(Error::InvalidInput { .. })));
    }
    let (system, state) = tumbling(Method::Point, AttitudeChart::Quaternion);
    for step in [0.0, -1.0, f64::NAN] {
        assert!(Simulation::new(&system, &state, splitting(step, Scheme::Leapfrog)).is_err());
    }
    // A body that turns too far in a step for the discrete rotation says so.
    let mut long = Simulation::new(&system, &state, Integrator::LieGroupVariational { step: 5.0 }).unwrap();
    assert!(matches!(long.step(100.0), Err(Error::NotConverged { .. })));
    assert_eq!(long.state(), state.clone());
    assert!(Scheme::named("ABA").is_err());
}
