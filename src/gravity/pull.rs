//! How the pull of one body on a distant point differs from that of a point mass.

use super::{FarCut, FarSeries, FieldKernel, LayerPull, Near};
use crate::error::Result;
use crate::math::lanes::Lanes;
use crate::math::matrix::{cross_times, times, transposed_times};
use crate::math::rotation::{turned, turned_back};
use crate::math::{Mat3, Vec3};
use crate::patience::Patience;
use crate::shape::{Body, Ellipsoid, Place, Shape};
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
        Self::of_ellipsoid(shape).filter(|pull| pull.quadrupole.amax() > 0.0)
    }

    /// Of an ellipsoid, also one with equal axes; none of another shape.
    pub fn of_ellipsoid(shape: &Shape) -> Option<Self> {
        let Shape::Ellipsoid(ellipsoid) = shape else { return None };
        let [a, b, c] = ellipsoid.semi_axes();
        // Differences of squares as products: exact for nearly equal axes.
        let (ab, bc, ca) = ((a - b) * (a + b), (b - c) * (b + c), (c - a) * (c + a));
        let quadrupole = Vec3::new(ab - ca, bc - ab, ca - bc) / 15.0;
        // The next moment is smaller by the deviation of the squares over |x|^2.
        let quadrupole_to = BEYOND_QUADRUPOLE / (5.0 * quadrupole.amax());
        let series = FarSeries::new(shape);
        Some(Self { ellipsoid: *ellipsoid, quadrupole, quadrupole_to, series, known: None })
    }

    /// At a point `x` of the body frame with the given 1/|x|^2 and 1/|x|^3, for a strength in place of GM: g + x/|x|^3, and x cross g.
    /// `None` inside the body.
    #[inline(always)]
    pub fn at(
        &mut self,
        x: &Vec3,
        inverse_square: f64,
        inverse_cube: f64,
        strength: f64,
    ) -> Option<(Vec3, Vec3)> {
        if inverse_square < self.quadrupole_to {
            // grad of 3/2 x.Dx / |x|^5, with the factors that are known first side by side.
            let fifth = 3.0 * strength * inverse_cube * inverse_square;
            let dx = self.quadrupole.component_mul(x);
            let bend = x.dot(&dx) * (2.5 * inverse_square * fifth);
            return Some((dx * fifth - x * bend, x.cross(&dx) * fifth));
        }
        let (excess, moment) = self.near(x, inverse_cube)?;
        Some((excess * strength, moment * strength))
    }

    #[cold]
    fn near(&mut self, x: &Vec3, inverse_cube: f64) -> Option<(Vec3, Vec3)> {
        let canonical = self.ellipsoid.canonical();
        let x = turned(&canonical, x);
        let [a, b, c] = self.ellipsoid.sorted();
        let square = x.norm_squared();
        if square < a * a && (x.x / a).powi(2) + (x.y / b).powi(2) + (x.z / c).powi(2) < 1.0 {
            return None;
        }
        let lanes: [Lanes<Scalar>; 3] = [x.x, x.y, x.z].map(|value| Lanes::splat(Scalar, value));
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

    /// At a point `x` of the body frame outside: dg/dx, and the derivative of -x cross g, per unit GM.
    pub fn slopes(&mut self, x: &Vec3) -> (Mat3, Mat3) {
        let canonical = self.ellipsoid.canonical();
        let x = turned(&canonical, x);
        let [a, ..] = self.ellipsoid.sorted();
        let lanes = [x.x, x.y, x.z].map(|value| Lanes::splat(Scalar, value));
        let (gradient, turning) = match self.cut(x.norm_squared() - a * a) {
            Some(cut) => slopes_at(self.series.cut(cut), lanes),
            None => slopes_at(Near::new(&self.ellipsoid, 0.0), lanes),
        };
        let back = |slope: Mat3| times(&transposed_times(&canonical, &slope), &canonical);
        (back(gradient), back(turning))
    }

    /// At a point `x` of the body frame outside: the derivatives of g by the semi-axes, per unit GM.
    pub fn by_axes(&mut self, x: &Vec3) -> [Vec3; 3] {
        let canonical = self.ellipsoid.canonical();
        let x = turned(&canonical, x);
        let [a, b, c] = self.ellipsoid.sorted();
        let lanes = [x.x, x.y, x.z].map(|value| Lanes::splat(Scalar, value));
        let rows = match self.cut(x.norm_squared() - a * a) {
            Some(cut) => by_axes_at(self.series.cut(cut), lanes),
            None => by_axes_at(Near::new(&self.ellipsoid, 0.0), lanes),
        };
        let by = transposed_times(&canonical, &(Mat3::from_diagonal(&Vec3::new(a, b, c)) * rows));
        let by = times(&by, &canonical);
        [0, 1, 2].map(|axis| by.row(axis).transpose())
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

fn slopes_at(kernel: impl FieldKernel, x: [Lanes<Scalar>; 3]) -> (Mat3, Mat3) {
    let field = kernel.field(x);
    let [xx, xy, xz, yy, yz, zz] = field.gradient(x).map(Lanes::first);
    let turning =
        field.turning(x, field.bend(x), kernel.square_differences()).map(|row| row.map(Lanes::first));
    (Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz), Mat3::from(turning).transpose())
}

/// Over each semi-axis, a row of them.
fn by_axes_at(kernel: impl FieldKernel, x: [Lanes<Scalar>; 3]) -> Mat3 {
    let (field, second) = kernel.second(x);
    let rows = field.by_axes(x, field.bend(x), second).map(|row| row.map(Lanes::first));
    Mat3::from(rows).transpose()
}

/// The slopes of the field of a point, which turns nothing.
pub(crate) fn slopes_of_point(x: &Vec3) -> (Mat3, Mat3) {
    let r = x.norm();
    let u = x / r;
    ((3.0 * u * u.transpose() - Mat3::identity()) / r / r / r, Mat3::zeros())
}

/// The same of a body: of an ordinary one that of its shape, of a composite or a polyhedron the sum over its parts.
#[derive(Debug, Clone)]
pub enum BodyPull {
    /// Of one shape, in the body's own frame.
    Ordinary(Box<ExtendedPull>),
    /// Of several parts, or of a polyhedron.
    Composite(Vec<PartPull>),
}

/// A part's share in the pull of its body.
#[derive(Debug, Clone)]
pub struct PartPull {
    /// Of the body's mass.
    share: f64,
    place: Place,
    radius: f64,
    extended: Option<Extended>,
}

/// The pull of a part that is no point.
#[derive(Debug, Clone)]
enum Extended {
    Ellipsoid(Box<ExtendedPull>),
    Polyhedron(Box<LayerPull>),
}

impl Extended {
    fn new(shape: &Shape) -> Option<Self> {
        match shape {
            Shape::Polyhedron(polyhedron) => Some(Self::Polyhedron(Box::new(LayerPull::new(polyhedron)))),
            _ => ExtendedPull::new(shape).map(|pull| Self::Ellipsoid(Box::new(pull))),
        }
    }

    fn at(&mut self, x: &Vec3, inverse_square: f64, inverse_cube: f64) -> Option<(Vec3, Vec3)> {
        match self {
            Self::Ellipsoid(pull) => pull.at(x, inverse_square, inverse_cube, 1.0),
            Self::Polyhedron(pull) => pull.at(x, inverse_square, inverse_cube),
        }
    }

    fn slopes(&mut self, x: &Vec3) -> Option<(Mat3, Mat3)> {
        match self {
            Self::Ellipsoid(pull) => Some(pull.slopes(x)),
            Self::Polyhedron(_) => None,
        }
    }
}

impl BodyPull {
    /// Computes the moments of polyhedra that [`Self::new`] takes, which are kept with the shapes.
    pub fn moments(body: &Body, patience: &mut Patience) -> Result<()> {
        let mut parts = body.parts().iter();
        parts.try_for_each(|part| match &part.shape {
            Shape::Polyhedron(polyhedron) => LayerPull::moments(polyhedron, patience),
            _ => Ok(()),
        })
    }

    /// Of a body; none of one whose field is that of a point.
    pub fn new(body: &Body) -> Option<Self> {
        if let [part] = body.parts()
            && part.place.is_none()
            && !matches!(part.shape, Shape::Polyhedron(_))
        {
            return ExtendedPull::new(&part.shape).map(|pull| Self::Ordinary(Box::new(pull)));
        }
        let parts = body.parts().iter().map(|part| PartPull {
            share: part.mass / body.mass,
            place: Place { position: part.position(), rotation: part.rotation() },
            radius: part.shape.circumradius(),
            extended: Extended::new(&part.shape),
        });
        Some(Self::Composite(parts.collect()))
    }

    /// As [`ExtendedPull::at`].
    #[inline(always)]
    pub fn at(
        &mut self,
        x: &Vec3,
        inverse_square: f64,
        inverse_cube: f64,
        strength: f64,
    ) -> Option<(Vec3, Vec3)> {
        match self {
            Self::Ordinary(pull) => pull.at(x, inverse_square, inverse_cube, strength),
            Self::Composite(parts) => {
                let (excess, moment) = PartPull::sum(parts, x, inverse_square, inverse_cube)?;
                Some((excess * strength, moment * strength))
            }
        }
    }

    /// As [`ExtendedPull::slopes`]; none of a polyhedron.
    pub fn slopes(&mut self, x: &Vec3) -> Option<(Mat3, Mat3)> {
        let parts = match self {
            Self::Ordinary(pull) => return Some(pull.slopes(x)),
            Self::Composite(parts) => parts,
        };
        let (mut gradient, mut turning) = (Mat3::zeros(), Mat3::zeros());
        for part in parts {
            let (p, turn) = (part.place.position, part.place.rotation);
            let from = turned_back(&turn, &(x - p));
            let (own, own_turning) = match &mut part.extended {
                Some(extended) => extended.slopes(&from)?,
                None => slopes_of_point(&from),
            };
            let own = turn * own * turn.transpose() * part.share;
            gradient += own;
            turning += turn * own_turning * turn.transpose() * part.share - cross_times(&p, &own);
        }
        Some((gradient, turning))
    }
}

impl PartPull {
    /// The sum over all parts.
    fn sum(parts: &mut [Self], x: &Vec3, inverse_square: f64, inverse_cube: f64) -> Option<(Vec3, Vec3)> {
        let (mut excess, mut moment) = (Vec3::zeros(), Vec3::zeros());
        for part in parts {
            let (field, turning) = part.at(x, inverse_square, inverse_cube)?;
            excess += field;
            moment += turning;
        }
        Some((excess, moment))
    }

    /// The part's field less that of its mass at the body's centre and less the dipole there, and its moment about that centre
    /// less the dipole's: the dipoles of all parts cancel.
    ///
    /// With p the part's place, q = p.(p - 2x)/|x|^2, s = sqrt(1 + q) and e = s - 1 = q/(1 + s), its point mass has
    /// |x|^3/|x-p|^3 = s^-3 = 1 + h with h = -e (1 + s + s^2)/s^3, and h = -3/2 q + k with
    /// k = e^2 (3/2 s^3 + 3 s^2 + 2 s + 1)/s^3: no term is a difference of nearly equal numbers. Its field less that at the centre
    /// and the dipole is then -(x (k - 3/2 |p|^2/|x|^2) - p h)/|x|^3, its moment h x cross p/|x|^3.
    fn at(&mut self, x: &Vec3, inverse_square: f64, inverse_cube: f64) -> Option<(Vec3, Vec3)> {
        let p = self.place.position;
        let from = x - p;
        if from.norm_squared() < self.radius * self.radius && self.extended.is_none() {
            return None;
        }
        let square = p.norm_squared() * inverse_square;
        let q = p.dot(&(p - 2.0 * x)) * inverse_square;
        let s = (1.0 + q).sqrt();
        let (s2, s3) = (1.0 + q, (1.0 + q) * s);
        let e = q / (1.0 + s);
        let h = -e * (1.0 + s + s2) / s3;
        let k = e * e * (1.5 * s3 + 3.0 * s2 + 2.0 * s + 1.0) / s3;
        let mut excess = (p * h - x * (k - 1.5 * square)) * inverse_cube;
        let mut moment = x.cross(&p) * (h * inverse_cube);
        if let Some(extended) = &mut self.extended {
            let turn = &self.place.rotation;
            let (field, turning) =
                extended.at(&turned_back(turn, &from), inverse_square / s2, inverse_cube / s3)?;
            let field = turned(turn, &field);
            excess += field;
            moment += turned(turn, &turning) + p.cross(&field);
        }
        Some((excess * self.share, moment * self.share))
    }
}
