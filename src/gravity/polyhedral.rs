//! The potential, field and gradient of a homogeneous polyhedron, exact, inside and outside (Werner &
//! Scheeres 1996, Celestial Mechanics and Dynamical Astronomy 65, 313).
//!
//! With r_e and r_f the vectors from the point to the edge e and the face f, let F_f = n n^T and E_e = n_A
//! m_A^T + n_B m_B^T, where n are the outward normals of the faces and m those of the edge in its two faces.
//! With V the volume, per unit GM,
//!
//!   Phi = (1/2V) [ sum_e r_e.E_e r_e L_e - sum_f r_f.F_f r_f w_f ],
//!   g   = (1/V) [ sum_f F_f r_f w_f - sum_e E_e r_e L_e ],
//!   dg/dx = (1/V) [ sum_e E_e L_e - sum_f F_f w_f ],
//!
//!   L_e = ln (p + q + e)/(p + q - e),   tan(w_f/2) = a.(b x c) / (abc + a b.c + b c.a + c a.b).
//!
//! Here p and q are the distances of the edge's ends and e is its length. Near the edge p + q - e loses its
//! digits; with the vectors p and q it equals 2 (pq + p.q)/(p + q + e), and pq + p.q = |p x q|^2/(pq - p.q)
//! where p.q is negative. Away from the edge L is the logarithm of a number near one, which [`ln_one_plus`]
//! computes without loss.
//!
//! The sums cancel away from the body: at the distance r they lose (r/R)^2 of their digits. Beyond a few
//! sizes of the body [`super::Layer`] gives the field with all digits.

use crate::math::lanes::{BLOCK, Lanes, Total, cross, dot, load_vector, minus, splat_vector, total_vector};
use crate::math::logarithm::{angle, ln_one_plus};
use crate::math::{Mat3, Vec3};
use crate::shape::Polyhedron;
use pulp::{Arch, Simd, WithSimd};

/// Potential, field and gradient per unit GM, and the solid angle of the surface as seen from the point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolyhedralField {
    /// The potential Phi, positive.
    pub potential: f64,
    /// The field g = grad Phi.
    pub field: Vec3,
    /// The gradient dg/dx; infinite on edges, and with a jump on faces.
    pub gradient: Mat3,
    /// The solid angle: 4 pi inside, 0 outside.
    pub solid_angle: f64,
}

/// The precomputed, point-independent terms of a polyhedron's field, edge by edge and face by face.
#[derive(Debug, Clone, PartialEq)]
pub struct Facets {
    /// For each edge, its ends (6), its length and E_e (6).
    edges: Vec<Vec<f64>>,
    /// For each face, its corners (9), its unit normal (3) and twice its area.
    faces: Vec<Vec<f64>>,
    /// For each edge whose faces do not lie in one plane, an end (3), the vector to the other end (3) and the
    /// inverse of that vector's square.
    ridges: Vec<Vec<f64>>,
    volume: f64,
}

const EDGE: usize = 13;
const FACE: usize = 13;
const RIDGE: usize = 7;
/// The size of an edge's dyad below which the field is smooth to round-off across the edge.
const FLAT: f64 = 1e-14;

