//! Photometry of bodies of any shape by facets: triangles of which others hide parts, computed exactly.
//!
//! On a facet mu and mu0 are constant, so that its brightness is that of a surface element times the area
//! that is both visible and illuminated. A point is hidden along a direction d where the ray from it enters
//! the facet's own polyhedron again, through a facet with n.d < 0, or leaves another part or body, through
//! one with n.d > 0: parts may overlap, and a point within another one is hidden. The part of such a facet
//! that lies in front of the first one's plane is projected along d and subtracted from it.
//! Where facets of two parts lie in one plane, that of the part that comes first hides that of the other one,
//! so that the common area counts once.
//!
//! A part that is wholly in front of a triangle hides what is within its silhouette, along which the triangle is
//! cut.
//!
//! Most facets need none of this: those that are turned away, those whose direction is above their horizon,
//! those beside the cylinder around each other part, and those behind the ball within it.
//!
//! Where an ellipsoid hides light, it has the facets of a subdivided icosahedron, scaled so that for a sphere
//! they have its area. Where light is hidden from an ellipsoid, its lune is divided into cells, whose unhidden
//! share multiplies the exact brightness. The errors fall with the square of the facets'
//! size.

use super::ellipsoid::{EllipsoidPose, LitEllipsoid};
use super::law::{Law, Scattering};
use super::mesh::{Facet, Mesh, Precedence, SIDES};
use super::region::{Line, Region};
use super::silhouette::{Hidden, Silhouette};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3};
use crate::shape::Horizons;

/// The number of facets between two interrupt checks.
const GROUP: usize = 512;
/// Units of work of a facet of which a part may be hidden.
const WORK: u64 = 20;

/// A part that may hide light from another one.
#[derive(Debug)]
pub struct Occluder<'a> {
    pub mesh: &'a Mesh,
    /// The light that it hides, by its index in the lights of the other part.
    pub light: usize,
    /// The pose (position and rotation R) and the growth of this part in the frame of the other one: a point y
    /// of this part is at x = growth R y + position.
    pub position: Vec3,
    pub rotation: Mat3,
    pub growth: f64,
    /// Which facets count where some of this part and some of the other one lie in one plane.
    pub precedence: Precedence,
    /// The silhouette of this part along the direction to the light; `None` if this part is in front of no
    /// facet of the other one.
    pub silhouette: Option<Silhouette>,
}

/// A part in sunlight, with the parts that may hide light from it, in its own frame.
#[derive(Debug)]
pub struct FacetedPart<'a, const L: usize = 2> {
    pub mesh: &'a Mesh,
    pub horizons: Option<&'a Horizons>,
    /// The rotation from its frame to the inertial one, and unit vectors to the lights: to the observer and to the
    /// Sun, or to the Sun alone.
    pub rotation: Mat3,
    pub lights: [Vec3; L],
    pub occluders: Vec<Occluder<'a>>,
}

/// A law at an epoch, with the albedo of a body: one number, or one for each facet.
#[derive(Debug)]
pub struct SurfaceLight<'a> {
    pub law: &'a Law,
    pub scattering: Scattering,
    pub albedo: &'a [f64],
    pub time: f64,
}

impl SurfaceLight<'_> {
    /// Returns the brightness of a facet per area at its cosines of emission and incidence; `out_of_plane` is
    /// the component of its normal along e x s.
    #[inline]
    pub fn per_area(&self, index: usize, [mu, mu0]: [f64; 2], out_of_plane: f64) -> f64 {
        let albedo = self.albedo.get(index).unwrap_or(&self.albedo[0]);
        mu * mu0 / (mu + mu0) * self.scattering.factor(mu, mu0, out_of_plane) * albedo
    }

    /// Returns the brightness of a facet of a smooth surface per area, and its derivatives with respect to the
    /// cosines of emission and incidence and to the phase angle.
    #[inline]
    pub fn per_area_with_partials(&self, index: usize, [mu, mu0]: [f64; 2]) -> [f64; 4] {
        let albedo = self.albedo.get(index).unwrap_or(&self.albedo[0]);
        let [factor, by_mu, by_mu0, phase] =
            self.scattering.factor_with_partials(mu, mu0).map(|value| value * albedo);
        let (lommel_seeliger, [share, share0]) = (mu * mu0 / (mu + mu0), [mu0, mu].map(|x| x / (mu + mu0)));
        [
            lommel_seeliger * factor,
            share * share * factor + lommel_seeliger * by_mu,
            share0 * share0 * factor + lommel_seeliger * by_mu0,
            lommel_seeliger * phase,
        ]
    }
}

