//! The exact potential and field of one homogeneous body, at many points at a time: of an ellipsoid outside
//! it, and of a polyhedron anywhere (`Facets`, and `Layer` far away).
//!
//! Takes points in the body's canonical frame (a >= b >= c) and gives, per unit GM, the potential Phi
//! (positive) and the field g = grad Phi. With kappa the largest root of sum x_i^2/(a_i^2 + kappa) = 1 (the
//! paper's `eq:kappa_eq`), s_i = a_i^2 + kappa and R_i = R_D(s_j, s_k; s_i),
//!
//! Phi = 1/2 sum_i (s_i - x_i^2) R_i,    g_i = -x_i R_i,
//!
//! which are the numbers of MacMillan's formulas (the paper's `eq:Potential_elliptic`, `eq:Oblate_spheroid`
//! and its appendix) without their 0/0 when axes are equal. The identity 3 R_F = sum_i s_i R_i has been used,
//! so that Phi is a sum of positive terms.
//!
//! Potential and field are computed in two ways: by `Far`, a power series in 1/(kappa + mean a^2) whose
//! coefficients belong to the body, and by `Near`, Newton's iteration for kappa and Carlson's duplication,
//! right down to the surface.

mod polyhedron_gravity;
mod block;
mod body_field;
mod ellipsoidal;
mod far;
mod harmonic_field;
mod layer;
mod layer_attraction;
mod points;
mod near;
mod polyhedral;
mod attraction;

pub(crate) use attraction::point_jacobian;
#[doc(hidden)]
pub use attraction::{BodyAttraction, BodyChange, ExtendedAttraction};
pub use body_field::{Attractor, BodyField};
#[doc(hidden)]
pub use ellipsoidal::{Ellipsoidal, Gravity};
#[doc(hidden)]
pub use far::{Far, FarSeries, FarTruncation};
#[doc(hidden)]
pub use harmonic_field::HarmonicField;
#[doc(hidden)]
pub use layer::Layer;
#[doc(hidden)]
pub use layer_attraction::LayerAttraction;
#[doc(hidden)]
pub use near::{Near, kappa};
pub use points::{GravityOutput, Points};
#[doc(hidden)]
pub use polyhedral::{Facets, PolyhedralField};
#[doc(hidden)]
pub use polyhedron_gravity::PolyhedronGravity;

use crate::math::lanes::{INTERLEAVED, Lanes, dot};
use pulp::Simd;

/// The field at one point.
#[derive(Clone, Copy)]
#[doc(hidden)]
pub struct PointField<S: Simd, const N: usize = INTERLEAVED> {
    /// R_D(s_j, s_k; s_i) for i = 1, 2, 3: the field is g_i = -x_i R_i.
    pub rd: [Lanes<S, N>; 3],
    /// `[R_3 - R_2, R_1 - R_3, R_2 - R_1]`, by `Far` without cancellation: (x cross g)_1 = -x_2 x_3 (R_3 -
    /// R_2).
    pub rd_difference: [Lanes<S, N>; 3],
    /// The squares s_i = a_i^2 + kappa.
    pub squares: [Lanes<S, N>; 3],
}

impl<S: Simd, const N: usize> PointField<S, N> {
    /// Returns the factors n and f of the gradient at a point outside, dg_i/dx_j = f n_i n_j - R_i delta_ij.
    /// With S = sum x_k^2/s_k^2 they are n_i = x_i/s_i, normal to the confocal ellipsoid through the point,
    /// and f = 3/(sqrt(s_1 s_2 s_3) S).
    #[inline(always)]
    pub fn gradient_factors(&self, x: [Lanes<S, N>; 3]) -> ([Lanes<S, N>; 3], Lanes<S, N>) {
        let [s1, s2, s3] = self.squares;
        let ([i1, i2, i3], inverse) = self.reciprocals();
        let n = [x[0] * i1, x[1] * i2, x[2] * i3];
        (n, s1.constant(3.0) * inverse * (s1 * s2 * s3).sqrt() / dot(n, n))
    }

    /// Returns 1/s_i and 1/(s_1 s_2 s_3), for which one division suffices.
    #[inline(always)]
    pub fn reciprocals(&self) -> ([Lanes<S, N>; 3], Lanes<S, N>) {
        let [s1, s2, s3] = self.squares;
        let product = s1 * s2;
        let all = s1.constant(1.0) / (product * s3);
        let last = all * s3;
        ([last * s2, last * s1, all * product], all)
    }

    /// Returns dg/dx at a point outside: xx, xy, xz, yy, yz, zz.
    #[inline(always)]
    pub fn gradient(&self, x: [Lanes<S, N>; 3]) -> [Lanes<S, N>; 6] {
        let (n, f) = self.gradient_factors(x);
        gradient_from_factors(n, f, self.rd)
    }
}

