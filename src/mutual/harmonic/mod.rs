//! The interaction of two bodies by their harmonic moments, exact outside their circumscribed spheres.
//!
//! With Schmidt's semi-normalised harmonics S_lm, a_lm and b_lm the means of S_lm over the bodies, and z
//! along the line of the centres, the addition theorem gives
//!
//! ```text
//! U = sum_m sum_l,l' (-1)^(l' + m) (l + l')! a_lm b_l'm / (w_lm w_l'm r^(l + l' + 1)),
//! w_lm = sqrt((l - m)! (l + m)!).
//! ```
//!
//! Both sets of moments are rotated to this line, so that an evaluation takes work of the third power of the
//! degree. The radial force counts each term l + l' + 1 times, the torques follow from the generators of
//! rotations, and the transverse force from the balance of the torques.

mod choice;
mod jacobian;
mod lengths;
mod line;
mod moments;
mod truncation;

use super::{Interaction, Pose};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::exchange::Exchange;
use crate::math::harmonics::count;
use crate::math::rotation::{rotate, rotate_back};
use crate::math::{Mat3, Vec3};
use crate::shape::Shape;
pub(super) use line::Tables;
use line::{Angle, Direction, LineMoments, orders};
use moments::Moments;
pub use moments::harmonics;
pub(super) use moments::sizes_and_tail;
use pulp::{Arch, Simd, WithSimd};
use std::sync::Arc;
pub(crate) use truncation::Truncation;
use truncation::{RequiredDegrees, required_degrees};

/// The degree to which moments are computed first.
pub(crate) const FIRST_DEGREE: usize = 12;

/// The signs of the torque on the second body, whose moments are stored with the sign (-1)^(l + m).
const SECOND: [f64; 3] = [-1.0, -1.0, 1.0];

/// The expansion of one pair.
#[derive(Debug, Clone)]
pub(crate) struct Harmonic {
    moments: [Moments; 2],
    /// The moments for the derivatives with respect to lengths, where these have been requested.
    lengths: Option<Box<Lengths>>,
    tables: Arc<Tables>,
    arch: Arch,
}

/// The derivatives of the moments of both bodies with respect to three semi-axes or to a scale. They are kept
/// apart from the moments in use, on which they must have no influence.
#[derive(Debug, Clone)]
struct Lengths {
    moments: [Moments; 2],
    derivatives: [Vec<Vec<f64>>; 2],
    truncation: Truncation,
}

impl Harmonic {
    /// Prepares the expansion of two shapes, with moments up to these degrees.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`].
    pub fn new(
        [first, second]: [&Shape; 2],
        [degree, other]: [usize; 2],
        arch: Arch,
        interrupt: &mut InterruptCheck,
    ) -> Result<Self> {
        let moments =
            [Moments::new(first, degree, arch, interrupt)?, Moments::new(second, other, arch, interrupt)?];
        let highest = moments.iter().map(Moments::degree).fold(degree.max(other), usize::max);
        let tables = Arc::new(Tables::new(highest));
        Ok(Self { moments, lengths: None, tables, arch })
    }

    /// Returns the separation down to which the series converges: the sum of the radii of the spheres that
    /// contain the polyhedra and the focal ellipses.
    pub fn converges_from(&self) -> f64 {
        self.moments.iter().map(|body| body.radius).sum()
    }

    /// Returns the degrees to which the moments are known.
    pub fn moment_degrees(&self) -> [usize; 2] {
        [0, 1].map(|body| self.moments[body].degree())
    }

