//! The bodies' gravity on a block of particles.
//!
//! A lane's result does not depend on the other lanes, so that a particle flies alone as it flies among others.

use super::course::{Block, COLUMNS};
use crate::error::Result;
use crate::gravity::{Anywhere, Ellipsoidal};
use crate::math::lanes::{BLOCK, Lanes, dot};
use crate::math::rotation::{matrix, turned, turned_back};
use crate::math::{Mat3, Vec3};
use crate::patience::Patience;
use crate::shape::{Body, Part, Place, Shape};
use pulp::{Arch, Simd};

/// A body's gravity.
#[derive(Debug, Clone)]
pub struct Puller {
    /// G times the mass.
    pub gm: f64,
    /// G times the mass of matter and voids together.
    pub strength: f64,
    parts: Vec<PartPuller>,
    /// Whether the attitude matters.
    turns: bool,
}

#[derive(Debug, Clone)]
struct PartPuller {
    gm: f64,
    place: Option<Place>,
    law: Law,
}

#[derive(Debug, Clone)]
enum Law {
    Point,
    Ellipsoid { field: Box<Ellipsoidal>, canonical: Mat3 },
    Polyhedron(Box<Anywhere>),
}

impl Puller {
    /// Of a body. Moments of polyhedra may take a while.
    pub fn new(
        body: &Body,
        gravitational_constant: f64,
        arch: Arch,
        patience: &mut Patience,
    ) -> Result<Self> {
        let part = |part: &Part| {
            let law = match &part.shape {
                Shape::Point => Law::Point,
                Shape::Ellipsoid(ellipsoid) => {
                    let [a, _, c] = ellipsoid.sorted();
                    if a == c {
                        Law::Point
                    } else {
                        let field = Ellipsoidal::new(&part.shape, gravitational_constant * part.mass);
                        Law::Ellipsoid { field: Box::new(field), canonical: ellipsoid.canonical() }
                    }
                }
                Shape::Polyhedron(p) => Law::Polyhedron(Box::new(Anywhere::new(p, arch, patience)?)),
            };
            Ok(PartPuller { gm: gravitational_constant * part.mass, place: part.place, law })
        };
        let parts = body.parts().iter().map(part).collect::<Result<Vec<_>>>()?;
        let central = |part: &PartPuller| matches!(part.law, Law::Point) && part.place.is_none();
        let strength = gravitational_constant * body.mass_without_signs();
        Ok(Self {
            gm: gravitational_constant * body.mass,
            strength,
            turns: !parts.iter().all(central),
            parts,
        })
    }

    /// Adds the acceleration of a block by the body whose columns these are. With `nearness`, the square of the distance from the
    /// nearest centre and the potential of the centres are brought up to date too.
    #[inline(always)]
    pub fn add<S: Simd>(
        &self,
        simd: S,
        columns: &[Block],
        x: &[Block; 3],
        out: &mut [Block; 3],
        mut nearness: Option<&mut [Block; 2]>,
    ) {
        for block in 0..Lanes::<S>::PER_BLOCK {
            let load = |values: &Block| Lanes::load(simd, values, block);
            let r = [
                load(&x[0]) - load(&columns[0]),
                load(&x[1]) - load(&columns[1]),
                load(&x[2]) - load(&columns[2]),
            ];
            let c = |value| r[0].constant(value);
            if let Some(near) = nearness.as_deref_mut() {
                let square = dot(r, r);
                let nearest = load(&near[0]);
                square.if_less(nearest, square, nearest).store(&mut near[0], block);
                (load(&near[1]) + c(self.gm) / square.sqrt()).store(&mut near[1], block);
            }
            let mut sum = [load(&out[0]), load(&out[1]), load(&out[2])];
            if !self.turns {
                for part in &self.parts {
                    let g = point(r, part.gm);
                    for k in 0..3 {
                        sum[k] = sum[k] + g[k];
                    }
                }
            } else {
                let q = [load(&columns[3]), load(&columns[4]), load(&columns[5]), load(&columns[6])];
                let rows = rotation(q);
                let y = [column(&rows, 0, r), column(&rows, 1, r), column(&rows, 2, r)];
                let mut g = [c(0.0); 3];
                for part in &self.parts {
                    let own = part.pull(y);
                    for k in 0..3 {
                        g[k] = g[k] + own[k];
                    }
                }
                for k in 0..3 {
                    sum[k] = sum[k] + dot(rows[k], g);
                }
            }
            for k in 0..3 {
                sum[k].store(&mut out[k], block);
            }
        }
    }

