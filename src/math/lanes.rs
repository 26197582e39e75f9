//! Many points at a time: formulas that are written once over [`Lanes`] and run with the widest vectors of
//! the machine, which the `pulp` crate chooses at run time.
//!
//! A path changes results at round-off only (fused or separate multiply-add, number of partial sums).
//! [`VectorPath::Portable`] gives the same bits on every machine: one lane, no fused operations.

use super::{Mat3, Vec3};
use crate::names::Named;
use pulp::{Arch, Simd};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The longest block that any path works on, in doubles; node lists are padded to a multiple of it.
pub const BLOCK: usize = WIDEST * INTERLEAVED;

/// The most lanes that a register has on any path.
pub const WIDEST: usize = 8;

/// The instructions that the hot loops use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum VectorPath {
    /// The widest instructions that this machine has.
    #[default]
    Auto,
    /// One lane without fused multiply-add: the same bits on every machine.
    Portable,
    /// AVX2 and FMA, four lanes.
    Avx2,
    /// AVX-512, eight lanes.
    Avx512,
    /// NEON of 64-bit ARM, two lanes.
    Neon,
    /// The vectors of WebAssembly, two lanes.
    Simd128,
}

impl Named for VectorPath {
    const WHAT: &'static str = "vector_path";
    const NAMES: &'static [(&'static str, Self)] = &[
        ("auto", Self::Auto),
        ("portable", Self::Portable),
        ("avx2", Self::Avx2),
        ("avx512", Self::Avx512),
        ("neon", Self::Neon),
        ("simd128", Self::Simd128),
    ];
}

impl VectorPath {
    /// Returns every path that this machine can run, the portable one first.
    pub fn available() -> Vec<Self> {
        let paths = Self::NAMES.iter().map(|&(_, path)| path).filter(|&path| path != Self::Auto);
        paths.filter(|path| path.arch().is_some()).collect()
    }

    /// Returns the dispatcher of this path, or `None` where the machine lacks its instructions.
    pub fn arch(self) -> Option<Arch> {
        match self {
            Self::Auto => Some(Arch::new()),
            Self::Portable => Some(Arch::Scalar),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => pulp::x86::V3::try_new().map(Arch::V3),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => pulp::x86::V4::try_new().map(Arch::V4),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => pulp::aarch64::Neon::try_new().map(Arch::Neon),
            #[cfg(target_arch = "wasm32")]
            Self::Simd128 => pulp::wasm::Simd128::try_new().map(Arch::Simd128),
            _ => None,
        }
    }
}

/// Returns narrower instructions where `count` doubles fill at most half of a register, and `arch` otherwise.
pub fn few(arch: Arch, count: usize) -> Arch {
    match (arch, count) {
        #[cfg(target_arch = "x86_64")]
        (Arch::V4(_), ..=4) => VectorPath::Avx2.arch().unwrap_or(arch),
        (arch, _) => arch,
    }
}

/// The number of registers that are processed side by side by default, so that the latency of one hides
/// behind the work on the others.
pub const INTERLEAVED: usize = 2;

/// Repeats a block of code with `k` from 0 to `N` - 1, without a loop. Inlined into one kernel, thousands of
/// such loops took the compiler a third of its time.
macro_rules! each_register {
    ($k:ident < $n:ident, $body:block) => {
        const { assert!($n <= 8, "a block has at most eight registers") };
        each_register!(@ $k $n $body 0 1 2 3 4 5 6 7);
    };
    (@ $k:ident $n:ident $body:block $($index:literal)*) => {
        $(if $index < $n {
            let $k: usize = $index;
            $body
        })*
    };
}

/// The last bits of 2^52 + k, for a whole number k from zero on and below 2^52, are k.
const TWO_TO_52: f64 = 4_503_599_627_370_496.0;

/// A block of doubles with the arithmetic operators: `N` registers.
#[derive(Clone, Copy)]
pub struct Lanes<S: Simd, const N: usize = INTERLEAVED> {
    simd: S,
    raw: [S::f64s; N],
}

