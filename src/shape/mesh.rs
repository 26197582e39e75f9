//! Checks that triangles bound a solid: closed, oriented outward, nowhere crossing. Errors name the face.

use super::crossing::first_crossing;
use super::tree::{BoundingBox, Tree};
use crate::error::{Error, Result, require_finite};
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3};
use std::f64::consts::PI;

/// The least height of a face relative to its longest edge; flatter faces have no reliable direction.
const FLATTEST: f64 = 1e-12;

/// Units of work of a solid angle.
pub const SOLID_ANGLE: u64 = 10;

/// The range of extents in which the volume and the quantities that follow from it neither under- nor
/// overflow.
const EXTENTS: std::ops::RangeInclusive<f64> = 1e-60..=1e60;

/// An edge and the two faces that share it; the first face traverses it forwards, the second one backwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// The indices of the two vertices.
    pub ends: [u32; 2],
    /// The indices of the two faces.
    pub faces: [u32; 2],
}

fn of_face(index: usize, value: impl std::fmt::Display, expected: &str) -> Error {
    Error::invalid(format!("face {index}"), value, expected)
}

/// Checks each vertex, face and edge on its own. Returns the edges.
pub fn check(vertices: &[Vec3], faces: &[[u32; 3]]) -> Result<Vec<Edge>> {
    for (index, vertex) in vertices.iter().enumerate() {
        require_finite(&format!("vertex {index}"), vertex.as_slice())?;
    }
    let extent = vertices.iter().map(|vertex| vertex.amax()).fold(0.0, f64::max);
    if extent > 0.0 && !EXTENTS.contains(&extent) {
        return Err(Error::invalid(
            "largest coordinate of the vertices",
            format!("{extent:e}"),
            "one whose cube is in the range of doubles; choose other units",
        ));
    }
    if faces.len() < 4 {
        return Err(Error::invalid("number of faces", faces.len(), "at least four"));
    }
    for (index, face) in faces.iter().enumerate() {
        check_face(vertices, index, *face)?;
    }
    edges(faces)
}

/// Checks that faces with these edges bound a solid, which takes about a second for two hundred thousand of
/// them.
pub fn check_solid(
    vertices: &[Vec3],
    faces: &[[u32; 3]],
    edges: &[Edge],
    interrupt: &mut InterruptCheck,
) -> Result<()> {
    if is_star(vertices, faces, interrupt)? {
        return Ok(());
    }
    let blocks: Vec<BoundingBox> =
        faces.iter().map(|face| BoundingBox::around(&face.map(|v| vertices[v as usize]))).collect();
    let tree = Tree::new(&blocks);
    if let Some([i, j]) = first_crossing(vertices, faces, &tree, interrupt)? {
        return Err(of_face(
            i,
            format!("crossing or touching face {j}"),
            "faces that meet at common edges alone",
        ));
    }
    check_orientation(vertices, faces, edges, interrupt)
}

/// Returns whether all of a closed surface is seen from behind from the origin, once in each direction: its
/// projection on a sphere then covers this once, so that no two faces meet but at common edges.
fn is_star(vertices: &[Vec3], faces: &[[u32; 3]], interrupt: &mut InterruptCheck) -> Result<bool> {
    let mut total = 0.0;
    for face in faces {
        interrupt.charge(SOLID_ANGLE, 0.0)?;
        let corners @ [a, b, c] = face.map(|v| vertices[v as usize]);
        // Vertices are finite here.
        if a.dot(&b.cross(&c)) <= FLATTEST * a.norm() * b.norm() * c.norm() {
            return Ok(false);
        }
        total += solid_angle(corners);
    }
    Ok((total - 4.0 * PI).abs() < 1e-6)
}

fn check_face(vertices: &[Vec3], index: usize, face: [u32; 3]) -> Result<()> {
    let [a, b, c] = face;
    let text = format!("({a}, {b}, {c})");
    if face.iter().any(|&v| v as usize >= vertices.len()) {
        return Err(of_face(
            index,
            text,
            &format!("vertices from 0 to {}", vertices.len().saturating_sub(1)),
        ));
    }
    if a == b || b == c || c == a {
        return Err(of_face(index, text, "three different vertices"));
    }
    let [a, b, c] = face.map(|v| vertices[v as usize]);
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let height = ((b - a) / longest).cross(&((c - a) / longest)).norm();
    // The comparison is written so that the NaN of three equal points is refused.
    if height > FLATTEST {
        Ok(())
    } else {
        Err(of_face(index, text, "three points that are not on one line"))
    }
}

