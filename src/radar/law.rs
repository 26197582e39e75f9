//! Radar scattering laws: the cross section of a surface element by the angle of incidence.
//!
//! With theta the angle between the normal and the direction to the radar, a law is d(sigma)/dS, where dS is the
//! area of the surface itself and not its projection. A bistatic radar has the bisector of the directions to its two
//! antennas in place of the direction to the radar. The laws are those of Magri et al. (2007), Icarus 186, 152, with
//! the reflectivity R at normal incidence and C, which is larger for a smoother surface:
//!
//! - the cosine law R (C + 1) cos^(2C)(theta),
//! - the Gaussian law R C exp(-C tan^2(theta)) / cos^4(theta),
//! - Hagfors' law (R C / 2) (cos^4(theta) + C sin^2(theta))^(-3/2) (Hagfors 1964, J. Geophys. Res. 69, 3779).

use crate::error::{Error, Result};
use crate::photometry::RULE;

/// The dependence of a scattering law on the angle of incidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The cosine law.
    Cosine,
    /// The Gaussian law.
    Gaussian,
    /// Hagfors' law.
    Hagfors,
}

/// A radar scattering law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    kind: Kind,
    /// The parameter C.
    c: f64,
    /// The law's factor: R (C + 1), R C or R C / 2.
    factor: f64,
    /// The cosine of the angle of incidence from which on nothing is reflected.
    pub(super) least_cosine: f64,
    /// The cross section of a sphere over its projected area, which tells the size of an echo.
    pub(super) albedo: f64,
    /// The integer 2 C of a cosine law with such an exponent.
    power: Option<i32>,
}

impl Law {
    /// Makes the cosine law.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a C or an R below zero.
    pub fn cosine(c: f64, reflectivity: f64) -> Result<Self> {
        Self::new(Kind::Cosine, c, reflectivity, c + 1.0, 0.0)
    }

    /// Makes the Gaussian law, with the angle of incidence from which on nothing is reflected, in radians.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a number out of its range.
    pub fn gaussian(c: f64, reflectivity: f64, cutoff: f64) -> Result<Self> {
        Self::new(Kind::Gaussian, c, reflectivity, c, cosine_of(cutoff)?)
    }

    /// Makes Hagfors' law, with the angle of incidence from which on nothing is reflected, in radians.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a number out of its range.
    pub fn hagfors(c: f64, reflectivity: f64, cutoff: f64) -> Result<Self> {
        Self::new(Kind::Hagfors, c, reflectivity, 0.5 * c, cosine_of(cutoff)?)
    }

    fn new(kind: Kind, c: f64, reflectivity: f64, factor: f64, least_cosine: f64) -> Result<Self> {
        let least = if kind == Kind::Cosine { 0.0 } else { LARGEST.recip() };
        for (what, value, least) in [("C", c, least), ("R", reflectivity, 0.0)] {
            if !(least..=LARGEST).contains(&value) {
                return Err(Error::invalid(what, value, format!("a number from {least} to {LARGEST}")));
            }
        }
        let whole = kind == Kind::Cosine && (2.0 * c).fract() == 0.0 && c < 16.0;
        let power = whole.then_some((2.0 * c) as i32);
        let mut law = Self { kind, c, factor: factor * reflectivity, least_cosine, power, albedo: 0.0 };
        let (mut f, tolerance) = (|cosine| Ok([2.0 * law.cross_section(cosine)]), 1e-9 * reflectivity);
        [law.albedo] = RULE.integrate([least_cosine, 1.0], &[tolerance], &mut f, &mut |_| {})?;
        Ok(law)
    }

    /// Returns whether the law is a smooth function of the position across the limb, or nearly so.
    pub fn has_whole_power(&self) -> bool {
        self.kind != Kind::Cosine || self.power.is_some() || self.c >= 8.0
    }

    /// Returns whether the law goes to zero at the limb with a low power that is no whole number.
    pub fn is_rough_at_limb(&self) -> bool {
        self.kind == Kind::Cosine && self.power.is_none() && self.c < 1.5
    }

    /// Returns the cross section per area of the surface at a cosine of the angle of incidence above zero.
    #[inline]
    pub fn cross_section(&self, cosine: f64) -> f64 {
        let cosine = cosine.max(LEAST);
        let square = cosine * cosine;
        self.factor
            * match (self.kind, self.power) {
                (Kind::Cosine, Some(power)) => cosine.powi(power),
                // This takes half the time of a general power.
                (Kind::Cosine, None) => (self.c * square.ln()).exp(),
                (Kind::Gaussian, _) => (self.c * (1.0 - square.recip())).exp() / (square * square),
                (Kind::Hagfors, _) => {
                    let argument = square * square + self.c * (1.0 - square);
                    (argument * argument.sqrt()).recip()
                }
            }
    }
}

/// The least cosine with which the laws are evaluated, since its powers are no zeros yet.
const LEAST: f64 = 1e-30;

/// The largest C and R, far above those of any surface.
const LARGEST: f64 = 1e6;

fn cosine_of(cutoff: f64) -> Result<f64> {
    if cutoff > 0.0 && cutoff <= std::f64::consts::FRAC_PI_2 {
        // The cosine of a right angle is rounded.
        Ok(if cutoff == std::f64::consts::FRAC_PI_2 { 0.0 } else { cutoff.cos() })
    } else {
        Err(Error::invalid("cutoff", cutoff, "an angle above zero, at most pi/2"))
    }
}