impl<S: Simd, const N: usize> Lanes<S, N> {
    /// Returns a block with the same value in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self { simd, raw: [simd.splat_f64s(value); N] }
    }

    /// The number of such blocks in [`BLOCK`] doubles.
    pub const PER_BLOCK: usize = BLOCK / (N * S::F64_LANES);

    /// Loads the block with this index from a slice of whole blocks.
    #[inline(always)]
    pub fn load(simd: S, values: &[f64], block: usize) -> Self {
        let (registers, _) = S::as_simd_f64s(values);
        Self { simd, raw: registers.as_chunks::<N>().0[block] }
    }

    /// Iterates over the blocks of a slice whose length is a multiple of [`BLOCK`].
    #[inline(always)]
    pub fn blocks(simd: S, values: &[f64]) -> impl Iterator<Item = Self> {
        let (registers, _) = S::as_simd_f64s(values);
        registers.as_chunks::<N>().0.iter().map(
            #[inline(always)]
            move |&raw| Self { simd, raw },
        )
    }

    /// Writes the block to this index of a slice of whole blocks.
    #[inline(always)]
    pub fn store(self, values: &mut [f64], block: usize) {
        let (registers, _) = S::as_mut_simd_f64s(values);
        registers[N * block..][..N].copy_from_slice(&self.raw);
    }

    /// Returns a block of the same kind with a constant in every lane.
    #[inline(always)]
    pub fn constant(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    /// Returns `self * b + c`, fused where the path has the instruction.
    #[inline(always)]
    pub fn mul_add(mut self, b: Self, c: Self) -> Self {
        each_register!(k < N, {
            self.raw[k] = self.simd.mul_add_e_f64s(self.raw[k], b.raw[k], c.raw[k]);
        });
        self
    }

    /// Returns the square root.
    #[inline(always)]
    pub fn sqrt(mut self) -> Self {
        each_register!(k < N, {
            self.raw[k] = self.simd.sqrt_f64s(self.raw[k]);
        });
        self
    }

    /// Returns the larger of two blocks, lane by lane.
    #[inline(always)]
    pub fn max(mut self, other: Self) -> Self {
        each_register!(k < N, {
            self.raw[k] = self.simd.max_f64s(self.raw[k], other.raw[k]);
        });
        self
    }

    /// Returns the smaller of two blocks, lane by lane.
    #[inline(always)]
    pub fn min(mut self, other: Self) -> Self {
        each_register!(k < N, {
            self.raw[k] = self.simd.min_f64s(self.raw[k], other.raw[k]);
        });
        self
    }

    /// Returns the absolute value.
    #[inline(always)]
    pub fn abs(mut self) -> Self {
        each_register!(k < N, {
            self.raw[k] = self.simd.abs_f64s(self.raw[k]);
        });
        self
    }

    /// Selects lane by lane: `then` where `self < than`, and `otherwise` elsewhere.
    #[inline(always)]
    pub fn if_less(mut self, than: Self, then: Self, otherwise: Self) -> Self {
        each_register!(k < N, {
            let mask = self.simd.less_than_f64s(self.raw[k], than.raw[k]);
            self.raw[k] = self.simd.select_f64s(mask, then.raw[k], otherwise.raw[k]);
        });
        self
    }

    /// Returns the largest lane.
    #[inline(always)]
    pub fn reduce_max(self) -> f64 {
        let mut largest = self.raw[0];
        for k in 1..N {
            largest = self.simd.max_f64s(largest, self.raw[k]);
        }
        self.simd.reduce_max_f64s(largest)
    }

    /// Returns the smallest lane.
    #[inline(always)]
    pub fn reduce_min(self) -> f64 {
        self.simd.reduce_min_f64s(self.simd.min_f64s(self.raw[0], self.raw[1]))
    }

    /// Returns two to the power of whole numbers from -1022 to 1023.
    #[inline(always)]
    pub fn power_of_two(self) -> Self {
        // The last twelve bits of this sum are the exponent of the result.
        let mut result = self + (f64::from(1023) + TWO_TO_52);
        for bits in pulp::bytemuck::cast_slice_mut::<S::f64s, u64>(&mut result.raw) {
            *bits <<= 52;
        }
        result
    }

    /// Splits positive normal numbers into a fraction from 1 to 2 and the exponent of a power of two.
    #[inline(always)]
    pub fn fraction_and_exponent(self) -> (Self, Self) {
        let (mut fraction, mut exponent) = (self, self);
        for bits in pulp::bytemuck::cast_slice_mut::<S::f64s, u64>(&mut fraction.raw) {
            *bits = *bits & ((1 << 52) - 1) | 1.0_f64.to_bits();
        }
        for bits in pulp::bytemuck::cast_slice_mut::<S::f64s, u64>(&mut exponent.raw) {
            *bits = *bits >> 52 | TWO_TO_52.to_bits();
        }
        (fraction, exponent + (-TWO_TO_52 - f64::from(1023)))
    }

    /// Returns the value of a block that has the same value in all lanes.
    #[inline(always)]
    pub fn first(self) -> f64 {
        self.simd.reduce_min_f64s(self.raw[0])
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $function:ident) => {
        impl<S: Simd, const N: usize> $trait for Lanes<S, N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                each_register!(k < N, {
                    self.raw[k] = self.simd.$function(self.raw[k], other.raw[k]);
                });
                self
            }
        }
    };
}
operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

macro_rules! operator_by_constant {
    ($trait:ident, $method:ident, $function:ident) => {
        impl<S: Simd, const N: usize> $trait<f64> for Lanes<S, N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: f64) -> Self {
                let other = self.simd.splat_f64s(other);
                each_register!(k < N, {
                    self.raw[k] = self.simd.$function(self.raw[k], other);
                });
                self
            }
        }
    };
}
operator_by_constant!(Add, add, add_f64s);
operator_by_constant!(Mul, mul, mul_f64s);

