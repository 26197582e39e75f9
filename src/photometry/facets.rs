//! Photometry of bodies of any shape by facets: triangles of which others hide parts, computed exactly.
//!
//! On a facet mu and mu0 are constant, so that its brightness is that of a surface element times the area
//! that is both visible and illuminated. A point is hidden along a direction d where the ray from it leaves a
//! solid: where it passes through an exit facet, one with n.d > 0, in front of the point. The part of each
//! exit facet that lies in front of another facet's plane and above that facet along d is clipped to a convex
//! polygon. The area of the union of these polygons, along the direction to the observer and along that to
//! the Sun together, is subtracted. The crate `i_overlay` computes the union on a grid of 2^-30 of the facet.
//! Parts that overlap need not be joined, since a point within a solid is hidden by the facets through which
//! the ray leaves it. Where facets of two parts lie in one plane, that of the part that comes first hides
//! that of the other one, so that the common area counts once.
//!
//! Where an ellipsoid hides light, it has the facets of a subdivided icosahedron, scaled so that for a sphere
//! they have its area. Where light is hidden from an ellipsoid, its lune is divided into cells: what is left
//! of them is the share that is left of the exact brightness. The errors fall with the square of the facets'
//! size.

use super::law::Scattering;
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3, perpendicular};
use crate::shape::{Body, BoundingBox, Part, Shape, Tree};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay;
use rayon::prelude::*;
use std::collections::HashMap;

/// The number of times that each face of an icosahedron is divided into four: 5,120 facets of size 0.07
/// radii.
const SUBDIVISIONS: u32 = 4;

/// The number of facets that are computed between two interrupt checks.
const GROUP: usize = 512;

/// Units of work of a facet.
const WORK: u64 = 100;

/// The facets of all parts of a body, in the body frame.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// The facets, each with the index of its part in the body's list.
    triangles: Vec<(usize, [Vec3; 3])>,
    /// The parts that are ellipsoids, with their places in the body's list.
    pub ellipsoids: Vec<(usize, Part)>,
}

impl Mesh {
    /// Makes the facets of a body.
    pub fn new(body: &Body) -> Self {
        let mut mesh = Self { triangles: Vec::new(), ellipsoids: Vec::new() };
        for (index, part) in body.outer_parts().enumerate() {
            let (position, rotation) = (part.position(), part.rotation());
            match &part.shape {
                Shape::Point | Shape::Stokes(_) => {}
                Shape::Polyhedron(polyhedron) => {
                    let faces = 0..polyhedron.faces().len();
                    let placed = |face| (index, polyhedron.corners(face).map(|v| position + rotation * v));
                    mesh.triangles.extend(faces.map(placed));
                }
                Shape::Ellipsoid(ellipsoid) => {
                    let axes = Vec3::from(ellipsoid.semi_axes());
                    let placed = |v: Vec3| position + rotation * v.component_mul(&axes);
                    mesh.triangles.extend(sphere(SUBDIVISIONS).into_iter().map(|t| (index, t.map(placed))));
                    mesh.ellipsoids.push((index, part.clone()));
                }
            }
        }
        mesh
    }

    /// Returns the facets of a body with this index in the list, at a position and rotation.
    fn placed(&self, body: usize, position: &Vec3, rotation: &Mat3) -> impl Iterator<Item = Facet> {
        self.triangles.iter().enumerate().map(move |(index, (part, triangle))| {
            Facet::new([body, *part], index, triangle.map(|v| position + rotation * v))
        })
    }

    /// Returns the facets of a body's polyhedra that face both the observer and the Sun, with the brightness
    /// that each has unobstructed. The body has this index in the list and this rotation, and is at the
    /// origin. The albedo is one number, or one for each facet.
    pub fn lit(
        &self,
        body: usize,
        rotation: &Mat3,
        [e, s]: &[Vec3; 2],
        scattering: &Scattering,
        albedo: &[f64],
    ) -> Vec<(Facet, f64)> {
        let across = e.cross(s);
        let bright = |facet: Facet| {
            let [mu, mu0] = [e, s].map(|direction| facet.normal.dot(direction));
            let curved = self.ellipsoids.iter().any(|(part, _)| *part == facet.part[1]);
            (mu > 0.0 && mu0 > 0.0 && !curved).then(|| {
                let factor = scattering.factor(mu, mu0, across.dot(&facet.normal));
                let albedo = albedo.get(facet.index).unwrap_or(&albedo[0]);
                let brightness = mu * mu0 / (mu + mu0) * factor * facet.area * albedo;
                (facet, brightness)
            })
        };
        self.placed(body, &Vec3::zeros(), rotation).filter_map(bright).collect()
    }
}

