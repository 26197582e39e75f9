//! How the pull of one body on a distant point differs from that of a point mass.

use super::{FarCut, FarSeries, FieldKernel, Near, PointField};
use crate::math::Vec3;
use crate::math::lanes::Lanes;
use crate::shape::{Ellipsoid, Shape};
use pulp::Scalar;

/// Relative size of what the series leaves out.
const TOLERANCE: f64 = 1e-17;

/// The body's field less that of its mass at its centre, and its moment about the centre. Neither loses digits at any distance.
#[derive(Debug, Clone)]
pub struct ExtendedPull {
    ellipsoid: Ellipsoid,
    series: FarSeries,
    /// The binary exponent of the last distance, and how much of the series it needs.
    known: Option<(i32, Option<FarCut>)>,
}

impl ExtendedPull {
    /// Of a shape; none of a point, and none of a sphere, whose field is that of a point.
    pub fn new(shape: &Shape) -> Option<Self> {
        let Shape::Ellipsoid(ellipsoid) = shape else { return None };
        let [a, _, c] = ellipsoid.sorted();
        (a > c).then(|| Self { ellipsoid: *ellipsoid, series: FarSeries::new(shape), known: None })
    }

    /// At a point `x` of the body frame, per unit GM: g + x / |x|^3, and x cross g. `None` inside the body.
    pub fn at(&mut self, x: &Vec3) -> Option<(Vec3, Vec3)> {
        let canonical = self.ellipsoid.canonical();
        let x = canonical * x;
        let [a, b, c] = self.ellipsoid.sorted();
        let square = x.norm_squared();
        if square < a * a && (x.x / a).powi(2) + (x.y / b).powi(2) + (x.z / c).powi(2) < 1.0 {
            return None;
        }
        let lanes = [x.x, x.y, x.z].map(|value| Lanes::splat(Scalar, value));
        let (excess, field) = match self.cut(square - a * a) {
            Some(cut) => {
                let far = self.series.cut(cut);
                (far.excess_field(lanes).map(Lanes::first), far.field(lanes))
            }
            None => {
                let field = Near::new(&self.ellipsoid, 0.0).field(lanes);
                let point = 1.0 / (square * square.sqrt());
                (field.rd.map(|rd| rd.first() - point), field)
            }
        };
        let PointField { rd_difference, .. } = field;
        let [first, second, third] = rd_difference.map(Lanes::first);
        let moment = -Vec3::new(x.y * x.z * first, x.z * x.x * second, x.x * x.y * third);
        let back = canonical.transpose();
        Some((back * -x.component_mul(&Vec3::from(excess)), back * moment))
    }

    /// How much of the series a distance needs, where kappa >= `kappa_min`. It depends on the binary exponent alone, so that
    /// results do not depend on what was asked before.
    fn cut(&mut self, kappa_min: f64) -> Option<FarCut> {
        let exponent = if kappa_min > 0.0 { kappa_min.log2().floor() as i32 } else { i32::MIN };
        match self.known {
            Some((known, cut)) if known == exponent => cut,
            _ => {
                let floor = if exponent == i32::MIN { 0.0 } else { 2.0_f64.powi(exponent) };
                let cut = self.series.cut_for(floor, TOLERANCE);
                self.known = Some((exponent, cut));
                cut
            }
        }
    }
}
