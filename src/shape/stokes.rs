//! A shape that is known by its gravity: Stokes coefficients, the mean moment of inertia and the radius of a
//! sphere that contains it.
//!
//! With S_lm of [`crate::math::harmonics`] the means a_lm of S_lm over the mass, in units of the reference
//! radius to the power l, are sqrt(2 l + 1) times the coefficients in the 4 pi normalisation of geodesy: C_lm
//! for m >= 0 and S_l,-m below. Degree 1 is the centre of mass, and degree 2 with the trace T of the second
//! moments is the inertia tensor: int x y = S_2,-2/sqrt 3, int x z = S_21/sqrt 3, int y z = S_2,-1/sqrt 3, int
//! x^2 - y^2 = 2 S_22/sqrt 3, int z^2 = (T + 2 S_20)/3.

use super::frame::{WorkingFrame, check_inertia, principal_axes, quaternion};
use crate::error::{Error, Result, require_finite, require_positive};
use crate::math::exchange::Exchange;
use crate::math::harmonics::{count, moved, scale_degrees};
use crate::math::{Mat3, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A shape by its gravity outside a sphere. It has no surface. Its frame has the origin in the centre of mass
/// and the axes along the principal axes of inertia.
#[derive(Debug, Clone, PartialEq)]
pub struct StokesCoefficients {
    input: Arc<InputCoefficients>,
    moments: Arc<Vec<f64>>,
    radius: f64,
    inertia: Vec3,
    frame: WorkingFrame,
}

/// Stokes coefficients as they were given, in the working frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputCoefficients {
    /// The coefficients in the 4 pi normalisation, in the order of `math::harmonics::index`.
    pub coefficients: Vec<f64>,
    /// The radius to which the coefficients refer.
    pub reference_radius: f64,
    /// A third of the trace of the inertia tensor of unit mass about the centre of mass.
    pub mean_inertia: f64,
    /// The radius of a sphere about the origin that contains the body.
    pub radius: f64,
}

impl StokesCoefficients {
    /// The indices of the coefficients that vanish about the centre of mass and the principal axes.
    pub(crate) const VANISHING: [usize; 6] = [1, 2, 3, 4, 5, 7];

    /// Makes a shape from coefficients, and moves it to its centre of mass and its principal axes.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] refuses numbers that are not finite, a number of coefficients that is not that
    /// of whole degrees from 2 to 80, a coefficient of degree zero other than one, moments of inertia that no
    /// body has, and those of a body that does not fit into the sphere.
    pub fn new(input: InputCoefficients) -> Result<Self> {
        let InputCoefficients { coefficients, reference_radius, mean_inertia, radius } = &input;
        let degree = coefficients.len().isqrt().saturating_sub(1);
        if coefficients.len() != count(degree) || !(2..=Exchange::MAX_DEGREE).contains(&degree) {
            let expected = format!("(L + 1)^2 for a degree L from 2 to {}", Exchange::MAX_DEGREE);
            return Err(Error::invalid("number of Stokes coefficients", coefficients.len(), expected));
        }
        require_finite("Stokes coefficients", coefficients)?;
        if coefficients[0] != 1.0 {
            return Err(Error::invalid("Stokes coefficient C00", coefficients[0], "1"));
        }
        require_positive("reference radius", *reference_radius)?;
        require_positive("mean moment of inertia", *mean_inertia)?;
        require_positive("radius", *radius)?;
        let mut moments = coefficients.clone();
        scale_degrees(&mut moments, |l| ((2 * l + 1) as f64).sqrt());
        let centre = Vec3::new(moments[3], moments[1], moments[2]);
        if centre != Vec3::zeros() {
            moments = moved(&moments, degree, |x| x - centre);
        }
        let trace = 1.5 * mean_inertia / reference_radius.powi(2);
        let tensor = inertia_tensor(&moments, trace);
        let axes = principal_axes(&tensor, 2.0 * trace);
        if axes != Mat3::identity() {
            moments = moved(&moments, degree, |x| axes * x);
        }
        let centre = centre * *reference_radius;
        let inertia = (axes * tensor * axes.transpose()).diagonal() * reference_radius.powi(2);
        check_inertia("the Stokes coefficients", &inertia, inertia.sum())?;
        let radius = radius + centre.norm();
        if 1.5 * mean_inertia > radius * radius {
            let expected =
                format!("at most {}: the body lies in a sphere of this radius", radius * radius / 1.5);
            return Err(Error::invalid("mean moment of inertia", mean_inertia, expected));
        }
        let ratio = reference_radius / radius;
        scale_degrees(&mut moments, |l| ratio.powi(l as i32));
        Self::VANISHING.iter().for_each(|&index| moments[index] = 0.0);
        let frame = WorkingFrame { position: -(axes * centre), attitude: quaternion(&axes) };
        Ok(Self { input: Arc::new(input), moments: Arc::new(moments), radius, inertia, frame })
    }

    /// Returns the coefficients as they were given.
    pub fn input(&self) -> &InputCoefficients {
        &self.input
    }

