//! Derivatives of the brightness of facets with respect to the corners of all facets and the directions.
//!
//! Let K be the brightness of a facet per area, n its normal and A its unhidden area. Where the corners
//! a_i move by da_i, the facet turns by dn = -sum grad(l_i) (n.da_i), l_i the shares of the corners in a point
//! of the facet, which changes mu, mu0 and K. A side of the unhidden area, from x to x', moves by dx in its middle,
//! and the area changes by N.dx, N = (x' - x) cross n. On a side of the facet dx is that of its corners. On
//! the shadow of a side with the point P, x = P - h d, and with v = N - (N.d / mu) n
//!
//!   N.dx = v.(dP - h dd) + (N.d / mu) n.(sum l_i da_i).
//!
//! Where two facets meet, x stays in both planes. Sides that two pieces share cancel.

use super::facets::{FacetedPart, SurfaceLight};
use super::mesh::{Facet, SIDES};
use super::region::{Corner, Region, sides};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;

/// Units of work of a facet with derivatives.
const WORK: u64 = 40;

/// Derivatives of the brightness of a part.
#[derive(Debug)]
pub struct FacetGradient {
    /// Derivatives with respect to the vertices of the part, in its frame.
    pub vertices: Vec<Vec3>,
    /// Derivatives with respect to the vertices of each occluder, in the frame of the occluder.
    pub occluders: Vec<Vec<Vec3>>,
    /// Derivatives with respect to the directions to the observer and to the Sun, in the part's frame.
    pub lights: [Vec3; 2],
}

/// A partly hidden facet, and its brightness per area.
struct LitFacet<'a> {
    facet: &'a Facet,
    face: [usize; 3],
    per_area: f64,
}