    /// The same of the body's polyhedra, which are evaluated point by point.
    pub fn add_polyhedra(&self, columns: &[Block], x: &[Block; 3], out: &mut [Block; 3]) {
        for part in &self.parts {
            let Law::Polyhedron(polyhedron) = &part.law else { continue };
            for lane in 0..BLOCK {
                let number = |column: usize| columns[column][lane];
                let turn = matrix([3, 4, 5, 6].map(number));
                let r = Vec3::from([0, 1, 2].map(|c| x[c][lane] - number(c)));
                let mut y = turned_back(&turn, &r);
                let mut g = match &part.place {
                    None => polyhedron.at(&y).field,
                    Some(place) => {
                        y = turned_back(&place.rotation, &(y - place.position));
                        turned(&place.rotation, &polyhedron.at(&y).field)
                    }
                };
                g = turned(&turn, &g) * part.gm;
                (0..3).for_each(|c| out[c][lane] += g[c]);
            }
        }
    }
}

/// The columns of all bodies, one body after the other.
pub fn by_body(columns: &[Block]) -> impl Iterator<Item = &[Block]> {
    columns.chunks_exact(COLUMNS)
}

impl PartPuller {
    /// The acceleration in the body frame at a place in it.
    #[inline(always)]
    fn pull<S: Simd>(&self, y: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
        let mut y = y;
        if let Some(place) = &self.place {
            let p = place.position;
            let c = |value| y[0].constant(value);
            y = back(&place.rotation, [y[0] - c(p.x), y[1] - c(p.y), y[2] - c(p.z)]);
        }
        let g = match &self.law {
            Law::Point => point(y, self.gm),
            Law::Ellipsoid { field, canonical } => back(canonical, field.at(forth(canonical, y)).field),
            Law::Polyhedron(_) => [y[0].constant(0.0); 3],
        };
        match &self.place {
            None => g,
            Some(place) => forth(&place.rotation, g),
        }
    }
}

/// -GM r / |r|^3.
#[inline(always)]
fn point<S: Simd>(r: [Lanes<S>; 3], gm: f64) -> [Lanes<S>; 3] {
    let square = dot(r, r);
    let strength = r[0].constant(-gm) / (square * square.sqrt());
    [strength * r[0], strength * r[1], strength * r[2]]
}

/// The rows of the rotation matrix of a quaternion of any length.
#[inline(always)]
fn rotation<S: Simd>(q: [Lanes<S>; 4]) -> [[Lanes<S>; 3]; 3] {
    let c = |value| q[0].constant(value);
    let [w, x, y, z] = q;
    let s = c(2.0) / w.mul_add(w, x.mul_add(x, y.mul_add(y, z * z)));
    let (xs, ys, zs) = (x * s, y * s, z * s);
    let (wx, wy, wz) = (w * xs, w * ys, w * zs);
    let (xx, xy, xz) = (x * xs, x * ys, x * zs);
    let (yy, yz, zz) = (y * ys, y * zs, z * zs);
    let one = c(1.0);
    [
        [one - (yy + zz), xy - wz, xz + wy],
        [xy + wz, one - (xx + zz), yz - wx],
        [xz - wy, yz + wx, one - (xx + yy)],
    ]
}

/// The scalar product of a column with a vector.
#[inline(always)]
fn column<S: Simd>(rows: &[[Lanes<S>; 3]; 3], k: usize, v: [Lanes<S>; 3]) -> Lanes<S> {
    dot([rows[0][k], rows[1][k], rows[2][k]], v)
}

#[inline(always)]
fn forth<S: Simd>(m: &Mat3, v: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
    back(&m.transpose(), v)
}

/// The transposed matrix times a vector.
#[inline(always)]
fn back<S: Simd>(m: &Mat3, v: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
    let mut out = v;
    for i in 0..3 {
        let c = |k: usize| v[0].constant(m[(k, i)]);
        out[i] = v[0].mul_add(c(0), v[1].mul_add(c(1), v[2] * c(2)));
    }
    out
}
