//! Solid harmonics, many points at a time.
//!
//! S_nm is |x|^n times the real spherical harmonic in Schmidt's semi-normalisation, m from -n to n (sines
//! below zero), so that the addition theorem is P_n(u . v) = sum_m S_nm(u) S_nm(v) for unit vectors and no
//! S_nm exceeds |x|^n. They are made by
//!
//!   S_nn  = sqrt((2n - 1)/(2n)) (x S_{n-1,n-1} - y S_{n-1,1-n}),   S_11 = x,
//!   S_n,-n = sqrt((2n - 1)/(2n)) (x S_{n-1,1-n} + y S_{n-1,n-1}),
//!   S_nm  = [(2n - 1) z S_{n-1,m} - sqrt((n-1)^2 - m^2) |x|^2 S_{n-2,m}] / sqrt(n^2 - m^2).

use super::Vec3;
use super::lanes::{BLOCK, Lanes, Total, dot};
use gauss_quad::GaussLegendre;
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::TAU;
use std::num::NonZeroUsize;

/// Returns the number of harmonics up to a degree.
pub const fn count(degree: usize) -> usize {
    (degree + 1) * (degree + 1)
}

/// Returns the index of S_nm in a list of harmonics.
pub const fn index(n: usize, m: isize) -> usize {
    (n * n + n).wrapping_add_signed(m)
}

/// Computes all harmonics up to a degree, in the order of [`index`].
#[inline(always)]
fn harmonics<S: Simd>(x: [Lanes<S>; 3], degree: usize, out: &mut [Lanes<S>]) {
    let c = |value| x[0].constant(value);
    let square = dot(x, x);
    let root = |value: usize| (value as f64).sqrt();
    out[0] = c(1.0);
    for m in 0..=degree {
        if m > 0 {
            let factor = c(if m == 1 { 1.0 } else { root(2 * m - 1) / root(2 * m) });
            let (cos, sin) = if m == 1 {
                (c(1.0), c(0.0))
            } else {
                (out[index(m - 1, m as isize - 1)], out[index(m - 1, 1 - m as isize)])
            };
            out[index(m, m as isize)] = factor * (x[0] * cos - x[1] * sin);
            out[index(m, -(m as isize))] = factor * x[0].mul_add(sin, x[1] * cos);
        }
        for sign in [1, -1] {
            let m = m as isize * sign;
            for n in m.unsigned_abs() + 1..=degree {
                let scale = 1.0 / root(n * n - m.unsigned_abs() * m.unsigned_abs());
                let next = c((2 * n - 1) as f64 * scale) * x[2] * out[index(n - 1, m)];
                out[index(n, m)] = if n > m.unsigned_abs() + 1 {
                    let back = root((n - 1) * (n - 1) - m.unsigned_abs() * m.unsigned_abs()) * scale;
                    next - c(back) * square * out[index(n - 2, m)]
                } else {
                    next
                };
            }
            if m == 0 {
                break;
            }
        }
    }
}

/// Computes sums of weights times harmonics over points and adds them to `sums`. The points come in whole
/// blocks.
pub struct WeightedHarmonics<'a> {
    /// The coordinates of the points.
    pub points: [&'a [f64]; 3],
    /// The weights of the points.
    pub weights: &'a [f64],
    /// The highest degree.
    pub degree: usize,
    /// The sums, in the order of [`index`].
    pub sums: &'a mut [f64],
}

impl WithSimd for WeightedHarmonics<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let [x, y, z] = self.points;
        let points = || Lanes::blocks(simd, x).zip(Lanes::blocks(simd, y)).zip(Lanes::blocks(simd, z));
        // The harmonics of an order and its own degree, times the weights. Those of higher degrees have a
        // factor that cosine and sine share, so that three numbers of a point stay in registers.
        let mut seeds: Vec<[Lanes<S>; 2]> =
            Lanes::blocks(simd, self.weights).map(|weight| [weight, Lanes::splat(simd, 0.0)]).collect();
        let root = |value: usize| (value as f64).sqrt();
        for m in 0..=self.degree {
            let (first, scale) =
                (m == 0, if m == 1 { 1.0 } else { root(2 * m.max(1) - 1) / root(2 * m.max(1)) });
            let coefficients: Vec<[f64; 2]> = (m + 1..=self.degree)
                .map(|n| {
                    let inverse = 1.0 / root(n * n - m * m);
                    [(2 * n - 1) as f64 * inverse, root((n - 1) * (n - 1) - m * m) * inverse]
                })
                .collect();
            let mut totals = vec![[Total::zero(simd); 2]; coefficients.len() + 1];
            for (seed, ((x, y), z)) in seeds.iter_mut().zip(points()) {
                let c = |value| x.constant(value);
                let [cos, sin] = *seed;
                if !first {
                    *seed = [c(scale) * (x * cos - y * sin), c(scale) * x.mul_add(sin, y * cos)];
                }
                let [cos, sin] = *seed;
                let square = dot([x, y, z], [x, y, z]);
                let (mut previous, mut factor) = (c(0.0), c(1.0));
                let (lowest, higher) = totals.split_at_mut(1);
                lowest[0][0].add_product(cos, factor);
                lowest[0][1].add_product(sin, factor);
                for (total, [up, back]) in higher.iter_mut().zip(&coefficients) {
                    let next = c(*up) * z * factor - c(*back) * square * previous;
                    (previous, factor) = (factor, next);
                    total[0].add_product(cos, factor);
                    total[1].add_product(sin, factor);
                }
            }
            for (n, [cos, sin]) in (m..).zip(totals) {
                self.sums[index(n, m as isize)] += cos.value();
                if m > 0 {
                    self.sums[index(n, -(m as isize))] += sin.value();
                }
            }
        }
    }
}

