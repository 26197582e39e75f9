//! Potential and field of one body at single points, with the checks that a caller from outside needs.

use super::{FarSeries, FieldKernel, Near};
use crate::error::{Error, Result, require_finite};
use crate::math::Vec3;
use crate::math::lanes::Lanes;
use crate::shape::{Body, Shape};
use pulp::Scalar;

/// A body's exterior gravity in its own frame.
#[derive(Debug, Clone)]
pub struct ExteriorField {
    body: Body,
    gm: f64,
    series: FarSeries,
}

impl ExteriorField {
    /// For a body and a gravitational constant.
    pub fn new(body: &Body, gravitational_constant: f64) -> Self {
        Self {
            body: body.clone(),
            gm: gravitational_constant * body.mass,
            series: FarSeries::new(&body.shape),
        }
    }

    /// Phi (positive) at a point of the body frame, outside or on the surface.
    pub fn potential(&self, point: &Vec3) -> Result<f64> {
        Ok(self.evaluate(point)?.0)
    }

    /// g = grad Phi at a point of the body frame, outside or on the surface.
    pub fn field(&self, point: &Vec3) -> Result<Vec3> {
        Ok(self.evaluate(point)?.1)
    }

    fn evaluate(&self, point: &Vec3) -> Result<(f64, Vec3)> {
        require_finite("point", point.as_slice())?;
        let (kernel, x, canonical) = match &self.body.shape {
            Shape::Point => (None, *point, crate::math::Mat3::identity()),
            Shape::Ellipsoid(e) => {
                let gauge = point.component_div(&Vec3::from(e.semi_axes())).norm_squared();
                // Points meant to lie on the surface may round to just inside it.
                if gauge < 1.0 - 1e-12 {
                    return Err(Error::invalid(
                        format!("point in the field of {}", self.body.name),
                        format!("{point:?}"),
                        "a point outside or on the surface",
                    ));
                }
                (Some(Near::new(e, 0.0)), e.canonical() * point, e.canonical())
            }
        };
        if point.norm() == 0.0 {
            return Err(Error::invalid("point", "at the centre of a point mass", "a point elsewhere"));
        }
        let kappa_min = x.norm_squared() - self.body.shape.circumradius().powi(2);
        let (excess, rd) = match (self.series.cut_for(kappa_min, 1e-17), kernel) {
            (Some(cut), _) => one_point(self.series.cut(cut), &x),
            (None, Some(near)) => one_point(near, &x),
            (None, None) => unreachable!("a point mass has a series of one term"),
        };
        let field = canonical.transpose() * -x.component_mul(&rd);
        Ok((self.gm * (1.0 / x.norm() + excess), self.gm * field))
    }
}

fn one_point(kernel: impl FieldKernel, x: &Vec3) -> (f64, Vec3) {
    let lanes = |v| Lanes::splat(Scalar, v);
    let (excess, rd) = kernel.excess_potential([lanes(x.x), lanes(x.y), lanes(x.z)]);
    (excess.first(), Vec3::new(rd[0].first(), rd[1].first(), rd[2].first()))
}
