//! The silhouette of a part that stands wholly in front of triangles, as seen along a direction.
//!
//! It consists of the edges between a facet that faces the light and one that does not. Each runs counterclockwise
//! about the facet that faces the light, so that the edges wind about a point as often as such facets cover it. A
//! triangle that no edge crosses is wholly hidden or wholly visible. Any other triangle is cut along the edges that
//! cross it, and each piece is hidden or visible. The edges are sorted into rows,
//! so that few are searched for each triangle. The limb of a body takes its edges from here too.

use super::mesh::{Facet, Mesh, SIDES};
use super::region::{Corner, Line, Region};
use crate::math::{Mat3, Vec3};

/// The part of a triangle that another part hides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hidden {
    Nothing,
    Everything,
    /// The part that the facets in front of its plane cover.
    ByFacets,
    /// The part within the silhouette, whose edges are those of the region.
    BySilhouette,
}

/// The edge of a silhouette that is nearest to a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestEdge {
    /// Whether the part covers the ray.
    pub inside: bool,
    /// The edge.
    pub line: Line,
    /// The fraction of the edge at which it is nearest, from 0 to 1.
    pub fraction: f64,
}

/// The silhouette of a part, in the frame of another one.
#[derive(Debug)]
pub struct Silhouette {
    /// Unit vectors across the direction, which form a right-handed frame with it.
    axes: [Vec3; 2],
    edges: Vec<Edge>,
    /// The least value along the second axis, and the number of rows to a length.
    low: f64,
    per_length: f64,
    /// The indices of the edges that extend into each row, and where the list of each row begins, with the end of the
    /// last one.
    listed: Vec<u32>,
    starts: Vec<usize>,
}

/// An edge from one point to another one across the direction, with its line and its first row.
#[derive(Debug)]
struct Edge {
    from: [f64; 2],
    to: [f64; 2],
    line: Line,
    first: usize,
}

/// The distance beyond an edge at which a point is on its other side, in heights of the silhouette.
const BEYOND: f64 = 1e-9;

/// An edge with its squared distance from a point, and the vector from that point to the edge's nearest one.
type Measured = (f64, [f64; 2], NearestEdge);

/// A triangle across the direction: its first corner, and its first two sides.
type Across = ([f64; 2], [[f64; 2]; 2]);

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

