//! The facets of one part of a body, and the part of a triangle that they hide.

use super::region::{Corner, Line, Region};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3};
use crate::shape::{BoundingBox, Horizons, Part, Polyhedron, Shape, Tree};
use std::collections::HashMap;
use std::ops::ControlFlow;

/// The number of times that each face of an icosahedron is divided into four: 5,120 facets of size 0.07
/// radii.
const SUBDIVISIONS: u32 = 4;

/// A point that is nearer to a facet's plane than this, in sizes of the facet, is in it up to rounding.
const LEVEL: f64 = 1e-10;
/// Likewise for facets of one polyhedron, whose common corners are the same numbers.
const LEVEL_IN_POLYHEDRON: f64 = 1e-12;

/// The number of lines of a facet: its three sides, and the line in which its plane meets that of the triangle.
pub const SIDES: u32 = 4;

/// How facets that hide a triangle belong to parts. Where a facet and a triangle of two parts lie in one plane, one of them
/// hides the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precedence {
    /// They belong to the part of the triangle.
    SamePart,
    /// They belong to a part that counts before that of the triangle, and hide it.
    Before,
    /// They belong to a part that counts after that of the triangle, and do not hide it.
    After,
}

/// A triangle of the surface of a part.
#[derive(Debug, Clone)]
pub struct Facet {
    pub corners: [Vec3; 3],
    pub normal: Vec3,
    pub area: f64,
}

impl Facet {
    pub fn new(corners: [Vec3; 3]) -> Self {
        let across = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let size = across.norm();
        Self { corners, normal: across / size, area: 0.5 * size }
    }

    /// Returns the length of the longer one of the first two sides.
    fn size(&self) -> f64 {
        let [a, b, c] = &self.corners;
        (b - a).norm().max((c - a).norm())
    }

    /// Returns three vectors whose products with a point's difference from the first corner are the point's coordinates
    /// in shares of the first two sides, as seen along a direction, and its height over the facet along that direction.
    pub fn rows(&self, direction: &Vec3) -> [Vec3; 3] {
        let [a, b, c] = self.corners;
        let along = self.normal.dot(direction);
        let across = (2.0 * self.area * along).recip();
        [(c - a).cross(direction) * across, direction.cross(&(b - a)) * across, self.normal / along]
    }

    /// Returns whether two facets lie in one plane and face the same side: all corners of the smaller one are in the
    /// plane of the larger one.
    fn is_coplanar_with(&self, other: &Self) -> bool {
        let (large, small) = if self.area >= other.area { (self, other) } else { (other, self) };
        let level = LEVEL * large.size();
        large.normal.dot(&small.normal) > 0.0
            && small.corners.iter().all(|v| large.normal.dot(&(v - large.corners[0])).abs() <= level)
    }
}

/// The facets of a part, in its own frame.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// The indices of the body and of the part in its list.
    pub indices: [usize; 2],
    /// The part's pose in the body frame.
    pub pose: (Vec3, Mat3),
    /// The facets, with the indices of their corners in the list of vertices.
    pub facets: Vec<Facet>,
    pub faces: Vec<[u32; 3]>,
    pub vertices: Vec<Vec3>,
    /// The two sides at each edge, by [`SIDES`] times the facet's index plus that of the side in it.
    pub edges: Vec<[u32; 2]>,
    /// The polyhedron; `None` for an ellipsoid.
    pub polyhedron: Option<Polyhedron>,
    /// The semi-axes of an ellipsoid.
    pub semi_axes: Vec3,
    /// The radii of the least ball about the origin that holds the facets, and of the largest one that is
    /// known to be within them.
    pub radii: [f64; 2],
    tree: Tree,
}

