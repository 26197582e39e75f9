//! Cells of a polyhedron's faces, each with the Gauss rule that integrates another body's potential over it.
//!
//! The other body's potential is analytic except on a singular set within that body: an ellipsoid's focal
//! ellipse, or a polyhedron's edges. Let the set be at distance d from the centre of a cell of radius s. The
//! error of a rule that is exact to degree L then falls like rate^-L. The rate depends on where the set lies:
//! it is between d/s in the cell's plane and twice that above it (Lundin's function; see `convergence`).
//! Halfway between it is
//!
//!   rate = x + sqrt(1 + x^2),    x = d / (sqrt(2) s).
//!
//! A cell for which this gives too many points is halved across its longest side. Towards a point of the set
//! the cells shrink with the distance, so that their number grows with the logarithm of the distance. Halving
//! ends where the contribution of a cell to the error is below the tolerance: the potential of a polyhedron
//! is singular on its edges like d^2 ln d.
//!
//! Cells follow from the pose alone and are not stored: they are made while the sum is taken, on a stack of
//! fixed size.

use crate::error::Result;
use crate::interrupt::{self, InterruptCheck};
use crate::math::Vec3;
use crate::shape::Polyhedron;
use std::ops::Range;

/// The largest number of points along a side of a cell.
pub const MOST_POINTS: usize = 12;
/// The largest number of halvings of a cell, which is also the size of the stack.
const MAX_HALVINGS: usize = 64;
/// The number of units into which a face can be divided between the pieces of a sum.
const UNITS: usize = 64;
/// The work of one piece of a sum.
const WORK: u64 = interrupt::UNITS;

/// The requirements of a rule over cells: the singularity of the other body's potential, and the allowed error.
#[derive(Debug, Clone, Copy)]
pub struct Demand {
    /// The smallest error that matters, as a force per unit G m m times the volume.
    pub error: f64,
    /// The radius of the other body.
    pub radius: f64,
    /// The power of the distance with which the singular part vanishes on the set: 0 for an ellipsoid, 2 for
    /// a polyhedron's potential, 1 for its field.
    pub power: i32,
}

impl Demand {
    /// Returns the number of points along a side for a cell of this area and radius at this distance from the
    /// singular set; `None` where the cell must be halved.
    fn points(&self, area: f64, radius: f64, distance: f64) -> Option<usize> {
        /// The error of a rule for the singular part, relative to that part, if it vanishes like the
        /// distance; the square of this number if it vanishes like the square.
        const SMOOTH: f64 = 0.1;
        let (reach, singular_radius) = (distance + radius, self.radius);
        let strength = if reach < singular_radius {
            (reach / singular_radius).powi(self.power) / singular_radius
        } else {
            1.0 / reach
        };
        let reduction = area * strength / self.error;
        if reduction <= 1.0 {
            return Some(2);
        }
        if reduction * SMOOTH.powi(self.power) <= 1.0 {
            return Some(4);
        }
        let x = distance / (std::f64::consts::SQRT_2 * radius);
        let degree = reduction.ln() / (x + 1.0f64.hypot(x)).ln();
        let points = (0.5 * degree).ceil() + 1.0;
        (points <= MOST_POINTS as f64).then_some((points as usize).max(2))
    }
}

/// A triangle within a face.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    /// The corners, in the polyhedron's frame.
    pub corners: [Vec3; 3],
    /// The outward normal.
    pub normal: Vec3,
    /// The area divided by the polyhedron's volume.
    pub share: f64,
    /// The number of points along a side.
    pub points: usize,
    unit: usize,
    span: usize,
    depth: usize,
}

/// The division of a polyhedron's cells into pieces of a sum.
#[derive(Debug, Clone, Default)]
pub struct Division {
    /// The number of points in all cells.
    pub points: usize,
    /// The units at which the second and later pieces begin.
    pub begins: Vec<usize>,
}

/// Iterates over the cells of a polyhedron's faces; `distance` returns the distance from a point to the
/// singular set.
pub struct Cells<'a, D> {
    polyhedron: &'a Polyhedron,
    demand: Demand,
    distance: D,
    range: Range<usize>,
    face: usize,
    volume: f64,
    stack: [Cell; MAX_HALVINGS + 1],
    length: usize,
}

