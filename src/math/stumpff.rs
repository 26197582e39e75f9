//! Stumpff's functions c_2 and c_3 of a small argument: the series of sine, cosine and their hyperbolic kin.
//!
//! cos x = 1 - x^2 c_2(x^2) and sin x = x - x^3 c_3(x^2), without the cancellation of 1 - cos x.

/// The largest argument, in size.
pub const REACH: f64 = 0.05;

/// Their terms; the first power that is left out is REACH^6 2/14! = 4e-19 of the first.
const TERMS: usize = 6;

/// The coefficients (-1)^n/(2 n + k)! of c_k.
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

/// c_2 and c_3 of an argument within [`REACH`].
#[inline(always)]
pub fn stumpff(z: f64) -> [f64; 2] {
    let square = z * z;
    // Even and odd powers apart: neither waits for the other.
    [C2, C3].map(|c| {
        let even = c[0] + square * (c[2] + square * c[4]);
        let odd = c[1] + square * (c[3] + square * c[5]);
        even + z * odd
    })
}
