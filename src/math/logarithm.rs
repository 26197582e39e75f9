//! The logarithm, and the logarithm and the angle of a ratio, for many numbers at a time, accurate to the last digits.
//!
//! The arguments of all functions are reduced to a short range about zero, where one division gives the
//! argument of a polynomial: a Chebyshev approximation of (atanh s / s - 1) / s^2 or of (atan t / t - 1) /
//! t^2, accurate to 5e-18.

use super::lanes::Lanes;
use pulp::Simd;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, LN_2, PI, SQRT_2};

/// The coefficients of the powers of s^2, for s^2 up to ((sqrt 2 - 1) / (sqrt 2 + 1))^2.
const ATANH: [f64; 7] = [
    0.333333333333333484,
    0.199999999999497216,
    0.142857143130016344,
    0.111111055651299385,
    0.0909144472783747302,
    0.0766585530910538578,
    0.0730829271244431099,
];

/// The coefficients of the powers of t^2, for t^2 up to tan(pi/8)^2.
const ATAN: [f64; 11] = [
    -0.333333333333333302,
    0.199999999999955165,
    -0.142857142846656808,
    0.111111110151870187,
    -0.0909090457530648908,
    0.0769218312537689209,
    -0.066645105255089366,
    0.0585814090486632828,
    -0.0508540783458948426,
    0.0392304477847930954,
    -0.0191754047111049338,
];

/// Returns x (1 + x^2 p(x^2)).
#[inline(always)]
fn odd<S: Simd, const N: usize, const K: usize>(x: Lanes<S, N>, coefficients: &[f64; K]) -> Lanes<S, N> {
    let z = x * x;
    let mut sum = x.constant(coefficients[K - 1]);
    for k in (0..K - 1).rev() {
        sum = sum.mul_add(z, x.constant(coefficients[k]));
    }
    (x * z).mul_add(sum, x)
}

/// Returns ln(1 + z) for z = `over` / `under` between zero and 2^250, as 2 atanh(z / (2 + z)) after division
/// by a power of two.
#[inline(always)]
pub fn ln_one_plus<S: Simd>(over: Lanes<S>, under: Lanes<S>) -> Lanes<S> {
    let c = |value| over.constant(value);
    // Here `power` is the power of two p with p / sqrt 2 <= 1 + z <= p sqrt 2, and `exponent` is log2 p.
    let (mut power, mut exponent) = (c(1.0), c(0.0));
    let beyond = |power: f64| SQRT_2 * power - 1.0;
    if (over - under * c(beyond(2.0))).reduce_max() > 0.0 {
        for k in (1..8).rev() {
            let step = f64::from(1u32 << k);
            let next = power * c(step.exp2());
            // The logarithm is above the middle of the interval below `next`.
            let least = next.mul_add(c(0.5 * SQRT_2), c(-1.0)) * under;
            power = least.if_less(over, next, power);
            exponent = least.if_less(over, exponent + c(step), exponent);
        }
    }
    let next = power + power;
    let least = power.mul_add(c(SQRT_2), c(-1.0)) * under;
    power = least.if_less(over, next, power);
    exponent = least.if_less(over, exponent + c(1.0), exponent);
    let s = (over - (power - c(1.0)) * under) / (power + c(1.0)).mul_add(under, over);
    let two_atanh = odd(s, &ATANH);
    exponent.mul_add(c(LN_2), two_atanh + two_atanh)
}

/// Returns ln(x) for positive normal numbers.
#[inline(always)]
pub fn ln<S: Simd, const N: usize>(x: Lanes<S, N>) -> Lanes<S, N> {
    let (mut fraction, mut exponent) = x.fraction_and_exponent();
    let (bound, one) = (x.constant(SQRT_2), x.constant(1.0));
    exponent = bound.if_less(fraction, exponent + one, exponent);
    fraction = bound.if_less(fraction, fraction * 0.5, fraction);
    let two_atanh = odd((fraction - one) / (fraction + one), &ATANH);
    exponent.mul_add(x.constant(LN_2), two_atanh + two_atanh)
}

/// Returns `atan2(y, x)`: the angle of the point (x, y), between -pi and pi, and zero at the origin.
#[inline(always)]
pub fn angle<S: Simd>(y: Lanes<S>, x: Lanes<S>) -> Lanes<S> {
    let c = |value| x.constant(value);
    let zero = c(0.0);
    let (height, width) = (y.abs(), x.abs());
    // The point is reflected into the lowest eighth of the circle, and then turned to within pi/8 of the
    // axis.
    let (low, long) = (width.if_less(height, width, height), width.max(height));
    let bound = long * c(SQRT_2 - 1.0);
    let over = bound.if_less(low, low - long, low);
    let under = bound.if_less(low, low + long, long);
    let t = over / under.max(c(f64::MIN_POSITIVE));
    let theta = odd(t, &ATAN) + bound.if_less(low, c(FRAC_PI_4), zero);
    let theta = width.if_less(height, c(FRAC_PI_2) - theta, theta);
    let theta = x.if_less(zero, c(PI) - theta, theta);
    y.if_less(zero, -theta, theta)
}
