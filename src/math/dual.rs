//! Dual numbers over lanes: values with their derivatives with respect to three variables, for formulas that
//! are generic in the number type.

use super::lanes::Lanes;
use pulp::Simd;
use std::ops::{Add, Div, Mul, Sub};

/// The operations that a generic formula uses.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Returns a constant of the same kind as this number.
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

/// A number and its derivatives with respect to three variables.
#[derive(Clone, Copy)]
pub struct Dual<S: Simd, const N: usize> {
    /// The value of the number.
    pub value: Lanes<S, N>,
    /// The derivatives of the number with respect to the three variables.
    pub by: [Lanes<S, N>; 3],
}

impl<S: Simd, const N: usize> Dual<S, N> {
    /// Returns the three variables themselves as dual numbers.
    #[inline(always)]
    pub fn variables(values: [Lanes<S, N>; 3]) -> [Self; 3] {
        let (zero, unit) = (values[0].constant(0.0), values[0].constant(1.0));
        let mut all = [Self { value: zero, by: [zero; 3] }; 3];
        for k in 0..3 {
            all[k].value = values[k];
            all[k].by[k] = unit;
        }
        all
    }

    /// Applies the chain rule: returns the number whose derivatives are those of `a` times `by_a` plus those
    /// of `b` times `by_b`.
    #[inline(always)]
    fn chain(value: Lanes<S, N>, a: Self, by_a: Lanes<S, N>, b: Self, by_b: Lanes<S, N>) -> Self {
        let mut by = a.by;
        for k in 0..3 {
            by[k] = a.by[k].mul_add(by_a, b.by[k] * by_b);
        }
        Self { value, by }
    }
}

impl<S: Simd, const N: usize> Number for Dual<S, N> {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        let zero = self.value.constant(0.0);
        Self { value: self.value.constant(value), by: [zero; 3] }
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self * b + c
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let factor = root.constant(0.5) / root;
        Self::chain(root, self, factor, self, root.constant(0.0))
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