impl Facets {
    /// Precomputes the terms of a polyhedron in units of `unit`.
    pub fn new(polyhedron: &Polyhedron, unit: f64) -> Self {
        let vertices: Vec<Vec3> = polyhedron.vertices().map(|v| v / unit).collect();
        let corners = |face: u32| polyhedron.faces()[face as usize].map(|v| vertices[v as usize]);
        let all = 0..polyhedron.faces().len() as u32;
        let areas: Vec<Vec3> = all.clone().map(corners).map(|[a, b, c]| (b - a).cross(&(c - a))).collect();
        let normals: Vec<Vec3> =
            all.clone().map(corners).zip(&areas).map(|(face, area)| normal(face, area)).collect();
        // Rows that fill up the last block of edges and faces have no weight.
        let (mut edges, mut ridges) = (Columns::new(EDGE), Columns::new(RIDGE));
        for edge in polyhedron.edges() {
            let [a, b] = edge.ends.map(|v| vertices[v as usize]);
            let along = b - a;
            let direction = along.normalize();
            let [n, m] = edge.faces.map(|face| normals[face as usize]);
            let dyad = n * direction.cross(&n).transpose() - m * direction.cross(&m).transpose();
            let dyad = 0.5 * (dyad + dyad.transpose());
            if dyad.norm() > FLAT {
                let inverse = 1.0 / along.norm_squared();
                ridges.push([a.x, a.y, a.z, along.x, along.y, along.z, inverse]);
            }
            let [xx, xy, xz] = [dyad[(0, 0)], dyad[(0, 1)], dyad[(0, 2)]];
            let [yy, yz, zz] = [dyad[(1, 1)], dyad[(1, 2)], dyad[(2, 2)]];
            edges.push([a.x, a.y, a.z, b.x, b.y, b.z, along.norm(), xx, xy, xz, yy, yz, zz]);
        }
        let mut faces = Columns::new(FACE);
        for ((face, area), n) in all.zip(&areas).zip(&normals) {
            let [a, b, c] = corners(face);
            faces.push([a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, n.x, n.y, n.z, area.norm()]);
        }
        Self {
            edges: edges.padded(),
            faces: faces.padded(),
            ridges: ridges.filled(),
            volume: polyhedron.volume() / unit.powi(3),
        }
    }

    /// Returns the distance of a point from the nearest edge whose faces do not lie in one plane; only there
    /// is the exterior potential singular.
    pub fn edge_distance(&self, arch: Arch, x: &Vec3) -> f64 {
        arch.dispatch(NearestEdge { facets: self, x })
    }

    /// Returns potential, field, gradient and solid angle at a point.
    pub fn at(&self, arch: Arch, x: &Vec3) -> PolyhedralField {
        arch.dispatch(Evaluation::<true> { facets: self, x })
    }

    /// Returns potential, field and solid angle, with a gradient of zeros.
    pub fn field(&self, arch: Arch, x: &Vec3) -> PolyhedralField {
        arch.dispatch(Evaluation::<false> { facets: self, x })
    }
}

/// Returns the normal of a face from its area vector. For a thin face, whose area vector has lost digits to
/// rounding, the normal is made perpendicular to its edges with all digits: the large dyads of the edges then
/// cancel as accurately as the small face requires.
fn normal([a, b, c]: [Vec3; 3], area: &Vec3) -> Vec3 {
    let [first, second, third] = [b - a, c - b, a - c];
    let longest = [second, third]
        .into_iter()
        .fold(first, |edge, other| if other.norm_squared() > edge.norm_squared() { other } else { edge });
    let across = area - longest * (longest.dot(area) / longest.norm_squared());
    across.normalize()
}

/// Columns of numbers of equal length.
struct Columns(Vec<Vec<f64>>);

impl Columns {
    fn new(width: usize) -> Self {
        Self(vec![Vec::new(); width])
    }

    fn push<const N: usize>(&mut self, row: [f64; N]) {
        self.0.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
    }

    /// Fills the last block with copies of the first row.
    fn filled(mut self) -> Vec<Vec<f64>> {
        for column in &mut self.0 {
            let first = column.first().copied().unwrap_or(0.0);
            column.resize(column.len().next_multiple_of(BLOCK), first);
        }
        self.0
    }

    fn padded(mut self) -> Vec<Vec<f64>> {
        for column in &mut self.0 {
            column.resize(column.len().next_multiple_of(BLOCK), 0.0);
        }
        self.0
    }
}

struct Evaluation<'a, const GRADIENT: bool> {
    facets: &'a Facets,
    x: &'a Vec3,
}

