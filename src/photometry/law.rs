//! Scattering laws: the brightness of a surface element by the cosines of emission and incidence.
//!
//! With mu = n.e toward the observer, mu0 = n.s toward the Sun and the phase angle g between e and s, the
//! brightness of an element dS is mu mu0 / (mu + mu0) T(mu, mu0, g) dS, times the albedo. The factor T is one
//! for Lommel-Seeliger's law and mu + mu0 for Lambert's.
//!
//! Hapke's law is T = w/4 [(1 + B(g)) P(g) + H(mu) H(mu0) - 1], with H(x) = (1 + 2 x) / (1 + 2 x sqrt(1 - w))
//! and B(g) = B0 / (1 + tan(g/2) / h) (Hapke 1981, 1986), the phase function P of Henyey & Greenstein, and
//! the correction for macroscopic roughness of Hapke (1984), which replaces the cosines by effective ones and
//! multiplies by a shadowing function. The bidirectional reflectance is r = (w / 4 pi) mu0 / (mu + mu0)
//! [...], and the brightness here is pi r mu dS, in the normalisation in which Lambert's law is mu mu0.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// The parameters of Hapke's law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Hapke {
    /// Single-scattering albedo w, from 0 to 1.
    pub single_scattering_albedo: f64,
    /// Amplitude B0 of the opposition surge.
    pub opposition_amplitude: f64,
    /// Angular width h of the opposition surge.
    pub opposition_width: f64,
    /// Asymmetry of Henyey & Greenstein's phase function, from -1 (backward) to 1; zero for isotropic
    /// scattering.
    pub asymmetry: f64,
    /// Mean slope angle of the macroscopic roughness, radians.
    pub roughness: f64,
}

/// A scattering law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Law {
    /// A sum of Lommel-Seeliger's and of Lambert's law with these factors: T = a + b (mu + mu0).
    Sum([f64; 2]),
    /// Hapke's law.
    Hapke(Hapke),
}

impl Law {
    /// Lommel-Seeliger's law, mu mu0 / (mu + mu0).
    pub const LOMMEL_SEELIGER: Self = Self::Sum([1.0, 0.0]);
    /// Lambert's law, mu mu0.
    pub const LAMBERT: Self = Self::Sum([0.0, 1.0]);

    /// Returns T where it is a constant, as in Lommel-Seeliger's law times a factor: integrals then have
    /// closed forms.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Self::Sum([factor, 0.0]) => Some(*factor),
            _ => None,
        }
    }

    /// Returns whether the law's derivatives jump, where emission and incidence are equal and where the
    /// azimuth between them is zero.
    pub fn has_edges(&self) -> bool {
        matches!(self, Self::Hapke(Hapke { roughness, .. }) if *roughness > 0.0)
    }

    /// Returns an error for a parameter out of its range, with its name.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] names the parameter and its range.
    pub fn check(&self) -> Result<()> {
        let within = |what: &str, value: f64, low: f64, high: f64| {
            if (low..=high).contains(&value) {
                Ok(())
            } else {
                Err(Error::invalid(what, value, format!("a number from {low} to {high}")))
            }
        };
        match self {
            Self::Sum([first, second]) => {
                within("factor of Lommel-Seeliger's law", *first, 0.0, f64::MAX)?;
                within("factor of Lambert's law", *second, 0.0, f64::MAX)
            }
            Self::Hapke(hapke) => {
                within("single_scattering_albedo", hapke.single_scattering_albedo, 0.0, 1.0)?;
                within("opposition_amplitude", hapke.opposition_amplitude, 0.0, f64::MAX)?;
                within("opposition_width", hapke.opposition_width, f64::MIN_POSITIVE, f64::MAX)?;
                within("asymmetry", hapke.asymmetry, -1.0 + 1e-9, 1.0 - 1e-9)?;
                within("roughness", hapke.roughness, 0.0, FRAC_PI_2 - 1e-3)
            }
        }
    }

    /// Returns the law at a phase angle, in radians.
    #[doc(hidden)]
    pub fn at(&self, phase: f64) -> Scattering {
        match self {
            Self::Sum([first, second]) => Scattering::Sum([*first, *second]),
            Self::Hapke(hapke) => {
                let [sin, cos] = [phase.sin(), phase.cos()];
                let (b, tan) = (hapke.asymmetry, (0.5 * phase).tan());
                let denominator = 1.0 + tan / hapke.opposition_width;
                let surge = hapke.opposition_amplitude / denominator;
                let surge_derivative =
                    -0.5 * surge / denominator / hapke.opposition_width * (1.0 + tan * tan);
                // The scattering angle is pi - g, so that positive asymmetry is forward.
                let square = 1.0 + 2.0 * b * cos + b * b;
                let single = (1.0 - b * b) / square.powf(1.5);
                Scattering::Hapke {
                    hapke: *hapke,
                    single: (1.0 + surge) * single,
                    single_derivative: surge_derivative * single
                        + (1.0 + surge) * 3.0 * b * sin / square * single,
                    phase: [sin, cos],
                }
            }
        }
    }
}

/// A law at a phase angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scattering {
    /// The factors of Lommel-Seeliger's and of Lambert's law.
    Sum([f64; 2]),
    /// Hapke's law.
    Hapke {
        /// The parameters of the law.
        hapke: Hapke,
        /// The single-particle term (1 + B(g)) P(g).
        single: f64,
        /// The derivative of the single-particle term with respect to g.
        single_derivative: f64,
        /// The sine and cosine of g.
        phase: [f64; 2],
    },
}

