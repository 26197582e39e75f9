//! Carlson's integrals, lanes, rotations and compensated sums.

use crate::support::*;
use fullbody::math::carlson::{duplications_needed, rd_triple};
use fullbody::math::compensated::{Compensated, sum, two_product, two_sum};
use fullbody::math::exponential::{exp, sin_cos};
use fullbody::math::gauss::Gauss;
use fullbody::math::lanes::{BLOCK, Lanes, Total, VectorPath, dot, polynomials};
use fullbody::math::logarithm::ln;
use fullbody::math::matrix::inverse;
use fullbody::math::{Mat3, Vec3, rotation};
use proptest::prelude::*;
use pulp::{Simd, WithSimd};
use std::f64::consts::{FRAC_PI_2, PI};

/// `rd_triple` of as many arguments as asked for, on the path it is dispatched to.
struct Triples<'a> {
    s: &'a [[f64; 3]],
    duplications: u32,
}

impl WithSimd for Triples<'_> {
    type Output = Vec<[f64; 3]>;

    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; 3]> {
        let every = |s: &[f64; 3]| -> [Lanes<S>; 3] { s.map(|v| Lanes::splat(simd, v)) };
        // All lanes are alike, so that the largest is any.
        self.s
            .iter()
            .map(|s| {
                rd_triple(every(s), self.duplications).map(|r| {
                    assert_eq!(r.reduce_max(), r.first());
                    r.first()
                })
            })
            .collect()
    }
}

fn triples(path: VectorPath, s: &[[f64; 3]], duplications: u32) -> Vec<[f64; 3]> {
    path.arch().unwrap().dispatch(Triples { s, duplications })
}

/// The three R_D by the `ellip` crate.
fn oracle(s: [f64; 3]) -> [f64; 3] {
    let rd = |x, y, z| ellip::elliprd(x, y, z).unwrap();
    [rd(s[1], s[2], s[0]), rd(s[2], s[0], s[1]), rd(s[0], s[1], s[2])]
}

#[test]
fn carlson_agrees_with_ellip_from_equal_arguments_to_a_spread_of_a_million() {
    for spread in
        [0.0, 1e-15, 1e-9, 1e-4, 0.008, 0.03, 0.047, 0.17, 0.3, 0.7, 0.97, 0.999, 1.0 - 1e-5, 1.0 - 1e-6]
    {
        for middle in [0.0, 1e-14, 0.1, 0.5, 0.9, 1.0] {
            for scale in [1e-6, 1.0, 3e7] {
                let s = [1.0, 1.0 - middle * spread, 1.0 - spread].map(|v| v * scale);
                let steps = duplications_needed(s);
                for path in VectorPath::available() {
                    let actual = triples(path, &[s], steps)[0];
                    for (actual, expected) in actual.into_iter().zip(oracle(s)) {
                        close(actual, expected, 4e-15);
                    }
                }
            }
        }
    }
}

#[test]
fn carlson_of_equal_arguments_is_a_power() {
    // R_D(s, s; s) = s^(-3/2), with no step at all.
    assert_eq!(duplications_needed([2.5; 3]), 0);
    for path in VectorPath::available() {
        for r in triples(path, &[[2.5; 3]], 0)[0] {
            close(r, 2.5f64.powf(-1.5), 1e-15);
        }
    }
}

#[test]
fn steps_for_a_spread_serve_all_that_are_less_spread() {
    let widest = [1.0, 0.4, 1e-3];
    let steps = duplications_needed(widest);
    let s: Vec<_> = (0..40).map(|k| widest.map(|v| v + 0.01 * 1.3f64.powi(k))).collect();
    for path in VectorPath::available() {
        for (actual, s) in triples(path, &s, steps).into_iter().zip(&s) {
            for (actual, expected) in actual.into_iter().zip(oracle(*s)) {
                close(actual, expected, 4e-15);
            }
        }
    }
}

