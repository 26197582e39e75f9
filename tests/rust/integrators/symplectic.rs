//! Tests of integrators of fixed step: the free rotor and Kepler motion as exact flows, the orders of the schemes,
//! reversibility, and energy without drift.

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

/// Returns Jacobi's elliptic functions sn, cn and dn of u for the parameter m = k^2, by descending Landen
/// transformations (arithmetic-geometric mean).
fn jacobi_elliptic(u: f64, m: f64) -> (f64, f64, f64) {
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

/// The spin of a free rotor is that of Euler's closed form (Landau & Lifshitz, Mechanics, section 37), its
/// inertial angular momentum is conserved, and the reversed rotation returns to the start.
#[test]
fn the_free_rotor_follows_jacobis_elliptic_functions() {
    let inertia = Vec3::new(1.0, 1.7, 2.4);
    // With L^2 > 2 T I_2 the spin circulates about the axis of the largest moment. It starts where its second
    // component is zero.
    let start = Vec3::new(0.6, 0.0, 1.1);
    let twice_energy = inertia.dot(&start.component_mul(&start));
    let momentum_square = inertia.component_mul(&start).norm_squared();
    let [i1, i2, i3] = [inertia.x, inertia.y, inertia.z];
    let rate = ((i3 - i2) * (momentum_square - twice_energy * i1) / (i1 * i2 * i3)).sqrt();
    let m = (i2 - i1) * (twice_energy * i3 - momentum_square)
        / ((i3 - i2) * (momentum_square - twice_energy * i1));
    let second_amplitude = ((twice_energy * i3 - momentum_square) / (i2 * (i3 - i2))).sqrt();
    let q = rotation::normalised([0.3, -0.5, 0.7, 0.2]);
    for time in [0.05, 0.7, 3.0, -11.0] {
        let (attitude_change, spin_change) = FreeRotor::new(inertia).rotate(q, start, time).unwrap();
        let (sn, cn, dn) = jacobi_elliptic(rate * time, m);
        let spin = start + spin_change;
        let expected = Vec3::new(start.x * cn, second_amplitude * sn, start.z * dn);
        // The second component increases at the start: I_2 dw_2/dt = (I_3 - I_1) w_3 w_1 > 0.
        assert!((spin - expected).norm() < 1e-14, "{time}: {spin:?} {expected:?}");
        let p: [f64; 4] = std::array::from_fn(|k| q[k] + attitude_change[k]);
        let length = p.iter().map(|x| x * x).sum::<f64>();
        assert!((length - 1.0).abs() < 4e-15, "{length}");
        let momentum = |q, w: Vec3| rotation::matrix(q) * inertia.component_mul(&w);
        assert!((momentum(p, spin) - momentum(q, start)).norm() < 4e-15);
        let (back, _) = FreeRotor::new(inertia).rotate(p, spin, -time).unwrap();
        let error = (0..4).map(|k| (p[k] + back[k] - q[k]).abs()).fold(0.0, f64::max);
        assert!(error < 4e-15, "{error:e}");
    }
}

/// A needle tumbles end over end as in Euler's closed form. The bound of its rotation angle is near the true
/// angle, where |L| over the smallest moment would give millions of radians.
#[test]
fn a_tumbling_needle_follows_jacobis_elliptic_functions() {
    let [a, b, c] = [1.0, 1.2e-3, 1e-3_f64];
    let inertia = Vec3::new(b * b + c * c, c * c + a * a, a * a + b * b) / 5.0;
    let start = Vec3::new(0.3, 0.0, 1.1);
    let [i1, i2, i3] = [inertia.x, inertia.y, inertia.z];
    // These are L^2 - 2 T I_2, L^2 - 2 T I_1 and 2 T I_3 - L^2, without cancellation.
    let beyond_second = i3 * (i3 - i2) * start.z * start.z - i1 * (i2 - i1) * start.x * start.x;
    let beyond_first = i3 * (i3 - i1) * start.z * start.z;
    let below_third = i1 * (i3 - i1) * start.x * start.x;
    assert!(beyond_second > 0.0);
    let rate = ((i3 - i2) * beyond_first / (i1 * i2 * i3)).sqrt();
    let m = (i2 - i1) * below_third / ((i3 - i2) * beyond_first);
    let second_amplitude = (below_third / (i2 * (i3 - i2))).sqrt();
    for time in [3.0, -40.0, 300.0] {
        assert!(inertia.component_mul(&start).norm() / i1 * f64::abs(time) > 1e6);
        assert!(rotation_angle_bound(inertia, start, time) < 1.5 * start.norm() * time.abs());
        let (attitude_change, spin_change) =
            FreeRotor::new(inertia).rotate([1.0, 0.0, 0.0, 0.0], start, time).unwrap();
        let (sn, cn, dn) = jacobi_elliptic(rate * time, m);
        let expected = Vec3::new(start.x * cn, second_amplitude * sn, start.z * dn);
        let error = (start + spin_change - expected).norm();
        println!("needle after {time}: {error:.1e}");
        assert!(error < 1e-12 * time.abs(), "{time}: {error:e}");
        let length =
            attitude_change[1..].iter().chain([&(1.0 + attitude_change[0])]).map(|x| x * x).sum::<f64>();
        assert!((length - 1.0).abs() < 1e-13, "{length}");
    }
}

proptest! {
    #![proptest_config(cases(200))]

    /// The spin of a free rotor never exceeds the bound of its rotation angle over a long time, per unit time.
    #[test]
    fn the_spin_of_a_free_rotor_stays_below_its_bound(axes in semi_axes(1e-3), along in direction()) {
        let [a, b, c] = axes;
        let inertia = Vec3::new(b * b + c * c, c * c + a * a, a * a + b * b) / 5.0;
        let (mut spin, mut q) = (along, [1.0, 0.0, 0.0, 0.0]);
        // Over so long a time the bound that follows from the energy is taken into account too.
        let bound = rotation_angle_bound(inertia, along, 1e6) / 1e6;
        for _ in 0..200 {
            let (attitude_change, spin_change) = FreeRotor::new(inertia).rotate(q, spin, 0.37).unwrap();
            (0..4).for_each(|k| q[k] += attitude_change[k]);
            spin += spin_change;
            prop_assert!(spin.norm() <= bound * (1.0 + 1e-12), "{} {bound}", spin.norm());
        }
    }
}

/// The two rotations of a symmetric top agree with the motion of a nearly symmetric one, for every axis of
/// symmetry, prolate, oblate and spherical tops, and over more than one revolution.
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

#[test]
fn a_free_rotor_does_not_change_without_spin_or_in_zero_time() {
    let (spin, q) = (Vec3::new(0.4, -0.3, 0.8), [0.5, 0.5, -0.5, 0.5]);
    for inertia in [Vec3::new(1.0, 1.7, 2.4), Vec3::new(1.0, 1.0, 2.4), Vec3::zeros()] {
        for (spin, time) in [(Vec3::zeros(), 1.3), (spin, 0.0)] {
            assert_eq!(FreeRotor::new(inertia).rotate(q, spin, time).unwrap(), ([0.0; 4], Vec3::zeros()));
        }
    }
}

/// Free rotors of all kinds, slow and fast ones, that are computed together rotate as each does alone.
#[test]
fn free_rotors_computed_together_rotate_as_each_alone() {
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
        // Point-mass gravity exerts no torque.
        let settings = Settings { gravity: Method::Point, vector_path, ..Settings::default() };
        let system = System::new(bodies.clone(), 1e-20, settings).unwrap();
        let mut simulation = Simulation::new(&system, &state, splitting(0.5, Scheme::Aba864)).unwrap();
        simulation.step(0.5).unwrap();
        let end = simulation.state();
        for (k, body) in bodies.iter().enumerate() {
            let (q, spin) = start(k);
            let (attitude_change, spin_change) = FreeRotor::new(body.inertia()).rotate(q, spin, 0.5).unwrap();
            let bound = 2e-14 * (1.0 + spin.norm());
            assert!(
                (end.spin()[k] - spin - spin_change).norm() < bound * (1.0 + spin.norm()),
                "{vector_path:?} {k}"
            );
            assert!(
                (0..4).all(|c| (end.attitude()[k][c] - q[c] - attitude_change[c]).abs() < bound),
                "{vector_path:?} {k}"
            );
        }
    }
}

