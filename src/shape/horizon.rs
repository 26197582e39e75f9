//! The horizon of each face of a polyhedron: the directions that nothing of the polyhedron can hide from any
//! point of the face.
//!
//! A face g hides a direction d from a point x of the face f where d is along y - x, y a point of g, and d
//! enters the solid through g. The differences of the corners of g and f span the cone of these directions.
//! About f the azimuth is divided into sectors. The cone's largest slope over the plane of f in a sector is
//! found at a corner within it or on its borders, and exceeds these only by one over the cosine of half the
//! sector. Beside this, d enters through g only below the plane of g. The lower one of the two bounds counts.

use super::tree::Tree;
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;
use std::array::from_fn;
use std::ops::ControlFlow;

/// The number of sectors of the azimuth.
const SECTORS: usize = 32;

/// Points that are nearer to a plane than this, in sizes of a face, are in it.
const LEVEL: f64 = 1e-12;

/// The largest number of faces in all lists together, of 12 bytes each.
const MOST_LISTED: usize = 4_000_000;

/// The horizons of all faces.
#[derive(Debug)]
pub struct Horizons {
    faces: Vec<Horizon>,
    /// The faces that make the horizons, and where the list of each face begins, with the end of the last
    /// one; lists that take too much room are left out.
    hiding: Vec<HidingFace>,
    starts: Vec<usize>,
}

/// The horizon of a face.
#[derive(Debug)]
struct Horizon {
    /// Two unit vectors in its plane, from which the azimuth is counted.
    axes: [Vec3; 2],
    /// For each sector the sine of the elevation above which nothing is hidden.
    sines: [f32; SECTORS],
}

/// A face that may hide directions from another one.
#[derive(Debug, Clone, Copy)]
pub struct HidingFace {
    /// The index of the face.
    pub face: u32,
    /// The sectors in which it does so, as bits.
    sectors: u32,
    /// The sine of the elevation above which it hides nothing.
    sine: f32,
}

/// The directions near one that a face's horizon may hide: its sector, as a bit, and the sine of its elevation.
#[derive(Debug, Clone, Copy)]
pub struct Elevation {
    sector: u32,
    sine: f64,
}

/// A sector of the azimuth: unit vectors along its borders, and the cosine of half of its angle.
struct Sector {
    borders: [[f64; 2]; 2],
    cos: f64,
}

/// Returns a number that grows with the azimuth of a vector, from zero to the number of sectors.
#[inline]
fn azimuth([x, y]: [f64; 2]) -> f64 {
    let share = y / (x.abs() + y.abs());
    (if x >= 0.0 { share + 1.0 } else { 3.0 - share }) * (0.25 * SECTORS as f64)
}

