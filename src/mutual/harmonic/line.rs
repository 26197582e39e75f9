//! Moments along the line of the centres.
//!
//! The moments of both bodies are rotated so that z points from the first centre to the second. In units of
//! the separation, and divided by sqrt((l - m)! (l + m)!), the coupling of two degrees is (l + l')!, and the
//! generators of rotations have integer entries.

use crate::math::Vec3;
use crate::math::exchange::{Exchange, MOST_ORDERS, Parities};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// The constant numbers of all degrees up to a highest one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tables {
    exchange: Exchange,
    /// One over sqrt((l - m)! (l + m)!), for each degree from order zero to the degree.
    weights: Vec<Vec<f64>>,
}

impl Tables {
    /// Computes the numbers up to a degree.
    pub fn new(degree: usize) -> Self {
        let exchange = Exchange::new(degree);
        let mut factorials = vec![1.0_f64];
        (1..=2 * exchange.degree()).for_each(|n| factorials.push(factorials[n - 1] * n as f64));
        let weight = |l: usize, m: usize| 1.0 / (factorials[l - m].sqrt() * factorials[l + m].sqrt());
        let weights = (0..=exchange.degree()).map(|l| (0..=l).map(|m| weight(l, m)).collect()).collect();
        Self { exchange, weights }
    }

    /// Returns the highest degree.
    pub fn degree(&self) -> usize {
        self.exchange.degree()
    }
}

/// The cosine and the sine of an angle.
pub(super) type Angle = [f64; 2];

/// The rotation from a body's frame to one whose z axis is a direction: by minus its longitude about z, and
/// then by minus its colatitude about y.
#[derive(Debug, Clone, Copy)]
pub(super) struct Direction {
    longitude: Angle,
    colatitude: Angle,
    /// The axes of the new frame in the body's frame.
    pub axes: [Vec3; 3],
}

impl Direction {
    /// Makes the rotation for a unit vector of the body's frame.
    pub fn new(n: Vec3) -> Self {
        let ring = n.x.hypot(n.y);
        let longitude = if ring > 0.0 { [n.x / ring, n.y / ring] } else { [1.0, 0.0] };
        let [cos, sin] = longitude;
        let axes = [Vec3::new(n.z * cos, n.z * sin, -ring), Vec3::new(-sin, cos, 0.0), n];
        Self { longitude, colatitude: [n.z, ring], axes }
    }
}

/// Returns cosine and sine of the multiples of an angle.
#[inline(always)]
fn multiples([cos, sin]: Angle, highest: usize) -> [Angle; Exchange::MAX_DEGREE + 1] {
    let mut out = [[1.0, 0.0]; Exchange::MAX_DEGREE + 1];
    for m in 1..=highest {
        let [c, s] = out[m - 1];
        out[m] = [c * cos - s * sin, s * cos + c * sin];
    }
    out
}

/// The moments of a body along the line of the centres, by order and, within an order, by degree.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineMoments<const N: usize> {
    pub degree: usize,
    pub cos: [f64; N],
    pub sin: [f64; N],
}

