//! Regions of the unit sphere between planes and outside of cylinders, ring by ring.
//!
//! A point of the sphere has the height z along the pole and the longitude l: (rho cos l, rho sin l, z) with
//! rho^2 = 1 - z^2. A plane leaves of each ring an arc about its azimuth, whose half width is an arccosine. A
//! quadric crosses a ring where a quartic in tan(l/2) is zero. As a function of the height, an integral over the
//! arcs is smooth between heights at which the ends of arcs appear, vanish or meet.

use crate::integrate::polynomial_roots;
use crate::math::{Mat3, Vec3};
use std::f64::consts::{PI, TAU};

/// The cap of the sphere where normal.s + offset > 0, with a normal of unit length.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    normal: Vec3,
    offset: f64,
    /// The length of the normal's part across the pole, and its azimuth.
    across: f64,
    azimuth: f64,
}

/// The part of the sphere where s.M s + linear.s + constant > 0.
#[derive(Debug, Clone, Copy)]
pub struct Quadric {
    pub matrix: Mat3,
    pub linear: Vec3,
    pub constant: f64,
}

/// The part of the sphere that lies within all of some planes and quadrics.
#[derive(Debug, Clone, Default)]
pub struct Region {
    pub planes: Vec<Plane>,
    pub quadrics: Vec<Quadric>,
    arcs: [Vec<Arc>; 2],
    crossings: Vec<[f64; 2]>,
}

/// An arc of a ring: its ends, and the indices of the planes or quadrics that it lies between, counted from one; zero
/// for an end of the whole ring.
#[derive(Debug, Clone, Copy)]
struct Arc {
    ends: [f64; 2],
    between: [u64; 2],
}

/// Replaces arcs by their intersections with other arcs, which are those of the plane or quadric with an index.
fn intersect(arcs: &mut Vec<Arc>, parts: &mut Vec<Arc>, others: &[[f64; 2]], index: u64) {
    parts.clear();
    for Arc { ends: [from, to], between } in &*arcs {
        for &[low, high] in others {
            if *between == [0, 0] {
                parts.push(Arc { ends: [low, high], between: [index; 2] });
                continue;
            }
            let apart = 0.5 * (low + high - from - to);
            let nearest = wrapped(apart) - apart;
            // Two arcs that are together longer than the ring may meet at both their ends.
            let turns: &[f64] = if high - low + to - from > TAU { &[-TAU, 0.0, TAU] } else { &[0.0] };
            for turn in turns {
                let (low, high) = (low + nearest + turn, high + nearest + turn);
                let ends = [from.max(low), to.min(high)];
                if ends[1] > ends[0] {
                    let start = if low > *from { index } else { between[0] };
                    let end = if high < *to { index } else { between[1] };
                    parts.push(Arc { ends, between: [start, end] });
                }
            }
        }
    }
    std::mem::swap(arcs, parts);
}

/// Points that are outside of a plane by less than this count as within it.
const MARGIN: f64 = 1e-12;
/// The largest number of changes of the arcs between two rings that are searched for.
const CHANGES: usize = 6;
/// How often the interval between two rings is halved to find where the arcs change.
const HALVINGS: u32 = 48;
/// The number of rings on which changes of the arcs by quadrics are searched for.
const RINGS: usize = 128;

impl Plane {
    /// Takes a normal of any length above zero, and the offset in the same unit.
    pub fn new(normal: &Vec3, offset: f64) -> Self {
        let scale = normal.norm().recip();
        let normal = normal * scale;
        let across = (normal.x * normal.x + normal.y * normal.y).sqrt();
        Self { normal, offset: offset * scale, across, azimuth: normal.y.atan2(normal.x) }
    }

    /// Returns the plane with the opposite inner side.
    pub fn flipped(&self) -> Self {
        Self::new(&-self.normal, -self.offset)
    }

    /// Returns normal.s + offset.
    fn value(&self, s: &Vec3) -> f64 {
        self.normal.dot(s) + self.offset
    }