/// a b + c, a square root, a polynomial in b and a sum over two blocks of 0, 1, 2, ...
struct Arithmetic {
    a: f64,
    b: f64,
    c: f64,
}

impl WithSimd for Arithmetic {
    type Output = [f64; 5];

    fn with_simd<S: Simd>(self, simd: S) -> [f64; 5] {
        let [a, b, c]: [Lanes<S>; 3] = [self.a, self.b, self.c].map(|v| Lanes::splat(simd, v));
        let [total, other] = polynomials(&[[1.0, 0.0], [-2.0, 1.0], [0.5, 0.0]], b);
        assert_eq!(other.first(), self.b);
        let count: Vec<f64> = (0..2 * BLOCK).map(|k| k as f64).collect();
        let mut sum = Total::zero(simd);
        Lanes::blocks(simd, &count).for_each(|block| sum.add_product(block, b.constant(1.0)));
        let product = dot([a, b, c], [b, c, c.constant(2.0)]);
        [a.mul_add(b, c).first(), (-a).abs().sqrt().first(), total.reduce_max(), sum.value(), product.first()]
    }
}

#[test]
fn the_portable_path_rounds_twice_and_the_others_once() {
    // (1 + e)(1 - e) - 1 = -e^2, which the separate product drops.
    let e = 2f64.powi(-27) * 1.5;
    for path in VectorPath::available() {
        let operation = Arithmetic { a: 1.0 + e, b: 1.0 - e, c: -1.0 };
        let [fused, root, value, sum, product] = path.arch().unwrap().dispatch(operation);
        let expected = if path == VectorPath::Portable { (1.0 - e * e) - 1.0 } else { -e * e };
        assert_eq!(fused, expected, "{path:?}");
        assert_eq!(root, (1.0 + e).sqrt());
        close(value, 1.0 - 2.0 * (1.0 - e) + 0.5 * (1.0 - e) * (1.0 - e), 4.0 * f64::EPSILON);
        assert_eq!(sum, (BLOCK * (2 * BLOCK - 1)) as f64);
        close(product, -2.0 + e, 4e-16);
    }
    assert_eq!(VectorPath::available()[0], VectorPath::Portable);
    assert!(VectorPath::Auto.arch().is_some());
}

/// The exponential function, the logarithm of the absolute value, the sine and the cosine of a block of numbers.
struct Elementary([f64; BLOCK]);

impl WithSimd for Elementary {
    type Output = [[f64; BLOCK]; 4];

    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut results = [[0.0; BLOCK]; 4];
        for block in 0..Lanes::<S>::PER_BLOCK {
            let x: Lanes<S> = Lanes::load(simd, &self.0, block);
            let [sine, cosine] = sin_cos(x);
            for (result, value) in results.iter_mut().zip([exp(x), ln(x.abs()), sine, cosine]) {
                value.store(result, block);
            }
        }
        results
    }
}

#[test]
fn elementary_functions_on_lanes_are_those_of_the_standard_library() {
    for path in VectorPath::available() {
        for step in 0..400 {
            let x: [f64; BLOCK] = std::array::from_fn(|k| {
                1e-9 + PI * (f64::from(step) + k as f64 / BLOCK as f64 - 200.0) / 200.0
            });
            let [exponential, logarithm, sine, cosine] = path.arch().unwrap().dispatch(Elementary(x));
            for k in 0..BLOCK {
                assert!((exponential[k] / x[k].exp() - 1.0).abs() < 2e-15, "{path:?} exp({})", x[k]);
                let scale = x[k].abs().ln().abs().max(1.0);
                assert!((logarithm[k] - x[k].abs().ln()).abs() < 1e-15 * scale, "{path:?} ln({})", x[k]);
                assert!((sine[k] - x[k].sin()).abs() < 1e-15, "{path:?} sin({})", x[k]);
                assert!((cosine[k] - x[k].cos()).abs() < 1e-15, "{path:?} cos({})", x[k]);
            }
        }
        // Far from zero, the argument's own rounding is a relative error of the exponential function.
        for x in [-707.9, -300.0, 88.5, 708.9] {
            let [exponential, ..] = path.arch().unwrap().dispatch(Elementary([x; BLOCK]));
            assert!((exponential[0] / x.exp() - 1.0).abs() < 3e-13, "{path:?} exp({x})");
        }
        for x in [1e-300, 3e-9, 7e11, 1e300] {
            let [_, logarithm, ..] = path.arch().unwrap().dispatch(Elementary([x; BLOCK]));
            assert!((logarithm[0] - x.ln()).abs() < 1e-15 * x.ln().abs(), "{path:?} ln({x})");
        }
    }
}