/// Evaluates series of harmonics, sums of coefficients times S_nm, at every point.
pub struct HarmonicSeries<'a> {
    /// The coordinates of the points, in whole blocks.
    pub points: [&'a [f64]; 3],
    /// The coefficients of each series, in the order of [`index`].
    pub series: &'a [&'a [f64]],
    /// The highest degree of all series.
    pub degree: usize,
    /// The values of the series: those of the first one at all points, then those of the next.
    pub out: &'a mut [f64],
}

impl WithSimd for HarmonicSeries<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut values = vec![Lanes::splat(simd, 0.0); count(self.degree)];
        let [x, y, z] = self.points;
        let points = Lanes::blocks(simd, x).zip(Lanes::blocks(simd, y)).zip(Lanes::blocks(simd, z));
        for (index, ((x, y), z)) in points.enumerate() {
            harmonics([x, y, z], self.degree, &mut values);
            for (coefficients, out) in self.series.iter().zip(self.out.chunks_exact_mut(self.points[0].len()))
            {
                let mut sum = x.constant(0.0);
                for (value, coefficient) in values.iter().zip(*coefficients) {
                    sum = value.mul_add(sum.constant(*coefficient), sum);
                }
                sum.store(out, index);
            }
        }
    }
}

/// Returns the harmonics up to a degree at a point, in the order of [`index`].
pub fn at(x: &Vec3, degree: usize) -> Vec<f64> {
    let mut sums = vec![0.0; count(degree)];
    let mut points = [[0.0; BLOCK]; 3];
    points.iter_mut().zip(x.iter()).for_each(|(row, x)| row[0] = *x);
    let mut weights = [0.0; BLOCK];
    weights[0] = 1.0;
    let points = points.each_ref().map(<[f64; BLOCK]>::as_slice);
    Arch::Scalar.dispatch(WeightedHarmonics { points, weights: &weights, degree, sums: &mut sums });
    sums
}

/// Multiplies all numbers of each degree, in the order of [`index`], by a factor.
pub fn scale_degrees(values: &mut [f64], factor: impl Fn(usize) -> f64) {
    values.iter_mut().enumerate().for_each(|(index, value)| *value *= factor(index.isqrt()));
}

/// A layer on the unit sphere: points, padded to whole blocks, with weights.
pub type Layer = ([Vec<f64>; 3], Vec<f64>);

/// Returns the layer of the density sum of (2 n + 1) M_nm S_nm with these means M_nm, at least up to the
/// degree: its points' means are the same up to the degree.
pub fn layer(means: &[f64], degree: usize, arch: Arch) -> Layer {
    let latitudes = NonZeroUsize::new(degree + 1).unwrap_or(NonZeroUsize::MIN);
    let rule = GaussLegendre::new(latitudes);
    let angles = 2 * degree + 1;
    let (mut points, mut weights): Layer = Default::default();
    for (&z, &weight) in rule.nodes().zip(rule.weights()) {
        let ring = ((1.0 - z) * (1.0 + z)).sqrt();
        for k in 0..angles {
            let (sin, cos) = (TAU * (k as f64 + 0.5) / angles as f64).sin_cos();
            points.iter_mut().zip([ring * cos, ring * sin, z]).for_each(|(p, value)| p.push(value));
            weights.push(0.5 * weight / angles as f64);
        }
    }
    let length = weights.len().next_multiple_of(BLOCK);
    points.iter_mut().for_each(|p| p.resize(length, 0.0));
    weights.resize(length, 0.0);
    let mut coefficients = means[..count(degree)].to_vec();
    scale_degrees(&mut coefficients, |n| (2 * n + 1) as f64);
    let mut density = vec![0.0; length];
    let (points_of, series) = (points.each_ref().map(Vec::as_slice), &[coefficients.as_slice()]);
    arch.dispatch(HarmonicSeries { points: points_of, series, degree, out: &mut density });
    weights.iter_mut().zip(&density).for_each(|(weight, density)| *weight *= density);
    (points, weights)
}

/// Returns the means of the harmonics up to a degree over a mass that a similarity has moved elsewhere, from
/// its means before, at least up to this degree. The harmonics of the image are harmonic polynomials of the
/// original, so that they have the same means over its layer.
pub fn moved(means: &[f64], degree: usize, map: impl Fn(&Vec3) -> Vec3) -> Vec<f64> {
    let ([mut x, mut y, mut z], weights) = layer(means, degree, Arch::Scalar);
    for ((x, y), z) in x.iter_mut().zip(&mut y).zip(&mut z) {
        [*x, *y, *z] = map(&Vec3::new(*x, *y, *z)).into();
    }
    let mut sums = vec![0.0; count(degree)];
    let points: [&[f64]; 3] = [&x, &y, &z];
    Arch::Scalar.dispatch(WeightedHarmonics { points, weights: &weights, degree, sums: &mut sums });
    sums
}
