//! How the pull of one body on a distant point differs from that of a point mass.

use super::{FarCut, FarSeries, FieldKernel, Near};
use crate::math::Vec3;
use crate::math::lanes::Lanes;
use crate::math::rotation::{turned, turned_back};
use crate::shape::{Ellipsoid, Shape};
use pulp::Scalar;

/// Size of what the series leaves out, relative to the field of a point.
const TOLERANCE: f64 = 1e-17;

/// Size of what is beyond the quadrupole, relative to it, where it is left out.
const BEYOND_QUADRUPOLE: f64 = 1e-16;

/// The body's field less that of its mass at its centre, and its moment about the centre. Neither loses digits at any distance.
#[derive(Debug, Clone)]
pub struct ExtendedPull {
    ellipsoid: Ellipsoid,
    /// (a_i^2 less their mean) / 5, along the body's axes: the quadrupole per unit mass.
    quadrupole: Vec3,
    /// The largest 1/|x|^2 at which the quadrupole is enough.
    quadrupole_to: f64,
    series: FarSeries,
    /// A bound below kappa at the last nearer point, and how much of the series it needs.
    known: Option<(f64, Option<FarCut>)>,
}

impl ExtendedPull {
    /// Of a shape; none of a point, and none of a sphere, whose field is that of a point.
    pub fn new(shape: &Shape) -> Option<Self> {
        let Shape::Ellipsoid(ellipsoid) = shape else { return None };
        let [a, b, c] = ellipsoid.semi_axes();
        // Differences of squares as products: exact for nearly equal axes.
        let (ab, bc, ca) = ((a - b) * (a + b), (b - c) * (b + c), (c - a) * (c + a));
        let quadrupole = Vec3::new(ab - ca, bc - ab, ca - bc) / 15.0;
        // The next moment is smaller by the deviation of the squares over |x|^2.
        let quadrupole_to = BEYOND_QUADRUPOLE / (5.0 * quadrupole.amax());
        let series = FarSeries::new(shape);
        (quadrupole.amax() > 0.0).then_some(Self {
            ellipsoid: *ellipsoid,
            quadrupole,
            quadrupole_to,
            series,
            known: None,
        })
    }

    /// At a point `x` of the body frame with the given 1/|x|^2 and 1/|x|^3, per unit GM: g + x/|x|^3, and x cross g. `None` inside
    /// the body.
    #[inline]
    pub fn at(&mut self, x: &Vec3, inverse_square: f64, inverse_cube: f64) -> Option<(Vec3, Vec3)> {
        if inverse_square < self.quadrupole_to {
            // grad of 3/2 x.Dx / |x|^5.
            let fifth = 3.0 * inverse_cube * inverse_square;
            let dx = self.quadrupole.component_mul(x);
            let excess = dx - x * (2.5 * x.dot(&dx) * inverse_square);
            return Some((excess * fifth, x.cross(&dx) * fifth));
        }
        self.near(x, inverse_cube)
    }

    fn near(&mut self, x: &Vec3, inverse_cube: f64) -> Option<(Vec3, Vec3)> {
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
            None => (Near::new(&self.ellipsoid, 0.0).field(lanes), inverse_cube),
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