/// The discrete rotation conserves the inertial angular momentum to round-off and is reversible.
#[test]
fn the_discrete_rotation_conserves_angular_momentum_and_is_of_second_order() {
    let (inertia, spin) = (Vec3::new(1.0, 1.7, 2.4), Vec3::new(0.6, 0.2, 1.1));
    let q = [1.0, 0.0, 0.0, 0.0];
    let add = |q: [f64; 4], d: [f64; 4]| std::array::from_fn(|k| q[k] + d[k]);
    let momentum = |q, w: Vec3| rotation::matrix(q) * inertia.component_mul(&w);
    let errors = [0.1, 0.05].map(|h| {
        let (attitude_change, spin_change) = variational_rotation(inertia, q, spin, h).unwrap();
        let p: [f64; 4] = add(q, attitude_change);
        assert!((momentum(p, spin + spin_change) - momentum(q, spin)).norm() < 2e-15);
        let (back, spin_change_back) = variational_rotation(inertia, p, spin + spin_change, -h).unwrap();
        assert!((spin_change + spin_change_back).norm() < 1e-15);
        assert!((0..4).all(|k| (attitude_change[k] + back[k]).abs() < 1e-15));
        let (exact, _) = FreeRotor::new(inertia).rotate(q, spin, h).unwrap();
        (0..4).map(|k| (attitude_change[k] - exact[k]).abs()).fold(0.0, f64::max)
    });
    // The error of one step is of one order more than that of a run.
    let order = (errors[0] / errors[1]).log2() - 1.0;
    println!("discrete rotation: order {order:.2}");
    assert!((order - 2.0).abs() < 0.1);
    assert!(variational_rotation(inertia, q, spin, 10.0).is_none());
}

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
            let (x, u) = elements(m0 + rate * time).to_cartesian(mu).unwrap();
            let scale = x.norm().max(r.norm());
            assert!(
                (r + change.position - x).norm() < 2e-13 * scale,
                "{e} {time}: {:e}",
                (r + change.position - x).norm()
            );
            assert!(
                (v + change.velocity - u).norm() < 2e-13 * u.norm().max(v.norm()) / (1.0 - e).abs().min(1.0)
            );
            let attraction = -mu / x.norm().powi(3) * x;
            assert!((change.acceleration - attraction).norm() < 1e-12 * attraction.norm() * scale / x.norm());
        }
    }
    let change = kepler_change(&Vec3::x(), &Vec3::y(), 0.0, 2.0).unwrap();
    assert_eq!((change.position, change.velocity), (2.0 * Vec3::y(), Vec3::zeros()));
    // In zero time nothing changes.
    let change = kepler_change(&Vec3::x(), &Vec3::y(), 2.0, 0.0).unwrap();
    assert_eq!((change.position, change.velocity), (Vec3::zeros(), Vec3::zeros()));
    assert_eq!(change.acceleration, -2.0 * Vec3::x());
}