impl<'a, D: FnMut(&Vec3) -> f64> Cells<'a, D> {
    /// Starts with the first cell of a range of units.
    #[inline]
    pub fn new(polyhedron: &'a Polyhedron, demand: Demand, range: &Range<usize>, distance: D) -> Self {
        let zero = Vec3::zeros();
        let none =
            Cell { corners: [zero; 3], normal: zero, share: 0.0, points: 0, unit: 0, span: 0, depth: 0 };
        let range = range.start..range.end.min(UNITS * polyhedron.faces().len());
        let (face, volume) = (range.start / UNITS, polyhedron.volume());
        Self { polyhedron, demand, distance, range, face, volume, stack: [none; MAX_HALVINGS + 1], length: 0 }
    }

    /// Divides all cells into pieces of a few milliseconds, where each point takes the work `work_per_point`.
    /// Returns `None` if all points together take more than `most`.
    pub fn divide(
        self,
        work_per_point: u64,
        most: u64,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<Division>> {
        let (mut division, mut work, mut all) = (Division::default(), 0, 0);
        for cell in self {
            interrupt.charge(1 + work_per_point / 8, 0.0)?;
            let points = cell.points * cell.points;
            let more = points as u64 * work_per_point;
            if work + more > WORK && division.begins.last().copied().unwrap_or(0) < cell.unit {
                division.begins.push(cell.unit);
                work = 0;
            }
            work += more;
            all += more;
            division.points += points;
            if all > most {
                return Ok(None);
            }
        }
        Ok(Some(division))
    }

    fn push(&mut self, cell: Cell) {
        self.stack[self.length] = cell;
        self.length += 1;
    }

    fn push_whole_face(&mut self) -> bool {
        if self.face * UNITS >= self.range.end {
            return false;
        }
        let corners @ [a, b, c] = self.polyhedron.corners(self.face);
        let across = (b - a).cross(&(c - a));
        let twice = across.norm();
        let unit = self.face * UNITS;
        self.face += 1;
        let share = 0.5 * twice / self.volume;
        self.push(Cell { corners, normal: across / twice, share, points: 0, unit, span: UNITS, depth: 0 });
        true
    }

    fn halve(&mut self, cell: Cell) {
        let corners = cell.corners;
        let side = |k: usize| (corners[(k + 2) % 3] - corners[(k + 1) % 3]).norm_squared();
        let apex = if side(0) >= side(1) && side(0) >= side(2) {
            0
        } else if side(1) >= side(2) {
            1
        } else {
            2
        };
        let [a, b, c] = [0, 1, 2].map(|k| corners[(apex + k) % 3]);
        let middle = 0.5 * (b + c);
        let half =
            Cell { share: 0.5 * cell.share, depth: cell.depth + 1, span: (cell.span / 2).max(1), ..cell };
        let second = if cell.span > 1 { cell.unit + half.span } else { cell.unit };
        self.push(Cell { corners: [a, middle, c], unit: second, ..half });
        self.push(Cell { corners: [a, b, middle], ..half });
    }
}

impl<D: FnMut(&Vec3) -> f64> Iterator for Cells<'_, D> {
    type Item = Cell;

    fn next(&mut self) -> Option<Cell> {
        loop {
            if self.length == 0 && !self.push_whole_face() {
                return None;
            }
            self.length -= 1;
            let cell = self.stack[self.length];
            if cell.unit >= self.range.end || cell.unit + cell.span <= self.range.start {
                continue;
            }
            let [a, b, c] = &cell.corners;
            let centre = (a + b + c) / 3.0;
            let radius =
                (a - centre).norm_squared().max((b - centre).norm_squared()).max((c - centre).norm_squared());
            let distance = (self.distance)(&centre);
            match self.demand.points(cell.share, radius.sqrt(), distance) {
                None if cell.depth < MAX_HALVINGS => self.halve(cell),
                points if cell.unit >= self.range.start => {
                    return Some(Cell { points: points.unwrap_or(MOST_POINTS), ..cell });
                }
                _ => {}
            }
        }
    }
}