impl<'a> Occluder<'a> {
    /// Makes the occluder for a part, given the pose and the growth of the occluding mesh in the part's frame, and
    /// the index of the light with a unit vector to it in that frame; `None` if it hides nothing of the part.
    pub fn new(
        part: &Mesh,
        mesh: &'a Mesh,
        (position, rotation): (Vec3, Mat3),
        growth: f64,
        light: usize,
        direction: &Vec3,
    ) -> Option<Self> {
        let along = position.dot(direction);
        let aside = (position - direction * along).norm();
        let reach = mesh.radii[0] * growth;
        if aside >= part.radii[0] + reach || along <= -(part.radii[0] + reach) {
            return None;
        }
        let silhouette = (along + part.radii[0] > reach)
            .then(|| Silhouette::new(mesh, (&position, &rotation), growth, direction));
        let is_before = mesh.indices < part.indices;
        let precedence = if is_before { Precedence::Before } else { Precedence::After };
        Some(Self { mesh, light, position, rotation, growth, precedence, silhouette })
    }

    /// Returns which part of a triangle the facets hide, and sets the edges of the region to those of the silhouette
    /// that cross the triangle; their lines are counted from `line`.
    fn hidden_part(&self, triangle: &Facet, direction: &Vec3, line: Line, region: &mut Region) -> Hidden {
        let [a, b, c] = triangle.corners;
        let centre = (a + b + c) / 3.0;
        let radius = triangle.corners.iter().map(|v| (v - centre).norm_squared()).fold(0.0, f64::max).sqrt();
        let from = self.position - centre;
        let along = from.dot(direction);
        let aside = (from - direction * along).norm();
        let [reach, within] = self.mesh.radii.map(|r| r * self.growth);
        if aside + radius < within && along > radius {
            return Hidden::Everything;
        }
        if aside >= reach + radius || along <= -(reach + radius) {
            return Hidden::Nothing;
        }
        match &self.silhouette {
            // The ball around the facets is in front of that around the triangle.
            Some(silhouette) if along > (1.0 + 1e-9) * (reach + radius) => {
                silhouette.hidden_part(triangle, triangle.normal.dot(direction), line, region)
            }
            _ => Hidden::ByFacets,
        }
    }

    /// Subtracts from a region of a triangle the part that the facets hide; their lines are counted from `line`.
    fn hide(&self, triangle: &Facet, direction: &Vec3, line: Line, region: &mut Region) {
        let back = |v: Vec3| self.rotation.tr_mul(&v);
        let corners = triangle.corners.map(|v| back(v - self.position) / self.growth);
        let searched = None::<std::iter::Empty<u32>>;
        self.mesh.hide(&Facet::new(corners), &back(*direction), self.precedence, line, searched, region);
    }
}

impl<const L: usize> FacetedPart<'_, L> {
    /// Sets the region to the part of a triangle that no occluder hides. The triangle is the facet with this index
    /// or, without one, a cell. Returns whether a part of it may be hidden; otherwise the region is not set.
    pub fn clip(&self, triangle: &Facet, facet: Option<(usize, [f64; L])>, region: &mut Region) -> bool {
        let mut partly = false;
        if let (Some(horizons), Some((index, cosines))) = (self.horizons, facet) {
            for (light, direction) in self.lights.iter().enumerate() {
                if let Some(elevation) = horizons.below(index, direction, cosines[light]) {
                    if !partly {
                        region.reset();
                        partly = true;
                    }
                    let line = self.first_line(self.occluders.len() + light);
                    let candidates = horizons.hiding(index, elevation);
                    self.mesh.hide(triangle, direction, Precedence::SamePart, line, candidates, region);
                    if region.is_empty() {
                        return true;
                    }
                }
            }
        }
        let mut next_line = self.first_line(0);
        for occluder in &self.occluders {
            let direction = &self.lights[occluder.light];
            let line = next_line;
            next_line += SIDES * occluder.mesh.facets.len() as Line;
            let hidden = occluder.hidden_part(triangle, direction, line, region);
            if hidden == Hidden::Nothing {
                continue;
            }
            if !partly {
                region.reset();
                partly = true;
            }
            match (hidden, &occluder.silhouette) {
                (Hidden::Everything, _) => region.clear(),
                (Hidden::BySilhouette, Some(silhouette)) => silhouette.hide(triangle, region),
                _ => occluder.hide(triangle, direction, line, region),
            }
            if region.is_empty() {
                return true;
            }
        }
        partly
    }

    /// Returns the number of the first line of an occluder. The numbers after those of all occluders belong to
    /// the part itself, for each light.
    fn first_line(&self, occluder: usize) -> Line {
        let previous = self.occluders[..occluder.min(self.occluders.len())].iter();
        let facets = previous.map(|other| other.mesh.facets.len()).sum::<usize>()
            + (occluder.saturating_sub(self.occluders.len())) * self.mesh.facets.len();
        3 + SIDES * facets as Line
    }
}