/// Long arcs of eccentric orbits and hyperbolas through periapsis end where the elements place them. Energy and
/// angular momentum would not show an error along the orbit.
#[test]
fn kepler_motion_through_periapsis_is_that_of_the_elements() {
    use fullbody::orbit::KeplerElements;
    let mu = 1.3;
    let mut worst = 0.0_f64;
    for (a, e) in [(2.3, 0.5), (2.3, 0.89), (2.3, 0.97), (-1.5, 1.2), (-0.2, 2.0), (-0.01, 3.0)] {
        let elements = |m| KeplerElements::new(a, e, 0.4, 0.5, 0.6, m).unwrap();
        let rate = (mu / f64::abs(a * a * a)).sqrt();
        // The largest mean anomaly: nearly that of the apoapsis of an ellipse, and of some hundred times the
        // periapsis distance of a hyperbola.
        let reach = if a > 0.0 { 3.0 } else { 100.0 * e };
        for start in -10..=10 {
            for arc in -20..=20 {
                let (from, by) = (reach * f64::from(start) / 10.0, reach * f64::from(arc) / 10.0);
                let (r, v) = elements(from).to_cartesian(mu).unwrap();
                let (x, u) = elements(from + by).to_cartesian(mu).unwrap();
                let change = kepler_change(&r, &v, mu, by / rate).unwrap();
                let periapsis = f64::abs(a) * (e - 1.0).abs();
                let scale = (x.norm() + r.norm()) * (x.norm() + r.norm()) / periapsis;
                worst = worst.max((r + change.position - x).norm() / scale);
                worst =
                    worst.max((v + change.velocity - u).norm() / (v.norm() + u.norm()) * periapsis / scale);
            }
        }
    }
    println!("Kepler motion past the periapsis: {worst:.1e}");
    assert!(worst < 1e-13);
}