/// Returns the unit vector on the border below a sector.
fn border(sector: usize) -> [f64; 2] {
    let share = 4.0 * sector as f64 / SECTORS as f64 - 1.0;
    let [x, y] =
        if share <= 1.0 { [1.0 - share.abs(), share] } else { [(2.0 - share).abs() - 1.0, 2.0 - share] };
    [x / x.hypot(y), y / x.hypot(y)]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

impl Horizons {
    /// Finds the horizons of triangles, whose boxes are in the tree. Returns `None` if no triangle rises over
    /// the plane of another one, as in a convex polyhedron.
    pub fn new(triangles: &[[Vec3; 3]], tree: &Tree, interrupt: &mut InterruptCheck) -> Result<Option<Self>> {
        let sectors: [Sector; SECTORS] = from_fn(|k| {
            let borders = [border(k), border((k + 1) % SECTORS)];
            Sector { borders, cos: (0.5 * (1.0 + dot(borders[0], borders[1]))).sqrt() }
        });
        let normals: Vec<Vec3> =
            triangles.iter().map(|[a, b, c]| (b - a).cross(&(c - a)).normalize()).collect();
        let count = triangles.len();
        let mut all = Self { faces: Vec::with_capacity(count), hiding: Vec::new(), starts: vec![0] };
        let mut list = Vec::new();
        for (own, [a, b, c]) in triangles.iter().enumerate() {
            let (normal, size) = (normals[own], (b - a).norm().max((c - a).norm()));
            let first = (b - a).normalize();
            let frame = [first, normal.cross(&first)];
            let mut slopes = [0.0; SECTORS];
            list.clear();
            let mut work = 10;
            let rises =
                |middle: Vec3, half: Vec3| normal.dot(&(middle - a)) + normal.abs().dot(&half) > LEVEL * size;
            let _: ControlFlow<()> = tree.search(
                |block| rises(0.5 * (block.low + block.high), 0.5 * (block.high - block.low)),
                |other| {
                    let (corners, other_normal) = (&triangles[other as usize], &normals[other as usize]);
                    work += 1;
                    let heights = corners.map(|v| normal.dot(&(v - a)));
                    let reach = LEVEL * (corners[1] - corners[0]).norm();
                    let faces = [a, b, c].iter().any(|v| other_normal.dot(&(*v - corners[0])) > reach);
                    if other as usize != own && faces && heights.iter().any(|h| *h > LEVEL * size) {
                        work += 20;
                        let local = |v: &Vec3| frame.map(|axis| axis.dot(&(v - a)));
                        let differences: [_; 9] = from_fn(|k| {
                            let ([x, y], [x0, y0]) = (local(&corners[k / 3]), local([a, b, c][k % 3]));
                            ([x - x0, y - y0], heights[k / 3])
                        });
                        let plane = (frame.map(|axis| axis.dot(other_normal)), normal.dot(other_normal));
                        let (bits, slope) = raise(&mut slopes, &sectors, &differences, plane);
                        list.push(HidingFace { face: other, sectors: bits, sine: sine(slope) });
                    }
                    ControlFlow::Continue(())
                },
            );
            interrupt.charge(work, 0.0)?;
            all.faces.push(Horizon { axes: frame, sines: slopes.map(sine) });
            if all.starts.len() == all.faces.len() && all.hiding.len() + list.len() <= MOST_LISTED {
                list.retain(|hiding| hiding.sectors != 0);
                list.sort_unstable_by(|a, b| b.sine.total_cmp(&a.sine).then(a.face.cmp(&b.face)));
                all.hiding.extend_from_slice(&list);
                all.starts.push(all.hiding.len());
            }
        }
        all.hiding.shrink_to_fit();
        Ok(all.faces.iter().flat_map(|face| face.sines).any(|sine| sine > 0.0).then_some(all))
    }

    /// Returns `None` if the whole polyhedron leaves a direction free at a face, over whose plane it has this
    /// sine.
    #[inline]
    pub fn below(&self, face: usize, direction: &Vec3, sine: f64) -> Option<Elevation> {
        // A direction along the normal has no azimuth.
        let Horizon { axes: [x, y], sines } = &self.faces[face];
        let azimuth = azimuth([x.dot(direction), y.dot(direction)]);
        let sector = (azimuth as usize).min(SECTORS - 1);
        (sine < f64::from(sines[sector])).then_some(Elevation { sector: 1 << sector, sine })
    }

    /// Iterates over the faces that may hide a direction from a face; `None` if these are not listed.
    pub fn hiding(&self, face: usize, at: Elevation) -> Option<impl Iterator<Item = u32>> {
        let list = &self.hiding[*self.starts.get(face)?..*self.starts.get(face + 1)?];
        let higher = list.iter().take_while(move |hiding| at.sine < f64::from(hiding.sine));
        Some(higher.filter(move |hiding| hiding.sectors & at.sector != 0).map(|hiding| hiding.face))
    }
}

/// Returns the sine of the elevation with this slope, with a margin for the rounding of directions and of
/// these numbers.
fn sine(slope: f64) -> f32 {
    let sine = if slope < 1e8 { slope / slope.hypot(1.0) } else { 1.0 };
    if slope > 0.0 { (sine * (1.0 + 1e-6) + 1e-7) as f32 } else { 0.0 }
}

/// Raises the slopes of a face's horizon to those of another face, given the differences of their corners in
/// the plane and across it and that face's normal, likewise. Returns the sectors of the other face, as bits,
/// and its largest slope.
fn raise(
    slopes: &mut [f64; SECTORS],
    sectors: &[Sector; SECTORS],
    differences: &[([f64; 2], f64); 9],
    (normal, upward): ([f64; 2], f64),
) -> (u32, f64) {
    let middle = differences.iter().fold([0.0; 2], |sum, (r, _)| [sum[0] + r[0], sum[1] + r[1]]);
    // Corners in common have no difference.
    let apart = || differences.iter().filter(|(r, h)| *r != [0.0; 2] || *h != 0.0);
    let narrow = apart().all(|(r, _)| dot(*r, middle) > 1e-3 * (dot(*r, *r) * dot(middle, middle)).sqrt());
    let ends = narrow.then(|| {
        let tangent = |r: [f64; 2]| cross(middle, r) / dot(middle, r);
        let least = |sign: f64| {
            apart().map(|(r, _)| *r).min_by(|a, b| (sign * tangent(*a)).total_cmp(&(sign * tangent(*b))))
        };
        [least(1.0), least(-1.0)].map(|r| r.map_or(0, |r| azimuth(r) as usize % SECTORS))
    });
    let [first, last] = ends.unwrap_or([0, SECTORS - 1]);
    let on_border = |c: [f64; 2]| {
        let mut most = f64::NEG_INFINITY;
        for (r, h) in apart() {
            let left = cross(c, *r);
            if left <= 0.0 {
                continue;
            }
            for (other, height) in apart() {
                let right = -cross(c, *other);
                if right >= 0.0 {
                    let ahead = right * dot(c, *r) + left * dot(c, *other);
                    if ahead > 0.0 {
                        most = most.max((right * h + left * height) / ahead);
                    }
                }
            }
        }
        most
    };
    let (mut bits, mut highest) = (0, 0.0_f64);
    let mut below = if narrow { on_border(sectors[first].borders[0]) } else { f64::INFINITY };
    for step in 0..=(last + SECTORS - first) % SECTORS {
        let index = (first + step) % SECTORS;
        let Sector { borders, cos } = &sectors[index];
        let mut most = f64::INFINITY;
        if narrow {
            let above = on_border(borders[1]);
            let within = apart().filter(|(r, _)| azimuth(*r) as usize % SECTORS == index);
            most = within.map(|(r, h)| h / dot(*r, *r).sqrt()).fold(below.max(above), f64::max) / cos;
            below = above;
        }
        let toward = borders.map(|c| -dot(normal, c)).into_iter().fold(f64::NEG_INFINITY, f64::max) / cos;
        if upward > 1e-9 {
            most = most.min(toward / upward);
        }
        if most > 0.0 {
            bits |= 1 << index;
            highest = highest.max(most);
            slopes[index] = slopes[index].max(most);
        }
    }
    (bits, highest)
}