impl Scattering {
    /// Returns T(mu, mu0) at a point where the normal has the component `out_of_plane` along e x s, which
    /// matters only to rough surfaces.
    #[inline]
    pub fn factor(&self, mu: f64, mu0: f64, out_of_plane: f64) -> f64 {
        match self {
            Self::Sum([first, second]) => first + second * (mu + mu0),
            Self::Hapke { hapke, single, phase, .. } => {
                let inner = |mu: f64, mu0: f64| {
                    0.25 * hapke.single_scattering_albedo * (single + hapke.h(mu)[0] * hapke.h(mu0)[0] - 1.0)
                };
                if hapke.roughness == 0.0 {
                    return inner(mu, mu0);
                }
                let psi = out_of_plane.abs().atan2(phase[1] - mu * mu0);
                let [mu_e, mu0_e, shadowing] = hapke.rough(mu, mu0, psi);
                // The rough surface has r = r(mu_e, mu0_e) S, of which T is the factor beside mu0 / (mu +
                // mu0).
                inner(mu_e, mu0_e) * shadowing * mu0_e / (mu_e + mu0_e) * (mu + mu0) / mu0.max(1e-12)
            }
        }
    }

    /// Returns T of a smooth surface and its derivatives with respect to mu, mu0 and g.
    pub fn factor_with_partials(&self, mu: f64, mu0: f64) -> [f64; 4] {
        match self {
            Self::Sum([first, second]) => [first + second * (mu + mu0), *second, *second, 0.0],
            Self::Hapke { hapke, single, single_derivative, .. } => {
                let (factor, [h, derivative], [h0, derivative0]) =
                    (0.25 * hapke.single_scattering_albedo, hapke.h(mu), hapke.h(mu0));
                [single + h * h0 - 1.0, derivative * h0, h * derivative0, *single_derivative]
                    .map(|value| factor * value)
            }
        }
    }
}

impl Hapke {
    /// Returns H(x) and its derivative.
    fn h(&self, x: f64) -> [f64; 2] {
        let root = (1.0 - self.single_scattering_albedo).sqrt();
        let denominator = 1.0 / (1.0 + 2.0 * x * root);
        [(1.0 + 2.0 * x) * denominator, 2.0 * (1.0 - root) * denominator * denominator]
    }

    /// Returns the effective cosines of emission and incidence and the shadowing function (Hapke 1984, Eqs.
    /// 45 to 50), where `psi` is the azimuth between the two directions.
    fn rough(&self, mu: f64, mu0: f64, psi: f64) -> [f64; 3] {
        let theta = self.roughness;
        let tan = theta.tan();
        let (mu, mu0) = (mu.clamp(1e-12, 1.0), mu0.clamp(1e-12, 1.0));
        let (sin_e, sin_i) = ((1.0 - mu * mu).sqrt(), (1.0 - mu0 * mu0).sqrt());
        let cos_psi = psi.cos();
        let chi = 1.0 / (1.0 + PI * tan * tan).sqrt();
        // The two functions are exp(-2 cot(theta) cot(x) / pi) and exp(-cot^2(theta) cot^2(x) / pi); they are
        // zero for x = 0.
        let exponentials = |cos: f64, sin: f64| {
            let cot = cos / (tan * sin.max(f64::MIN_POSITIVE));
            ((-2.0 / PI * cot).exp(), (-cot * cot / PI).exp())
        };
        let (e1_e, e2_e) = exponentials(mu, sin_e);
        let (e1_i, e2_i) = exponentials(mu0, sin_i);
        let eta = |cos: f64, sin: f64, e1: f64, e2: f64| chi * (cos + sin * tan * e2 / (2.0 - e1));
        let (eta_e, eta_i) = (eta(mu, sin_e, e1_e, e2_e), eta(mu0, sin_i, e1_i, e2_i));
        let half = (0.5 * psi).sin().powi(2);
        let f = (-2.0 * (0.5 * psi).tan().min(1e8)).exp();
        let phase_fraction = psi / PI;
        // The formulas distinguish the larger and the smaller angle of the two.
        let share = |e1_large: f64, e1_small: f64| 2.0 - e1_large - phase_fraction * e1_small;
        let (mu_e, mu0_e, shadowing);
        if mu0 >= mu {
            let denominator = share(e1_e, e1_i);
            mu0_e = chi * (mu0 + sin_i * tan * (cos_psi * e2_e + half * e2_i) / denominator);
            mu_e = chi * (mu + sin_e * tan * (e2_e - half * e2_i) / denominator);
            shadowing = mu_e / eta_e * (mu0 / eta_i) * chi / (1.0 - f + f * chi * mu0 / eta_i);
        } else {
            let denominator = share(e1_i, e1_e);
            mu0_e = chi * (mu0 + sin_i * tan * (e2_i - half * e2_e) / denominator);
            mu_e = chi * (mu + sin_e * tan * (cos_psi * e2_i + half * e2_e) / denominator);
            shadowing = mu_e / eta_e * (mu0 / eta_i) * chi / (1.0 - f + f * chi * mu / eta_e);
        }
        [mu_e, mu0_e, shadowing]
    }
}
