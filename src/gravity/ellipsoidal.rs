//! The gravity of a homogeneous ellipsoid, sphere or point at many points anywhere: outside, on the surface
//! and inside.
//!
//! Inside, kappa is zero: Phi = GM/2 sum_i (a_i^2 - x_i^2) R_i and g_i = -GM x_i R_i with constant R_i, and
//! the gradient is -GM diag(R_i), whose trace is -4 pi G rho. For the outside see
//! [`super::PointField::gradient_factors`].

use super::{FarSeries, FarTruncation, Near, gradient_from_factors};
use crate::math::Mat3;
use crate::math::lanes::{Lanes, dot};
use crate::shape::{Ellipsoid, Shape};
use pulp::Simd;

/// Phi (positive), g = grad Phi and dg/dx at points.
#[derive(Clone, Copy)]
pub struct Gravity<S: Simd> {
    /// The potential Phi.
    pub potential: Lanes<S>,
    /// The field g.
    pub field: [Lanes<S>; 3],
    /// The gradient dg/dx: xx, xy, xz, yy, yz, zz.
    pub gradient: [Lanes<S>; 6],
}

impl<S: Simd> Gravity<S> {
    /// Replaces the result by another one in the lanes in which the square of the distance is at least a
    /// bound.
    #[inline(always)]
    fn replaced(mut self, square: Lanes<S>, from: Lanes<S>, other: Self) -> Self {
        self.potential = square.if_less(from, self.potential, other.potential);
        for i in 0..3 {
            self.field[i] = square.if_less(from, self.field[i], other.field[i]);
        }
        for k in 0..6 {
            self.gradient[k] = square.if_less(from, self.gradient[k], other.gradient[k]);
        }
        self
    }
}

/// The gravity of a shape with a mass, evaluated at points of the frame of its sorted axes, a >= b >= c.
#[derive(Debug, Clone)]
pub struct Ellipsoidal {
    /// One over the unit of length, a power of two; all other numbers are in this unit.
    inverse_unit: f64,
    /// GM divided by the first three powers of the unit.
    scales: [f64; 3],
    /// The product GM.
    gm: f64,
    /// Whether the field outside is that of a point.
    central: bool,
    series: FarSeries,
    /// The forms of the field from the nearest on, each with the least square of the distance at which it is
    /// used.
    pub(super) forms: Vec<(f64, FieldForm)>,
}

/// The form in which the field is evaluated.
#[derive(Debug, Clone, Copy)]
pub enum FieldForm {
    /// Carlson's integrals.
    Near(Near),
    /// The far series.
    Far(FarTruncation),
    /// The field of a point, with numbers that stay in range at any distance.
    Point,
}

/// The square of the distance from which on only the field of a point is left, and sixth powers leave the
/// range of doubles.
const POINT_FROM: f64 = 1e100;

/// The largest truncation error of the series.
const TOLERANCE: f64 = 1e-17;

/// The values of kappa, in squares of the longest semi-axis, beyond which Carlson's integrals take fewer
/// steps.
const NEAR: [f64; 1] = [0.5];

/// The numbers of terms of the series, each of which is used beyond some distance. There are few of them,
/// since points of different forms share no registers and terms cost little. Nine terms are the most for
/// which one Newton step suffices.
const TERMS: [u32; 3] = [27, 9, 3];

/// The largest number of forms that a shape can have.
pub(super) const MOST_FORMS: usize = 1 + NEAR.len() + TERMS.len() + 1;

impl Ellipsoidal {
    /// Prepares the gravity of an ellipsoid, a sphere or a point; any other shape counts as a point.
    pub fn new(shape: &Shape, gm: f64) -> Self {
        let unit = shape.natural_unit();
        let shape = shape.scaled(1.0 / unit);
        let series = FarSeries::new(&shape);
        let forms = match &shape {
            Shape::Ellipsoid(ellipsoid) => forms(ellipsoid, &series),
            _ => vec![(0.0, FieldForm::Point)],
        };
        let scales = [gm / unit, gm / unit / unit, gm / unit / unit / unit];
        let central = match &shape {
            Shape::Ellipsoid(ellipsoid) => ellipsoid.sorted()[0] == ellipsoid.sorted()[2],
            _ => true,
        };
        Self { inverse_unit: 1.0 / unit, scales, gm, central, series, forms }
    }

