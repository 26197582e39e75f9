//! Carlson's elliptic integrals R_F and R_D by duplication, over lanes.
//!
//! R_F(x,y,z) = 1/2 int_0^inf dt / sqrt((t+x)(t+y)(t+z)), and
//! R_D(x,y,z) = 3/2 int_0^inf dt / (sqrt((t+x)(t+y)(t+z)) (t+z)).
//! Carlson (1995), Numer. Algor. 10, 13; series to seventh degree as in DLMF 19.36(i).

use super::dual::Number;

/// Returns the three R_D integrals of an ellipsoid's field at one point, for s1 >= s2 >= s3 > 0:
/// `[R_D(s2,s3;s1), R_D(s3,s1;s2), R_D(s1,s2;s3)]`.
///
/// The two smaller ones are computed by `duplications` shared duplication steps. The largest follows from the
/// identity R_D + R_D + R_D = 3 / sqrt(s1 s2 s3), which is free of cancellation in this order.
/// [`duplications_needed`] returns the number of steps that full precision takes.
#[inline(always)]
pub fn rd_triple<N: Number>(s: [N; 3], duplications: u32) -> [N; 3] {
    let c = |value| s[0].constant(value);
    let product_root = (s[0] * s[1] * s[2]).sqrt();
    let [mut x, mut y, mut z] = s;
    let mut power = 1.0;
    let (mut sum_x, mut sum_y) = (c(0.0), c(0.0));
    for _ in 0..duplications {
        let (rx, ry, rz) = (x.sqrt(), y.sqrt(), z.sqrt());
        let lambda = rx.mul_add(ry + rz, ry * rz);
        let (x_lambda, y_lambda) = (x + lambda, y + lambda);
        // One division serves both sums: 1/(rx (x+l)) and 1/(ry (y+l)).
        let (dx, dy) = (rx * x_lambda, ry * y_lambda);
        let shared = c(power) / (dx * dy);
        sum_x = shared.mul_add(dy, sum_x);
        sum_y = shared.mul_add(dx, sum_y);
        power *= 0.25;
        x = x_lambda * c(0.25);
        y = y_lambda * c(0.25);
        z = (z + lambda) * c(0.25);
    }
    let rd_x = c(3.0).mul_add(sum_x, c(power) * rd_series(y, z, x));
    let rd_y = c(3.0).mul_add(sum_y, c(power) * rd_series(z, x, y));
    let rd_z = c(3.0) / product_root - rd_x - rd_y;
    [rd_x, rd_y, rd_z]
}

/// Returns R_D(x, y; z) of nearly equal arguments by its Taylor series to seventh degree.
#[inline(always)]
fn rd_series<N: Number>(x: N, y: N, z: N) -> N {
    let c = |value| x.constant(value);
    let mean = c(3.0).mul_add(z, x + y) * c(0.2);
    let inverse = c(1.0) / mean;
    let (dx, dy) = ((mean - x) * inverse, (mean - y) * inverse);
    let dz = (dx + dy) * c(-1.0 / 3.0);
    let (xy, zz) = (dx * dy, dz * dz);
    let e2 = c(-6.0).mul_add(zz, xy);
    let e3 = c(3.0).mul_add(xy, c(-8.0) * zz) * dz;
    let e4 = c(3.0) * (xy - zz) * zz;
    let e5 = xy * zz * dz;
    // The series is 1 - 3/14 E2 + 1/6 E3 + 9/88 E2^2 - 3/22 E4 - 9/52 E2 E3 + 3/26 E5 - 1/16 E2^3 + 3/40 E3^2
    // + 3/20 E2 E4 + 45/272 E2^2 E3 - 9/68 (E3 E4 + E2 E5).
    let e22 = e2 * e2;
    let mut series = c(-9.0 / 68.0) * e3.mul_add(e4, e2 * e5);
    series = (c(45.0 / 272.0) * e22).mul_add(e3, series);
    series = (c(3.0 / 20.0) * e2).mul_add(e4, series);
    series = (c(3.0 / 40.0) * e3).mul_add(e3, series);
    series = (c(-1.0 / 16.0) * e22).mul_add(e2, series);
    series = c(3.0 / 26.0).mul_add(e5, series);
    series = (c(-9.0 / 52.0) * e2).mul_add(e3, series);
    series = c(-3.0 / 22.0).mul_add(e4, series);
    series = c(9.0 / 88.0).mul_add(e22, series);
    series = c(1.0 / 6.0).mul_add(e3, series);
    series = c(-3.0 / 14.0).mul_add(e2, series) + c(1.0);
    series * inverse / mean.sqrt()
}

/// Returns the number of duplication steps after which the remainder of the series is below round-off, for
/// arguments whose spread is at most that of `s` (largest first).
pub fn duplications_needed(s: [f64; 3]) -> u32 {
    // The remainder is about 3/2 delta^8, where delta is the largest relative distance of an argument from
    // the mean.
    const ENOUGH: f64 = 0.009;
    let [mut x, mut y, mut z] = s;
    let mut steps = 0;
    while {
        let lowest_mean = (3.0 * z + x + y).min(3.0 * x + y + z) / 5.0;
        (x - z) / lowest_mean > ENOUGH && steps < 40
    } {
        let lambda = (x * y).sqrt() + (y * z).sqrt() + (z * x).sqrt();
        (x, y, z) = ((x + lambda) / 4.0, (y + lambda) / 4.0, (z + lambda) / 4.0);
        steps += 1;
    }
    steps
}