impl Silhouette {
    /// Finds the silhouette of a mesh along a direction of another part's frame, in which it has this pose and
    /// growth.
    pub fn new(mesh: &Mesh, (position, rotation): (&Vec3, &Mat3), growth: f64, direction: &Vec3) -> Self {
        let mut other = Vec3::zeros();
        other[direction.iamin()] = 1.0;
        let axis = direction.cross(&other).normalize();
        let axes = [axis, direction.cross(&axis)];
        let (rows, offsets) = (axes.map(|v| rotation.tr_mul(&v) * growth), axes.map(|v| v.dot(position)));
        let toward = rotation.tr_mul(direction);
        let lit: Vec<bool> = mesh.facets.iter().map(|facet| facet.normal.dot(&toward) > 0.0).collect();
        let project = |vertex: u32| [0, 1].map(|k| rows[k].dot(&mesh.vertices[vertex as usize]) + offsets[k]);
        let mut edges = Vec::new();
        for sides in &mesh.edges {
            let [first_is_lit, second_is_lit] = sides.map(|side| lit[(side / SIDES) as usize]);
            if first_is_lit != second_is_lit {
                let line = sides[usize::from(second_is_lit)];
                let (face, k) = (mesh.faces[(line / SIDES) as usize], (line % SIDES) as usize);
                let [from, to] = [face[k], face[(k + 1) % 3]].map(project);
                edges.push(Edge { from, to, line, first: 0 });
            }
        }
        let heights = || edges.iter().map(|edge| edge.from[1]);
        let (low, high) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::MIN, f64::max));
        let count = edges.len() / 2 + 1;
        let per_length = count as f64 / (high - low);
        let mut all = Self { axes, edges, low, per_length, listed: Vec::new(), starts: vec![0; count + 1] };
        let spans: Vec<[usize; 2]> = all
            .edges
            .iter()
            .map(|edge| all.rows(edge.from[1].min(edge.to[1]), edge.from[1].max(edge.to[1])))
            .collect();
        for (edge, [first, last]) in all.edges.iter_mut().zip(&spans) {
            edge.first = *first;
            (*first..=*last).for_each(|row| all.starts[row + 1] += 1);
        }
        (0..count).for_each(|row| all.starts[row + 1] += all.starts[row]);
        all.listed.resize(all.starts[count], 0);
        let mut ends = all.starts.clone();
        for (index, [first, last]) in (0..).zip(spans) {
            for end in &mut ends[first..=last] {
                all.listed[*end] = index;
                *end += 1;
            }
        }
        all
    }

    /// Returns the rows of two heights.
    fn rows(&self, low: f64, high: f64) -> [usize; 2] {
        // A number below zero becomes zero.
        [low, high]
            .map(|height| (((height - self.low) * self.per_length) as usize).min(self.starts.len() - 2))
    }

    /// Iterates over the edges that extend into a row.
    fn row(&self, row: usize) -> impl Iterator<Item = &Edge> {
        self.listed[self.starts[row]..self.starts[row + 1]].iter().map(|&index| &self.edges[index as usize])
    }

    /// Iterates over the lines of the edges.
    pub fn lines(&self) -> impl Iterator<Item = Line> {
        self.edges.iter().map(|edge| edge.line)
    }

    /// Returns the coordinates of a point across the direction.
    fn coordinates(&self, point: &Vec3) -> [f64; 2] {
        self.axes.map(|axis| axis.dot(point))
    }

    /// Returns the edge of the outline that is nearest to the ray through a point. Edges with the part on both
    /// sides do not belong to the outline.
    pub fn nearest(&self, point: &Vec3) -> NearestEdge {
        let at = self.coordinates(point);
        let inside = self.covers(at);
        let measured = self.edges.iter().map(|edge| {
            let (side, from) = (minus(edge.to, edge.from), minus(at, edge.from));
            let square = dot(side, side);
            // An edge along the direction is a point.
            let fraction = if square > 0.0 { (dot(from, side) / square).clamp(0.0, 1.0) } else { 0.0 };
            let apart = minus(side.map(|x| fraction * x), from);
            (dot(apart, apart), apart, NearestEdge { inside, line: edge.line, fraction })
        });
        // The line from a point inside to the nearest point of the outline leaves the part at that point.
        let beyond = BEYOND * (self.starts.len() - 1) as f64 / self.per_length;
        let leaves = |(square, apart, _): &&Measured| {
            let factor = 1.0 + beyond / square.sqrt();
            !inside || *square == 0.0 || !self.covers([0, 1].map(|k| at[k] + factor * apart[k]))
        };
        let order = |a: &Measured, b: &Measured| a.0.total_cmp(&b.0);
        let first = measured.clone().min_by(order).expect("a closed surface has a silhouette");
        if leaves(&&first) {
            return first.2;
        }
        let mut measured: Vec<_> = measured.collect();
        measured.sort_unstable_by(order);
        measured.iter().find(leaves).unwrap_or(&first).2
    }

    /// Returns the fractions, from 0 to 1, of a displacement of the ray through a point at which it crosses edges.
    pub fn crossings(&self, point: &Vec3, displacement: &Vec3) -> Vec<f64> {
        let (at, displacement) = (self.coordinates(point), self.coordinates(displacement));
        let crossing = |edge: &Edge| {
            let (side, from) = (minus(edge.to, edge.from), minus(edge.from, at));
            let inverse = cross(displacement, side).recip();
            let [fraction, on_edge] = [cross(from, side) * inverse, cross(from, displacement) * inverse];
            ((0.0..=1.0).contains(&fraction) && (0.0..=1.0).contains(&on_edge)).then_some(fraction)
        };
        self.edges.iter().filter_map(crossing).collect()
    }

    /// Returns a triangle in coordinates across the direction.
    fn across(&self, triangle: &Facet) -> Across {
        let [a, b, c] = triangle.corners.map(|v| self.coordinates(&v));
        (a, [minus(b, a), minus(c, a)])
    }

    /// Returns whether the part covers a point.
    fn covers(&self, at: [f64; 2]) -> bool {
        let mut winding = 0;
        for Edge { from, to, .. } in self.row(self.rows(at[1], at[1])[0]) {
            let [below, below_next] = [from, to].map(|end| end[1] <= at[1]);
            if below != below_next && (cross(minus(*to, *from), minus(at, *from)) > 0.0) == below {
                winding += if below { 1 } else { -1 };
            }
        }
        winding > 0
    }

    /// Returns which part of a triangle is hidden, whose normal has this cosine to the direction, and sets the edges
    /// of a region to those that cross it; their lines are counted from `line`.
    pub fn hidden_part(&self, triangle: &Facet, cosine: f64, line: Line, region: &mut Region) -> Hidden {
        let (a, [b, c]) = self.across(triangle);
        let [wide, tall] = [0, 1].map(|k| {
            let ends = [0.0, b[k], c[k]];
            [ends.into_iter().fold(0.0, f64::min) + a[k], ends.into_iter().fold(0.0, f64::max) + a[k]]
        });
        let scale = (2.0 * triangle.area * cosine).recip();
        region.edges.clear();
        let [first, last] = self.rows(tall[0], tall[1]);
        for row in first..=last {
            for edge in self.row(row) {
                let beside = |k: usize, [least, most]: [f64; 2]| {
                    edge.from[k].max(edge.to[k]) < least || edge.from[k].min(edge.to[k]) > most
                };
                if row != edge.first.max(first) || beside(0, wide) || beside(1, tall) {
                    continue;
                }
                let [p, q] = [edge.from, edge.to].map(|end| {
                    let from = minus(end, a);
                    [cross(from, c) * scale, cross(b, from) * scale]
                });
                let outside = |p: [f64; 2]| [p[0] <= 0.0, p[1] <= 0.0, p[0] + p[1] >= 1.0];
                let along = minus(q, p);
                let aside = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|corner| cross(along, minus(corner, p)));
                if (0..3).any(|k| outside(p)[k] && outside(q)[k])
                    || aside.iter().all(|side| *side >= 0.0)
                    || aside.iter().all(|side| *side <= 0.0)
                {
                    continue;
                }
                region.edges.push([p, q].map(|at| Corner { at, line: line + edge.line }));
            }
        }
        if !region.edges.is_empty() {
            Hidden::BySilhouette
        } else if self.covers([0, 1].map(|k| a[k] + (b[k] + c[k]) / 3.0)) {
            Hidden::Everything
        } else {
            Hidden::Nothing
        }
    }

    /// Subtracts the hidden part from a region of a triangle, given the edges that cross it.
    pub fn hide(&self, triangle: &Facet, region: &mut Region) {
        let (a, [b, c]) = self.across(triangle);
        region.cut(|[u, v]| self.covers([0, 1].map(|k| a[k] + u * b[k] + v * c[k])));
    }
}