/// A triangle of the surface of a body.
#[derive(Debug, Clone)]
pub struct Facet {
    /// The body and the index of the part in its list.
    part: [usize; 2],
    /// The index of the facet in its body; [`CELL`] for a facet that represents a cell of a curved surface.
    index: usize,
    corners: [Vec3; 3],
    normal: Vec3,
    /// The area.
    pub area: f64,
}

/// The index of a cell of an ellipsoid, which its own part does not hide.
const CELL: usize = usize::MAX;

/// A point that is nearer to a facet's plane than this, in sizes of the facet, is in it up to rounding.
const LEVEL: f64 = 1e-10;

impl Facet {
    fn new(part: [usize; 2], index: usize, corners: [Vec3; 3]) -> Self {
        let across = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let size = across.norm();
        Self { part, index, corners, normal: across / size, area: 0.5 * size }
    }

    /// Makes a cell of the surface of an ellipsoid.
    pub fn cell(part: [usize; 2], corners: [Vec3; 3]) -> Self {
        Self::new(part, CELL, corners)
    }

    /// The length of the longer one of the first two sides.
    fn size(&self) -> f64 {
        let [a, b, c] = &self.corners;
        (b - a).norm().max((c - a).norm())
    }

    /// Whether two facets lie in one plane and face the same side: all corners of the smaller one are in the
    /// plane of the larger one.
    fn is_level_with(&self, other: &Self) -> bool {
        let (large, small) = if self.area >= other.area { (self, other) } else { (other, self) };
        let level = LEVEL * large.size();
        large.normal.dot(&small.normal) > 0.0
            && small.corners.iter().all(|v| large.normal.dot(&(v - large.corners[0])).abs() <= level)
    }
}

/// The facets through which rays along a direction leave solids, in a tree of boxes whose third axis is the
/// direction.
struct ExitFacets {
    frame: Mat3,
    direction: Vec3,
    facets: Vec<Facet>,
    tree: Tree,
}

impl ExitFacets {
    /// Takes facets, of which it keeps those of exits, and a unit vector.
    fn new(facets: impl Iterator<Item = Facet>, direction: &Vec3) -> Self {
        let first = perpendicular(direction);
        let frame = Mat3::from_columns(&[first, direction.cross(&first), *direction]).transpose();
        let facets: Vec<Facet> = facets.filter(|f| f.normal.dot(direction) > 0.0).collect();
        let blocks: Vec<BoundingBox> =
            facets.iter().map(|f| BoundingBox::of(&f.corners.map(|v| frame * v))).collect();
        Self { frame, direction: *direction, tree: Tree::new(&blocks), facets }
    }

    /// Adds the polygons that exit facets hide of a facet, in fractions of its first two sides.
    fn hide(&self, facet: &Facet, out: &mut Vec<Vec<[f64; 2]>>) {
        let mut around = BoundingBox::of(&facet.corners.map(|v| self.frame * v));
        around.high.z = f64::INFINITY;
        let [a, b, c] = facet.corners;
        // Points that are above the plane only by rounding are not in front of it; neighbours share an edge.
        let plane = (facet.normal, facet.normal.dot(&a) + LEVEL * facet.size());
        let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| {
            let inward = self.direction.cross(&(to - from)).normalize();
            (inward, inward.dot(&from))
        });
        self.tree.meeting(&around, |index| {
            let other = &self.facets[index as usize];
            let same_part = other.part == facet.part;
            if same_part && (facet.index == other.index || facet.index == CELL) {
                return;
            }
            let mut polygon = if !same_part && facet.is_level_with(other) {
                if other.part > facet.part {
                    return;
                }
                other.corners.to_vec()
            } else if other.corners.iter().all(|v| facet.normal.dot(v) <= plane.1) {
                return;
            } else {
                clipped(&other.corners, plane)
            };
            for side in sides {
                polygon = clipped(&polygon, side);
            }
            if polygon.len() > 2 {
                out.push(polygon.iter().map(|v| self.shares(facet, v)).collect());
            }
        });
    }

    /// Returns the point of a facet's plane below a point, along the direction, in fractions of the facet's
    /// first two sides.
    fn shares(&self, facet: &Facet, point: &Vec3) -> [f64; 2] {
        let [a, b, c] = facet.corners;
        let down = facet.normal.dot(&(point - a)) / facet.normal.dot(&self.direction);
        let from = point - self.direction * down - a;
        let (u, v) = (b - a, c - a);
        let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
        let (fu, fv, below) = (from.dot(&u), from.dot(&v), uu * vv - uv * uv);
        [(fu * vv - fv * uv) / below, (fv * uu - fu * uv) / below]
    }
}

