//! Kepler's equation: from the mean anomaly to the eccentric one, and back.
//!
//! Takes the eccentricity e != 1, and |1 - e| separately, which may be known to more digits than e near 1 can
//! represent. Gives sines and cosines of the eccentric anomaly E (ellipse) or H (hyperbola). Both equations
//! are written as sums of positive terms,
//!
//!   M = (1 - e) E + e (E - sin E),     M = (e - 1) sinh H + (sinh H - H),
//!
//! so that nothing cancels near periapsis when e is near 1. The hyperbolic equation is solved for sinh H: far
//! out, H itself is too coarse a number (one unit of its last place is 1e-13 of the distance at H = 500).

use crate::error::{Error, Result, require_finite};
use std::f64::consts::{PI, TAU};

/// The difference of 2 pi and the double nearest to it.
const TAU_LOW: f64 = 2.449_293_598_294_706_4e-16;

/// The eccentric anomaly of a point on an ellipse or a hyperbola, with functions of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct EccentricAnomaly {
    /// The anomaly: E in [-pi, pi], or H.
    pub(super) anomaly: f64,
    /// The value sin E or sinh H.
    pub(super) sine: f64,
    /// The value cos E or cosh H.
    pub(super) cosine: f64,
    /// The value 1 - cos E or cosh H - 1, without their cancellation.
    pub(super) versine: f64,
}

impl EccentricAnomaly {
    /// Solves Kepler's equation for any finite mean anomaly.
    pub(super) fn from_mean(mean: f64, eccentricity: f64) -> Result<Self> {
        require_finite("mean anomaly", &[mean])?;
        let gap = (1.0 - eccentricity).abs();
        if eccentricity < 1.0 {
            // sin and cos reduce a large angle modulo the exact 2 pi; a remainder by the double TAU would
            // not.
            let nearest = if mean.abs() <= PI { mean } else { mean.sin().atan2(mean.cos()) };
            let anomaly = elliptic(nearest.abs(), eccentricity, gap)?.copysign(nearest);
            let half = (0.5 * anomaly).sin();
            Ok(Self { anomaly, sine: anomaly.sin(), cosine: anomaly.cos(), versine: 2.0 * half * half })
        } else {
            let sine = hyperbolic(mean.abs(), eccentricity, gap)?.copysign(mean);
            let (anomaly, cosine) = (sine.asinh(), sine.hypot(1.0));
            require_finite("hyperbolic anomaly", &[anomaly])?;
            Ok(Self { anomaly, sine, cosine, versine: sine * (sine / (1.0 + cosine)) })
        }
    }
}

/// Returns the mean anomaly M for E in [-pi, pi] on an ellipse with 1 - e = `gap`.
pub(super) fn elliptic_mean(anomaly: f64, eccentricity: f64, gap: f64) -> f64 {
    gap * anomaly + eccentricity * cubic_and_higher(anomaly, -1.0)
}

/// Returns the mean anomaly M for sinh H on a hyperbola with e - 1 = `gap`.
pub(super) fn hyperbolic_mean(sine: f64, gap: f64) -> f64 {
    let anomaly = sine.asinh();
    let beyond = if anomaly.abs() <= PI { cubic_and_higher(anomaly, 1.0) } else { sine - anomaly };
    gap * sine + beyond
}

/// Reduces an angle to [0, 2 pi); a result that would round to 2 pi becomes 0.
pub(super) fn wrapped(angle: f64) -> f64 {
    let revolutions = (angle / TAU).floor();
    let inside = revolutions.mul_add(-TAU, revolutions.mul_add(-TAU_LOW, angle));
    // Adding zero turns -0 into 0.
    if (0.0..TAU).contains(&inside) { inside + 0.0 } else { 0.0 }
}

/// Returns E in [0, pi] for M in [0, pi].
fn elliptic(mean: f64, eccentricity: f64, gap: f64) -> Result<f64> {
    // An upper bound follows from e (E - sin E) <= M and from E - sin E >= E^3 / pi^2 up to E = pi.
    let above = (mean / gap).min((PI * PI * mean / eccentricity).cbrt()).min(mean + eccentricity);
    root_from_above(mean, above, |x| {
        let half = (0.5 * x).sin();
        Curve {
            value: elliptic_mean(x, eccentricity, gap),
            slope: gap + eccentricity * (2.0 * half * half),
            curvature: eccentricity * x.sin(),
        }
    })
}

/// Returns sinh H for M >= 0.
fn hyperbolic(mean: f64, eccentricity: f64, gap: f64) -> Result<f64> {
    // An upper bound follows from e sinh H = M + H and from H^3 / 6 <= sinh H - H <= M / e.
    let above = (mean / gap).min((mean + (6.0 * mean / eccentricity).cbrt()) / eccentricity);
    root_from_above(mean, above, |x| {
        let cosine = x.hypot(1.0);
        Curve {
            value: hyperbolic_mean(x, gap),
            slope: gap + (x / cosine) * (x / (1.0 + cosine)),
            curvature: x / cosine / cosine / cosine,
        }
    })
}

/// A function with its first two derivatives at a point.
struct Curve {
    value: f64,
    slope: f64,
    curvature: f64,
}

/// Returns the root of curve(x) = `target` in [0, `above`], where the curve rises from 0 and bends upwards.
///
/// Each iteration takes Halley's step where it stays between the bounds known so far, and halves the interval
/// otherwise.
fn root_from_above(target: f64, above: f64, curve: impl Fn(f64) -> Curve) -> Result<f64> {
    const LIMIT: usize = 100;
    if target == 0.0 {
        return Ok(0.0);
    }
    let (mut low, mut high, mut x) = (0.0, above, above);
    for _ in 0..LIMIT {
        let Curve { value, slope, curvature } = curve(x);
        let residual = value - target;
        if residual > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let newton = residual / slope;
        let next = x - newton / (1.0 - 0.5 * newton * (curvature / slope));
        // The error falls with the cube of the step: after a step this short the next one would be round-off.
        if (next - x).abs() <= 1e-8 * x {
            return Ok(next);
        }
        if low < next && next < high {
            x = next;
        } else {
            x = 0.5 * (low + high);
            if x == low || x == high {
                return Ok(x);
            }
        }
    }
    Err(Error::NotConverged {
        what: "Kepler's equation".into(),
        detail: format!("mean anomaly {target:e} after {LIMIT} steps"),
    })
}

/// Returns x - sin x (`sign` = -1) or sinh x - x (`sign` = 1) for |x| <= pi, accurate to the last digits for
/// small x too.
fn cubic_and_higher(x: f64, sign: f64) -> f64 {
    let square = sign * x * x;
    // The series is x^3/3! (1 + square/(4 5) (1 + square/(6 7) (...))). Its term with 29! is below 1e-17 at x
    // = pi.
    let mut tail = 1.0;
    for k in (2..=14).rev() {
        let n = f64::from(2 * k);
        tail = 1.0 + square / (n * (n + 1.0)) * tail;
    }
    x * x * x / 6.0 * tail
}
