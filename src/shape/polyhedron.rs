//! The homogeneous polyhedron: a solid within triangles, with its volume, centre, second moments and harmonic
//! moments.
//!
//! With tetrahedra from an origin to the faces (a, b, c), each with the signed volume v = a.(b x c)/6, the
//! volume is sum v, the first moments are sum v (a + b + c)/4, and the second ones
//!
//!   int x_i x_j dV = sum v/20 [ s_i s_j + a_i a_j + b_i b_j + c_i c_j ],   s = a + b + c
//!
//! (Lien & Kajiya 1984, IEEE Computer Graphics and Applications 4 (10), 35). A polynomial H that is
//! homogeneous of degree n has the integral sum_f h_f / (n + 3) int_f H dS, with h_f the face's height above
//! the origin, and Gauss's rule on a face is exact to any degree.

use super::distance::{angle_at, between_triangles, closest_point};
use super::frame::{WorkingFrame, principal_axes, quaternion};
use super::horizon::Horizons;
use super::mesh::{Edge, SOLID_ANGLE, check, check_solid, solid_angle, sums};
use super::moment_cache::{MomentCache, cached_moments};
use super::tree::{BoundingBox, Tree};
use crate::error::{Error, Result};
use crate::interrupt::InterruptCheck;
use crate::math::harmonics::{self, WeightedHarmonics};
use crate::math::lanes::BLOCK;
use crate::math::{Mat3, Vec3, triangle};
use pulp::Arch;
use std::convert::Infallible;
use std::mem::discriminant;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

/// Units of work of the distance of two faces.
const FACE_PAIR: u64 = 20;

/// A homogeneous polyhedron in its own frame: the origin in the centre of mass, the axes along the principal
/// axes of inertia. Copies share their data.
///
/// ```
/// use fullbody::interrupt::InterruptCheck;
/// use fullbody::math::Vec3;
/// use fullbody::shape::{Body, Polyhedron, Shape};
///
/// // An octahedron, whose faces are counterclockwise from outside.
/// let corners = [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| [axis, -axis]).concat();
/// let mut faces = Vec::new();
/// for [x, y, z] in [[0, 2, 4], [3, 0, 4], [1, 3, 4], [2, 1, 4]] {
///     faces.extend([[x, y, z], [y, x, 5]]);
/// }
/// let octahedron = Polyhedron::new(&corners, &faces, &mut InterruptCheck::never())?;
/// let body = Body::with_density("Octahedron", Shape::Polyhedron(octahedron), 3.0)?;
/// assert!((body.mass() - 4.0).abs() < 1e-14); // its volume is 4/3
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Polyhedron {
    solid: Arc<Solid>,
    /// The factor from the lengths of the shared solid to those of this polyhedron.
    scale: f64,
}

#[derive(Debug)]
struct Solid {
    /// The vertices as they were given, in the working frame.
    input_vertices: Vec<Vec3>,
    vertices: Vec<Vec3>,
    faces: Vec<[u32; 3]>,
    edges: Vec<Edge>,
    tree: Tree,
    volume: f64,
    inertia: Vec3,
    circumradius: f64,
    frame: WorkingFrame,
    /// Whether the faces are known to bound a solid.
    checked: AtomicBool,
    /// The cached harmonic moments.
    moments: MomentCache,
    /// The horizons of the faces, once they are known; none for a convex polyhedron.
    horizons: OnceLock<Option<Horizons>>,
}

impl PartialEq for Polyhedron {
    fn eq(&self, other: &Self) -> bool {
        let same = |a: &Solid, b: &Solid| a.input_vertices == b.input_vertices && a.faces == b.faces;
        self.scale == other.scale
            && (Arc::ptr_eq(&self.solid, &other.solid) || same(&self.solid, &other.solid))
    }
}

impl Solid {
    /// Returns the corners of a face.
    fn corners(&self, face: u32) -> [Vec3; 3] {
        self.faces[face as usize].map(|v| self.vertices[v as usize])
    }
}

impl Polyhedron {
    /// Makes a polyhedron from vertices and the triangles between them, whose vertices are counterclockwise
    /// as seen from outside.
    ///
    /// The surface must be closed, each edge shared by two faces, with no face doubled, without an area or
    /// crossing another. Several surfaces, one beside another or a hollow in a solid, are one polyhedron.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] names the vertex, edge or face at fault, and [`Error::Interrupted`].
    pub fn new(input_vertices: &[Vec3], faces: &[[u32; 3]], interrupt: &mut InterruptCheck) -> Result<Self> {
        let edges = check(input_vertices, faces)?;
        check_solid(input_vertices, faces, &edges, interrupt)?;
        let polyhedron = Self::from_edges(input_vertices, faces, edges)?;
        polyhedron.solid.checked.store(true, Ordering::Relaxed);
        Ok(polyhedron)
    }