    /// Returns the gravity at points of the frame of the sorted axes. Each lane uses the form that its own
    /// distance needs, so that its result does not depend on the other lanes. Results that are not used cost
    /// nothing. For a point mass the points must be away from it.
    #[inline(always)]
    pub fn at<S: Simd>(&self, x: [Lanes<S>; 3]) -> Gravity<S> {
        let x = self.in_unit(x);
        let square = dot(x, x);
        let [nearest, farthest] = [square.reduce_min(), square.reduce_max()];
        let zero = square.constant(0.0);
        let mut gravity = Gravity { potential: zero, field: [zero; 3], gradient: [zero; 6] };
        for (index, &(from, form)) in self.forms.iter().enumerate() {
            let to = self.forms.get(index + 1).map_or(f64::INFINITY, |next| next.0);
            // The first form takes the lanes whose distance is not a number.
            if to <= nearest || (index > 0 && from > farthest) {
                continue;
            }
            gravity = gravity.replaced(square, square.constant(from), self.evaluate(form, x));
        }
        gravity
    }

    /// Returns whether this is the gravity of a point.
    pub fn is_point(&self) -> bool {
        matches!(self.forms[0].1, FieldForm::Point)
    }

    /// Returns whether the field outside is that of a point.
    #[inline(always)]
    pub fn is_central(&self) -> bool {
        self.central
    }

    /// Returns the field of a point with this mass, -GM x / |x|^3, at points for which the sixth power of the
    /// distance is within the range of doubles.
    #[inline(always)]
    pub fn central_field<S: Simd>(&self, x: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
        let square = dot(x, x);
        let strength = x[0].constant(-self.gm) / (square * square.sqrt());
        [strength * x[0], strength * x[1], strength * x[2]]
    }

    /// Returns the index of the form that a point at a distance needs.
    #[inline(always)]
    pub(super) fn form_index<S: Simd>(&self, distance_square: Lanes<S>) -> Lanes<S> {
        let c = |value| distance_square.constant(value);
        let mut form_index = c(0.0);
        for &(from, _) in &self.forms[1..] {
            form_index = form_index + distance_square.if_less(c(from), c(0.0), c(1.0));
        }
        form_index
    }

    #[inline(always)]
    pub(super) fn in_unit<S: Simd>(&self, x: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
        let unit = x[0].constant(self.inverse_unit);
        [x[0] * unit, x[1] * unit, x[2] * unit]
    }

    /// Evaluates one form at points in the unit of length.
    #[inline(always)]
    pub(super) fn evaluate<S: Simd>(&self, form: FieldForm, x: [Lanes<S>; 3]) -> Gravity<S> {
        let (potential, field, outside) = match form {
            FieldForm::Near(near) => near.anywhere(x),
            FieldForm::Far(truncation) => {
                let (potential, field) = self.series.truncated(truncation).potential_and_field(x);
                (potential, field, x[0].constant(1.0))
            }
            FieldForm::Point => return self.point(x),
        };
        let zero = x[0].constant(0.0);
        let (n, factor) = field.gradient_factors(x);
        // In the centre there is no normal.
        let factor = zero.if_less(outside, factor, zero);
        let rd = field.rd;
        let [potential_scale, field_scale, gradient_scale] =
            [self.scales[0], -self.scales[1], self.scales[2]];
        let (potential_scale, field_scale, gradient_scale) =
            (x[0].constant(potential_scale), x[0].constant(field_scale), x[0].constant(gradient_scale));
        Gravity {
            potential: potential_scale * potential,
            field: [field_scale * rd[0] * x[0], field_scale * rd[1] * x[1], field_scale * rd[2] * x[2]],
            gradient: gradient_from_factors(
                n,
                gradient_scale * factor,
                [gradient_scale * rd[0], gradient_scale * rd[1], gradient_scale * rd[2]],
            ),
        }
    }

