//! The difference between the attraction of a distant point by one body and by a point mass.

use super::{FarSeries, FarTruncation, FieldKernel, HarmonicField, LayerAttraction, Near};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::difference::{STEP, steps};
use crate::math::lanes::Lanes;
use crate::math::matrix::{cross_times, times, transposed_times};
use crate::math::rotation::{rotate, rotate_back};
use crate::math::{Mat3, Vec3};
use crate::shape::{Body, Ellipsoid, PartDerivative, Placement, Shape};
use pulp::Scalar;

/// The truncation error of the series, relative to the field of a point.
const TOLERANCE: f64 = 1e-17;

/// The size of the terms beyond the quadrupole, relative to it, at which they are neglected.
const BEYOND_QUADRUPOLE: f64 = 1e-16;

/// The excess of the body's field over that of its mass at its centre, and its moment about the centre. Both
/// keep all digits at any distance.
#[derive(Debug, Clone)]
pub struct ExtendedAttraction {
    ellipsoid: Ellipsoid,
    /// The quadrupole per unit mass, (a_i^2 - their mean) / 5, along the body's axes.
    quadrupole: Vec3,
    /// The largest 1/|x|^2 at which the quadrupole suffices.
    quadrupole_to: f64,
    series: FarSeries,
    /// A lower bound of kappa at the last near point, and the terms of the series that it needs.
    cached_truncation: Option<(f64, Option<FarTruncation>)>,
}

impl ExtendedAttraction {
    /// Prepares a shape; `None` for a point and for a sphere, whose field is that of a point.
    pub fn new(shape: &Shape) -> Option<Self> {
        Self::ellipsoidal(shape).filter(|attraction| attraction.quadrupole.amax() > 0.0)
    }

    /// Prepares an ellipsoid, also one with equal axes; `None` for another shape.
    pub fn ellipsoidal(shape: &Shape) -> Option<Self> {
        let Shape::Ellipsoid(ellipsoid) = shape else { return None };
        let [a, b, c] = ellipsoid.semi_axes();
        // Differences of squares are formed as products, exact for nearly equal axes.
        let (ab, bc, ca) = ((a - b) * (a + b), (b - c) * (b + c), (c - a) * (c + a));
        let quadrupole = Vec3::new(ab - ca, bc - ab, ca - bc) / 15.0;
        // The next moment is smaller by the deviation of the squares over |x|^2.
        let quadrupole_to = BEYOND_QUADRUPOLE / (5.0 * quadrupole.amax());
        let series = FarSeries::new(shape);
        Some(Self { ellipsoid: *ellipsoid, quadrupole, quadrupole_to, series, cached_truncation: None })
    }

    /// Returns g + x/|x|^3 and x cross g at a point `x` of the body frame with the given 1/|x|^2 and 1/|x|^3,
    /// for a strength in place of GM; `None` inside the body.
    #[inline(always)]
    pub fn at(
        &mut self,
        x: &Vec3,
        inverse_square: f64,
        inverse_cube: f64,
        strength: f64,
    ) -> Option<(Vec3, Vec3)> {
        if inverse_square < self.quadrupole_to {
            // This is the gradient of 3/2 x.Dx / |x|^5, where factors that are known early are multiplied
            // first.
            let fifth = 3.0 * strength * inverse_cube * inverse_square;
            let dx = self.quadrupole.component_mul(x);
            let along = x.dot(&dx) * (2.5 * inverse_square * fifth);
            return Some((dx * fifth - x * along, x.cross(&dx) * fifth));
        }
        let (perturbation, moment) = self.near(x, inverse_cube)?;
        Some((perturbation * strength, moment * strength))
    }

    #[cold]
    fn near(&mut self, x: &Vec3, inverse_cube: f64) -> Option<(Vec3, Vec3)> {
        let canonical = self.ellipsoid.canonical();
        let x = rotate(&canonical, x);
        let [a, b, c] = self.ellipsoid.sorted();
        let square = x.norm_squared();
        if square < a * a && (x.x / a).powi(2) + (x.y / b).powi(2) + (x.z / c).powi(2) < 1.0 {
            return None;
        }
        let lanes: [Lanes<Scalar>; 3] = [x.x, x.y, x.z].map(|value| Lanes::splat(Scalar, value));
        let (field, point) = match self.truncation(square - a * a) {
            Some(truncation) => (self.series.truncated(truncation).field_perturbation(lanes), 0.0),
            None => (Near::new(&self.ellipsoid, 0.0).field(lanes), inverse_cube),
        };
        let perturbation = field.rd.map(|rd| rd.first() - point);
        let [first, second, third] = field.rd_difference.map(Lanes::first);
        let moment = -Vec3::new(x.y * x.z * first, x.z * x.x * second, x.x * x.y * third);
        let force = -x.component_mul(&Vec3::from(perturbation));
        Some((rotate_back(&canonical, &force), rotate_back(&canonical, &moment)))
    }