    /// Returns the means of the harmonics in the body frame, in units of the radius.
    pub fn moments(&self) -> &Arc<Vec<f64>> {
        &self.moments
    }

    /// Returns the highest degree.
    pub fn degree(&self) -> usize {
        self.moments.len().isqrt() - 1
    }

    /// Returns the radius of a sphere about the centre of mass that contains the body.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns the principal moments of inertia of unit mass.
    pub fn inertia_per_mass(&self) -> Vec3 {
        self.inertia
    }

    /// Returns where the working frame, in which the coefficients were given, lies in the body frame.
    pub fn working_frame(&self) -> WorkingFrame {
        self.frame
    }

    /// Returns the shape with all lengths multiplied by a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let input = InputCoefficients {
            coefficients: self.input.coefficients.clone(),
            reference_radius: self.input.reference_radius * factor,
            mean_inertia: self.input.mean_inertia * factor * factor,
            radius: self.input.radius * factor,
        };
        Self {
            input: Arc::new(input),
            moments: self.moments.clone(),
            radius: self.radius * factor,
            inertia: self.inertia * factor * factor,
            frame: WorkingFrame { position: self.frame.position * factor, attitude: self.frame.attitude },
        }
    }
}

/// A number of a shape that is given by Stokes coefficients, in the body frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StokesNumber {
    /// The coefficient with this index, in the 4 pi normalisation, for the reference radius. One of degree 2
    /// changes the moments of inertia, but not their mean.
    Coefficient(usize),
    /// The mean moment of inertia of unit mass.
    MeanInertia,
}

impl StokesCoefficients {
    /// Iterates over the numbers that do not vanish in every principal frame, with their names.
    pub fn numbers(&self) -> impl Iterator<Item = (String, StokesNumber)> {
        let free = (count(1)..self.moments.len()).filter(|index| !Self::VANISHING.contains(index));
        let coefficient = |index: usize| {
            let l = index.isqrt();
            let m = index as isize - (l * l + l) as isize;
            let letter = if m < 0 { "S" } else { "C" };
            (format!("{letter}{l},{}", m.unsigned_abs()), StokesNumber::Coefficient(index))
        };
        let inertia = ("mean moment of inertia".to_owned(), StokesNumber::MeanInertia);
        free.map(coefficient).chain([inertia])
    }

    /// Returns the derivative of the moment of this index with respect to the coefficient for a reference
    /// radius.
    pub fn moment_by_coefficient(&self, index: usize, reference_radius: f64) -> f64 {
        let l = index.isqrt();
        ((2 * l + 1) as f64).sqrt() * (reference_radius / self.radius).powi(l as i32)
    }

    /// Returns a number for a reference radius.
    pub fn number(&self, number: StokesNumber, reference_radius: f64) -> f64 {
        match number {
            StokesNumber::Coefficient(index) => {
                self.moments[index] / self.moment_by_coefficient(index, reference_radius)
            }
            StokesNumber::MeanInertia => self.inertia.sum() / 3.0,
        }
    }

    /// Returns the derivatives of the moments of inertia of unit mass with respect to a number.
    pub fn inertia_by(&self, number: StokesNumber) -> Vec3 {
        let reference_radius = self.input.reference_radius;
        match number {
            StokesNumber::MeanInertia => Vec3::repeat(1.0),
            StokesNumber::Coefficient(index) if index < count(2) => {
                let mut unit = [0.0; count(2)];
                unit[index] = 5.0_f64.sqrt() * reference_radius.powi(2);
                inertia_tensor(&unit, 0.0).diagonal()
            }
            StokesNumber::Coefficient(_) => Vec3::zeros(),
        }
    }

    /// Returns the shape with a number changed, in the body frame.
    ///
    /// # Errors
    /// Returns the errors of [`Self::new`].
    pub fn with(&self, number: StokesNumber, by: f64) -> Result<Self> {
        let InputCoefficients { reference_radius, mean_inertia, .. } = *self.input;
        let value = |index| self.number(StokesNumber::Coefficient(index), reference_radius);
        let mut input = InputCoefficients {
            coefficients: (0..self.moments.len()).map(value).collect(),
            reference_radius,
            mean_inertia,
            radius: self.radius,
        };
        match number {
            StokesNumber::Coefficient(index) => input.coefficients[index] += by,
            StokesNumber::MeanInertia => input.mean_inertia += by,
        }
        Self::new(input)
    }
}

/// Returns the inertia tensor of unit mass from moments about the centre of mass and the trace of the second
/// moments.
fn inertia_tensor(moments: &[f64], trace: f64) -> Mat3 {
    let root = 3.0_f64.sqrt();
    let [xy, yz, s20, xz, s22] =
        [moments[4] / root, moments[5] / root, moments[6], moments[7] / root, moments[8] / root];
    let zz = (trace + 2.0 * s20) / 3.0;
    let (xx, yy) = (0.5 * (trace - zz) + s22, 0.5 * (trace - zz) - s22);
    Mat3::from_diagonal_element(trace) - Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}
