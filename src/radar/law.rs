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
use crate::math::exponential::exp;
use crate::math::lanes::Lanes;
use crate::math::logarithm::ln;
use crate::photometry::RULE;
use pulp::{Scalar, Simd};

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

/// The kind of position at which a law changes fast or is not smooth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Roughness {
    /// The law is smooth everywhere.
    None,
    /// The law goes to zero at the limb with a power that is not an integer. The substitution with this power makes the
    /// resulting power large.
    Limb(usize),
    /// The law has a peak at normal incidence.
    Peak,
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
    power: Option<u32>,
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
        let is_power = kind == Kind::Cosine && (2.0 * c).fract() == 0.0 && c < 16.0;
        let power = is_power.then_some((2.0 * c) as u32);
        let mut law = Self { kind, c, factor: factor * reflectivity, least_cosine, power, albedo: 0.0 };
        // The substitution 1 - t^6 finds any peak.
        let range = 1.0 - least_cosine;
        let mut f = |t: f64| Ok([12.0 * range * t.powi(5) * law.cross_section(1.0 - range * t.powi(6))]);
        [law.albedo] = RULE.integrate([0.0, 1.0], &[1e-9 * reflectivity], &mut f, &mut |_| {})?;
        Ok(law)
    }

    /// Returns the kind of position at which the law changes fast or is not smooth.
    pub fn roughness(&self) -> Roughness {
        match (self.kind, self.power) {
            (Kind::Cosine, _) if self.c >= PEAK => Roughness::Peak,
            (Kind::Cosine, Some(_)) => Roughness::None,
            (Kind::Cosine, None) => Roughness::Limb((LIMB / (2.0 * self.c + 1.0)).ceil() as usize),
            _ if self.c >= 10.0 => Roughness::Peak,
            _ => Roughness::None,
        }
    }

    /// Returns the relative rounding of the law, which is that of the cosine times the exponent.
    pub fn rounding(&self) -> f64 {
        f64::EPSILON * (16.0 + 4.0 * self.c)
    }

    /// Returns the cross section per area of the surface at a cosine of the angle of incidence above zero.
    pub fn cross_section(&self, cosine: f64) -> f64 {
        let [cosine, one] = [cosine, 1.0].map(|value| Lanes::<_, 1>::splat(Scalar, value));
        self.times_length(cosine, one).first()
    }

    /// Returns the cross section per area of the surface times the length of the normal, given its square and its
    /// product with the direction to the radar, which is the length times the cosine of incidence.
    #[inline(always)]
    pub fn times_length<S: Simd, const N: usize>(
        &self,
        product: Lanes<S, N>,
        length_squared: Lanes<S, N>,
    ) -> Lanes<S, N> {
        let product = product.max(product.constant(LEAST));
        let (square, one) = (product * product, product.constant(1.0));
        let relative = match (self.kind, self.power) {
            (Kind::Cosine, Some(1)) => product,
            (Kind::Cosine, Some(power)) => {
                let mut factor = square / length_squared;
                let mut result = if power % 2 == 1 { product } else { length_squared.sqrt() };
                for bit in 1..u32::BITS - power.leading_zeros() {
                    result = if power >> bit & 1 == 1 { result * factor } else { result };
                    factor = factor * factor;
                }
                result
            }
            (Kind::Cosine, None) => length_squared.sqrt() * exp(ln(square / length_squared) * self.c),
            (Kind::Gaussian, _) => {
                let inverse = length_squared / square;
                length_squared.sqrt() * exp((one - inverse) * self.c) * inverse * inverse
            }
            (Kind::Hagfors, _) => {
                let sine_term = (length_squared - square) * length_squared;
                let inverse = length_squared / square.mul_add(square, sine_term * self.c);
                inverse * inverse.sqrt() * length_squared * length_squared
            }
        };
        relative * self.factor
    }
}

/// The exponent of the distance from the limb, plus one, from which on a power is nearly smooth for the rules.
pub const LIMB: f64 = 7.0;
/// The exponent C from which on the cosine law has a peak.
const PEAK: f64 = 3.0;

/// The least cosine with which the laws are evaluated; its powers do not underflow to zero.
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