/// Returns the number of orders from zero up, over all degrees up to a highest one.
pub(super) const fn orders(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

impl<const N: usize> LineMoments<N> {
    /// Returns moments that are all zero.
    #[inline(always)]
    pub fn zeros(degree: usize) -> Self {
        Self { degree, cos: [0.0; N], sin: [0.0; N] }
    }

    /// Returns the index of the first degree of an order, which is the order itself.
    #[inline(always)]
    pub fn start(&self, order: usize) -> usize {
        order * (2 * self.degree + 3 - order) / 2
    }

    /// Rotates moments of a body's frame, whose unit of length is `ratio` times the separation. The moments
    /// of the second body, which count with the sign (-1)^(l + m), are rotated by an azimuth as well.
    #[inline(always)]
    pub fn new(
        tables: &Tables,
        moments: &[f64],
        degree: usize,
        ratio: f64,
        direction: &Direction,
        azimuth: Option<Angle>,
    ) -> Self {
        let mut out = Self::zeros(degree);
        let longitudes = multiples(direction.longitude, degree);
        let colatitudes = multiples(direction.colatitude, degree);
        let azimuths = multiples(azimuth.unwrap_or([1.0, 0.0]), degree);
        let mut power = 1.0;
        // Degrees of a point other than zero are not stored.
        for l in 0..=degree.min(moments.len().isqrt() - 1) {
            let (row, counts) = (&moments[l * l..(l + 1) * (l + 1)], Parities::counts(l));
            let mut p = Parities::zeros();
            let gather = |parity: usize, cosines: &mut [f64; MOST_ORDERS], sines: &mut [f64; MOST_ORDERS]| {
                for k in 0..counts[parity] {
                    let m = l - parity - 2 * k;
                    let [c, s] = longitudes[m];
                    let (cosine, sine) = (row[l + m], if m > 0 { row[l - m] } else { 0.0 });
                    cosines[k] = (cosine * c + sine * s) * power;
                    sines[k] = (sine * c - cosine * s) * power;
                }
            };
            gather(0, &mut p.even_cosines, &mut p.even_sines);
            gather(1, &mut p.odd_cosines, &mut p.odd_sines);
            let mut p = tables.exchange.apply(l, &p);
            let rotate_phases = |parity: usize,
                                 cosines: &mut [f64; MOST_ORDERS],
                                 sines: &mut [f64; MOST_ORDERS]| {
                for k in 0..counts[parity] {
                    let [c, s] = colatitudes[l - parity - 2 * k];
                    (cosines[k], sines[k]) = (cosines[k] * c - sines[k] * s, sines[k] * c + cosines[k] * s);
                }
            };
            rotate_phases(0, &mut p.even_cosines, &mut p.even_sines);
            rotate_phases(1, &mut p.odd_cosines, &mut p.odd_sines);
            let p = tables.exchange.apply(l, &p);
            let weights = &tables.weights[l];
            let mut scatter = |parity: usize, cosines: &[f64; MOST_ORDERS], sines: &[f64; MOST_ORDERS]| {
                for k in 0..counts[parity] {
                    let m = l - parity - 2 * k;
                    let sign = if azimuth.is_some() && parity == 1 { -1.0 } else { 1.0 };
                    let ([c, s], weight) = (azimuths[m], sign * weights[m]);
                    let index = out.start(m) + l - m;
                    out.cos[index] = (cosines[k] * c - sines[k] * s) * weight;
                    out.sin[index] = (sines[k] * c + cosines[k] * s) * weight;
                }
            };
            scatter(0, &p.even_cosines, &p.even_sines);
            scatter(1, &p.odd_cosines, &p.odd_sines);
            power *= ratio;
        }
        out
    }

    /// Returns the derivative of the energy with respect to the moments of a body of another degree, for the
    /// moments of the other body: the sum of (l + l')!, or of the other factors, times the moments.
    #[inline(always)]
    pub fn coupled(&self, factors: &[f64], degree: usize) -> Self {
        let mut out = Self::zeros(degree);
        for m in 0..=degree.min(self.degree) {
            let (from, to) = (self.start(m), out.start(m));
            let rows = degree - m + 1;
            let (cosines, sines) = (&mut out.cos[to..to + rows], &mut out.sin[to..to + rows]);
            for l in m..=self.degree {
                let (cos, sin) = (self.cos[from + l - m], self.sin[from + l - m]);
                let factors = &factors[l + m..l + m + rows];
                for ((c, s), factor) in cosines.iter_mut().zip(sines.iter_mut()).zip(factors) {
                    *c += cos * factor;
                    *s += sin * factor;
                }
            }
        }
        out
    }

    /// Returns the sum of the products of all moments.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> f64 {
        let size = orders(self.degree);
        product_sum(&self.cos[..size], &other.cos[..size])
            + product_sum(&self.sin[..size], &other.sin[..size])
    }

    /// Returns the sum of the products of all moments, each times its degree.
    #[inline(always)]
    pub fn weighted_dot(&self, other: &Self) -> f64 {
        let mut sum = 0.0;
        for m in 0..=self.degree {
            let range = self.range(m);
            let degrees = &INTEGERS[m..];
            sum += weighted_sum(&self.cos[range.clone()], &other.cos[range.clone()], degrees);
            sum += weighted_sum(&self.sin[range.clone()], &other.sin[range], degrees);
        }
        sum
    }

    #[inline(always)]
    fn range(&self, order: usize) -> std::ops::Range<usize> {
        self.start(order)..self.start(order + 1)
    }

    /// Returns the torque on the body, from the derivative of the energy with respect to its moments: the
    /// sums of the products of these and [`Self::rotated`].
    #[inline(always)]
    pub fn torque(&self, derivative: &Self) -> Vec3 {
        let mut torque = Vec3::zeros();
        for m in 0..=self.degree {
            let row = self.range(m);
            let (cos, sin) = (&derivative.cos[row.clone()], &derivative.sin[row.clone()]);
            if m < self.degree {
                let (above, weights) = (self.range(m + 1), &INTEGERS[2 * m + 2..]);
                let (cosines, sines) = (&self.cos[above.clone()], &self.sin[above]);
                let factor = if m == 0 { FRAC_1_SQRT_2 } else { 0.5 };
                let sum = |a: &[f64], b: &[f64]| factor * weighted_sum(&a[1..], b, weights);
                torque.x += sum(cos, sines) - sum(sin, cosines);
                torque.y -= sum(cos, cosines) + sum(sin, sines);
            }
            if m > 0 {
                let (below, weights) = (self.range(m - 1), &INTEGERS[1..]);
                let (cosines, sines) = (&self.cos[below.clone()][1..], &self.sin[below][1..]);
                let factor = if m == 1 { 0.5 * SQRT_2 } else { 0.5 };
                let sum = |a: &[f64], b: &[f64]| weighted_sum(a, b, weights);
                torque.x += 0.5 * sum(cos, sines) - factor * sum(sin, cosines);
                torque.y += factor * sum(cos, cosines) + 0.5 * sum(sin, sines);
                let cross_sum = product_sum(sin, &self.cos[row.clone()]) - product_sum(cos, &self.sin[row]);
                torque.z += m as f64 * cross_sum;
            }
        }
        torque
    }

    /// Returns the change of the moments by a rotation of the body about x, y and z, per angle.
    #[inline(always)]
    pub fn rotated(&self) -> [Self; 3] {
        let mut out = [0, 1, 2].map(|_| Self::zeros(self.degree));
        let [about_x, about_y, about_z] = &mut out;
        for m in 0..=self.degree {
            let row = self.start(m);
            // The terms of the order above, where the degree has it.
            if m < self.degree {
                let above = self.start(m + 1);
                let factor = if m == 0 { FRAC_1_SQRT_2 } else { 0.5 };
                for k in 0..self.degree - m {
                    let weight = factor * (k + 2 * m + 2) as f64;
                    let (cos, sin) = (weight * self.cos[above + k], weight * self.sin[above + k]);
                    about_x.cos[row + 1 + k] += sin;
                    about_y.cos[row + 1 + k] -= cos;
                    if m > 0 {
                        about_x.sin[row + 1 + k] -= cos;
                        about_y.sin[row + 1 + k] -= sin;
                    }
                }
            }
            if m > 0 {
                let below = self.start(m - 1);
                let factor = if m == 1 { 0.5 * SQRT_2 } else { 0.5 };
                for k in 0..=self.degree - m {
                    let weight = (k + 1) as f64;
                    let (cos, sin) =
                        (weight * factor * self.cos[below + 1 + k], weight * 0.5 * self.sin[below + 1 + k]);
                    about_x.cos[row + k] += sin;
                    about_x.sin[row + k] -= cos;
                    about_y.cos[row + k] += cos;
                    about_y.sin[row + k] += sin;
                    about_z.cos[row + k] = -(m as f64) * self.sin[row + k];
                    about_z.sin[row + k] = m as f64 * self.cos[row + k];
                }
            }
        }
        out
    }
}