impl<S: Simd, const N: usize> Neg for Lanes<S, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        each_register!(k < N, {
            self.raw[k] = self.simd.neg_f64s(self.raw[k]);
        });
        self
    }
}

/// A running sum in one register, to which the registers of a block are added in turn. Its lanes are added at
/// the end.
#[derive(Clone, Copy)]
pub struct Total<S: Simd> {
    simd: S,
    raw: S::f64s,
}

impl<S: Simd> Total<S> {
    /// Returns a sum of zero.
    #[inline(always)]
    pub fn zero(simd: S) -> Self {
        Self { simd, raw: simd.splat_f64s(0.0) }
    }

    /// Adds a block to the sum.
    #[inline(always)]
    pub fn add<const N: usize>(&mut self, a: Lanes<S, N>) {
        each_register!(k < N, {
            self.raw = self.simd.add_f64s(self.raw, a.raw[k]);
        });
    }

    /// Adds the products of two blocks to the sum.
    #[inline(always)]
    pub fn add_product<const N: usize>(&mut self, a: Lanes<S, N>, b: Lanes<S, N>) {
        each_register!(k < N, {
            self.raw = self.simd.mul_add_e_f64s(a.raw[k], b.raw[k], self.raw);
        });
    }

    /// Returns the sum over all lanes.
    #[inline(always)]
    pub fn value(self) -> f64 {
        self.simd.reduce_sum_f64s(self.raw)
    }
}

// Kernels contain no closures over arrays (`map`, `from_fn`): the compiler would compile those separately,
// without the instructions of the path, and call them.

/// Evaluates several polynomials at once by Horner's rule. Coefficients are in ascending powers; an empty
/// list is zero.
#[inline(always)]
pub fn polynomials<S: Simd, const N: usize, const K: usize>(
    coefficients: &[[f64; K]],
    x: Lanes<S, N>,
) -> [Lanes<S, N>; K] {
    let mut sums = [x.constant(0.0); K];
    for row in coefficients.iter().rev() {
        for i in 0..K {
            sums[i] = sums[i].mul_add(x, x.constant(row[i]));
        }
    }
    sums
}

/// Replaces numbers, of any count, by a function of each.
#[inline(always)]
pub fn replace<S: Simd>(simd: S, numbers: &mut [f64], f: impl Fn(Lanes<S>) -> Lanes<S>) {
    let mut buffer = [0.0; BLOCK];
    for numbers in numbers.chunks_mut(BLOCK) {
        buffer[..numbers.len()].copy_from_slice(numbers);
        for block in 0..Lanes::<S>::PER_BLOCK {
            f(Lanes::load(simd, &buffer, block)).store(&mut buffer, block);
        }
        numbers.copy_from_slice(&buffer[..numbers.len()]);
    }
}

/// Returns a vector that is the same in every lane.
#[inline(always)]
pub fn splat_vector<S: Simd, const N: usize>(simd: S, v: &Vec3) -> [Lanes<S, N>; 3] {
    [Lanes::splat(simd, v.x), Lanes::splat(simd, v.y), Lanes::splat(simd, v.z)]
}

/// Loads a block of vectors from three lists of coordinates.
#[inline(always)]
pub fn load_vector<S: Simd, const N: usize>(simd: S, lists: &[Vec<f64>], block: usize) -> [Lanes<S, N>; 3] {
    [
        Lanes::load(simd, &lists[0], block),
        Lanes::load(simd, &lists[1], block),
        Lanes::load(simd, &lists[2], block),
    ]
}

/// Returns the difference of two vectors.
#[inline(always)]
pub fn minus<S: Simd, const N: usize>(a: [Lanes<S, N>; 3], b: [Lanes<S, N>; 3]) -> [Lanes<S, N>; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Returns the vector product.
#[inline(always)]
pub fn cross<S: Simd, const N: usize>(a: [Lanes<S, N>; 3], b: [Lanes<S, N>; 3]) -> [Lanes<S, N>; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the scalar product.
#[inline(always)]
pub fn dot<S: Simd, const N: usize>(a: [Lanes<S, N>; 3], b: [Lanes<S, N>; 3]) -> Lanes<S, N> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// Returns the vector of three sums.
#[inline(always)]
pub fn total_vector<S: Simd>(v: [Total<S>; 3]) -> Vec3 {
    Vec3::new(v[0].value(), v[1].value(), v[2].value())
}

/// Returns the matrix of these rows of sums.
#[inline(always)]
pub fn total_matrix<S: Simd>(rows: [[Total<S>; 3]; 3]) -> Mat3 {
    let [x, y, z] = [total_vector(rows[0]), total_vector(rows[1]), total_vector(rows[2])];
    Mat3::new(x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z)
}
