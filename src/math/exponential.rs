//! The exponential function, sine and cosine, for many numbers at a time, accurate to the last digits.
//!
//! The arguments are reduced to a short range about zero, on which Taylor's series converge fast.

use super::lanes::{Lanes, polynomials};
use pulp::Simd;
use std::f64::consts::{LN_2, LOG2_E};

/// The sum of LN_2 and this is the logarithm of two in double precision twice.
const LN_2_REST: f64 = 2.319_046_813_846_299_6e-17;

/// The limits of the argument of the exponential function, beyond which its value is that at the limit.
const RANGE: [f64; 2] = [-708.0, 709.0];

/// The coefficients of the powers of x^2 in sinh(x)/x and in cosh(x), for arguments up to ln(2)/2.
const HYPERBOLIC: [[f64; 2]; 7] = series(1.0);
/// The coefficients of the powers of x^2 in sin(x)/x and in cos(x), for arguments up to pi/2.
const TRIGONOMETRIC: [[f64; 2]; 11] = series(-1.0);

/// Returns the coefficients s^k / (2 k + 1)! and s^k / (2 k)!, with the sign s.
const fn series<const K: usize>(sign: f64) -> [[f64; 2]; K] {
    let mut result = [[1.0; 2]; K];
    let mut k = 1;
    while k < K {
        let even = sign * result[k - 1][0] / (2 * k) as f64;
        result[k] = [even / (2 * k + 1) as f64, even];
        k += 1;
    }
    result
}

/// Returns e^x; beyond the range of doubles its least or largest value.
#[inline(always)]
pub fn exp<S: Simd, const N: usize>(x: Lanes<S, N>) -> Lanes<S, N> {
    let x = x.max(x.constant(RANGE[0])).min(x.constant(RANGE[1]));
    // Adding and subtracting this number rounds to the nearest whole number.
    let round = x.constant(1.5 / f64::EPSILON);
    let exponent = x.mul_add(x.constant(LOG2_E), round) - round;
    let nearest = exponent.mul_add(x.constant(-LN_2), x);
    let rest = exponent.mul_add(x.constant(-LN_2_REST), nearest);
    let [over, cosh] = polynomials(&HYPERBOLIC, rest * rest);
    rest.mul_add(over, cosh) * exponent.power_of_two()
}

/// Returns sine and cosine of angles from -pi to pi.
#[inline(always)]
pub fn sin_cos<S: Simd, const N: usize>(x: Lanes<S, N>) -> [Lanes<S, N>; 2] {
    let half = x * 0.5;
    let [over, cosine] = polynomials(&TRIGONOMETRIC, half * half);
    let sine = over * half;
    let twice = sine + sine;
    [twice * cosine, x.constant(1.0) - twice * sine]
}