    /// Returns the truncation for all separations from this one up: the lowest degrees that reach the tolerance.
    /// `None` where the highest degree does not suffice.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`].
    pub fn truncation(
        &mut self,
        distance: f64,
        tolerance: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<Truncation>> {
        loop {
            let [first, second] = &self.moments;
            match required_degrees([first, second], distance, tolerance) {
                RequiredDegrees::Degrees(degrees) => {
                    self.extend(degrees, interrupt)?;
                    return Ok(Some(Truncation::new(degrees, degrees[0] + degrees[1], distance)));
                }
                RequiredDegrees::Moments(body) => {
                    let degree = self.moments[body].degree();
                    let higher = (degree + degree / 3).min(Exchange::MAX_DEGREE);
                    self.moments[body] = self.moments[body].to_degree(higher, self.arch, interrupt)?;
                }
                RequiredDegrees::BeyondHighest => return Ok(None),
            }
        }
    }

    /// Returns the truncation with all moments where there are no others, which is valid wherever the series
    /// converges.
    pub fn complete(&self) -> Option<Truncation> {
        let degrees = self.moment_degrees();
        self.moments
            .iter()
            .all(Moments::is_complete)
            .then(|| Truncation::new(degrees, degrees[0] + degrees[1], self.converges_from()))
    }

    /// Extends the moments and constants to these degrees where they are known to lower ones.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`].
    pub fn extend(&mut self, degrees: [usize; 2], interrupt: &mut InterruptCheck) -> Result<()> {
        for (body, degree) in degrees.into_iter().enumerate() {
            if self.moments[body].degree() < degree && !self.moments[body].is_complete() {
                self.moments[body] = self.moments[body].to_degree(degree, self.arch, interrupt)?;
            }
        }
        self.extend_tables(degrees);
        Ok(())
    }

    fn extend_tables(&mut self, degrees: [usize; 2]) {
        let highest = degrees[0].max(degrees[1]);
        if self.tables.degree() < highest {
            self.tables = Arc::new(Tables::new(highest));
        }
    }

    /// Returns force and torques.
    pub fn interaction(&self, truncation: &Truncation, pose: &Pose) -> Interaction {
        let values = [0, 1].map(|body| self.moments[body].values.as_slice());
        self.interaction_of(values, self.radii(), truncation, pose)
    }

    /// Returns the derivatives of force and torques with respect to one of the moments of a body in use, given
    /// by its index.
    pub fn by_moment(&self, truncation: &Truncation, pose: &Pose, body: usize, index: usize) -> Interaction {
        let degree = index.isqrt();
        let mut unit = vec![0.0; count(degree)];
        unit[index] = 1.0;
        let mut values = [0, 1].map(|body| self.moments[body].values.as_slice());
        values[body] = &unit;
        let mut degrees = truncation.degrees;
        degrees[body] = degree;
        let truncation = Truncation::new(degrees, degrees[0] + degrees[1], truncation.valid_from);
        self.interaction_of(values, self.radii(), &truncation, pose)
    }

    fn radii(&self) -> [f64; 2] {
        [0, 1].map(|body| self.moments[body].radius)
    }

    /// Returns force and torques for other moments, in units of these radii.
    fn interaction_of(
        &self,
        moments: [&[f64]; 2],
        radii: [f64; 2],
        truncation: &Truncation,
        pose: &Pose,
    ) -> Interaction {
        self.series_of(moments, radii, truncation).interaction(pose)
    }

    /// Returns the mutual potential U (positive) per unit G m m.
    pub fn mutual_potential(&self, truncation: &Truncation, pose: &Pose) -> f64 {
        self.series(truncation).mutual_potential(pose)
    }

    fn series<'a>(&'a self, truncation: &'a Truncation) -> Series<'a> {
        let values = [0, 1].map(|body| self.moments[body].values.as_slice());
        self.series_of(values, self.radii(), truncation)
    }

    fn series_of<'a>(
        &'a self,
        moments: [&'a [f64]; 2],
        radii: [f64; 2],
        truncation: &'a Truncation,
    ) -> Series<'a> {
        let Truncation { degrees, factors, .. } = truncation;
        Series { tables: &self.tables, moments, radii, degrees: *degrees, factors, arch: self.arch }
    }
}

/// The series of two sets of moments in units of two radii.
#[derive(Debug, Clone, Copy)]
pub(super) struct Series<'a> {
    pub tables: &'a Tables,
    pub moments: [&'a [f64]; 2],
    pub radii: [f64; 2],
    pub degrees: [usize; 2],
    /// The factors of [`Truncation`], at least up to the sum of the degrees.
    pub factors: &'a [Vec<f64>; 3],
    pub arch: Arch,
}

impl Series<'_> {
    /// Returns force and torques.
    pub fn interaction(&self, pose: &Pose) -> Interaction {
        let line = Line::new(pose);
        line.interaction(&self.sums(Request::Loads, &line))
    }

    /// Returns the mutual potential U (positive) per unit G m m.
    pub fn mutual_potential(&self, pose: &Pose) -> f64 {
        let line = Line::new(pose);
        self.sums(Request::Energy, &line).energy / line.distance
    }

    /// Computes sums with arrays of the size that the degrees need.
    fn sums(&self, request: Request, line: &Line) -> SeriesSums {
        let ratios = self.radii.map(|radius| radius / line.distance);
        let task = Task { series: self, request, line, ratios };
        match self.degrees[0].max(self.degrees[1]) {
            ..=6 => self.arch.dispatch(Sized::<{ orders(6) }>(task)),
            7..=20 => self.arch.dispatch(Sized::<{ orders(20) }>(task)),
            21..=28 => self.arch.dispatch(Sized::<{ orders(28) }>(task)),
            29..=40 => self.arch.dispatch(Sized::<{ orders(40) }>(task)),
            _ => self.arch.dispatch(Sized::<{ orders(Exchange::MAX_DEGREE) }>(task)),
        }
    }
}

/// The quantities that are computed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Request {
    Energy,
    Loads,
    Derivatives,
}