impl<S: Simd, const N: usize> PointField<S, N> {
    /// Returns the rows of the torque gradient, the derivative of -x cross g, with n and f from
    /// [`Self::gradient_factors`] and the differences from [`FieldKernel::square_differences`]. With Q_i the
    /// differences of the R_i, -(x cross g)_1 = x_2 x_3 Q_1 and dQ_1/dx_j = f (a_3^2 - a_2^2) n_j / (s_2
    /// s_3), free of cancellation at any distance.
    #[inline(always)]
    pub fn torque_gradient(
        &self,
        x: [Lanes<S, N>; 3],
        (n, f): ([Lanes<S, N>; 3], Lanes<S, N>),
        differences: [f64; 3],
    ) -> [[Lanes<S, N>; 3]; 3] {
        let mut rows = [x; 3];
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let common = f * n[j] * n[k] * f.constant(differences[i]);
            rows[i] = [common * n[0], common * n[1], common * n[2]];
            rows[i][j] = rows[i][j] + x[k] * self.rd_difference[i];
            rows[i][k] = rows[i][k] + x[j] * self.rd_difference[i];
        }
        rows
    }

    /// Returns the derivatives of the potential with respect to the semi-axes at a point outside, dPhi/da_i
    /// over a_i, with the R_ij of [`FieldKernel::second_integrals`]: 3/2 x_i^2 R_ii - 1/2 R_i + 1/2 sum of
    /// x_k^2 R_ik, where 3 R_ii = 3/(sqrt(s_1 s_2 s_3) s_i) - sum of R_ik, and k is each axis other than i.
    #[inline(always)]
    pub fn potential_by_axes(
        &self,
        x: [Lanes<S, N>; 3],
        second_integrals: [Lanes<S, N>; 3],
    ) -> [Lanes<S, N>; 3] {
        let [s1, s2, s3] = self.squares;
        let (inverse, all) = self.reciprocals();
        let last = s1.constant(3.0) * all * (s1 * s2 * s3).sqrt();
        let squares = [x[0] * x[0], x[1] * x[1], x[2] * x[2]];
        let half = s1.constant(0.5);
        let mut out = x;
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let diagonal_part = last * inverse[i] - second_integrals[j] - second_integrals[k];
            let others = squares[j].mul_add(second_integrals[k], squares[k] * second_integrals[j]);
            out[i] = half * (squares[i].mul_add(diagonal_part, others) - self.rd[i]);
        }
        out
    }

    /// Returns the derivatives of the field with respect to the semi-axes at a point outside, dg_j/da_i over
    /// a_i in row i, with n and f from [`Self::gradient_factors`] and the R_ij of
    /// [`FieldKernel::second_integrals`]: x_j R_ij - f n_i^2 n_j for i other than j, and x_i (3/(sqrt(s_1 s_2
    /// s_3) s_i) - sum of R_ij) - f n_i^3.
    #[inline(always)]
    pub fn semi_axis_derivatives(
        &self,
        x: [Lanes<S, N>; 3],
        (n, f): ([Lanes<S, N>; 3], Lanes<S, N>),
        second_integrals: [Lanes<S, N>; 3],
    ) -> [[Lanes<S, N>; 3]; 3] {
        let (inverse, _) = self.reciprocals();
        // This is 3 / sqrt(s_1 s_2 s_3) = f S.
        let last = f * (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        let mut rows = [x; 3];
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let falling = f * n[i] * n[i];
            rows[i][i] =
                x[i] * (last * inverse[i] - second_integrals[j] - second_integrals[k]) - falling * n[i];
            rows[i][j] = x[j] * second_integrals[k] - falling * n[j];
            rows[i][k] = x[k] * second_integrals[j] - falling * n[k];
        }
        rows
    }
}

/// Returns f n_i n_j - R_i delta_ij: xx, xy, xz, yy, yz, zz.
#[inline(always)]
fn gradient_from_factors<S: Simd, const N: usize>(
    n: [Lanes<S, N>; 3],
    f: Lanes<S, N>,
    rd: [Lanes<S, N>; 3],
) -> [Lanes<S, N>; 6] {
    let m = [f * n[0], f * n[1], f * n[2]];
    [m[0] * n[0] - rd[0], m[0] * n[1], m[0] * n[2], m[1] * n[1] - rd[1], m[1] * n[2], m[2] * n[2] - rd[2]]
}

/// Potential and field of a body of unit GM at as many points as the machine has lanes.
#[doc(hidden)]
pub trait FieldKernel: Copy {
    /// Returns the field at points of the canonical frame.
    fn field<S: Simd, const N: usize>(&self, x: [Lanes<S, N>; 3]) -> PointField<S, N>;

    /// Returns the field, and `[R_23, R_31, R_12]` with (a_i^2 - a_j^2) R_ij = R_j - R_i, for equal axes too:
    /// the integrals (3/2) int dt / (sqrt((t+a_1^2)(t+a_2^2)(t+a_3^2)) (t+a_i^2)(t+a_j^2)) from kappa to
    /// infinity.
    fn second_integrals<S: Simd, const N: usize>(
        &self,
        x: [Lanes<S, N>; 3],
    ) -> (PointField<S, N>, [Lanes<S, N>; 3]);

    /// Returns `[a_3^2 - a_2^2, a_1^2 - a_3^2, a_2^2 - a_1^2]`, exact for nearly equal axes.
    fn square_differences(&self) -> [f64; 3];

    /// Returns Phi - 1/r and the field.
    fn potential_perturbation<S: Simd, const N: usize>(
        &self,
        x: [Lanes<S, N>; 3],
    ) -> (Lanes<S, N>, PointField<S, N>);

    /// Returns Phi.
    #[inline(always)]
    fn potential<S: Simd, const N: usize>(&self, x: [Lanes<S, N>; 3]) -> Lanes<S, N> {
        x[0].constant(1.0) / dot(x, x).sqrt() + self.potential_perturbation(x).0
    }
}
