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
    let power_of_yz = degree - i;
    power_of_yz * (power_of_yz + 1) / 2 + (power_of_yz - j)
}

/// Returns the index of x^i y^j z^l among all monomials.
pub fn index(e: [usize; 3]) -> usize {
    let degree = e[0] + e[1] + e[2];
    offset(degree) + position(degree, e[0], e[1])
}

/// Iterates over the exponents (i, j) of the monomials of a degree, in the order of [`position`].
pub fn exponents(degree: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..=degree)
        .flat_map(move |power_of_yz| (0..=power_of_yz).map(move |l| (degree - power_of_yz, power_of_yz - l)))
}

/// A row of monomials x^power y^(rest - l) z^l for l from 0 to `power_of_yz`. The rows of a degree follow
/// each other by falling power of x, and within a row l rises.
#[derive(Clone, Copy)]
pub struct Row {
    /// The power of x.
    pub power: usize,
    /// The power of y and z together.
    pub power_of_yz: usize,
    /// The index of the row's first monomial among the monomials of the degree.
    pub start: usize,
}

impl Row {
    /// Returns the indices of the row's monomials.
    pub fn monomials(self) -> Range<usize> {
        self.start..self.start + self.power_of_yz + 1
    }

    /// Returns the indices, one degree higher, of a monomial times x, y and z.
    pub fn raised_once(self, index: usize) -> [usize; 3] {
        [index, index + self.power_of_yz + 1, index + self.power_of_yz + 2]
    }

    /// Returns the indices, two degrees higher, of a monomial times xx, xy, xz, yy, yz and zz.
    pub fn raised_twice(self, index: usize) -> [usize; 6] {
        let (next_row, row_after_next) = (index + self.power_of_yz + 1, index + 2 * self.power_of_yz + 3);
        [index, next_row, next_row + 1, row_after_next, row_after_next + 1, row_after_next + 2]
    }
}

/// Iterates over the rows of a degree.
pub fn rows(degree: usize) -> impl Iterator<Item = Row> {
    (0..=degree).map(move |power_of_yz| Row {
        power: degree - power_of_yz,
        power_of_yz,
        start: power_of_yz * (power_of_yz + 1) / 2,
    })
}

/// Adds a multiple of one homogeneous polynomial to another one.
#[inline]
pub fn add(sum: &mut [f64], term: &[f64], degree: usize, factor: f64) {
    for (s, t) in sum.iter_mut().zip(term).take(count(degree)) {
        *s += factor * t;
    }
}