#[test]
fn the_inverse_is_that_of_nalgebra() {
    for numbers in
        [[2.0, -1.0, 0.5, 0.3, 4.0, 1.0, -7.0, 0.25, 3.0], [1e-9, 2.0, 0.0, 0.0, 1e9, 5.0, 1.0, 0.0, 1.0]]
    {
        let matrix = Mat3::from_row_slice(&numbers);
        let expected = matrix.try_inverse().unwrap();
        within((inverse(&matrix).unwrap() - expected).amax() / expected.amax(), 4e-16, "inverse");
    }
    assert_eq!(inverse(&Mat3::from_row_slice(&[1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 0.0, 1.0, 0.0])), None);
}

/// The paper's three matrices, multiplied out by the library of matrices.
fn paper_matrix([phi, theta, psi]: [f64; 3]) -> Mat3 {
    let ((sf, cf), (st, ct), (sp, cp)) = (phi.sin_cos(), theta.sin_cos(), psi.sin_cos());
    let rx = Mat3::new(1.0, 0.0, 0.0, 0.0, cf, -sf, 0.0, sf, cf);
    let ry = Mat3::new(ct, 0.0, st, 0.0, 1.0, 0.0, -st, 0.0, ct);
    let rz = Mat3::new(cp, -sp, 0.0, sp, cp, 0.0, 0.0, 0.0, 1.0);
    rz * ry * rx
}

fn angles() -> impl Strategy<Value = [f64; 3]> {
    (-PI..PI, -FRAC_PI_2..FRAC_PI_2, -PI..PI).prop_map(|(f, t, p)| [f, t, p])
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn angles_and_quaternions_give_the_papers_matrix(angles in angles()) {
        let expected = paper_matrix(angles);
        let quaternion = rotation::from_tait_bryan(angles);
        within((rotation::tait_bryan_matrix(angles) - expected).amax(), 5e-16, "matrix of angles");
        within((rotation::matrix(quaternion) - expected).amax(), 2e-15, "matrix of quaternion");
        // Any length stands for the same attitude.
        within((rotation::matrix(quaternion.map(|q| -37.0 * q)) - expected).amax(), 2e-15, "scaled");
        let unit = rotation::normalised(quaternion.map(|q| 1e3 * q));
        within(unit.iter().zip(quaternion).fold(0.0, |m, (a, b)| f64::max(m, (a - b).abs())), 5e-16, "unit");
    }

    #[test]
    fn angles_survive_the_way_through_a_quaternion(angles in angles()) {
        let back = rotation::to_tait_bryan(rotation::from_tait_bryan(angles));
        // Near the pole phi and psi are worth 1/cos(theta) less, theta is not.
        let tolerance = 4e-15 / angles[1].cos();
        for (i, tolerance) in [tolerance, 2e-15, tolerance].into_iter().enumerate() {
            let turn = (back[i] - angles[i] + PI).rem_euclid(2.0 * PI) - PI;
            within(turn.abs(), tolerance, format!("angle {i}"));
        }
    }

    #[test]
    fn rates_are_those_of_the_matrix(angles in angles(), axis in direction(), rate in 0.1..3.0f64) {
        // dR/dt = R [spin]x, here for both charts by the chain rule over the paper's matrices.
        let spin = axis * rate;
        let expected = paper_matrix(angles) * spin.cross_matrix();
        let h = 1e-3;
        let along = |derivative: [f64; 3]| {
            let at = |k: f64| paper_matrix([0, 1, 2].map(|i| angles[i] + k * h * derivative[i]));
            (45.0 * (at(1.0) - at(-1.0)) - 9.0 * (at(2.0) - at(-2.0)) + (at(3.0) - at(-3.0))) / (60.0 * h)
        };
        let away_from_pole = angles[1].cos();
        if away_from_pole > 0.2 {
            within((along(rotation::tait_bryan_rate(angles, spin)) - expected).amax(), 1e-11, "angles");
        }
        let q = rotation::from_tait_bryan(angles);
        let dq = rotation::quaternion_rate(q, spin);
        // The rate keeps the length, and its matrix is that of the product q (0, spin) / 2.
        within((0..4).map(|i| q[i] * dq[i]).sum::<f64>().abs(), 1e-15, "length");
        let at = |k: f64| rotation::matrix([0, 1, 2, 3].map(|i| q[i] + k * h * dq[i]));
        let slope =
            (45.0 * (at(1.0) - at(-1.0)) - 9.0 * (at(2.0) - at(-2.0)) + (at(3.0) - at(-3.0))) / (60.0 * h);
        within((slope - expected).amax(), 1e-11, "quaternion");
    }
}