fn splitting(step: f64, scheme: Scheme) -> Integrator {
    Integrator::SymplecticSplitting { step, scheme }
}

/// The orders are measured against a run of tight tolerance: two for leapfrog and the variational integrator. The
/// schemes (8,6,4) and (10,6,4) have at least their lowest order, four.
#[test]
fn integrators_of_fixed_step_have_their_orders() {
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

/// For A + epsilon B the error linear in epsilon falls as h^2 with leapfrog, h^8 with ABA(8,6,4) and h^10 with
/// ABA(10,6,4).
#[test]
fn the_error_linear_in_epsilon_has_order_8_for_aba864_and_10_for_aba1064() {
    use fullbody::integrate::Flows;
    /// Duffing's oscillator in two flows: the harmonic oscillator, and kicks by the force -epsilon y^3.
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
    // Returns the largest error of the energy over many steps, whose leading term is epsilon h^n.
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

/// A run to a later time and back returns to the start, nearly to round-off.
#[test]
fn runs_there_and_back_return_to_the_start() {
    for (system, state) in [tumbling(Method::Focal, AttitudeChart::Quaternion), triple()] {
        // From the fifth on: Verner's pair of order 9 and all integrators of fixed step.
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

/// Over 180 orbits the largest error of the energy in the last quarter is that in the first quarter, up to slow
/// changes of the orbit; a linear drift would make it four times as large.
#[test]
fn the_energy_does_not_drift_with_fixed_steps() {
    let (system, state) = tumbling(Method::Multipole(2), AttitudeChart::Quaternion);
    for integrator in all(1e-9, 0.1).into_iter().skip(5) {
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let record = integrate(&mut simulation, 2000.0, &Output::Steps, false);
        let energy: Vec<f64> = record.energy.iter().step_by(4).copied().collect();
        let n = energy.len();
        let worst = |range: &[f64]| range.iter().map(|e| (e / energy[0] - 1.0).abs()).fold(0.0, f64::max);
        let (first, last) = (worst(&energy[..n / 4]), worst(&energy[3 * n / 4..]));
        let momentum = |k: usize| Vec3::from_column_slice(&record.angular_momentum[3 * k..3 * k + 3]);
        let momentum_error = (momentum(n - 1) - momentum(0)).norm() / momentum(0).norm();
        println!(
            "{integrator:?}: energy {first:.1e} then {last:.1e}, angular momentum {momentum_error:.1e}, {} \
             evaluations",
            simulation.statistics().evaluations
        );
        assert!(last < 3.0 * first && momentum_error < 1e-13);
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
    // A step in which a body rotates too far for the discrete rotation is an error, and the state stays.
    let mut long = Simulation::new(&system, &state, Integrator::LieGroupVariational { step: 5.0 }).unwrap();
    assert!(matches!(long.step(100.0), Err(Error::NotConverged { .. })));
    assert_eq!(long.state(), state.clone());
    assert!(Scheme::named("ABA").is_err());
}
