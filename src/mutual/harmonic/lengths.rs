//! The derivatives of force and torques by the harmonic series with respect to the lengths of both bodies:
//! the semi-axes of an ellipsoid, or the scale of a polyhedron.

use super::{Harmonic, Lengths, Truncation};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::exchange::Exchange;
use crate::mutual::{Pose, ShapeDerivatives};

impl Harmonic {
    /// Prepares [`Self::shape_derivatives`] for the current truncation of the series. Unless the truncation
    /// is fixed, it follows from a tolerance, and the derivatives need two more degrees.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`].
    pub fn prepare_lengths(
        &mut self,
        truncation: &Truncation,
        is_fixed: bool,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        // A sphere has the moment of degree 0 alone, but its derivatives by the semi-axes are of degree 2.
        let extra_degrees = if is_fixed { 0 } else { 2 };
        let degrees = truncation.degrees.map(|degree| (degree + extra_degrees).min(Exchange::MAX_DEGREE));
        if self.lengths.as_ref().is_some_and(|lengths| lengths.truncation.degrees == degrees) {
            return Ok(());
        }
        let [first, second] = &self.moments;
        let moments = [
            first.to_degree(degrees[0], self.arch, interrupt)?,
            second.to_degree(degrees[1], self.arch, interrupt)?,
        ];
        let derivatives = [0, 1].map(|body| moments[body].by_lengths(degrees[body], self.arch));
        let truncation = match is_fixed {
            true => truncation.clone(),
            false => Truncation::new(degrees, degrees[0] + degrees[1], 0.0),
        };
        self.lengths = Some(Box::new(Lengths { moments, derivatives, truncation }));
        self.extend_tables(degrees);
        Ok(())
    }

    /// Returns the derivatives of force and torques with respect to the lengths of both bodies; zeros before
    /// [`Self::prepare_lengths`].
    pub fn shape_derivatives(&self, pose: &Pose) -> ShapeDerivatives {
        let mut result = ShapeDerivatives::ZERO;
        let Some(lengths) = &self.lengths else { return result };
        let Lengths { moments, derivatives, truncation } = &**lengths;
        for body in 0..2 {
            let interaction_with = |derivative: &Vec<f64>| {
                let mut values = [0, 1].map(|k| moments[k].values.as_slice());
                let mut radii = self.radii();
                (values[body], radii[body]) = (derivative, moments[body].circumradius);
                self.interaction_of(values, radii, truncation, pose)
            };
            match derivatives[body].as_slice() {
                [a, b, c] => {
                    result.axes[body] = [interaction_with(a), interaction_with(b), interaction_with(c)]
                }
                [scale] => result.scale[body] = interaction_with(scale),
                _ => {}
            }
        }
        result
    }
}