/// The sums over all terms along the line of the centres, in units of the separation. A dash marks the
/// weights l + l' + 1, and two of them (l + l' + 1)(l + l' + 2).
#[derive(Debug, Clone, Copy, Default)]
struct SeriesSums {
    energy: f64,
    radial: f64,
    torques: [Vec3; 2],
    second_radial: f64,
    torques_radial: [Vec3; 2],
    /// The derivatives of the torque on the first body by its own rotation and by that of the second body,
    /// and of the torque on the second body by its own.
    by_rotation: [Mat3; 3],
}

/// The line of the centres: its length, its frame, and the bodies in it.
#[derive(Debug, Clone, Copy)]
struct Line {
    distance: f64,
    directions: [Direction; 2],
    azimuth: Angle,
    /// The axes of the line's frame in the inertial frame, as columns.
    inertial: Mat3,
    /// The rotations from the line's frame into those of the bodies.
    bodies: [Mat3; 2],
}

impl Line {
    #[inline]
    fn new(pose: &Pose) -> Self {
        let distance = pose.separation.norm();
        let along = pose.separation / distance;
        let rotations = [&pose.rotation_first, &pose.rotation_second];
        let directions = rotations.map(|rotation| Direction::new(rotate_back(rotation, &along)));
        let [first, second] =
            [0, 1].map(|body| directions[body].axes.map(|axis| rotate(rotations[body], &axis)));
        let (cos, sin) = (first[0].dot(&second[0]), first[1].dot(&second[0]));
        let size = cos.hypot(sin);
        let azimuth = [cos / size, sin / size];
        let [x, y, z] = directions[1].axes;
        let second_axes = [x * azimuth[0] - y * azimuth[1], x * azimuth[1] + y * azimuth[0], z];
        Self {
            distance,
            directions,
            azimuth,
            inertial: Mat3::from_columns(&first),
            bodies: [Mat3::from_columns(&directions[0].axes), Mat3::from_columns(&second_axes)],
        }
    }

    /// Returns the force on the second body in this frame, in units of the separation.
    fn force(&self, sums: &SeriesSums) -> Vec3 {
        let torque = sums.torques[0] + sums.torques[1];
        Vec3::new(-torque.y, torque.x, -sums.radial)
    }

    fn interaction(&self, sums: &SeriesSums) -> Interaction {
        let r = self.distance;
        Interaction {
            force_on_first: rotate(&self.inertial, &self.force(sums)) / (-r * r),
            torque_first: rotate(&self.bodies[0], &sums.torques[0]) / r,
            torque_second: rotate(&self.bodies[1], &sums.torques[1]) / r,
        }
    }
}

struct Task<'a> {
    series: &'a Series<'a>,
    request: Request,
    line: &'a Line,
    ratios: [f64; 2],
}

/// A task with arrays for so many orders.
struct Sized<'a, const N: usize>(Task<'a>);

impl<const N: usize> WithSimd for Sized<'_, N> {
    type Output = SeriesSums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> SeriesSums {
        let Task { series, request, line, ratios } = self.0;
        let Series { tables, moments, degrees, factors: [unweighted, once, twice], .. } = series;
        let [first, second] = *degrees;
        let along = |body: usize, azimuth| {
            let degree = degrees[body];
            LineMoments::<N>::new(
                tables,
                moments[body],
                degree,
                ratios[body],
                &line.directions[body],
                azimuth,
            )
        };
        let (a, b) = (along(0, None), along(1, Some(line.azimuth)));
        let by_first = b.coupled(unweighted, first);
        let mut sums = SeriesSums { energy: a.dot(&by_first), ..SeriesSums::default() };
        if request == Request::Energy {
            return sums;
        }
        let signs = Vec3::from(SECOND);
        let by_second = a.coupled(unweighted, second);
        sums.torques = [a.torque(&by_first), b.torque(&by_second).component_mul(&signs)];
        sums.radial = sums.energy + a.weighted_dot(&by_first) + b.weighted_dot(&by_second);
        if request == Request::Loads {
            return sums;
        }
        let (radial_first, radial_second) = (b.coupled(once, first), a.coupled(once, second));
        sums.second_radial = a.dot(&b.coupled(twice, first));
        sums.torques_radial = [a.torque(&radial_first), b.torque(&radial_second).component_mul(&signs)];
        let (rotated_a, rotated_b) = (a.rotated(), b.rotated());
        for (axis, sign) in SECOND.into_iter().enumerate() {
            let first_by_first = rotated_a[axis].torque(&by_first);
            let by_other = a.torque(&rotated_b[axis].coupled(unweighted, first)) * sign;
            let second = rotated_b[axis].torque(&by_second);
            for (block, column) in
                [first_by_first, by_other, second.component_mul(&signs) * sign].iter().enumerate()
            {
                sums.by_rotation[block].set_column(axis, column);
            }
        }
        sums
    }
}