/// The integers from zero on.
static INTEGERS: [f64; 2 * Exchange::MAX_DEGREE + 3] = {
    let mut numbers = [0.0; 2 * Exchange::MAX_DEGREE + 3];
    let mut n = 0;
    while n < numbers.len() {
        numbers[n] = n as f64;
        n += 1;
    }
    numbers
};

/// Returns the sum of products with weights, in four sums side by side.
#[inline(always)]
fn weighted_sum(a: &[f64], b: &[f64], weights: &[f64]) -> f64 {
    let size = a.len().min(b.len());
    let weights = &weights[..size];
    let ((a, a_remainder), (b, b_remainder), (w, w_remainder)) =
        (a[..size].as_chunks::<4>(), b[..size].as_chunks::<4>(), weights.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for ((a, b), w) in a.iter().zip(b).zip(w) {
        for k in 0..4 {
            sums[k] += a[k] * b[k] * w[k];
        }
    }
    let remainder: f64 =
        a_remainder.iter().zip(b_remainder).zip(w_remainder).map(|((a, b), w)| a * b * w).sum();
    ((sums[0] + sums[2]) + (sums[1] + sums[3])) + remainder
}

/// Returns the sum of products, in eight sums side by side.
#[inline(always)]
fn product_sum(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (chunks, remainder) = a.as_chunks::<8>();
    let (others, last) = b.as_chunks::<8>();
    for (a, b) in chunks.iter().zip(others) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    let remainder: f64 = remainder.iter().zip(last).map(|(a, b)| a * b).sum();
    ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7])) + remainder
}