#[test]
fn at_the_pole_the_attitude_is_kept() {
    for theta in [FRAC_PI_2, -FRAC_PI_2] {
        for (phi, psi) in [(0.3, 1.1), (-2.0, 0.4), (0.0, 0.0), (3.0, -2.5)] {
            let quaternion = rotation::from_tait_bryan([phi, theta, psi]);
            let angles = rotation::to_tait_bryan(quaternion);
            assert!((angles[1] - theta).abs() < 1e-7 && angles[0] == 0.0, "{angles:?}");
            within((paper_matrix(angles) - paper_matrix([phi, theta, psi])).amax(), 2e-15, "pole");
        }
    }
}

#[test]
fn near_the_pole_the_attitude_is_kept() {
    for distance in [1e-3, 1e-6, 1e-9, 1e-11, 1e-13, 1e-15] {
        for theta in [FRAC_PI_2 - distance, distance - FRAC_PI_2] {
            let expected = paper_matrix([0.7, theta, -1.9]);
            let angles = rotation::to_tait_bryan(rotation::from_tait_bryan([0.7, theta, -1.9]));
            // Only one combination of phi and psi is well determined; that one makes the attitude. Closer
            // than 1e-12 the chart counts as at its pole.
            let tolerance = if distance < 1e-12 { 2e-12 } else { 3e-15 };
            within(
                (paper_matrix(angles) - expected).amax(),
                tolerance,
                format!("{distance:e} from the pole"),
            );
        }
    }
}

#[test]
fn a_constant_spin_turns_by_the_closed_form() {
    // q(t) = q0 exp(spin t / 2): the series' first terms against Rodrigues' turn.
    let (spin, h) = (Vec3::new(0.3, -0.7, 0.5), 1e-2);
    let q0 = rotation::from_tait_bryan([0.4, -0.9, 2.2]);
    let (mut q, mut term) = (q0, q0);
    for n in 1..12 {
        term = rotation::quaternion_rate(term, spin).map(|v| v * h / f64::from(n));
        q = [0, 1, 2, 3].map(|i| q[i] + term[i]);
    }
    let expected = rotation::matrix(q0) * rotation_about(&spin.normalize(), spin.norm() * h);
    within((rotation::matrix(q) - expected).amax(), 1e-15, "turn");
}