/// Clips a convex polygon to the half space n.x > level.
fn clipped(polygon: &[Vec3], (n, level): (Vec3, f64)) -> Vec<Vec3> {
    let mut left = Vec::with_capacity(polygon.len() + 1);
    for (k, here) in polygon.iter().enumerate() {
        let next = &polygon[(k + 1) % polygon.len()];
        let [over, over_next] = [here, next].map(|v| n.dot(v) - level);
        if over > 0.0 {
            left.push(*here);
        }
        if (over > 0.0) != (over_next > 0.0) {
            left.push(here + (next - here) * (over / (over - over_next)));
        }
    }
    left
}

/// Returns twice the area of the union of polygons in fractions of a facet's sides: one for a facet that is
/// hidden entirely.
fn union(polygons: &[Vec<[f64; 2]>]) -> f64 {
    let area = |contour: &[[f64; 2]]| -> f64 {
        let next = contour.iter().cycle().skip(1);
        contour.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
    };
    match polygons {
        [] => 0.0,
        [single] => area(single).abs(),
        // All polygons are given the same orientation, so that none is subtracted from another one.
        polygons => {
            let oriented = polygons.iter().map(|polygon| {
                let mut polygon = polygon.clone();
                if area(&polygon) < 0.0 {
                    polygon.reverse();
                }
                polygon
            });
            let oriented: Vec<_> = oriented.collect();
            let nothing: [Vec<[f64; 2]>; 0] = [];
            let joined = oriented.overlay(&nothing, OverlayRule::Subject, FillRule::NonZero);
            joined.iter().flatten().map(|contour| area(contour)).sum::<f64>().abs()
        }
    }
}

/// The facets of several bodies that hide light.
pub struct Faceted {
    exits: [ExitFacets; 2],
}

impl Faceted {
    /// Takes for the observer's light and for the Sun's the facets of bodies with their indices, positions
    /// and rotations, and the unit vectors along which these are hidden.
    pub fn new(meshes: [Vec<(usize, &Mesh, Vec3, Mat3)>; 2], directions: &[Vec3; 2]) -> Self {
        let exits = [0, 1].map(|light: usize| {
            let meshes = meshes[light].iter();
            let placed = meshes.flat_map(|(body, mesh, at, rotation)| mesh.placed(*body, at, rotation));
            ExitFacets::new(placed, &directions[light])
        });
        Self { exits }
    }

    /// Returns the sum of what is left of the brightness of facets. Each faces the observer and the Sun, and
    /// comes with its brightness unobstructed.
    pub fn left(&self, facets: &[(Facet, f64)], time: f64, interrupt: &mut InterruptCheck) -> Result<f64> {
        let of = |(facet, brightness): &(Facet, f64)| {
            let mut hidden = Vec::new();
            self.exits.iter().for_each(|exits| exits.hide(facet, &mut hidden));
            brightness * (1.0 - union(&hidden)).max(0.0)
        };
        let mut all = Vec::with_capacity(facets.len());
        for facets in facets.chunks(GROUP) {
            interrupt.charge(WORK * facets.len() as u64, time)?;
            all.par_extend(facets.par_iter().map(of));
        }
        Ok(all.iter().sum())
    }
}

/// Returns the faces of an icosahedron, each divided into four this many times, scaled to have the unit
/// sphere's area in total.
fn sphere(subdivisions: u32) -> Vec<[Vec3; 3]> {
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
    let near = |i: usize, j: usize| (vertices[i] - vertices[j]).norm() < edge;
    let mut faces = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(k, i) {
                    let outward = vertices[i].dot(&vertices[j].cross(&vertices[k])) > 0.0;
                    faces.push(if outward { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    for _ in 0..subdivisions {
        let mut middles = HashMap::new();
        let mut middle = |a: usize, b: usize| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a] + vertices[b]).normalize());
                vertices.len() - 1
            })
        };
        let divided = faces.iter().flat_map(|&[a, b, c]| {
            let (p, q, r) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, p, r], [p, b, q], [r, q, c], [p, q, r]]
        });
        faces = divided.collect();
    }
    let triangles = faces.iter().map(|face| face.map(|v| vertices[v]));
    let area: f64 = triangles.clone().map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum();
    let growth = (4.0 * std::f64::consts::PI / area).sqrt();
    triangles.map(|triangle| triangle.map(|v| v * growth)).collect()
}