    /// Makes a polyhedron from a description, where no interrupt can be checked: [`Self::check`] makes the
    /// long checks before the polyhedron is used.
    pub(super) fn unchecked(input_vertices: &[Vec3], faces: &[[u32; 3]]) -> Result<Self> {
        Self::from_edges(input_vertices, faces, check(input_vertices, faces)?)
    }

    /// Checks that the faces bound a solid, where that is not yet known.
    ///
    /// # Errors
    /// Returns the errors of [`Self::new`].
    pub fn check(&self, interrupt: &mut InterruptCheck) -> Result<()> {
        if !self.solid.checked.load(Ordering::Relaxed) {
            check_solid(&self.solid.input_vertices, &self.solid.faces, &self.solid.edges, interrupt)?;
            self.solid.checked.store(true, Ordering::Relaxed);
        }
        Ok(())
    }

    fn from_edges(input_vertices: &[Vec3], faces: &[[u32; 3]], edges: Vec<Edge>) -> Result<Self> {
        // Vertices that belong to no face do not count.
        let mut used = vec![false; input_vertices.len()];
        faces.iter().flatten().for_each(|&v| used[v as usize] = true);
        let count = used.iter().filter(|used| **used).count();
        let middle =
            input_vertices.iter().zip(&used).filter(|(_, used)| **used).map(|(v, _)| v).sum::<Vec3>()
                / count as f64;
        let vertices: Vec<Vec3> = input_vertices.iter().map(|v| v - middle).collect();
        let (volume, first, _) = sums(&vertices, faces);
        let reach = |face: &[u32; 3], vertices: &[Vec3]| {
            face.map(|v| vertices[v as usize].norm()).into_iter().fold(0.0, f64::max)
        };
        let extent = faces.iter().map(|face| reach(face, &vertices)).fold(0.0, f64::max);
        if !(volume > 1e-12 * extent.powi(3) && volume.is_finite()) {
            return Err(Error::invalid("volume", volume, "one above zero, in units that keep it in range"));
        }
        let shift = first / volume;
        let vertices: Vec<Vec3> = vertices.iter().map(|v| v - shift).collect();
        let (volume, _, second) = sums(&vertices, faces);
        let second = second / volume;
        let tensor = Mat3::from_diagonal_element(second.trace()) - second;
        let axes = principal_axes(&tensor, tensor.trace());
        let vertices: Vec<Vec3> = vertices.iter().map(|v| axes * v).collect();
        let blocks: Vec<BoundingBox> =
            faces.iter().map(|face| BoundingBox::around(&face.map(|v| vertices[v as usize]))).collect();
        let solid = Solid {
            input_vertices: input_vertices.to_vec(),
            circumradius: faces.iter().map(|face| reach(face, &vertices)).fold(0.0, f64::max),
            inertia: (axes * tensor * axes.transpose()).diagonal(),
            frame: WorkingFrame { position: -(axes * (middle + shift)), attitude: quaternion(&axes) },
            tree: Tree::new(&blocks),
            faces: faces.to_vec(),
            edges,
            volume,
            vertices,
            checked: AtomicBool::new(false),
            moments: MomentCache::default(),
            horizons: OnceLock::new(),
        };
        Ok(Self { solid: Arc::new(solid), scale: 1.0 })
    }

