//! Monomials of three variables in a fixed order: by degree, then by falling powers of x, then of y.

use std::ops::Range;

/// Returns the number of monomials of a degree.
pub const fn count(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

/// Returns the number of monomials of all lower degrees.
pub const fn offset(degree: usize) -> usize {
    degree * (degree + 1) * (degree + 2) / 6
}

/// Returns the index of x^i y^j z^(degree-i-j) among the monomials of its degree.
pub const fn position(degree: usize, i: usize, j: usize) -> usize {
    let rest = degree - i;
    rest * (rest + 1) / 2 + (rest - j)
}

/// Returns the index of x^i y^j z^l among all monomials.
pub fn index(e: [usize; 3]) -> usize {
    let degree = e[0] + e[1] + e[2];
    offset(degree) + position(degree, e[0], e[1])
}

/// Iterates over the exponents (i, j) of the monomials of a degree, in the order of [`position`].
pub fn exponents(degree: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..=degree).flat_map(move |rest| (0..=rest).map(move |l| (degree - rest, rest - l)))
}

/// A row of monomials x^power y^(rest - l) z^l for l from 0 to `rest`. The rows of a degree follow each other
/// by falling power of x, and within a row l rises.
#[derive(Clone, Copy)]
pub struct Row {
    /// The power of x.
    pub power: usize,
    /// The power of y and z together.
    pub rest: usize,
    /// The index of the row's first monomial among the monomials of the degree.
    pub start: usize,
}

impl Row {
    /// Returns the indices of the row's monomials.
    pub fn monomials(self) -> Range<usize> {
        self.start..self.start + self.rest + 1
    }

    /// Returns the indices, one degree higher, of a monomial times x, y and z.
    pub fn times_one(self, place: usize) -> [usize; 3] {
        [place, place + self.rest + 1, place + self.rest + 2]
    }

    /// Returns the indices, two degrees higher, of a monomial times xx, xy, xz, yy, yz and zz.
    pub fn times_two(self, place: usize) -> [usize; 6] {
        let (one, two) = (place + self.rest + 1, place + 2 * self.rest + 3);
        [place, one, one + 1, two, two + 1, two + 2]
    }
}

/// Iterates over the rows of a degree.
pub fn rows(degree: usize) -> impl Iterator<Item = Row> {
    (0..=degree).map(move |rest| Row { power: degree - rest, rest, start: rest * (rest + 1) / 2 })
}

/// Adds a multiple of one homogeneous polynomial to another one.
#[inline]
pub fn add(sum: &mut [f64], term: &[f64], degree: usize, factor: f64) {
    for (s, t) in sum.iter_mut().zip(term).take(count(degree)) {
        *s += factor * t;
    }
}