impl Mesh {
    /// Makes the facets of a part; `None` for a part without a surface.
    pub fn new(indices: [usize; 2], part: &Part) -> Option<Self> {
        let (vertices, faces, semi_axes): (Vec<Vec3>, _, _) = match &part.shape {
            Shape::Point | Shape::Stokes(_) => return None,
            Shape::Polyhedron(shape) => (shape.vertices().collect(), shape.faces().to_vec(), Vec3::zeros()),
            Shape::Ellipsoid(ellipsoid) => {
                let axes = Vec3::from(ellipsoid.semi_axes());
                let (vertices, faces) = sphere(SUBDIVISIONS);
                (vertices.iter().map(|v| v.component_mul(&axes)).collect(), faces, axes)
            }
        };
        let facets: Vec<_> =
            faces.iter().map(|face| Facet::new(face.map(|v| vertices[v as usize]))).collect();
        let circumradius = faces.iter().flatten().map(|&v| vertices[v as usize].norm()).fold(0.0, f64::max);
        // If the origin is below all planes, no facet reaches the ball that touches the nearest one.
        let heights = facets.iter().map(|facet| facet.normal.dot(&facet.corners[0]));
        let within = heights.fold(f64::INFINITY, f64::min).max(0.0);
        let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * faces.len());
        for (face, index) in faces.iter().zip(0..) {
            let ends = (0..3).map(|k| [face[k], face[(k + 1) % 3]]);
            sides.extend(ends.zip(SIDES * index..).map(|([u, v], side)| ([u.min(v), u.max(v)], side)));
        }
        sides.sort_unstable();
        let edges = sides.chunks_exact(2).map(|pair| [pair[0].1, pair[1].1]).collect();
        let blocks: Vec<_> = facets.iter().map(|facet| BoundingBox::around(&facet.corners)).collect();
        Some(Self {
            indices,
            pose: (part.position(), part.rotation()),
            facets,
            faces,
            vertices,
            edges,
            polyhedron: match &part.shape {
                Shape::Polyhedron(polyhedron) => Some(polyhedron.clone()),
                _ => None,
            },
            semi_axes,
            radii: [circumradius, within],
            tree: Tree::new(&blocks),
        })
    }

    /// Returns the horizons of the facets; `None` if the part hides nothing of itself.
    pub fn horizons(&self, interrupt: &mut InterruptCheck) -> Result<Option<&Horizons>> {
        self.polyhedron.as_ref().map_or(Ok(None), |polyhedron| polyhedron.horizons(interrupt))
    }

    /// Subtracts from a region of a triangle the part that facets hide along a direction, all in the part's frame. The line
    /// of a side is `line` and [`SIDES`] times the facet's index. Without candidates all facets are searched.
    pub fn hide(
        &self,
        triangle: &Facet,
        direction: &Vec3,
        precedence: Precedence,
        line: Line,
        candidates: Option<impl Iterator<Item = u32>>,
        region: &mut Region,
    ) {
        let rows = triangle.rows(direction);
        let [a, ..] = triangle.corners;
        let scale = triangle.size() / triangle.normal.dot(direction);
        let is_other_part = precedence != Precedence::SamePart;
        // Points that are above the plane only by rounding are not in front of it.
        let (level, clip_height) = if is_other_part {
            [LEVEL * scale; 2].into()
        } else {
            (LEVEL_IN_POLYHEDRON * scale, -LEVEL_IN_POLYHEDRON * scale)
        };
        // The test for coplanar facets is relative to the size of the larger one.
        let margin = if is_other_part { 1e4 * level } else { -level };
        let third = -(rows[0] + rows[1]);
        let bounds = [(rows[0], 0.0), (rows[1], 0.0), (third, 1.0), (rows[2], margin)]
            .map(|(row, offset)| (row, row.abs(), offset));
        let enter = |block: &BoundingBox| {
            let (middle, half) = (0.5 * (block.low + block.high) - a, 0.5 * (block.high - block.low));
            for (row, sizes, offset) in &bounds {
                if row.dot(&middle) + sizes.dot(&half) + offset <= 0.0 {
                    return false;
                }
            }
            true
        };
        let hide = |index: u32| {
            let facet = &self.facets[index as usize];
            // A ray enters the solid of its own facet before it leaves it; it may start within another part.
            if (facet.normal.dot(direction) > 0.0) != is_other_part {
                return ControlFlow::Continue(());
            }
            let (mut projected, mut largest) = ([[0.0; 3]; 3], [f64::NEG_INFINITY; 4]);
            for (at, v) in projected.iter_mut().zip(&facet.corners) {
                let from = v - a;
                *at = [rows[0].dot(&from), rows[1].dot(&from), rows[2].dot(&from)];
                let beyond = [at[0], at[1], 1.0 - at[0] - at[1], at[2]];
                largest.iter_mut().zip(beyond).for_each(|(largest, value)| *largest = largest.max(value));
            }
            if largest[..3].iter().any(|largest| *largest <= 0.0) {
                return ControlFlow::Continue(());
            }
            let (mut level, mut clip_height) = (level, clip_height);
            if is_other_part && triangle.is_coplanar_with(facet) {
                if precedence == Precedence::After {
                    return ControlFlow::Continue(());
                }
                (level, clip_height) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
            }
            if largest[3] > level {
                let (mut polygon, count) = above(&projected, clip_height, line + SIDES * index);
                region.subtract(&mut polygon[..count]);
                if region.is_empty() {
                    return ControlFlow::Break(());
                }
            }
            ControlFlow::Continue(())
        };
        let _ = match candidates {
            Some(mut candidates) => candidates.try_for_each(hide),
            None => self.tree.search(enter, hide),
        };
    }
}