    #[inline(always)]
    fn point<S: Simd>(&self, x: [Lanes<S>; 3]) -> Gravity<S> {
        let c = |value| x[0].constant(value);
        let largest = x[0].abs().max(x[1].abs()).max(x[2].abs());
        let shrink = c(1.0) / largest;
        let u = [x[0] * shrink, x[1] * shrink, x[2] * shrink];
        let inverse = c(1.0) / dot(u, u).sqrt();
        let u = [u[0] * inverse, u[1] * inverse, u[2] * inverse];
        let near = shrink * inverse;
        let potential = c(self.scales[0]) * near;
        let attraction = c(-self.scales[1]) * near * near;
        let tide = c(self.scales[2]) * near * near * near;
        Gravity {
            potential,
            field: [attraction * u[0], attraction * u[1], attraction * u[2]],
            gradient: gradient_from_factors(u, c(3.0) * tide, [tide; 3]),
        }
    }
}

fn forms(ellipsoid: &Ellipsoid, series: &FarSeries) -> Vec<(f64, FieldForm)> {
    let longest = ellipsoid.sorted()[0].powi(2);
    let mut forms: Vec<(f64, FieldForm)> = vec![(0.0, FieldForm::Near(Near::new(ellipsoid, 0.0)))];
    for share in NEAR {
        let kappa = share * longest;
        let near = Near::new(ellipsoid, kappa);
        if !matches!(forms.last(), Some((_, FieldForm::Near(last))) if *last == near) {
            forms.push((longest + kappa, FieldForm::Near(near)));
        }
    }
    for terms in TERMS {
        let kappa = series.kappa_from(terms, TOLERANCE).max(0.0);
        if let Some(truncation) = series.truncation_for(kappa, TOLERANCE)
            && !matches!(forms.last(), Some((_, FieldForm::Far(last))) if *last == truncation)
        {
            // Where the series is valid, Carlson's integrals are not needed.
            forms.retain(|(from, _)| *from < longest + kappa);
            forms.push((longest + kappa, FieldForm::Far(truncation)));
        }
    }
    forms.push((POINT_FROM, FieldForm::Point));
    forms
}

impl<S: Simd> Gravity<S> {
    /// Rotates field and gradient by the transposed matrix.
    #[inline(always)]
    pub fn rotate_back(self, m: &Mat3) -> Self {
        let g = self.gradient;
        let c = |value| self.potential.constant(value);
        // The gradient is multiplied by the matrix, and the transposed matrix by the result.
        let rows = [[g[0], g[1], g[2]], [g[1], g[3], g[4]], [g[2], g[4], g[5]]];
        let mut right = rows;
        for i in 0..3 {
            right[i] = rotate_back(rows[i], m);
        }
        let mut out = [c(0.0); 6];
        for (k, (i, j)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
            out[k] = dot([c(m[(0, i)]), c(m[(1, i)]), c(m[(2, i)])], [right[0][j], right[1][j], right[2][j]]);
        }
        Self { potential: self.potential, field: rotate_back(self.field, m), gradient: out }
    }
}

/// Returns the matrix times a vector.
#[inline(always)]
pub fn rotate<S: Simd>(v: [Lanes<S>; 3], m: &Mat3) -> [Lanes<S>; 3] {
    rotate_back(v, &m.transpose())
}

/// Returns the transposed matrix times a vector.
#[inline(always)]
pub fn rotate_back<S: Simd>(v: [Lanes<S>; 3], m: &Mat3) -> [Lanes<S>; 3] {
    let mut out = v;
    for i in 0..3 {
        let c = |k: usize| v[0].constant(m[(k, i)]);
        out[i] = v[0].mul_add(c(0), v[1].mul_add(c(1), v[2] * c(2)));
    }
    out
}