impl<const GRADIENT: bool> WithSimd for Evaluation<'_, GRADIENT> {
    type Output = PolyhedralField;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> PolyhedralField {
        let x = splat_vector(simd, self.x);
        let c = |value| Lanes::splat(simd, value);
        let zero = Total::zero(simd);
        let (mut potential, mut solid_angle) = ([zero; 2], zero);
        let (mut field, mut gradient) = ([[zero; 3]; 2], [[zero; 6]; 2]);

        let edges = &self.facets.edges;
        for block in 0..edges[0].len() / BLOCK * Lanes::<S>::PER_BLOCK {
            let p = minus(load_vector(simd, &edges[0..], block), x);
            let q = minus(load_vector(simd, &edges[3..], block), x);
            let length = Lanes::load(simd, &edges[6], block);
            let (pp, qq) = (dot(p, p).sqrt(), dot(q, q).sqrt());
            let (product, scalar) = (pp * qq, dot(p, q));
            let across = cross(p, minus(q, p));
            // The argument z of ln(1 + z) is e (p + q + e)/(pq + p.q), with pq + p.q = |p x q|^2/(pq - p.q)
            // where p.q is negative.
            let sum = product + scalar.abs();
            let over = length * (pp + qq + length);
            let (over, under) =
                (scalar.if_less(c(0.0), over * sum, over), scalar.if_less(c(0.0), dot(across, across), sum));
            // On the edge itself the logarithm is infinite, and its factor is zero.
            let under = under.max(over.mul_add(c(LEAST), c(f64::MIN_POSITIVE)));
            let log = ln_one_plus(over, under);
            let [xx, xy, xz] = load_vector(simd, &edges[7..], block);
            let [yy, yz, zz] = load_vector(simd, &edges[10..], block);
            let dyad = [xx, xy, xz, yy, yz, zz];
            let er = [dot([xx, xy, xz], p), dot([xy, yy, yz], p), dot([xz, yz, zz], p)];
            potential[0].add_product(dot(er, p), log);
            for i in 0..3 {
                field[0][i].add_product(er[i], log);
            }
            if GRADIENT {
                for k in 0..6 {
                    gradient[0][k].add_product(dyad[k], log);
                }
            }
        }

        let faces = &self.facets.faces;
        for block in 0..faces[0].len() / BLOCK * Lanes::<S>::PER_BLOCK {
            let a = minus(load_vector(simd, &faces[0..], block), x);
            let b = minus(load_vector(simd, &faces[3..], block), x);
            let d = minus(load_vector(simd, &faces[6..], block), x);
            let (p, q, r) = (dot(a, a).sqrt(), dot(b, b).sqrt(), dot(d, d).sqrt());
            let n = load_vector(simd, &faces[9..], block);
            let height = dot(n, a);
            let under = (p * q).mul_add(r, p.mul_add(dot(b, d), q.mul_add(dot(d, a), r * dot(a, b))));
            let half = angle(height * Lanes::load(simd, &faces[12], block), under);
            let omega = half + half;
            let weighted = height * omega;
            solid_angle.add(omega);
            potential[1].add_product(height, weighted);
            for i in 0..3 {
                field[1][i].add_product(n[i], weighted);
            }
            if GRADIENT {
                let scaled = [n[0] * omega, n[1] * omega, n[2] * omega];
                for (k, (i, j)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
                    gradient[1][k].add_product(scaled[i], n[j]);
                }
            }
        }

        let volume = self.facets.volume;
        let [xx, xy, xz, yy, yz, zz] =
            [0, 1, 2, 3, 4, 5].map(|k| (gradient[0][k].value() - gradient[1][k].value()) / volume);
        PolyhedralField {
            potential: 0.5 * (potential[0].value() - potential[1].value()) / volume,
            field: (total_vector(field[1]) - total_vector(field[0])) / volume,
            gradient: Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            solid_angle: solid_angle.value(),
        }
    }
}

struct NearestEdge<'a> {
    facets: &'a Facets,
    x: &'a Vec3,
}

impl WithSimd for NearestEdge<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let (x, ridges) = (splat_vector(simd, self.x), &self.facets.ridges);
        let c = |value| Lanes::splat(simd, value);
        // Squares are negated, since lanes have a maximum only.
        let mut nearest = c(f64::NEG_INFINITY);
        for block in 0..ridges[0].len() / BLOCK * Lanes::<S>::PER_BLOCK {
            let from: [Lanes<S>; 3] = minus(x, load_vector(simd, &ridges[0..], block));
            let along = load_vector(simd, &ridges[3..], block);
            let part = (dot(from, along) * Lanes::load(simd, &ridges[6], block)).max(c(0.0));
            let part = -(-part).max(c(-1.0));
            let perpendicular =
                [from[0] - part * along[0], from[1] - part * along[1], from[2] - part * along[2]];
            nearest = nearest.max(-dot(perpendicular, perpendicular));
        }
        (-nearest.reduce_max()).sqrt()
    }
}

/// The least ratio whose logarithm is taken: beyond it, a point is on the edge.
const LEAST: f64 = 1e-60;
