//! The brightness of a convex body by the areas and normals of its facets, of which none hides another.
//!
//! With n_i the normals and A_i the areas, the brightness is the sum of A_i mu mu0 / (mu + mu0) T(mu, mu0) over
//! the facets with mu = n_i.e > 0 and mu0 = n_i.s > 0 (Kaasalainen & Torppa 2001, Icarus 153, 24): it is linear
//! in the areas, and needs no vertices.

use super::ellipsoid::Partials;
use super::facets::SurfaceLight;
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3};
use crate::shape::Facets;

/// Units of work of a facet.
const WORK: u64 = 1;

/// A convex body in sunlight.
pub struct ConvexBody<'a> {
    pub body: usize,
    pub facets: &'a Facets,
    pub surface: SurfaceLight<'a>,
    /// The rotation from the body frame to the inertial one, and unit vectors to the observer and to the Sun in
    /// the body frame.
    pub rotation: Mat3,
    pub lights: [Vec3; 2],
}

impl ConvexBody<'_> {
    /// Iterates over the indices, normals and areas of the facets that are visible and illuminated, with the
    /// cosines of emission and incidence.
    fn lit(&self) -> impl Iterator<Item = (usize, &Vec3, f64, [f64; 2])> {
        let facets = self.facets.normals().iter().zip(self.facets.areas()).enumerate();
        facets.filter_map(|(index, (normal, area))| {
            let cosines = self.lights.map(|light| normal.dot(&light));
            cosines.iter().all(|cosine| *cosine > 0.0).then_some((index, normal, *area, cosines))
        })
    }

    /// Returns the brightness.
    pub fn brightness(&self, interrupt: &mut InterruptCheck) -> Result<f64> {
        interrupt.charge(WORK * self.facets.areas().len() as u64, self.surface.time)?;
        let across = self.lights[0].cross(&self.lights[1]);
        let light = self.lit().map(|(index, normal, area, cosines)| {
            area * self.surface.per_area(index, cosines, across.dot(normal))
        });
        Ok(light.sum())
    }

    /// Returns the brightness and adds its derivatives to `partials`.
    pub fn partials(&self, partials: &mut Partials, interrupt: &mut InterruptCheck) -> Result<f64> {
        interrupt.charge(WORK * self.facets.areas().len() as u64, self.surface.time)?;
        let (mut total, mut by_phase, mut by_light) = (0.0, 0.0, [Vec3::zeros(); 2]);
        for (index, normal, area, cosines) in self.lit() {
            let [per_area, by_mu, by_mu0, phase] = self.surface.per_area_with_partials(index, cosines);
            total += per_area * area;
            by_phase += phase * area;
            by_light[0] += normal * (by_mu * area);
            by_light[1] += normal * (by_mu0 * area);
            if let Some(by_area) = partials.by_area.get_mut(self.body) {
                by_area[index] += per_area;
            }
        }
        let [e, s] = self.lights;
        let sin = e.cross(&s).norm();
        if sin > 0.0 {
            by_light[0] -= s * (by_phase / sin);
            by_light[1] -= e * (by_phase / sin);
        }
        for (k, by_light) in by_light.iter().enumerate() {
            // A rotation by phi changes a direction d in the body frame to d + d x phi.
            partials.by_body[self.body].rotation += by_light.cross(&self.lights[k]);
            partials.by_direction[k] += self.rotation * by_light;
        }
        Ok(total)
    }
}
