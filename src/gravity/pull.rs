//! How the pull of one body on a distant point differs from that of a point mass.

use super::{FarCut, FarSeries, FieldKernel, Near};
use crate::math::Vec3;
use crate::math::lanes::Lanes;
use crate::math::rotation::{turned, turned_back};
use crate::shape::{Ellipsoid, Shape};
use pulp::Scalar;

/// Relative size of what the series leaves out.
const TOLERANCE: f64 = 1e-17;

/// The body's field less that of its mass at its centre, and its moment about the centre. Neither loses digits at any distance.
#[derive(Debug, Clone)]
pub struct ExtendedPull {
    ellipsoid: Ellipsoid,
    series: FarSeries,
    /// A bound below kappa at the last point, and how much of the series it needs.
    known: Option<(f64, Option<FarCut>)>,
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
        let x = turned(&canonical, x);
        let [a, b, c] = self.ellipsoid.sorted();
        let square = x.norm_squared();
        if square < a * a && (x.x / a).powi(2) + (x.y / b).powi(2) + (x.z / c).powi(2) < 1.0 {
            return None;
        }
        let lanes = [x.x, x.y, x.z].map(|value| Lanes::splat(Scalar, value));
        let (field, point) = match self.cut(square - a * a) {
            Some(cut) => (self.series.cut(cut).excess_field(lanes), 0.0),
            None => (Near::new(&self.ellipsoid, 0.0).field(lanes), 1.0 / (square * square.sqrt())),
        };
        let excess = field.rd.map(|rd| rd.first() - point);
        let [first, second, third] = field.rd_difference.map(Lanes::first);
        let moment = -Vec3::new(x.y * x.z * first, x.z * x.x * second, x.x * x.y * third);
        let force = -x.component_mul(&Vec3::from(excess));
        Some((turned_back(&canonical, &force), turned_back(&canonical, &moment)))
    }

    /// How much of the series a distance needs, where kappa >= `kappa_min`. It depends on the binary exponent alone, so that
    /// results do not depend on what was asked before.
    fn cut(&mut self, kappa_min: f64) -> Option<FarCut> {
        // The double with the same exponent and no fraction: a power of two.
        let floor = f64::from_bits(kappa_min.max(0.0).to_bits() >> 52 << 52);
        match self.known {
            Some((known, cut)) if known == floor => cut,
            _ => {
                let cut = self.series.cut_for(floor, TOLERANCE);
                self.known = Some((floor, cut));
                cut
            }
        }
    }
}
