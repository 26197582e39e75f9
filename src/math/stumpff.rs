//! Stumpff's functions c_2 and c_3 of a small argument, by their power series.
//!
//! They are defined by cos x = 1 - x^2 c_2(x^2) and sin x = x - x^3 c_3(x^2), so that 1 - cos x and x - sin x
//! follow without cancellation. Negative arguments, x imaginary, give the hyperbolic functions.

use super::lanes::Lanes;
use pulp::Simd;

/// The largest magnitude of an argument for which the series are accurate to round-off.
pub const SERIES_LIMIT: f64 = 0.08;

/// The number of terms of a series. Relative to c_2(0), the first neglected term is at most
/// SERIES_LIMIT^6 2!/14! = 6e-18.
const TERMS: usize = 6;

/// Returns the coefficients (-1)^n/(2n + k)! of z^n in c_k(z).
const fn coefficients(k: usize) -> [f64; TERMS] {
    let mut coefficients = [0.0; TERMS];
    let (mut n, mut m, mut factorial) = (0, 1, 1.0);
    while n < TERMS {
        while m <= 2 * n + k {
            factorial *= m as f64;
            m += 1;
        }
        coefficients[n] = if n % 2 == 0 { 1.0 / factorial } else { -1.0 / factorial };
        n += 1;
    }
    coefficients
}

const C2: [f64; TERMS] = coefficients(2);
const C3: [f64; TERMS] = coefficients(3);

/// Returns c_2(z) and c_3(z) for |z| up to [`SERIES_LIMIT`].
#[inline(always)]
pub fn stumpff<S: Simd, const N: usize>(z: Lanes<S, N>) -> [Lanes<S, N>; 2] {
    let square = z * z;
    let mut sums = [z; 2];
    for (sum, c) in sums.iter_mut().zip([C2, C3]) {
        // Even and odd powers are summed separately, so that the two sums are computed in parallel.
        let even = square.mul_add(square.mul_add(z.constant(c[4]), z.constant(c[2])), z.constant(c[0]));
        let odd = square.mul_add(square.mul_add(z.constant(c[5]), z.constant(c[3])), z.constant(c[1]));
        *sum = z.mul_add(odd, even);
    }
    sums
}