    /// Returns whether the whole sphere is on the inner side, 1, or on the outer side, -1; 0 if it is cut.
    pub fn side(&self) -> i32 {
        i32::from(self.offset >= 1.0) - i32::from(self.offset <= -1.0)
    }

    /// Calls `take` with the lowest and the highest point of the circle in which the plane cuts the sphere.
    fn extremes(&self, take: &mut impl FnMut(Vec3)) {
        let square = 1.0 - self.offset * self.offset;
        if square > 0.0 {
            let upward = Vec3::new(
                -self.normal.x * self.normal.z,
                -self.normal.y * self.normal.z,
                self.across.powi(2),
            );
            let upward = upward.try_normalize(1e-150).unwrap_or(Vec3::x()) * square.sqrt();
            [upward, -upward].into_iter().for_each(|offset| take(offset - self.normal * self.offset));
        }
    }

    /// Calls `take` with the points of the sphere that are on two planes.
    fn intersections(&self, other: &Self, take: &mut impl FnMut(Vec3)) {
        let along = self.normal.cross(&other.normal);
        let square = along.norm_squared();
        let nearest =
            (other.normal.cross(&along) * -self.offset + along.cross(&self.normal) * -other.offset) / square;
        let square_length = (1.0 - nearest.norm_squared()) / square;
        if square > 1e-28 && square_length > 0.0 {
            let offset = along * square_length.sqrt();
            [offset, -offset].into_iter().for_each(|offset| take(nearest + offset));
        }
    }
}

impl Quadric {
    fn value(&self, s: &Vec3) -> f64 {
        s.dot(&(self.matrix * s)) + self.linear.dot(s) + self.constant
    }

    /// Writes the arcs of a ring within the quadric, which is a whole ring or begins and ends where the ring crosses it.
    fn arcs(&self, z: f64, rho: f64, arcs: &mut Vec<[f64; 2]>) {
        arcs.clear();
        self.crossings(z, rho, |l| arcs.push([l; 2]));
        let value = |l: f64| self.value(&Vec3::new(rho * l.cos(), rho * l.sin(), z));
        if arcs.is_empty() {
            arcs.push([-PI, PI]);
        } else {
            arcs.sort_unstable_by(|one, other| one[0].total_cmp(&other[0]));
            let first = arcs[0][0] + TAU;
            for k in 0..arcs.len() {
                arcs[k][1] = arcs.get(k + 1).map_or(first, |next| next[0]);
            }
        }
        arcs.retain(|[from, to]| to > from && value(0.5 * (from + to)) > 0.0);
    }

    /// Calls `take` with the longitudes at which a ring crosses the quadric.
    fn crossings(&self, z: f64, rho: f64, mut take: impl FnMut(f64)) {
        let m = &self.matrix;
        let (cc, ss, cs) = (rho * rho * m[(0, 0)], rho * rho * m[(1, 1)], rho * rho * m[(0, 1)]);
        let [c, s] = [0, 1].map(|k| rho * (2.0 * z * m[(k, 2)] + self.linear[k]));
        let constant = z * (z * m[(2, 2)] + self.linear.z) + self.constant;
        // With t = tan(l/2) each half of the ring has t from -1 to 1; its other half has the opposite cosine and sine.
        for (origin, sign) in [(0.0, 1.0), (PI, -1.0)] {
            let (c, s) = (sign * c, sign * s);
            let quartic = [
                cc + c + constant,
                4.0 * cs + 2.0 * s,
                4.0 * ss + 2.0 * (constant - cc),
                2.0 * s - 4.0 * cs,
                cc - c + constant,
            ];
            polynomial_roots(&quartic, &mut |t| take(wrapped(origin + 2.0 * t.atan())));
        }
    }
}

/// Returns an angle between -pi and pi, given one that is at most a turn outside.
pub fn wrapped(angle: f64) -> f64 {
    if angle > PI {
        angle - TAU
    } else if angle < -PI {
        angle + TAU
    } else {
        angle
    }
}