#[test]
fn sums_keep_what_doubles_drop() {
    // Each of these adds up to nonsense in plain doubles; the exact sums are obvious.
    assert_eq!(sum([1.0, 1e100, 1.0, -1e100]), 2.0);
    assert_eq!(sum([1e16, 1.0, 1.0, 1.0, -1e16]), 3.0);
    assert_eq!(sum(std::iter::repeat_n(0.1, 10_000_000)), 1_000_000.0);
    // Ill-conditioned: large terms cancel in an order that hides the small ones.
    let small: Vec<f64> = (0..1000).map(|k| 2f64.powi(-60) * f64::from(k % 7 + 1)).collect();
    let large: Vec<f64> =
        (0..1000).map(|k| 2f64.powi(20 + k % 9) * if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
    let mixed = large.iter().chain(&small).copied().chain(large.iter().map(|v| -v));
    let exact = small.iter().sum::<f64>();
    close(sum(mixed), exact, 1e-15);
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn error_free_operations_are(a in -1e8..1e8f64, b in -1e-3..1e-3f64) {
        // Exact in integers of 2^-80: both numbers are multiples of 2^-62 and well below 2^27.
        let grid = |v: f64| (v * 2f64.powi(40)).round() / 2f64.powi(40);
        let (a, b) = (grid(a), grid(b));
        let integer = |v: f64| (v * 2f64.powi(40)) as i128;
        let (high, low) = two_sum(a, b);
        prop_assert_eq!(integer(high) + integer(low), integer(a) + integer(b));
        prop_assert_eq!(high, a + b);
        let (high, low) = two_product(a, b);
        let wide = |v: f64| (v * 2f64.powi(80)) as i128;
        prop_assert_eq!(wide(high) + wide(low), integer(a) * integer(b));
        let difference = Compensated::difference(a, b);
        prop_assert_eq!(integer(difference.high) + integer(difference.low), integer(a) - integer(b));
        prop_assert_eq!(Compensated::new(a).value(), a);
    }
}

#[test]
fn gauss_integrates_and_continues_polynomials() {
    for count in 1..=6 {
        let gauss = Gauss::new(count.try_into().unwrap());
        let Gauss { nodes, weights, integrals, .. } = &gauss;
        for power in 0..2 * count as i32 {
            let exact = |c: f64| c.powi(power + 1) / f64::from(power + 1);
            let sum = |b: &[f64]| b.iter().zip(nodes).map(|(b, c)| b * c.powi(power)).sum::<f64>();
            close(sum(weights), exact(1.0), 2e-15);
            if power < count as i32 {
                for (row, &c) in integrals.iter().zip(nodes) {
                    assert!((sum(row) - exact(c)).abs() < 1e-15, "{power} of {count} at {c}");
                }
                let mut factors = vec![0.0; count];
                gauss.factors(1.7, &mut factors);
                close(sum(&factors), 1.7_f64.powi(power), 1e-11);
                gauss.integrals_to(0.3, &mut factors);
                assert!((sum(&factors) - exact(0.3)).abs() < 1e-15, "{power} of {count} to 0.3");
            }
        }
        // A polynomial of lower degree has no term of the highest one; 2 c - 1 is the Legendre polynomial of degree 1.
        let highest =
            |f: &dyn Fn(f64) -> f64| gauss.highest().zip(nodes).map(|(by, &c)| by * f(c)).sum::<f64>();
        let coefficient = highest(&|c| 2.0 * c - 1.0);
        assert!((coefficient - f64::from(count == 2)).abs() < 1e-15, "{count}: {coefficient}");
        // The condition under which a method keeps quadratic invariants.
        for i in 0..count {
            for j in 0..count {
                let kept = weights[i] * integrals[i][j] + weights[j] * integrals[j][i];
                assert!((kept - weights[i] * weights[j]).abs() < 1e-16, "{i} {j} of {count}");
            }
        }
    }
}