    /// Returns dg/dx and the derivative of -x cross g, per unit GM, at a point `x` of the body frame outside
    /// the body.
    pub fn jacobian(&mut self, x: &Vec3) -> (Mat3, Mat3) {
        let canonical = self.ellipsoid.canonical();
        let x = rotate(&canonical, x);
        let [a, ..] = self.ellipsoid.sorted();
        let lanes = [x.x, x.y, x.z].map(|value| Lanes::splat(Scalar, value));
        let (gradient, torque_gradient) = match self.truncation(x.norm_squared() - a * a) {
            Some(truncation) => jacobian_at(self.series.truncated(truncation), lanes),
            None => jacobian_at(Near::new(&self.ellipsoid, 0.0), lanes),
        };
        let to_body = |slope: Mat3| times(&transposed_times(&canonical, &slope), &canonical);
        (to_body(gradient), to_body(torque_gradient))
    }

    /// Returns the derivatives of g with respect to the semi-axes, per unit GM, at a point `x` of the body
    /// frame outside the body.
    pub fn semi_axis_derivatives(&mut self, x: &Vec3) -> [Vec3; 3] {
        let canonical = self.ellipsoid.canonical();
        let x = rotate(&canonical, x);
        let [a, b, c] = self.ellipsoid.sorted();
        let lanes = [x.x, x.y, x.z].map(|value| Lanes::splat(Scalar, value));
        let rows = match self.truncation(x.norm_squared() - a * a) {
            Some(truncation) => semi_axis_derivatives_at(self.series.truncated(truncation), lanes),
            None => semi_axis_derivatives_at(Near::new(&self.ellipsoid, 0.0), lanes),
        };
        // A semi-axis has no sign, unlike the direction of its axis.
        let by = transposed_times(&canonical.abs(), &(Mat3::from_diagonal(&Vec3::new(a, b, c)) * rows));
        let by = times(&by, &canonical);
        [0, 1, 2].map(|axis| by.row(axis).transpose())
    }

    /// Returns the terms of the series that a distance needs, where kappa >= `kappa_min`. They depend on the
    /// binary exponent of `kappa_min` alone, so that results do not depend on earlier calls.
    fn truncation(&mut self, kappa_min: f64) -> Option<FarTruncation> {
        // This is the double with the same exponent and no fraction: a power of two.
        let floor = f64::from_bits(kappa_min.max(0.0).to_bits() >> 52 << 52);
        match self.cached_truncation {
            Some((cached_truncation, truncation)) if cached_truncation == floor => truncation,
            _ => {
                let truncation = self.series.truncation_for(floor, TOLERANCE);
                self.cached_truncation = Some((floor, truncation));
                truncation
            }
        }
    }
}

fn jacobian_at(kernel: impl FieldKernel, x: [Lanes<Scalar>; 3]) -> (Mat3, Mat3) {
    let field = kernel.field(x);
    let [xx, xy, xz, yy, yz, zz] = field.gradient(x).map(Lanes::first);
    let torque_gradient = field
        .torque_gradient(x, field.gradient_factors(x), kernel.square_differences())
        .map(|row| row.map(Lanes::first));
    (Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz), Mat3::from(torque_gradient).transpose())
}

/// Returns the derivatives divided by each semi-axis, one row for each of them.
fn semi_axis_derivatives_at(kernel: impl FieldKernel, x: [Lanes<Scalar>; 3]) -> Mat3 {
    let (field, second_integrals) = kernel.second_integrals(x);
    let rows = field
        .semi_axis_derivatives(x, field.gradient_factors(x), second_integrals)
        .map(|row| row.map(Lanes::first));
    Mat3::from(rows).transpose()
}

/// Returns the Jacobian of the field of a point mass, whose torque is zero.
pub(crate) fn point_jacobian(x: &Vec3) -> (Mat3, Mat3) {
    let r = x.norm();
    let u = x / r;
    ((3.0 * u * u.transpose() - Mat3::identity()) / r / r / r, Mat3::zeros())
}

/// The excess of a body's attraction over that of a point mass: that of its shape for an ordinary body, and
/// the sum over the parts for another one.
#[derive(Debug, Clone)]
pub enum BodyAttraction {
    /// An ellipsoid, in the body's own frame.
    Ordinary(Box<ExtendedAttraction>),
    /// Several parts, a polyhedron, or Stokes coefficients.
    Composite(Vec<PartAttraction>),
}

/// The contribution of a part to the attraction by its body.
#[derive(Debug, Clone)]
pub struct PartAttraction {
    /// The mass of the part divided by the mass of the body.
    share: f64,
    placement: Placement,
    radius: f64,
    extended: Option<Extended>,
}

