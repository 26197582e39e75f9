//! Stumpff's functions c_2 and c_3 of a small argument, by series.
//!
//! They give cos x = 1 - x^2 c_2(x^2) and sin x = x - x^3 c_3(x^2) without the cancellation of 1 - cos x, and
//! cosh and sinh for negative arguments.

use super::lanes::Lanes;
use pulp::Simd;

/// The largest magnitude of the argument.
pub const SERIES_LIMIT: f64 = 0.08;

/// The number of terms. The first term that is left out is at most SERIES_LIMIT^6 2/14! = 6e-18 of the first one.
const TERMS: usize = 6;

/// Returns the coefficients (-1)^n/(2 n + k)! of c_k.
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

/// Returns c_2 and c_3 for arguments within [`SERIES_LIMIT`].
#[inline(always)]
pub fn stumpff<S: Simd, const N: usize>(z: Lanes<S, N>) -> [Lanes<S, N>; 2] {
    let square = z * z;
    let mut sums = [z; 2];
    for (sum, c) in sums.iter_mut().zip([C2, C3]) {
        // Even and odd powers are summed apart, so that neither sum waits for the other.
        let even = square.mul_add(square.mul_add(z.constant(c[4]), z.constant(c[2])), z.constant(c[0]));
        let odd = square.mul_add(square.mul_add(z.constant(c[5]), z.constant(c[3])), z.constant(c[1]));
        *sum = z.mul_add(odd, even);
    }
    sums
}
