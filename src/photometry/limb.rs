//! The limb of a polyhedron: the distances of rays from it, and the points at which moving rays cross it.
//!
//! A ray is given by a point w on it and its unit direction u, toward the light. It passes through the polyhedron
//! where the silhouette along u winds about it. Its distance from the outline is that from the nearest edge that
//! does not have the polyhedron on both sides. With the ends a and a + t of this edge, which runs counterclockwise,
//! r = w - a and the outward normal n = (t x u)/|t x u|, the distance is n.r, and its derivatives with respect to w
//! and u are
//!
//!   n   and   (r - (n.r) n) x t/|t x u|.
//!
//! Beyond an end of the edge the distance is |s| with s = r - (r.u) u, r from this end, and the derivatives
//! are s/|s| and -(r.u) s/|s|.

use super::mesh::{Mesh, SIDES};
use super::region::Line;
use super::silhouette::Silhouette;
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3};
use crate::shape::{Part, Polyhedron, Shape};

/// Units of work of a ray for each face.
const WORK: u64 = 1;

/// The limb of a polyhedron, in its own frame.
#[derive(Debug, Clone)]
pub struct Limb {
    mesh: Mesh,
}

/// The distance of a ray from a limb, with its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimbDistance {
    /// The distance, negative for a ray through the body.
    pub distance: f64,
    /// The derivative with respect to the point of the ray.
    pub by_point: Vec3,
    /// The derivative with respect to the direction of the ray.
    pub by_direction: Vec3,
}

impl Limb {
    /// Makes the limb of a polyhedron.
    pub fn new(polyhedron: Polyhedron) -> Self {
        let part = Part { shape: Shape::Polyhedron(polyhedron), mass: 1.0, placement: None };
        Self { mesh: Mesh::new([0, 0], &part).expect("a polyhedron has a surface") }
    }

    /// Returns the silhouette of the polyhedron along a direction.
    fn silhouette(&self, direction: &Vec3) -> Silhouette {
        Silhouette::new(&self.mesh, (&Vec3::zeros(), &Mat3::identity()), 1.0, direction)
    }

    /// Returns the ends of an edge of the silhouette.
    fn ends(&self, line: Line) -> [Vec3; 2] {
        let (face, k) = (self.mesh.faces[(line / SIDES) as usize], (line % SIDES) as usize);
        [face[k], face[(k + 1) % 3]].map(|vertex| self.mesh.vertices[vertex as usize])
    }

    /// Counts the work of a ray, and checks for an interrupt.
    fn charge(&self, interrupt: &mut InterruptCheck) -> Result<()> {
        interrupt.charge(WORK * self.mesh.facets.len() as u64, 0.0)
    }

    /// Returns the distances of rays, given by points and unit directions, from the limb.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::error::Error::Interrupted).
    pub fn distances(
        &self,
        points: &[Vec3],
        directions: &[Vec3],
        interrupt: &mut InterruptCheck,
    ) -> Result<Vec<LimbDistance>> {
        let mut cached: Option<(Vec3, Silhouette)> = None;
        let rays = points.iter().zip(directions);
        rays.map(|(point, direction)| {
            self.charge(interrupt)?;
            let (_, silhouette) = match cached.take() {
                Some(previous) if previous.0 == *direction => cached.insert(previous),
                _ => cached.insert((*direction, self.silhouette(direction))),
            };
            let nearest = silhouette.nearest(point);
            Ok(along_edge(self.ends(nearest.line), nearest.fraction, nearest.inside, point, direction))
        })
        .collect()
    }

    /// Returns the fractions, from 0 to 1, of the displacements of rays at which they cross edges of the limb that is
    /// seen along their directions, with the index of each fraction's ray. The fractions of a ray increase.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::error::Error::Interrupted).
    pub fn crossings(
        &self,
        points: &[Vec3],
        directions: &[Vec3],
        displacements: &[Vec3],
        interrupt: &mut InterruptCheck,
    ) -> Result<(Vec<usize>, Vec<f64>)> {
        let (mut rays, mut fractions) = (Vec::new(), Vec::new());
        for (ray, ((point, direction), displacement)) in
            points.iter().zip(directions).zip(displacements).enumerate()
        {
            self.charge(interrupt)?;
            let mut crossed = self.silhouette(direction).crossings(point, displacement);
            crossed.sort_unstable_by(f64::total_cmp);
            rays.extend(crossed.iter().map(|_| ray));
            fractions.extend(crossed);
        }
        Ok((rays, fractions))
    }

    /// Returns the ends of the edges of the limb that is seen along a direction, counterclockwise about the faces
    /// that face it.
    pub fn edges(&self, direction: &Vec3) -> Vec<[Vec3; 2]> {
        self.silhouette(direction).lines().map(|line| self.ends(line)).collect()
    }
}

/// Returns the distance of a ray from an edge whose nearest point is at this fraction of it, negative for a ray
/// inside.
fn along_edge(
    [from, to]: [Vec3; 2],
    fraction: f64,
    inside: bool,
    point: &Vec3,
    direction: &Vec3,
) -> LimbDistance {
    if fraction == 0.0 || fraction == 1.0 {
        let from_end = point - if fraction == 0.0 { from } else { to };
        let depth = from_end.dot(direction);
        let across = from_end - direction * depth;
        let distance = across.norm();
        if distance > 0.0 {
            let by_point = across * (if inside { -1.0 } else { 1.0 } / distance);
            return LimbDistance {
                distance: if inside { -distance } else { distance },
                by_point,
                by_direction: by_point * -depth,
            };
        }
    }
    let (side, from_end) = (to - from, point - from);
    // Edges run counterclockwise, so that this normal is an outward one.
    let normal = side.cross(direction);
    let size = normal.norm();
    let normal = normal / size;
    let height = normal.dot(&from_end);
    LimbDistance {
        distance: height,
        by_point: normal,
        by_direction: (from_end - normal * height).cross(&side) / size,
    }
}