impl FacetedPart<'_> {
    /// Returns the brightness of the part; if W is four, then the sums of it times the coordinates of the point, in
    /// the part's frame.
    pub fn light<const W: usize>(
        &self,
        surface: &SurfaceLight<'_>,
        interrupt: &mut InterruptCheck,
    ) -> Result<[f64; W]> {
        if self.mesh.polyhedron.is_none() {
            return self.ellipsoid(surface, interrupt);
        }
        let [e, s] = &self.lights;
        let across = e.cross(s);
        let (mut region, mut total, mut remaining) = (Region::default(), [0.0; W], GROUP);
        for (index, facet) in self.mesh.facets.iter().enumerate() {
            remaining -= 1;
            if remaining == 0 {
                interrupt.charge(GROUP as u64, surface.time)?;
                remaining = GROUP;
            }
            let mu = facet.normal.dot(e);
            if mu <= 0.0 {
                continue;
            }
            let mu0 = facet.normal.dot(s);
            if mu0 <= 0.0 {
                continue;
            }
            let brightness = surface.per_area(index, [mu, mu0], across.dot(&facet.normal)) * facet.area;
            let partly = self.clip(facet, Some((index, [mu, mu0])), &mut region);
            if partly {
                interrupt.charge(WORK, surface.time)?;
            }
            let shares = shares::<W>(facet, partly.then_some(&region));
            total.iter_mut().zip(shares).for_each(|(sum, share)| *sum += brightness * share);
        }
        Ok(total)
    }

    /// Returns the light of an ellipsoid: its exact brightness times the unhidden share of its cells.
    fn ellipsoid<const W: usize>(
        &self,
        surface: &SurfaceLight<'_>,
        interrupt: &mut InterruptCheck,
    ) -> Result<[f64; W]> {
        let pose = EllipsoidPose {
            body: 0,
            semi_axes: self.mesh.semi_axes,
            position: Vec3::zeros(),
            rotation: Mat3::identity(),
        };
        let lit = LitEllipsoid::new(&pose, surface.law, surface.time, self.lights, std::iter::empty());
        let unhidden = lit.light::<W>(interrupt)?.map(|sum| surface.albedo[0] * sum);
        if self.occluders.is_empty() {
            return Ok(unhidden);
        }
        let (mut region, mut all, mut left) = (Region::default(), [0.0; W], [0.0; W]);
        for (cell, brightness) in lit.cells() {
            interrupt.charge(WORK, surface.time)?;
            let partly = self.clip(&cell, None, &mut region);
            for (sums, region) in [(&mut all, None), (&mut left, partly.then_some(&region))] {
                let shares = shares::<W>(&cell, region);
                sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += brightness * share);
            }
        }
        if all[0] <= 0.0 {
            return Ok([0.0; W]);
        }
        // The cells give the centre of the unhidden part relative to that of the ellipsoid without occluders.
        let share = left[0] / all[0];
        let moment = |k: usize| unhidden[k] * share + unhidden[0] / all[0] * (left[k] - all[k] * share);
        Ok(std::array::from_fn(|k| if k == 0 { unhidden[0] * share } else { moment(k) }))
    }
}

/// Returns the share of a triangle within a region, all of it without a region; if W is four, then the sums of it times
/// the coordinates.
pub fn shares<const W: usize>(triangle: &Facet, region: Option<&Region>) -> [f64; W] {
    if W == 1 {
        return [region.map_or(1.0, Region::share); W];
    }
    let [a, b, c] = &triangle.corners;
    let [share, u, v] = region.map_or([1.0, 1.0 / 3.0, 1.0 / 3.0], Region::moments);
    let moment = a * share + (b - a) * u + (c - a) * v;
    let all = [share, moment.x, moment.y, moment.z];
    std::array::from_fn(|k| all[k])
}