/// The attraction by a part with extent.
#[derive(Debug, Clone)]
enum Extended {
    Ellipsoid(Box<ExtendedAttraction>),
    Polyhedron(Box<LayerAttraction>),
    /// The field without that of the mass at the centre.
    Stokes(Box<HarmonicField>),
}

impl Extended {
    fn new(shape: &Shape) -> Option<Self> {
        match shape {
            Shape::Polyhedron(polyhedron) => {
                Some(Self::Polyhedron(Box::new(LayerAttraction::new(polyhedron))))
            }
            Shape::Stokes(stokes) => {
                let mut moments = stokes.moments().to_vec();
                moments[0] = 0.0;
                Some(Self::Stokes(Box::new(HarmonicField::new(&moments, stokes.radius()))))
            }
            _ => ExtendedAttraction::new(shape).map(|attraction| Self::Ellipsoid(Box::new(attraction))),
        }
    }

    fn at(&mut self, x: &Vec3, inverse_square: f64, inverse_cube: f64) -> Option<(Vec3, Vec3)> {
        match self {
            Self::Ellipsoid(attraction) => attraction.at(x, inverse_square, inverse_cube, 1.0),
            Self::Polyhedron(attraction) => attraction.at(x, inverse_square, inverse_cube),
            Self::Stokes(attraction) => attraction.field_and_moment(x),
        }
    }

    fn jacobian(&mut self, x: &Vec3) -> (Mat3, Mat3) {
        match self {
            Self::Ellipsoid(attraction) => attraction.jacobian(x),
            Self::Polyhedron(attraction) => attraction.jacobian(x),
            Self::Stokes(attraction) => {
                let perturbation = attraction.at(x);
                let torque_gradient =
                    perturbation.field.cross_matrix() - cross_times(x, &perturbation.gradient);
                (perturbation.gradient + point_jacobian(x).0, torque_gradient)
            }
        }
    }
}

impl BodyAttraction {
    /// Computes the moments of polyhedra that [`Self::new`] needs, which are cached with the shapes.
    pub fn moments(body: &Body, interrupt: &mut InterruptCheck) -> Result<()> {
        let mut parts = body.parts().iter();
        parts.try_for_each(|part| match &part.shape {
            Shape::Polyhedron(polyhedron) => LayerAttraction::moments(polyhedron, interrupt),
            _ => Ok(()),
        })
    }

    /// Prepares a body; `None` for one whose field is that of a point.
    pub fn new(body: &Body) -> Option<Self> {
        if let [part] = body.parts()
            && part.placement.is_none()
            && matches!(part.shape, Shape::Ellipsoid(_) | Shape::Point)
        {
            return ExtendedAttraction::new(&part.shape)
                .map(|attraction| Self::Ordinary(Box::new(attraction)));
        }
        let parts = body.parts().iter().map(|part| PartAttraction {
            share: part.mass / body.mass,
            placement: Placement { position: part.position(), rotation: part.rotation() },
            radius: part.shape.circumradius(),
            extended: Extended::new(&part.shape),
        });
        Some(Self::Composite(parts.collect()))
    }

    /// Returns the excess and the moment as [`ExtendedAttraction::at`].
    #[inline(always)]
    pub fn at(
        &mut self,
        x: &Vec3,
        inverse_square: f64,
        inverse_cube: f64,
        strength: f64,
    ) -> Option<(Vec3, Vec3)> {
        match self {
            Self::Ordinary(attraction) => attraction.at(x, inverse_square, inverse_cube, strength),
            Self::Composite(parts) => {
                let (perturbation, moment) = PartAttraction::sum(parts, x, inverse_square, inverse_cube)?;
                Some((perturbation * strength, moment * strength))
            }
        }
    }

    /// Returns the derivatives as [`ExtendedAttraction::jacobian`] does.
    pub fn jacobian(&mut self, x: &Vec3) -> (Mat3, Mat3) {
        let parts = match self {
            Self::Ordinary(attraction) => return attraction.jacobian(x),
            Self::Composite(parts) => parts,
        };
        let (mut gradient, mut torque_gradient) = (Mat3::zeros(), Mat3::zeros());
        for part in parts {
            let (p, rotation) = (part.placement.position, part.placement.rotation);
            let from = rotate_back(&rotation, &(x - p));
            let (gradient_part, torque_gradient_part) = match &mut part.extended {
                Some(extended) => extended.jacobian(&from),
                None => point_jacobian(&from),
            };
            let gradient_part = rotation * gradient_part * rotation.transpose() * part.share;
            gradient += gradient_part;
            torque_gradient += rotation * torque_gradient_part * rotation.transpose() * part.share
                - cross_times(&p, &gradient_part);
        }
        (gradient, torque_gradient)
    }

