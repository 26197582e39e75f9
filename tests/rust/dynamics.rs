//! Tests of parts of the dynamics that compute in twice the working precision: the normalisation of quaternions
//! and the Kepler drift in Jacobi coordinates.

use crate::support::*;
use fullbody::dynamics::{AttitudeChart, BarycentricFrame, DriftKind, Dynamics, Settings, Splitting, System};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::compensated::{Compensated, two_product};
use fullbody::math::{Vec3, rotation};
use fullbody::mutual::Method;
use fullbody::orbit::KeplerElements;
use fullbody::shape::{Body, Shape};

fn point_masses(masses: &[f64], chart: AttitudeChart) -> System {
    let names = ["A", "B", "C"].into_iter().zip(masses);
    let bodies = names.map(|(name, mass)| Body::with_mass(name, Shape::Point, *mass).unwrap());
    let settings = Settings { gravity: Method::Point, attitude_chart: chart, ..Settings::default() };
    System::new(bodies.collect(), 1.0, settings).unwrap()
}

/// The equations of motion of a system whose barycentre rests at the origin.
fn equations(system: &System) -> Dynamics {
    let (barycentre, barycentre_velocity) = ([0.0; 3], [0.0; 3]);
    let frame = BarycentricFrame { layout: system.layout(), epoch: 0.0, barycentre, barycentre_velocity };
    system.dynamics(&frame, &mut InterruptCheck::never()).unwrap()
}

/// A quaternion in two parts whose length is 1 + excess becomes one of unit length and the same direction, more
/// accurately than a double can represent. Newton's step leaves 3 excess^2 of the square of the length.
#[test]
fn quaternions_are_normalised_in_twice_the_working_precision() {
    let dynamics = equations(&point_masses(&[1.0, 2.0], AttitudeChart::Quaternion));
    let layout = dynamics.layout();
    for excess in [1e-9, -1e-9, 3e-13] {
        let (mut high, mut low) = (vec![0.7; layout.dimension()], vec![1e-18; layout.dimension()]);
        let unit =
            [rotation::normalised([0.3, -0.5, 0.7, 0.2]), rotation::normalised([-0.1, 0.9, 0.01, 0.4])];
        for body in 0..2 {
            for k in 0..4 {
                high[layout.attitude(body) + k] = unit[body][k] * (1.0 + excess);
                low[layout.attitude(body) + k] = 1e-17 * unit[(k + body) % 2][k];
            }
        }
        let before = (high.clone(), low.clone());
        dynamics.restore(&mut high, &mut low);
        for body in 0..2 {
            let a = layout.attitude(body);
            let mut square = Compensated::new(-1.0);
            for c in a..a + 4 {
                let (product, error) = two_product(high[c], high[c]);
                [product, error, 2.0 * high[c] * low[c]].into_iter().for_each(|part| square.add(part));
                // All components change by the same factor.
                let change = (high[c] - before.0[c]) + (low[c] - before.1[c]);
                let expected = -excess * before.0[c];
                assert!((change - expected).abs() < 3e-16 * before.0[c].abs(), "{change:e} {expected:e}");
            }
            assert!(square.value().abs() < 3.1 * excess * excess + 1e-30, "{excess:e}: {:e}", square.value());
        }
        // Nothing else changes.
        for c in (0..layout.attitude(0)).chain(layout.spin(0)..layout.dimension()) {
            assert_eq!((high[c], low[c]), (before.0[c], before.1[c]));
        }
    }
    // Tait-Bryan angles are not normalised.
    let dynamics = equations(&point_masses(&[1.0, 2.0], AttitudeChart::TaitBryan));
    let (mut high, mut low) =
        (vec![0.7; dynamics.layout().dimension()], vec![0.0; dynamics.layout().dimension()]);
    dynamics.restore(&mut high, &mut low);
    assert!(high.iter().all(|x| *x == 0.7) && low.iter().all(|x| *x == 0.0));
}

/// Three bodies at a million separations from the origin drift: their Jacobi vectors follow Kepler orbits to
/// 1e-14, though the high parts of the positions alone resolve these vectors to 1e-10 only.
#[test]
fn jacobi_vectors_follow_kepler_orbits_far_from_the_origin() {
    let masses = [3.0, 1.0, 2.0];
    let system = point_masses(&masses, AttitudeChart::Quaternion);
    let dynamics = equations(&system);
    let layout = dynamics.layout();
    let orbits = [([1.0, 0.2, 0.3, 0.4, 0.5, 0.6], 4.0), ([9.0, 0.1, 0.5, 1.4, 2.5, 0.2], 6.0)];
    let vectors = |time: f64| {
        orbits.map(|([a, e, i, node, periapsis, mean], mu)| {
            let mean = mean + time * f64::sqrt(mu / (a * a * a));
            KeplerElements::new(a, e, i, node, periapsis, mean).unwrap().to_cartesian(mu).unwrap()
        })
    };
    // A has an arbitrary position and velocity with low parts. B is at the first Jacobi vector from A, and C at
    // the second from the barycentre of A and B, which is a quarter of the first vector from A.
    let far = |c: usize| Compensated { high: 1e6 * (c as f64 + 1.3), low: 3e-11 * (c as f64 - 1.7) };
    let plus = |mut number: Compensated, parts: &[f64]| {
        parts.iter().for_each(|part| number.add(*part));
        number
    };
    let (mut high, mut low) = (vec![0.0; layout.dimension()], vec![0.0; layout.dimension()]);
    for body in 0..3 {
        high[layout.attitude(body)] = 1.0;
    }
    let [first, second] = vectors(0.0);
    let blocks = [(layout.position(0), first.0, second.0), (layout.velocity(0), first.1, second.1)];
    for (block, first, second) in blocks {
        for c in 0..3 {
            let positions = [far(c), plus(far(c), &[first[c]]), plus(far(c), &[0.25 * first[c], second[c]])];
            for (body, number) in positions.into_iter().enumerate() {
                (high[block + 3 * body + c], low[block + 3 * body + c]) = (number.high, number.low);
            }
        }
    }
    let time = 0.7;
    let mut splitting = Splitting::new(&dynamics, DriftKind::Kepler).unwrap();
    splitting.drift(&dynamics, time, [&mut high, &mut low], &mut InterruptCheck::never()).unwrap();
    let [first, second] = vectors(time);
    let blocks = [(layout.position(0), first.0, second.0), (layout.velocity(0), first.1, second.1)];
    for (block, first, second) in blocks {
        let between = |from: &[(usize, f64)]| {
            Vec3::from([0, 1, 2].map(|c| {
                let mut sum = Compensated::default();
                for &(body, factor) in from {
                    sum.add(factor * high[block + 3 * body + c]);
                    sum.add(factor * low[block + 3 * body + c]);
                }
                sum.value()
            }))
        };
        close_vector(&between(&[(1, 1.0), (0, -1.0)]), &first, 1e-14);
        close_vector(&between(&[(2, 1.0), (0, -0.5), (0, -0.25), (1, -0.25)]), &second, 1e-14);
    }
}
