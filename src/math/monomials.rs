//! Monomials of three variables in a fixed order: by degree, then by falling powers of x, then of y.

/// Number of those of a degree.
pub const fn count(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

/// Number of those of all lower degrees.
pub const fn offset(degree: usize) -> usize {
    degree * (degree + 1) * (degree + 2) / 6
}

/// Place of x^i y^j z^(degree-i-j) among the monomials of its degree.
pub const fn position(degree: usize, i: usize, j: usize) -> usize {
    let rest = degree - i;
    rest * (rest + 1) / 2 + (rest - j)
}

/// Place of x^i y^j z^l among all monomials.
pub fn index(e: [usize; 3]) -> usize {
    let degree = e[0] + e[1] + e[2];
    offset(degree) + position(degree, e[0], e[1])
}

/// Exponents (i, j) of the monomials of a degree, in the order of [`position`].
pub fn exponents(degree: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..=degree).flat_map(move |rest| (0..=rest).map(move |l| (degree - rest, rest - l)))
}