    /// Returns the derivatives of the result of [`Self::at`] for a strength of one by a change of the body
    /// while its mass stays the same. They are differences of eighth order: the excess loses no digits at any
    /// distance.
    pub fn by_change(
        &mut self,
        change: &BodyChange,
        mass: f64,
        x: &Vec3,
        inverse_square: f64,
        inverse_cube: f64,
    ) -> [Vec3; 2] {
        if let BodyChange::Moment(field) = change {
            return field
                .field_and_moment(x)
                .map_or([Vec3::zeros(); 2], |(perturbation, moment)| [perturbation, moment]);
        }
        let mut sums = [Vec3::zeros(); 2];
        for (by, weight) in steps(STEP * change.size()) {
            let changed = match (change, &mut *self) {
                (BodyChange::Scale, attraction) => {
                    // The change is in units of the length that grows.
                    let s = 1.0 + by;
                    attraction
                        .at(&(x / s), inverse_square * s * s, inverse_cube * s * s * s, 1.0)
                        .map(|(perturbation, moment)| (perturbation / (s * s), moment / s))
                }
                (BodyChange::Part(derivative), Self::Composite(parts)) => {
                    let mut sum = Some((Vec3::zeros(), Vec3::zeros()));
                    for (index, part) in parts.iter_mut().enumerate() {
                        let previous = (part.placement, part.share);
                        (part.placement, part.share) =
                            derivative.changed(index, &previous.0, previous.1, mass, by);
                        let share = part.at(x, inverse_square, inverse_cube);
                        (part.placement, part.share) = previous;
                        sum = sum.zip(share).map(|(a, b)| (a.0 + b.0, a.1 + b.1));
                    }
                    sum
                }
                (BodyChange::Part(_), Self::Ordinary(_)) | (BodyChange::Moment(_), _) => None,
            };
            let (perturbation, moment) = changed.unwrap_or_default();
            sums[0] += perturbation * weight;
            sums[1] += moment * weight;
        }
        sums
    }
}

/// A change of a body that changes its own field.
#[derive(Debug, Clone)]
pub enum BodyChange {
    /// A change of all lengths by a common factor.
    Scale,
    /// A change of a number of a part of a composite.
    Part(PartDerivative),
    /// A change of a harmonic moment, which changes the field by this one.
    Moment(HarmonicField),
}

impl BodyChange {
    /// Returns the natural size of the number that changes.
    fn size(&self) -> f64 {
        match self {
            Self::Scale | Self::Moment(_) => 1.0,
            Self::Part(derivative) => derivative.size,
        }
    }
}

impl PartAttraction {
    /// Returns the sum over all parts.
    fn sum(parts: &mut [Self], x: &Vec3, inverse_square: f64, inverse_cube: f64) -> Option<(Vec3, Vec3)> {
        let (mut perturbation, mut moment) = (Vec3::zeros(), Vec3::zeros());
        for part in parts {
            let (field_part, moment_part) = part.at(x, inverse_square, inverse_cube)?;
            perturbation += field_part;
            moment += moment_part;
        }
        Some((perturbation, moment))
    }

    /// Returns the excess of the part's field over that of its mass at the body's centre and the dipole
    /// there, and its moment about that centre without the dipole's: the dipoles of all parts cancel.
    ///
    /// With p the part's position, q = p.(p - 2x)/|x|^2, s = sqrt(1 + q) and e = s - 1 = q/(1 + s), its point
    /// mass has |x|^3/|x-p|^3 = s^-3 = 1 + h with h = -e (1 + s + s^2)/s^3, and h = -3/2 q + k with k = e^2
    /// (3/2 s^3 + 3 s^2 + 2 s + 1)/s^3: no term is a difference of nearly equal numbers. The excess of its
    /// field is then -(x (k - 3/2 |p|^2/|x|^2) - p h)/|x|^3, and its moment h x cross p/|x|^3.
    fn at(&mut self, x: &Vec3, inverse_square: f64, inverse_cube: f64) -> Option<(Vec3, Vec3)> {
        let p = self.placement.position;
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
        let mut perturbation = (p * h - x * (k - 1.5 * square)) * inverse_cube;
        let mut moment = x.cross(&p) * (h * inverse_cube);
        if let Some(extended) = &mut self.extended {
            let rotation = &self.placement.rotation;
            let (field_part, moment_part) =
                extended.at(&rotate_back(rotation, &from), inverse_square / s2, inverse_cube / s3)?;
            let field_part = rotate(rotation, &field_part);
            perturbation += field_part;
            moment += rotate(rotation, &moment_part) + p.cross(&field_part);
        }
        Some((perturbation * self.share, moment * self.share))
    }
}