/// Returns the edges of faces, where each must be shared by exactly two that traverse it in opposite
/// directions.
fn edges(faces: &[[u32; 3]]) -> Result<Vec<Edge>> {
    let mut sides: Vec<([u32; 2], u32, bool)> = (0u32..)
        .zip(faces)
        .flat_map(|(index, &[a, b, c])| {
            [(a, b), (b, c), (c, a)].map(|(u, v)| ([u.min(v), u.max(v)], index, u < v))
        })
        .collect();
    sides.sort_unstable();
    let mut edges = Vec::with_capacity(sides.len() / 2);
    for group in sides.chunk_by(|a, b| a.0 == b.0) {
        let [u, v] = group[0].0;
        let first = group[0].1 as usize;
        let along = format!("the edge of vertices {u} and {v}");
        let twice = group.iter().enumerate().find_map(|(k, (_, j, _))| {
            let same = |side: &&([u32; 2], u32, bool)| doubled(faces[side.1 as usize], faces[*j as usize]);
            group[..k].iter().find(same).map(|side| (side.1, *j))
        });
        if let Some((i, j)) = twice {
            let value = format!("the same three vertices as face {i}");
            return Err(of_face(j as usize, value, "each face once"));
        }
        match group {
            [(_, i, i_along), (_, j, j_along)] if i_along != j_along => {
                let faces = if *i_along { [*i, *j] } else { [*j, *i] };
                edges.push(Edge { ends: [u, v], faces });
            }
            [(_, i, _), (_, j, _)] => {
                return Err(of_face(
                    *j as usize,
                    format!("turned against face {i} at {along}"),
                    "all faces turned outward",
                ));
            }
            [_] => return Err(of_face(first, format!("alone at {along}"), "a closed surface")),
            more => {
                let all: Vec<String> = more.iter().map(|side| side.1.to_string()).collect();
                let value = format!("at {along}, together with faces {}", all[1..].join(", "));
                return Err(of_face(first, value, "two faces at an edge"));
            }
        }
    }
    Ok(edges)
}

fn doubled(mut first: [u32; 3], mut second: [u32; 3]) -> bool {
    first.sort_unstable();
    second.sort_unstable();
    first == second
}

/// Checks that every closed surface has the solid on its inner side, or, for a hollow within another surface,
/// on its outer side.
fn check_orientation(
    vertices: &[Vec3],
    faces: &[[u32; 3]],
    edges: &[Edge],
    interrupt: &mut InterruptCheck,
) -> Result<()> {
    let surfaces = surfaces(faces.len(), edges);
    let corners = |face: usize| faces[face].map(|v| vertices[v as usize]);
    for (index, surface) in surfaces.iter().enumerate() {
        let origin = corners(surface[0])[0];
        let volume: f64 = surface
            .iter()
            .map(|&face| {
                let [a, b, c] = corners(face).map(|v| v - origin);
                a.dot(&b.cross(&c))
            })
            .sum();
        let mut enclosures = 0.0;
        for other in surfaces.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, other)| other)
        {
            interrupt.charge(4 * other.len() as u64, 0.0)?;
            let angle: f64 = other.iter().map(|&face| solid_angle(corners(face).map(|v| v - origin))).sum();
            enclosures += angle / (4.0 * std::f64::consts::PI);
        }
        let (within, first) = (enclosures.round() as i64, surface[0]);
        match (volume > 0.0, within) {
            (true, 0) | (false, 1) => {}
            (false, 0) => {
                return Err(of_face(
                    first,
                    "turned inward",
                    "faces turned outward: vertices counterclockwise as seen from outside",
                ));
            }
            (true, _) => {
                return Err(of_face(
                    first,
                    "of a surface within another one",
                    "a hollow's faces turned inward, away from the solid",
                ));
            }
            (false, _) => return Err(of_face(first, "of a hollow outside the solid", "hollows within")),
        }
    }
    Ok(())
}

/// Returns the solid angle of a triangle as seen from the origin, positive if seen from behind (van Oosterom
/// & Strackee 1983).
pub fn solid_angle([a, b, c]: [Vec3; 3]) -> f64 {
    let (p, q, r) = (a.norm(), b.norm(), c.norm());
    2.0 * a.dot(&b.cross(&c)).atan2(p * q * r + a.dot(&b) * r + b.dot(&c) * p + c.dot(&a) * q)
}

/// Returns the sets of faces that are connected by edges.
fn surfaces(count: usize, edges: &[Edge]) -> Vec<Vec<usize>> {
    let mut parent: Vec<usize> = (0..count).collect();
    fn root(parent: &mut [usize], mut face: usize) -> usize {
        while parent[face] != face {
            parent[face] = parent[parent[face]];
            face = parent[face];
        }
        face
    }
    for edge in edges {
        let [i, j] = edge.faces.map(|face| root(&mut parent, face as usize));
        parent[i.max(j)] = i.min(j);
    }
    let mut surfaces: Vec<Vec<usize>> = Vec::new();
    let mut index = vec![usize::MAX; count];
    for face in 0..count {
        let first = root(&mut parent, face);
        if first == face {
            index[face] = surfaces.len();
            surfaces.push(Vec::new());
        }
        surfaces[index[first]].push(face);
    }
    surfaces
}

/// Returns the volume and the first and second moments.
pub fn sums(vertices: &[Vec3], faces: &[[u32; 3]]) -> (f64, Vec3, Mat3) {
    let (mut volume, mut first, mut second) = (0.0, Vec3::zeros(), Mat3::zeros());
    for face in faces {
        let [a, b, c] = face.map(|v| vertices[v as usize]);
        let v = a.dot(&b.cross(&c)) / 6.0;
        let s = a + b + c;
        volume += v;
        first += s * (v / 4.0);
        second +=
            (s * s.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose()) * (v / 20.0);
    }
    (volume, first, second)
}