impl FacetedPart<'_> {
    /// Returns the brightness of the part, a polyhedron with a smooth surface, with its derivatives.
    pub fn partials(
        &self,
        surface: &SurfaceLight<'_>,
        interrupt: &mut InterruptCheck,
    ) -> Result<(f64, FacetGradient)> {
        let zeros = |vertices: usize| vec![Vec3::zeros(); vertices];
        let mut gradient = FacetGradient {
            vertices: zeros(self.mesh.vertices.len()),
            occluders: self.occluders.iter().map(|other| zeros(other.mesh.vertices.len())).collect(),
            lights: [Vec3::zeros(); 2],
        };
        let [e, s] = self.lights;
        let (mut region, mut total, mut by_phase) = (Region::default(), 0.0, 0.0);
        for (index, facet) in self.mesh.facets.iter().enumerate() {
            interrupt.charge(1, surface.time)?;
            let [mu, mu0] = [e, s].map(|d| facet.normal.dot(&d));
            if mu <= 0.0 || mu0 <= 0.0 {
                continue;
            }
            interrupt.charge(WORK, surface.time)?;
            let partly = self.clip(facet, Some((index, [mu, mu0])), &mut region);
            let left = facet.area * if partly { region.share() } else { 1.0 };
            let [per_area, by_mu, by_mu0, phase] = surface.per_area_with_partials(index, [mu, mu0]);
            total += per_area * left;
            by_phase += phase * left;
            let face = self.mesh.faces[index].map(|v| v as usize);
            let by_normal = e * by_mu + s * by_mu0;
            gradient.lights[0] += facet.normal * (by_mu * left);
            gradient.lights[1] += facet.normal * (by_mu0 * left);
            let [a, b, c] = facet.corners;
            for (vertex, across) in face.into_iter().zip([c - b, a - c, b - a]) {
                let slope = facet.normal.cross(&across) / (2.0 * facet.area);
                gradient.vertices[vertex] -= facet.normal * (left * slope.dot(&by_normal));
                if !partly {
                    gradient.vertices[vertex] += slope * (per_area * left);
                }
            }
            if partly {
                let lit = LitFacet { facet, face, per_area };
                region.pieces().flat_map(sides).for_each(|side| self.add_side(&lit, side, &mut gradient));
            }
        }
        let sin = e.cross(&s).norm();
        if sin > 0.0 {
            gradient.lights[0] -= s * (by_phase / sin);
            gradient.lights[1] -= e * (by_phase / sin);
        }
        Ok((total, gradient))
    }

    /// Adds the derivatives that follow from the shift of one side of the unhidden area of a facet.
    fn add_side(&self, lit: &LitFacet<'_>, (from, to): (&Corner, &Corner), gradient: &mut FacetGradient) {
        let LitFacet { facet, face, per_area } = lit;
        let (normal, [a, b, c]) = (&facet.normal, facet.corners);
        let [x, y] = [from, to].map(|corner| (b - a) * corner.at[0] + (c - a) * corner.at[1]);
        let outward = (y - x).cross(normal) * *per_area;
        if outward == Vec3::zeros() {
            // A side without a length has no line, and no effect.
            return;
        }
        let [u, v] = [0, 1].map(|i| 0.5 * (from.at[i] + to.at[i]));
        let shares = [1.0 - u - v, u, v];
        let Some(line) = from.line.checked_sub(3) else {
            let ends = [from.line as usize, (from.line as usize + 1) % 3];
            ends.into_iter().for_each(|k| gradient.vertices[face[k]] += outward * shares[k]);
            return;
        };
        let (mut other, side) = ((line / SIDES) as usize, (line % SIDES) as usize);
        let mut occluders = self.occluders.iter().enumerate();
        let hiding = occluders.find(|(_, occluder)| {
            let is_of_occluder = other < occluder.mesh.facets.len();
            other -= if is_of_occluder { 0 } else { occluder.mesh.facets.len() };
            is_of_occluder
        });
        let count = self.mesh.facets.len();
        let (light, mesh) = match hiding {
            Some((_, occluder)) => (occluder.light, occluder.mesh),
            None => (other / count, self.mesh),
        };
        other %= mesh.facets.len();
        let in_frame_of_part = |v: Vec3| match hiding {
            Some((_, occluder)) => occluder.position + occluder.rotation * v * occluder.growth,
            None => v,
        };
        let (corners, vertices) = (mesh.facets[other].corners.map(in_frame_of_part), mesh.faces[other]);
        let mut add = |k: usize, by: Vec3| {
            let vertex = vertices[k] as usize;
            match hiding {
                Some((index, occluder)) => {
                    gradient.occluders[index][vertex] += occluder.rotation.tr_mul(&by) * occluder.growth;
                }
                None => gradient.vertices[vertex] += by,
            }
        };
        let along = if side == 3 {
            // The point stays in the planes of both facets.
            let hiding = Facet::new(corners);
            let scale = outward.norm_squared() / hiding.normal.dot(&outward);
            let [row, other_row, _] = hiding.rows(&hiding.normal);
            let from = a + 0.5 * (x + y) - corners[0];
            let [u, v] = [row.dot(&from), other_row.dot(&from)];
            let shares = [1.0 - u - v, u, v];
            (0..3).for_each(|k| add(k, hiding.normal * (scale * shares[k])));
            -scale * hiding.normal.dot(normal)
        } else {
            let (direction, ends) = (&self.lights[light], [side, (side + 1) % 3]);
            let [row, other_row, up] = facet.rows(direction);
            let [p, q] = ends.map(|k| corners[k] - a);
            let [along_side, from_p] = [q - p, 0.5 * (x + y) - p].map(|v| [row.dot(&v), other_row.dot(&v)]);
            let t = (along_side[0] * from_p[0] + along_side[1] * from_p[1])
                / (along_side[0] * along_side[0] + along_side[1] * along_side[1]);
            let tilt = outward.dot(direction) / normal.dot(direction);
            let shift = outward - normal * tilt;
            add(ends[0], shift * (1.0 - t));
            add(ends[1], shift * t);
            gradient.lights[light] -= shift * up.dot(&(p + (q - p) * t));
            tilt
        };
        (0..3).for_each(|k| gradient.vertices[face[k]] += normal * (along * shares[k]));
    }
}
