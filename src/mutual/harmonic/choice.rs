//! The choice of the degrees of a pair's series, made between steps.

use super::{FIRST_DEGREE, Harmonic, Truncation};
use crate::error::{Error, Result};
use crate::interrupt::InterruptCheck;
use crate::math::exchange::Exchange;
use crate::mutual::{Method, Pair};
use crate::shape::Shape;

/// The fractions of the smallest predicted separation for which degrees are chosen; the second is tried where
/// no degree suffices at the first.
const MARGINS: [f64; 2] = [0.95, 0.999];
/// The largest ratio of a separation to that for which degrees were chosen, up to which these stay in use.
const REUSED_TO: f64 = 1.15;
/// Beside a point, the field of a polyhedron of fewer faces is cheaper than the series.
const FEW_FACES: usize = 200;

impl Pair {
    /// Chooses the degrees of the series for a separation, and for all separations down to `reach`. Returns
    /// whether the series is used.
    ///
    /// # Errors
    /// [`Error::NotConverged`] where the method is a series that does not converge or whose highest degree
    /// does not reach the tolerance, and [`Error::Interrupted`].
    pub(in crate::mutual) fn prepare_series(
        &mut self,
        separation: f64,
        reach: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<bool> {
        let total = match self.method {
            Method::Multipole(degree) => Some(degree),
            _ => None,
        };
        let has = |is_kind: fn(&Shape) -> bool| self.bodies.iter().any(|body| is_kind(&body.shape));
        let only_series = self.method == Method::Harmonic || has(|shape| matches!(shape, Shape::Stokes(_)));
        if total.is_none() && !only_series && !self.gains_by_series() {
            return Ok(false);
        }
        // The polynomials of a total degree in the semi-axes are defined wherever two ellipsoids are apart.
        let always =
            total.is_some() && !has(|shape| matches!(shape, Shape::Stokes(_) | Shape::Polyhedron(_)));
        if let Some(truncation) = &self.truncation {
            let reusable = truncation.valid_from..REUSED_TO * truncation.valid_from;
            if reusable.contains(&reach) || (self.has_fixed_degrees() && separation > truncation.valid_from) {
                return Ok(true);
            }
        }
        let mut harmonic = match self.harmonic.take() {
            Some(harmonic) => harmonic,
            None => self.make_series([FIRST_DEGREE; 2], interrupt)?,
        };
        let from = if always { 0.0 } else { harmonic.converges_from() };
        let chosen = match (total, self.fixed) {
            _ if separation <= from => None,
            (Some(total), _) => {
                // Two degrees more estimate the truncation error.
                harmonic.extend([total + 2; 2], interrupt)?;
                Some(Truncation::new([total; 2], total, from))
            }
            (None, Some(order)) => {
                harmonic.extend([order.gauss; 2], interrupt)?;
                Some(Truncation::new([order.gauss; 2], 2 * order.gauss, from))
            }
            (None, None) => {
                let mut chosen = None;
                for margin in MARGINS {
                    if chosen.is_none() && margin * reach > from {
                        chosen = harmonic.truncation(margin * reach, self.tolerance, interrupt)?;
                    }
                }
                chosen.or_else(|| harmonic.complete())
            }
        };
        self.harmonic = Some(harmonic);
        self.truncation = chosen;
        if self.truncation.is_some() {
            self.rule = None;
            return Ok(true);
        }
        if total.is_none() && !only_series {
            return Ok(false);
        }
        let detail = if separation <= from {
            format!(
                "at separation {} the series of their moments diverges: it takes {}, the sum of the radii of \
                 the spheres that contain them",
                separation * self.unit,
                from * self.unit
            )
        } else {
            format!(
                "at separation {} degrees up to {} do not reach the tolerance {:e}; use a larger \
                 gravity_tolerance or gravity=\"focal\"",
                separation * self.unit,
                Exchange::MAX_DEGREE,
                self.tolerance
            )
        };
        let what = format!("{} between {} and {}", self.method, self.bodies[0].name, self.bodies[1].name);
        Err(Error::NotConverged { what, detail })
    }

    /// Puts degrees from an archive in use again, with moments up to the degrees that were known.
    pub(in crate::mutual) fn restore_series(
        &mut self,
        degrees: [usize; 2],
        moment_degrees: [usize; 2],
        valid_from: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let mut harmonic = self.make_series(moment_degrees, interrupt)?;
        harmonic.extend(degrees, interrupt)?;
        let total = match self.method {
            Method::Multipole(degree) => degree,
            _ => degrees[0] + degrees[1],
        };
        self.truncation = Some(Truncation::new(degrees, total, valid_from));
        self.harmonic = Some(harmonic);
        Ok(())
    }

    fn make_series(&self, degrees: [usize; 2], interrupt: &mut InterruptCheck) -> Result<Harmonic> {
        Harmonic::new([&self.bodies[0].shape, &self.bodies[1].shape], degrees, self.arch, interrupt)
    }

    pub(in crate::mutual) fn has_fixed_degrees(&self) -> bool {
        self.fixed.is_some() || matches!(self.method, Method::Multipole(_))
    }

    /// Returns whether the series is cheaper than the rules over faces, wherever it reaches the tolerance.
    fn gains_by_series(&self) -> bool {
        let faces = |k: usize| self.bodies[k].polyhedron().map_or(0, |polyhedron| polyhedron.faces().len());
        let is_spherical = |k: usize| faces(k) == 0 && self.bodies[k].focal_axes()[0] == 0.0;
        let is_small = |k: usize| is_spherical(k) && faces(1 - k) < FEW_FACES;
        self.method == Method::Focal
            && self.fixed.is_none()
            && (faces(0) > 0 || faces(1) > 0)
            && !is_small(0)
            && !is_small(1)
    }
}
