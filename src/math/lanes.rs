//! Many points at a time: formulas written once over [`Lanes`], run with the widest vectors the machine
//! has, chosen at run time by the `pulp` crate.
//!
//! A path changes results at round-off only (fused or separate multiply-add, number of partial sums).
//! [`VectorPath::Portable`] gives the same bits on every machine: one lane, no fused operations.

use pulp::{Arch, Simd, WithSimd};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// The widest vector any path uses, in doubles; node lists are padded to a multiple of it.
pub const MAX_LANES: usize = 8;

/// Which instructions the hot loops use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VectorPath {
    /// The widest that this machine has.
    #[default]
    Auto,
    /// One lane, no fused multiply-add: the same bits on every machine.
    Portable,
    /// AVX2 and FMA, four lanes.
    Avx2,
    /// AVX-512, eight lanes.
    Avx512,
}

impl VectorPath {
    /// Every path that this machine can run, the portable one first.
    pub fn available() -> Vec<Self> {
        [Self::Portable, Self::Avx2, Self::Avx512].into_iter().filter(|p| p.arch().is_some()).collect()
    }

    /// The dispatcher of this path, or `None` where the machine lacks it.
    #[cfg(target_arch = "x86_64")]
    pub fn arch(self) -> Option<Arch> {
        match self {
            Self::Auto => Some(Arch::new()),
            Self::Portable => Some(Arch::Scalar),
            Self::Avx2 => pulp::x86::V3::try_new().map(Arch::V3),
            Self::Avx512 => pulp::x86::V4::try_new().map(Arch::V4),
        }
    }

    /// The dispatcher of this path, or `None` where the machine lacks it.
    #[cfg(not(target_arch = "x86_64"))]
    pub fn arch(self) -> Option<Arch> {
        match self {
            Self::Auto => Some(Arch::new()),
            Self::Portable => Some(Arch::Scalar),
            Self::Avx2 | Self::Avx512 => None,
        }
    }
}

/// Runs an operation over the lanes of `arch`.
#[inline]
pub fn dispatch<O: WithSimd>(arch: Arch, operation: O) -> O::Output {
    arch.dispatch(operation)
}

/// One vector register of doubles with the arithmetic operators.
#[derive(Clone, Copy)]
pub struct Lanes<S: Simd> {
    simd: S,
    /// The raw register.
    pub raw: S::f64s,
}

impl<S: Simd> Lanes<S> {
    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self { simd, raw: simd.splat_f64s(value) }
    }

    /// Wraps a raw register.
    #[inline(always)]
    pub fn new(simd: S, raw: S::f64s) -> Self {
        Self { simd, raw }
    }

    /// A constant beside this register.
    #[inline(always)]
    pub fn constant(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    /// `self * b + c`, fused where the path has it.
    #[inline(always)]
    pub fn mul_add(self, b: Self, c: Self) -> Self {
        Self::new(self.simd, self.simd.mul_add_e_f64s(self.raw, b.raw, c.raw))
    }

    /// Square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self::new(self.simd, self.simd.sqrt_f64s(self.raw))
    }

    /// The larger of two, lane by lane.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self::new(self.simd, self.simd.max_f64s(self.raw, other.raw))
    }

    /// Largest lane.
    #[inline(always)]
    pub fn reduce_max(self) -> f64 {
        self.simd.reduce_max_f64s(self.raw)
    }

    /// Smallest lane.
    #[inline(always)]
    pub fn reduce_min(self) -> f64 {
        self.simd.reduce_min_f64s(self.raw)
    }

    /// Absolute value.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self::new(self.simd, self.simd.abs_f64s(self.raw))
    }

    /// Sum of the lanes.
    #[inline(always)]
    pub fn reduce_sum(self) -> f64 {
        self.simd.reduce_sum_f64s(self.raw)
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $function:ident) => {
        impl<S: Simd> $trait for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self::new(self.simd, self.simd.$function(self.raw, other.raw))
            }
        }
    };
}
operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(self.simd, self.simd.neg_f64s(self.raw))
    }
}

impl<S: Simd> AddAssign for Lanes<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// Horner's rule with coefficients in ascending powers; an empty list is zero.
#[inline(always)]
pub fn polynomial<S: Simd>(coefficients: &[f64], x: Lanes<S>) -> Lanes<S> {
    let mut sum = x.constant(0.0);
    for &c in coefficients.iter().rev() {
        sum = sum.mul_add(x, x.constant(c));
    }
    sum
}