/// Returns the part of a triangle whose third coordinate is above a height, and the number of its corners. Its lines
/// are counted from `line`.
#[inline]
fn above(projected: &[[f64; 3]; 3], height: f64, line: Line) -> ([Corner; 4], usize) {
    let mut polygon = [Corner { at: [0.0; 2], line }; 4];
    let mut count = 0;
    let mut push = |at: [f64; 2], line: Line| {
        polygon[count] = Corner { at, line };
        count += 1;
    };
    for k in 0..3 {
        let [corner, next] = [projected[k], projected[(k + 1) % 3]];
        let [height_over, next_height] = [corner, next].map(|v| v[2] - height);
        if height_over > 0.0 {
            push([corner[0], corner[1]], line + k as u32);
        }
        if (height_over > 0.0) != (next_height > 0.0) {
            let share = height_over / (height_over - next_height);
            let at = [0, 1].map(|i| corner[i] + share * (next[i] - corner[i]));
            push(at, line + if height_over > 0.0 { SIDES - 1 } else { k as u32 });
        }
    }
    (polygon, count)
}

/// Returns the vertices and faces of an icosahedron, each face divided into four this many times, scaled to
/// have the unit sphere's area in total.
fn sphere(subdivisions: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let mut vertices: Vec<Vec3> = (0..3)
        .flat_map(|axis| {
            [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)].map(|pair| (axis, pair))
        })
        .map(|(axis, (small, large))| {
            let mut v = Vec3::zeros();
            (v[axis], v[(axis + 1) % 3]) = (small, large);
            v.normalize()
        })
        .collect();
    // The faces are the triples of vertices that are neighbours of each other.
    let edge = 2.0 / (golden * 5f64.sqrt()).sqrt() * 1.01;
    let near = |i: u32, j: u32| (vertices[i as usize] - vertices[j as usize]).norm() < edge;
    let mut faces = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(k, i) {
                    let [a, b, c] = [i, j, k].map(|v| vertices[v as usize]);
                    faces.push(if a.dot(&b.cross(&c)) > 0.0 { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    for _ in 0..subdivisions {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        let divided = faces.iter().flat_map(|&[a, b, c]| {
            let (p, q, r) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, p, r], [p, b, q], [r, q, c], [p, q, r]]
        });
        faces = divided.collect();
    }
    let area: f64 = faces.iter().map(|face| Facet::new(face.map(|v| vertices[v as usize])).area).sum();
    let growth = (4.0 * std::f64::consts::PI / area).sqrt();
    (vertices.into_iter().map(|v| v * growth).collect(), faces)
}
