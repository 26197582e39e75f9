//! Dual numbers: values with their first derivatives with respect to three variables (forward automatic
//! differentiation).
//!
//! A formula that is generic in [`Number`] gives its values with [`Lanes`] and its derivatives too with
//! [`Dual`].

use super::lanes::Lanes;
use pulp::Simd;
use std::ops::{Add, Div, Mul, Sub};

/// A number type with the operations that generic formulas use.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Returns a constant as a number of this type; the value of `self` is not used.
    fn constant(self, value: f64) -> Self;
    /// Returns `self * b + c`.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// Returns the square root.
    fn sqrt(self) -> Self;
}

impl<S: Simd, const N: usize> Number for Lanes<S, N> {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        Lanes::constant(self, value)
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Lanes::mul_add(self, b, c)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Lanes::sqrt(self)
    }
}

/// A value and its derivatives with respect to three variables.
#[derive(Clone, Copy)]
pub struct Dual<S: Simd, const N: usize> {
    /// The value.
    pub value: Lanes<S, N>,
    /// The derivatives with respect to the three variables.
    pub gradient: [Lanes<S, N>; 3],
}

impl<S: Simd, const N: usize> Dual<S, N> {
    /// Returns the three variables themselves as dual numbers.
    #[inline(always)]
    pub fn variables(values: [Lanes<S, N>; 3]) -> [Self; 3] {
        let (zero, unit) = (values[0].constant(0.0), values[0].constant(1.0));
        let mut all = [Self { value: zero, gradient: [zero; 3] }; 3];
        for k in 0..3 {
            all[k].value = values[k];
            all[k].gradient[k] = unit;
        }
        all
    }

    /// Applies the chain rule: returns f(a, b) from its value and its partial derivatives `by_a` and `by_b`.
    #[inline(always)]
    fn chain(value: Lanes<S, N>, a: Self, by_a: Lanes<S, N>, b: Self, by_b: Lanes<S, N>) -> Self {
        let mut gradient = a.gradient;
        for k in 0..3 {
            gradient[k] = a.gradient[k].mul_add(by_a, b.gradient[k] * by_b);
        }
        Self { value, gradient }
    }
}

impl<S: Simd, const N: usize> Number for Dual<S, N> {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        let zero = self.value.constant(0.0);
        Self { value: self.value.constant(value), gradient: [zero; 3] }
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self * b + c
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let derivative = root.constant(0.5) / root;
        // There is no second variable.
        Self::chain(root, self, derivative, self, root.constant(0.0))
    }
}

impl<S: Simd, const N: usize> Add for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let unit = self.value.constant(1.0);
        Self::chain(self.value + other.value, self, unit, other, unit)
    }
}

impl<S: Simd, const N: usize> Sub for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let unit = self.value.constant(1.0);
        Self::chain(self.value - other.value, self, unit, other, -unit)
    }
}

impl<S: Simd, const N: usize> Mul for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::chain(self.value * other.value, self, other.value, other, self.value)
    }
}

impl<S: Simd, const N: usize> Div for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = self.value.constant(1.0) / other.value;
        let value = self.value * inverse;
        Self::chain(value, self, inverse, other, -value * inverse)
    }
}