impl Region {
    /// Returns the part of the region within further planes.
    pub fn within(&self, planes: &[Plane]) -> Self {
        let mut part = self.clone();
        part.planes.extend_from_slice(planes);
        part
    }

    /// Calls `take` with both ends of each arc of a ring within the region, the second above the first. Returns a
    /// number that tells between which planes and quadrics the arcs lie, zero if there are none.
    pub fn arcs(&mut self, z: f64, mut take: impl FnMut(f64, f64)) -> u64 {
        let rho = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        let Self { planes, quadrics, arcs: [arcs, parts], crossings } = self;
        arcs.clear();
        arcs.push(Arc { ends: [-PI, PI], between: [0, 0] });
        for (index, plane) in (1..).zip(&*planes) {
            let (level, across) = (plane.normal.z * z + plane.offset, rho * plane.across);
            if level <= -across {
                arcs.clear();
            } else if level < across {
                let half = (-level / across).acos();
                intersect(arcs, parts, &[[plane.azimuth - half, plane.azimuth + half]], index);
            }
        }
        for (index, quadric) in (planes.len() as u64 + 1..).zip(&*quadrics) {
            if !arcs.is_empty() {
                quadric.arcs(z, rho, crossings);
                intersect(arcs, parts, crossings, index);
            }
        }
        let mut signature = 0_u64;
        for Arc { ends: [from, to], between: [start, end] } in &*arcs {
            take(*from, *to);
            signature = signature.wrapping_add((1 + 31 * start + end).pow(2));
        }
        signature
    }

    /// Returns the heights, in rising order, of the points where the planes meet each other and where they and the
    /// sphere are lowest and highest; none if the planes leave nothing. Within the planes the sphere reaches from the
    /// first to the last one.
    pub fn corners(&self) -> Vec<f64> {
        let mut heights = Vec::new();
        let mut add = |s: Vec3| {
            if self.planes.iter().all(|plane| plane.value(&s) > -MARGIN) {
                heights.push(s.z.clamp(-1.0, 1.0));
            }
        };
        [1.0, -1.0].into_iter().for_each(|z| add(Vec3::z() * z));
        for (k, plane) in self.planes.iter().enumerate() {
            plane.extremes(&mut add);
            self.planes[..k].iter().for_each(|other| plane.intersections(other, &mut add));
        }
        heights.sort_unstable_by(f64::total_cmp);
        heights.dedup_by(|one, other| *one - *other < MARGIN);
        heights
    }

    /// Returns the heights between which integrals over the arcs of rings are smooth: the corners, and those where
    /// quadrics change the arcs.
    pub fn heights(&mut self) -> Vec<f64> {
        let mut heights = self.corners();
        if !self.quadrics.is_empty() {
            for k in 1..heights.len() {
                let (from, length) = (heights[k - 1], heights[k] - heights[k - 1]);
                // Rings are nearer to each other at both ends, where outlines may meet the limb.
                let ring = |index: usize| {
                    let share = 0.5 - 0.5 * (PI * index as f64 / RINGS as f64).cos();
                    from + length * share.clamp(MARGIN, 1.0 - MARGIN)
                };
                let mut low = ring(0);
                let mut signature = self.arcs(low, |_, _| ());
                for high in (1..=RINGS).map(ring) {
                    let next = self.arcs(high, |_, _| ());
                    for _ in 0..CHANGES {
                        if next == signature {
                            break;
                        }
                        low = self.change(low, high, signature);
                        heights.push(low);
                        signature = self.arcs(low, |_, _| ());
                    }
                    (low, signature) = (high, next);
                }
            }
            heights.sort_unstable_by(f64::total_cmp);
        }
        heights
    }

    /// Returns the first height, up to rounding, at which the arcs are no longer those of the lower one of two heights.
    fn change(&mut self, mut low: f64, mut high: f64, signature: u64) -> f64 {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.arcs(middle, |_, _| ()) == signature {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }
}
