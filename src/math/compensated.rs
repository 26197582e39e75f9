//! Sums with low parts, the remainders after rounding: error-free addition and a running sum.
//!
//! The methods are Knuth's two-sum and Dekker's fast two-sum; see Ogita, Rump & Oishi (2005), SIAM J. Sci.
//! Comput. 26, 1955.

use pulp::Simd;

/// Returns the sum of two numbers and its exact rounding error.
#[inline(always)]
pub fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_virtual = sum - a;
    (sum, (a - (sum - b_virtual)) + (b - b_virtual))
}

/// Returns the result of [`two_sum`] in every lane.
#[inline(always)]
pub fn two_sum_in<S: Simd>(simd: S, a: S::f64s, b: S::f64s) -> (S::f64s, S::f64s) {
    let sum = simd.add_f64s(a, b);
    let b_virtual = simd.sub_f64s(sum, a);
    let lost = simd.sub_f64s(a, simd.sub_f64s(sum, b_virtual));
    (sum, simd.add_f64s(lost, simd.sub_f64s(b, b_virtual)))
}

/// Returns the product of two numbers and its exact rounding error.
#[inline(always)]
pub fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

/// Adds an increment to a number that is held as a high and a low part.
#[inline(always)]
pub fn add(high: &mut f64, low: &mut f64, change: f64) {
    let (sum, error) = two_sum(*high, change);
    let tail = error + *low;
    // After two_sum the tail is the smaller of the two summands, as the fast two-sum requires.
    *high = sum + tail;
    *low = tail - (*high - sum);
}

/// Adds multiples of three numbers to three numbers that are held in two parts, as [`add`] does.
#[inline(always)]
pub fn add_multiples<const N: usize>(high: &mut [f64; N], low: &mut [f64; N], size: f64, changes: &[f64; N]) {
    // All sums are read first and written last, so that the compiler adds them side by side.
    let (mut sums, mut tails) = (*high, *low);
    for c in 0..N {
        add(&mut sums[c], &mut tails[c], size * changes[c]);
    }
    (*high, *low) = (sums, tails);
}

/// Adds multiples of numbers to equally many numbers that are held in two parts, as [`add`] does.
#[inline(always)]
pub fn add_all<S: Simd>(simd: S, high: &mut [f64], low: &mut [f64], size: f64, changes: &[f64]) {
    let (high, high_rest) = S::as_mut_simd_f64s(&mut high[..changes.len()]);
    let (low, low_rest) = S::as_mut_simd_f64s(&mut low[..changes.len()]);
    let (changes, changes_rest) = S::as_simd_f64s(changes);
    let factor = simd.splat_f64s(size);
    for ((high, low), change) in high.iter_mut().zip(low).zip(changes) {
        let change = simd.mul_f64s(factor, *change);
        let (sum, error) = two_sum_in(simd, *high, change);
        let tail = simd.add_f64s(error, *low);
        *high = simd.add_f64s(sum, tail);
        *low = simd.sub_f64s(tail, simd.sub_f64s(*high, sum));
    }
    for ((high, low), change) in high_rest.iter_mut().zip(low_rest).zip(changes_rest) {
        add(high, low, size * change);
    }
}

/// A number carried as the unevaluated sum of a high and a low part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Compensated {
    /// The rounded value.
    pub high: f64,
    /// The low part: the remainder after rounding.
    pub low: f64,
}

impl Compensated {
    /// Wraps a value that is exact: the low part is zero.
    pub fn new(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }

    /// Returns the difference of two numbers without rounding.
    pub fn difference(a: f64, b: f64) -> Self {
        let (high, low) = two_sum(a, -b);
        Self { high, low }
    }

    /// Adds an increment.
    #[inline(always)]
    pub fn add(&mut self, increment: f64) {
        let (high, low) = two_sum(self.high, increment);
        // The number is renormalised, so that the high part is always the nearest double.
        let (high, low) = two_sum(high, low + self.low);
        self.high = high;
        self.low = low;
    }

    /// Returns the sum of two numbers in twice the working precision.
    pub fn plus(self, other: Self) -> Self {
        let (high, low) = two_sum(self.high, other.high);
        let (high, low) = two_sum(high, low + (self.low + other.low));
        Self { high, low }
    }

    /// Returns the product of two numbers in twice the working precision.
    pub fn times(self, other: Self) -> Self {
        let (high, low) = two_product(self.high, other.high);
        let (high, low) = two_sum(high, low + (self.high * other.low + self.low * other.high));
        Self { high, low }
    }

    /// Returns the nearest double.
    pub fn value(self) -> f64 {
        self.high + self.low
    }
}

/// Returns the sum of an iterator as if it were formed in twice the working precision.
pub fn sum(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut total = Compensated::default();
    for value in values {
        total.add(value);
    }
    total.value()
}
