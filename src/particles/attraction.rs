//! The acceleration of a block of particles by the bodies' gravity.
//!
//! A lane's result does not depend on the other lanes, so that a particle flies in the same way alone and
//! among others.

use super::body_ephemeris::{COLUMNS, LaneBlock};
use crate::error::Result;
use crate::gravity::BodyField;
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;
use crate::math::lanes::{BLOCK, Lanes, dot};
use crate::math::rotation::{matrix, rotate, rotate_back};
use crate::shape::Body;
use pulp::{Arch, Simd};

/// The gravity of one body.
#[derive(Debug, Clone)]
pub struct ParticleAttractor {
    field: BodyField,
    /// G times the sum of the magnitudes of the parts' masses.
    pub strength: f64,
    /// Whether the field depends on the attitude.
    depends_on_attitude: bool,
    is_pointwise: bool,
}

impl ParticleAttractor {
    /// Prepares the gravity of a body. The moments of polyhedra may take a while.
    pub fn new(
        body: &Body,
        gravitational_constant: f64,
        arch: Arch,
        interrupt: &mut InterruptCheck,
    ) -> Result<Self> {
        let field = BodyField::new(body, gravitational_constant, arch, interrupt)?;
        let strength = gravitational_constant * body.mass_without_signs();
        let (depends_on_attitude, is_pointwise) = (!field.is_central(), field.is_pointwise());
        Ok(Self { field, strength, depends_on_attitude, is_pointwise })
    }

    /// Returns G times the mass.
    pub fn gm(&self) -> f64 {
        self.field.gm
    }

    /// Adds the acceleration of a block by the body with these columns. With `nearness`, the squared distance
    /// from the nearest centre and the potential of the centres are updated too.
    #[inline(always)]
    pub fn add<S: Simd>(
        &self,
        simd: S,
        columns: &[LaneBlock],
        x: &[LaneBlock; 3],
        out: &mut [LaneBlock; 3],
        mut nearness: Option<&mut [LaneBlock; 2]>,
    ) {
        for block in 0..Lanes::<S>::PER_BLOCK {
            let load = |values: &LaneBlock| Lanes::load(simd, values, block);
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
                (load(&near[1]) + c(self.gm()) / square.sqrt()).store(&mut near[1], block);
            }
            let g = if self.depends_on_attitude {
                let q = [load(&columns[3]), load(&columns[4]), load(&columns[5]), load(&columns[6])];
                let rows = rotation(q);
                let y = [column(&rows, 0, r), column(&rows, 1, r), column(&rows, 2, r)];
                let g = self.field.field_outside(y);
                [dot(rows[0], g), dot(rows[1], g), dot(rows[2], g)]
            } else {
                self.field.field_outside(r)
            };
            for k in 0..3 {
                (load(&out[k]) + g[k]).store(&mut out[k], block);
            }
        }
    }

    /// Adds the acceleration by the parts that are evaluated point by point.
    pub fn add_pointwise(&self, columns: &[LaneBlock], x: &[LaneBlock; 3], out: &mut [LaneBlock; 3]) {
        if !self.is_pointwise {
            return;
        }
        for lane in 0..BLOCK {
            let number = |column: usize| columns[column][lane];
            let rotation = matrix([3, 4, 5, 6].map(number));
            let r = Vec3::from([0, 1, 2].map(|c| x[c][lane] - number(c)));
            let g = rotate(&rotation, &self.field.pointwise_outside(&rotate_back(&rotation, &r)));
            (0..3).for_each(|c| out[c][lane] += g[c]);
        }
    }
}

/// Iterates over the bodies, each with its columns.
pub fn by_body(columns: &[LaneBlock]) -> impl Iterator<Item = &[LaneBlock]> {
    columns.chunks_exact(COLUMNS)
}

/// Returns the rows of the rotation matrix of a quaternion of any length.
#[inline(always)]
fn rotation<S: Simd>(q: [Lanes<S>; 4]) -> [[Lanes<S>; 3]; 3] {
    let c = |value| q[0].constant(value);
    let [w, x, y, z] = q;
    let s = c(2.0) / w.mul_add(w, x.mul_add(x, y.mul_add(y, z * z)));
    let (xs, ys, zs) = (x * s, y * s, z * s);
    let (wx, wy, wz) = (w * xs, w * ys, w * zs);
    let (xx, xy, xz) = (x * xs, x * ys, x * zs);
    let (yy, yz, zz) = (y * ys, y * zs, z * zs);
    let unit = c(1.0);
    [
        [unit - (yy + zz), xy - wz, xz + wy],
        [xy + wz, unit - (xx + zz), yz - wx],
        [xz - wy, yz + wx, unit - (xx + yy)],
    ]
}

/// Returns the scalar product of a column with a vector.
#[inline(always)]
fn column<S: Simd>(rows: &[[Lanes<S>; 3]; 3], k: usize, v: [Lanes<S>; 3]) -> Lanes<S> {
    dot([rows[0][k], rows[1][k], rows[2][k]], v)
}