    /// Returns the polyhedron with all lengths multiplied by a factor above zero.
    #[doc(hidden)]
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { solid: self.solid.clone(), scale: self.scale * factor }
    }

    /// Returns numbers that identify the polyhedron: only copies of it share them while one of them exists.
    pub fn identity(&self) -> (usize, u64) {
        (Arc::as_ptr(&self.solid) as usize, self.scale.to_bits())
    }

    /// Iterates over the vertices in the polyhedron's own frame.
    pub fn vertices(&self) -> impl Iterator<Item = Vec3> {
        self.solid.vertices.iter().map(|v| v * self.scale)
    }

    /// Iterates over the vertices as they were given, in the working frame.
    pub fn input_vertices(&self) -> impl Iterator<Item = Vec3> {
        self.solid.input_vertices.iter().map(|v| v * self.scale)
    }

    /// Returns the triangles as indices of vertices.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.solid.faces
    }

    /// Returns the edges with their faces.
    pub fn edges(&self) -> &[Edge] {
        &self.solid.edges
    }

    /// Returns the volume.
    pub fn volume(&self) -> f64 {
        self.solid.volume * self.scale.powi(3)
    }

    /// Returns where the frame in which the vertices were given lies in the polyhedron's own frame.
    pub fn working_frame(&self) -> WorkingFrame {
        let WorkingFrame { position, attitude } = self.solid.frame;
        WorkingFrame { position: position * self.scale, attitude }
    }

    /// Returns the principal moments of inertia of unit mass.
    pub fn inertia_per_mass(&self) -> Vec3 {
        self.solid.inertia * (self.scale * self.scale)
    }

    /// Returns the largest distance of a vertex from the centre of mass.
    pub fn circumradius(&self) -> f64 {
        self.solid.circumradius * self.scale
    }

    /// Returns the corners of a face.
    pub fn corners(&self, face: usize) -> [Vec3; 3] {
        self.solid.corners(face as u32).map(|v| v * self.scale)
    }

    /// Returns the distance of a point from the surface, from either side.
    pub fn distance(&self, point: &Vec3) -> f64 {
        self.scale * self.closest(&(point / self.scale)).0
    }

    /// Returns the distance and the position of the surface point nearest to a point, at scale one.
    fn closest(&self, point: &Vec3) -> (f64, Vec3) {
        let mut nearest = (f64::INFINITY, *point);
        let to_face = |face: u32, _| {
            let closest = closest_point(point, &self.solid.corners(face));
            let distance = (closest - point).norm();
            if distance < nearest.0 {
                nearest = (distance, closest);
            }
            Ok::<f64, Infallible>(distance)
        };
        let Ok(_) = self.solid.tree.least(f64::INFINITY, |block| block.distance(point), to_face);
        nearest
    }

    /// Returns the outward normal at the surface point nearest to a point, and a height over it whose sign
    /// tells whether the point is outside. On an edge or a corner the normals of all adjacent faces are
    /// weighted by their angles (Baerentzen & Aanaes 2005, IEEE TVCG 11, 243).
    pub fn outward(&self, point: &Vec3) -> (Vec3, f64) {
        let (local, size) = (point / self.scale, self.solid.circumradius);
        let (distance, nearest) = self.closest(&local);
        // Faces count as nearest within rounding.
        let most = distance * (1.0 + 1e-12) + 1e-14 * size;
        let (mut normal, mut height) = (Vec3::zeros(), 0.0);
        let around = BoundingBox::around(&[local.add_scalar(-most), local.add_scalar(most)]);
        self.solid.tree.meeting(&around, |face| {
            let triangle @ [a, b, c] = self.solid.corners(face);
            let closest = closest_point(&local, &triangle);
            let from = local - closest;
            if from.norm() <= most && (closest - nearest).norm() <= 1e-7 * size {
                let face_normal =
                    (b - a).cross(&(c - a)).normalize() * angle_at(&closest, &triangle, 1e-7 * size);
                normal += face_normal;
                height += face_normal.dot(&from);
            }
        });
        (normal.normalize(), height * self.scale)
    }

    /// Returns the horizons of the faces, which are found once; `None` for a convex polyhedron.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    #[doc(hidden)]
    pub fn horizons(&self, interrupt: &mut InterruptCheck) -> Result<Option<&Horizons>> {
        let solid = &self.solid;
        if let Some(horizons) = solid.horizons.get() {
            return Ok(horizons.as_ref());
        }
        let triangles: Vec<_> = (0..solid.faces.len() as u32).map(|face| solid.corners(face)).collect();
        let horizons = Horizons::new(&triangles, &solid.tree, interrupt)?;
        Ok(solid.horizons.get_or_init(|| horizons).as_ref())
    }

    /// Returns the least value of a function of a face's corners; `bound` returns a lower bound for all faces in a box.
    pub(super) fn nearest(
        &self,
        bound: impl Fn(&BoundingBox) -> f64,
        mut value: impl FnMut([Vec3; 3]) -> Result<f64>,
    ) -> Result<f64> {
        let bound = |block: &BoundingBox| bound(&block.scaled(self.scale));
        self.solid.tree.least(f64::INFINITY, bound, |face, _| value(self.corners(face as usize)))
    }

    /// Returns the distance of the nearest faces of this polyhedron and of another one at this position and
    /// rotation; zero where they meet. `charge` counts work and checks for an interrupt.
    pub(super) fn nearest_to(
        &self,
        other: &Self,
        position: &Vec3,
        rotation: &Mat3,
        charge: &mut impl FnMut(u64) -> Result<()>,
    ) -> Result<f64> {
        let bounding_box = self.solid.tree.bounding_box().scaled(self.scale);
        // Each face of the other polyhedron is searched against the tree of this one.
        let bound = |block: &BoundingBox| {
            let (centre, radius) = block.scaled(other.scale).sphere();
            bounding_box.distance(&(position + rotation * centre)) - radius
        };
        other.solid.tree.least(f64::INFINITY, bound, |face, least| {
            let triangle = other.corners(face as usize).map(|v| position + rotation * v);
            let around = BoundingBox::around(&triangle);
            let bound = |block: &BoundingBox| block.scaled(self.scale).apart(&around);
            self.solid.tree.least(least, bound, |face, _| {
                charge(FACE_PAIR)?;
                Ok(between_triangles(&self.corners(face as usize), &triangle))
            })
        })
    }

    /// Returns the units of work of [`Self::contains`].
    pub(super) fn work_of_containment(&self) -> u64 {
        SOLID_ANGLE * self.faces().len() as u64
    }

    /// Returns whether a point lies within the solid. For a point on the surface either answer is possible.
    pub fn contains(&self, point: &Vec3) -> bool {
        if point.norm() > self.circumradius() {
            return false;
        }
        let solid_angle_of = |face| solid_angle(self.corners(face).map(|v| v - point));
        (0..self.faces().len()).map(solid_angle_of).sum::<f64>() > 2.0 * std::f64::consts::PI
    }

    /// Returns the means over the solid of the solid harmonics of x / circumradius up to a degree, in the
    /// order of `math::harmonics::index`. They are cached.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    #[doc(hidden)]
    pub fn harmonic_moments(
        &self,
        degree: usize,
        arch: Arch,
        interrupt: &mut InterruptCheck,
    ) -> Result<Arc<Vec<f64>>> {
        let key = (degree, self.scale.to_bits(), Some(discriminant(&arch)));
        cached_moments(&self.solid.moments, key, || self.moments_to(degree, arch, interrupt))
    }

    fn moments_to(&self, degree: usize, arch: Arch, interrupt: &mut InterruptCheck) -> Result<Vec<f64>> {
        let unit = 1.0 / self.circumradius();
        let faces = (0..self.faces().len()).map(|face| self.corners(face).map(|v| v * unit));
        solid_moments(faces, self.volume() * unit.powi(3), degree, arch, interrupt)
    }
}

