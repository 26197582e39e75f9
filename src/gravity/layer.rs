//! A body as a layer on its circumscribed sphere: points that attract like the body from outside.
//!
//! The mean over the body of a function that is harmonic in a sphere about it equals the mean over the sphere
//! with the density
//!
//!   sum_n (2n + 1) sum_m M_nm S_nm(u),
//!
//! where M_nm are the means of the solid harmonics of x/R over the body (Green 1828). A layer of degree N
//! reproduces all harmonics to that degree, and Gauss-Legendre in z times equal angles is exact for products
//! of two such degrees. The points' attraction equals that of the body to (R/r)^(N + 1): the error consists
//! only of products of a term of the layer with a term of 1/|x - y| whose degrees add up to more than
//! 2 N + 1. The terms of the sum have nearly one sign, so that no digits are lost at any distance.

use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::lanes::{Lanes, Total, dot, splat_vector, total_vector};
use crate::math::{Mat3, Vec3, harmonics};
use crate::shape::Polyhedron;
use pulp::{Arch, Simd, WithSimd};

/// The points of a layer; their weights add up to one.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Coordinates from the centre of mass, padded with weightless points to whole blocks.
    pub points: [Vec<f64>; 3],
    /// The weights of the points.
    pub weights: Vec<f64>,
    /// The number of points with a weight.
    pub count: usize,
}

impl Layer {
    /// The highest degree of a layer.
    pub const MAX_DEGREE: usize = 60;

    /// Computes the layer of a polyhedron.
    pub fn new(
        polyhedron: &Polyhedron,
        degree: usize,
        arch: Arch,
        interrupt: &mut InterruptCheck,
    ) -> Result<Self> {
        let moments = polyhedron.harmonic_moments(degree, arch, interrupt)?;
        Ok(Self::from_moments(&moments, polyhedron.circumradius(), degree, arch))
    }

    /// Computes the layer from the means of the solid harmonics of x / radius, at least up to the degree.
    pub fn from_moments(moments: &[f64], radius: f64, degree: usize, arch: Arch) -> Self {
        let (mut points, weights) = harmonics::layer(moments, degree, arch);
        let count = (degree + 1) * (2 * degree + 1);
        points.iter_mut().flatten().for_each(|value| *value *= radius);
        Self { points, weights, count }
    }

    /// Returns Phi, g and dg/dx per unit GM at a point outside the sphere.
    pub fn at(&self, arch: Arch, x: &Vec3) -> (f64, Vec3, Mat3) {
        arch.dispatch(Attraction { layer: self, x })
    }
}

struct Attraction<'a> {
    layer: &'a Layer,
    x: &'a Vec3,
}

impl WithSimd for Attraction<'_> {
    type Output = (f64, Vec3, Mat3);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (f64, Vec3, Mat3) {
        let position: [Lanes<S>; 3] = splat_vector(simd, self.x);
        let zero = Total::zero(simd);
        let (mut potential, mut field, mut outer) = (zero, [zero; 3], [zero; 6]);
        let mut trace = zero;
        let [x, y, z] = &self.layer.points;
        let points = Lanes::blocks(simd, x).zip(Lanes::blocks(simd, y)).zip(Lanes::blocks(simd, z));
        for (((x, y), z), weight) in points.zip(Lanes::blocks(simd, &self.layer.weights)) {
            let d = [x - position[0], y - position[1], z - position[2]];
            let inverse_square = x.constant(1.0) / dot(d, d);
            let attraction = weight * inverse_square.sqrt();
            potential.add(attraction);
            let cube = attraction * inverse_square;
            trace.add(cube);
            let fifth = cube * inverse_square;
            for i in 0..3 {
                field[i].add_product(cube, d[i]);
            }
            let w = [fifth * d[0], fifth * d[1], fifth * d[2]];
            for (k, (i, j)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
                outer[k].add_product(w[i], d[j]);
            }
        }
        let [xx, xy, xz, yy, yz, zz] = outer.map(|total| 3.0 * total.value());
        let gradient =
            Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) - Mat3::from_diagonal_element(trace.value());
        (potential.value(), total_vector(field), gradient)
    }
}