/// Returns the means of the solid harmonics up to a degree over the solid within triangles, of which none
/// reaches beyond the unit sphere.
///
/// # Errors
/// [`Error::Interrupted`].
pub(crate) fn solid_moments(
    triangles: impl Iterator<Item = [Vec3; 3]>,
    volume: f64,
    degree: usize,
    arch: Arch,
    interrupt: &mut InterruptCheck,
) -> Result<Vec<f64>> {
    let mut rules: Vec<Option<Vec<triangle::TriangleNode>>> = vec![None; degree / 2 + 2];
    let mut points: [Vec<f64>; 3] = Default::default();
    let mut weights = Vec::new();
    let mut moments = vec![0.0; harmonics::count(degree)];
    let mut add = |points: &mut [Vec<f64>; 3], weights: &mut Vec<f64>| {
        let length = weights.len().next_multiple_of(BLOCK);
        points.iter_mut().for_each(|p| p.resize(length, 0.0));
        weights.resize(length, 0.0);
        let [x, y, z] = &*points;
        arch.dispatch(WeightedHarmonics { points: [x, y, z], weights, degree, sums: &mut moments });
        points.iter_mut().for_each(Vec::clear);
        weights.clear();
    };
    for [a, b, c] in triangles {
        let order = points_for(degree, [a, b, c]);
        interrupt.charge((order * order * harmonics::count(degree) / 64 + 1) as u64, 0.0)?;
        let rule = rules[order].get_or_insert_with(|| triangle::rule(order));
        // This is six times the volume of the tetrahedron: height times twice the area.
        let solid = 0.5 * a.dot(&b.cross(&c));
        for node in rule {
            let [i, j, k] = node.shares;
            let x = a * i + b * j + c * k;
            points.iter_mut().zip(x.iter()).for_each(|(p, x)| p.push(*x));
            weights.push(node.weight * solid);
        }
        if weights.len() >= 4096 {
            add(&mut points, &mut weights);
        }
    }
    add(&mut points, &mut weights);
    for n in 0..=degree {
        moments[n * n..harmonics::count(n)].iter_mut().for_each(|m| *m /= (n + 3) as f64 * volume);
    }
    Ok(moments)
}

/// Returns the order of Gauss's rule for harmonics up to a degree on a face near the unit sphere: exact, or
/// accurate to round-off on a small face.
///
/// On the ellipse of the complex plane with the parameter rho about a segment of half-length d, the harmonics
/// are below e^(degree d rho / 2), so that n points err by (4 n / (degree d e))^-2n with the best rho.
fn points_for(degree: usize, [a, b, c]: [Vec3; 3]) -> usize {
    let middle = (a + b + c) / 3.0;
    let size = (a - middle).norm().max((b - middle).norm()).max((c - middle).norm());
    let exact = degree / 2 + 1;
    let enough = |n: usize| {
        let rate = 4.0 * n as f64 / (degree as f64 * size * std::f64::consts::E);
        rate > 1.0 && rate.powi(-2 * n as i32) < 1e-17
    };
    (1..exact).find(|&n| enough(n)).unwrap_or(exact)
}
