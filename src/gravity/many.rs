//! The gravity of bodies at many points, in blocks over the cores.
//!
//! What a point gets depends on the point alone: those of a block that need the same form of an ellipsoid's field are brought
//! together, and within the lanes no point looks at another.

use super::body_field::{BodyField, Kind, PartField, Polyhedral, columns};
use super::ellipsoidal::{Ellipsoidal, Gravity, MOST_FORMS, turned};
use crate::error::{Error, Result, require_finite};
use crate::math::lanes::{BLOCK, Lanes, dot, load_vector, minus, splat_vector};
use crate::math::{Mat3, Vec3};
use crate::patience::{Patience, UNITS};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::ops::Range;

/// A body's gravity where the body is.
#[derive(Debug, Clone, Copy)]
pub struct Attractor<'a> {
    /// The gravity in the body's frame.
    pub field: &'a BodyField,
    /// The body's centre in the frame of the points.
    pub position: Vec3,
    /// Turns the body's vectors into that frame.
    pub rotation: Mat3,
}

/// What is computed, and where it is put, in C order.
pub enum Wanted<'a> {
    /// Phi (P,) and g (P, 3).
    Field(&'a mut [f64], &'a mut [f64]),
    /// dg/dx (P, 3, 3).
    Gradient(&'a mut [f64]),
}

impl Default for Wanted<'_> {
    fn default() -> Self {
        Self::Gradient(&mut [])
    }
}

impl Wanted<'_> {
    /// What belongs to so many points, and the rest.
    pub fn split_at(self, count: usize) -> (Self, Self) {
        match self {
            Self::Field(potential, field) => {
                let (potential, field) = (potential.split_at_mut(count), field.split_at_mut(3 * count));
                (Self::Field(potential.0, field.0), Self::Field(potential.1, field.1))
            }
            Self::Gradient(gradient) => {
                let (now, later) = gradient.split_at_mut(9 * count);
                (Self::Gradient(now), Self::Gradient(later))
            }
        }
    }
}

/// Points, in C order.
#[derive(Debug, Clone, Copy)]
pub struct Points<'a> {
    /// Coordinates (P, 3).
    pub coordinates: &'a [f64],
    /// The shape in which the caller counts points, for errors.
    pub shape: &'a [usize],
    /// How many of the caller's points stand before these.
    pub before: usize,
}

/// Points of a block at most.
const CHUNK: usize = 512;

/// Work, in facets of a polyhedron, of a block at most, and of all blocks between two looks at the clock.
const BLOCK_WORK: usize = 100_000;
const GROUP_WORK: usize = 2_000_000;

impl Points<'_> {
    /// The gravity of bodies, summed.
    pub fn gravity(
        &self,
        attractors: &[Attractor<'_>],
        wanted: Wanted<'_>,
        arch: Arch,
        patience: &mut Patience,
    ) -> Result<()> {
        let parts = attractors.iter().flat_map(|attractor| &attractor.field.parts);
        let work: usize = parts.map(PartField::work).sum();
        let length = (BLOCK_WORK / work.max(1)).clamp(1, CHUNK);
        let mut jobs = jobs(self.coordinates, wanted, length);
        let group = (GROUP_WORK / (work * length).max(1)).max(1);
        for jobs in jobs.chunks_mut(group) {
            patience.spend(UNITS / 2, 0.0)?;
            let room = || Room::new(length.min(self.coordinates.len() / 3));
            // What is done sooner than threads wake.
            let bad = if jobs.len() * length * work < 2000 {
                let mut room = room();
                jobs.iter_mut().find_map(|job| job.run(attractors, arch, &mut room))
            } else {
                let run = |room: &mut Room, job: &mut Job<'_>| job.run(attractors, arch, room);
                jobs.par_iter_mut().map_init(room, run).flatten().min()
            };
            if let Some(index) = bad {
                return Err(self.complaint(attractors, index));
            }
        }
        Ok(())
    }

    /// Why there is no finite result at a point.
    fn complaint(&self, attractors: &[Attractor<'_>], index: usize) -> Error {
        let x = Vec3::from_column_slice(&self.coordinates[3 * index..][..3]);
        let what = self.label(index);
        if let Err(error) = require_finite(&what, x.as_slice()) {
            return error;
        }
        let value = format!("[{}, {}, {}]", x.x, x.y, x.z);
        for attractor in attractors {
            let name = &attractor.field.name;
            for part in &attractor.field.parts {
                let (position, turn) = part.placed(attractor);
                match &part.kind {
                    Kind::Ellipsoidal(point) if point.is_point() && x == position => {
                        let expected = format!("one away from the point mass of {name}");
                        return Error::invalid(what, value, expected);
                    }
                    Kind::Polyhedral(polyhedral) if polyhedral.is_surface(&(turn * (x - position))) => {
                        let expected = format!(
                            "one off the surface of {name}, where the gradient jumps and is infinite on edges"
                        );
                        return Error::invalid(what, value, expected);
                    }
                    _ => {}
                }
            }
        }
        let expected = "one where gravity is a finite number; choose units that keep the numbers in range";
        Error::invalid(what, value, expected)
    }

    /// The place of a point as the caller counts it.
    fn label(&self, index: usize) -> String {
        let mut rest = index + self.before;
        let mut places: Vec<String> = Vec::new();
        for &length in self.shape.iter().rev() {
            places.push((rest % length.max(1)).to_string());
            rest /= length.max(1);
        }
        places.reverse();
        match places.as_slice() {
            [] => "point".to_owned(),
            [place] => format!("point {place}"),
            _ => format!("point ({})", places.join(", ")),
        }
    }
}

impl PartField {
    /// Work at a point, in facets.
    fn work(&self) -> usize {
        match &self.kind {
            Kind::Ellipsoidal(_) => 4,
            Kind::Polyhedral(polyhedral) => polyhedral.polyhedron.faces().len(),
        }
    }

    /// The part's centre in the frame of the points, and what turns that frame's vectors into its own.
    fn placed(&self, attractor: &Attractor<'_>) -> (Vec3, Mat3) {
        (attractor.position + attractor.rotation * self.position, self.turn * attractor.rotation.transpose())
    }
}

/// A block of points and the places of its results.
struct Job<'a> {
    start: usize,
    points: &'a [f64],
    wanted: Wanted<'a>,
}

fn jobs<'a>(coordinates: &'a [f64], wanted: Wanted<'a>, length: usize) -> Vec<Job<'a>> {
    let mut rest = wanted;
    let blocks = coordinates.chunks(3 * length).enumerate();
    let job = |(block, points): (usize, &'a [f64])| {
        let (wanted, later) = std::mem::take(&mut rest).split_at(points.len() / 3);
        rest = later;
        Job { start: block * length, points, wanted }
    };
    blocks.map(job).collect()
}

impl Job<'_> {
    /// Computes the results, and gives the place of the first point that has none.
    fn run(&mut self, attractors: &[Attractor<'_>], arch: Arch, room: &mut Room) -> Option<usize> {
        let points = self.points.as_chunks::<3>().0;
        let out = match &mut self.wanted {
            Wanted::Field(potential, field) => {
                arch.dispatch(Block::<false> { attractors, points, room });
                let [phi, x, y, z, ..] = &room.out;
                potential.copy_from_slice(&phi[..points.len()]);
                let g = field.as_chunks_mut::<3>().0.iter_mut().zip(x).zip(y).zip(z);
                g.for_each(|(((g, x), y), z)| *g = [*x, *y, *z]);
                &room.out[..width(false)]
            }
            Wanted::Gradient(gradient) => {
                arch.dispatch(Block::<true> { attractors, points, room });
                let out = &room.out;
                for (k, matrix) in gradient.as_chunks_mut::<9>().0.iter_mut().enumerate() {
                    let [xx, xy, xz, yy, yz, zz] = [0, 1, 2, 3, 4, 5].map(|column| out[column][k]);
                    *matrix = [xx, xy, xz, xy, yy, yz, xz, yz, zz];
                }
                &out[..width(true)]
            }
        };
        // Without a way out of the loop, which is so the faster.
        let finite =
            |column: &Vec<f64>| column[..points.len()].iter().fold(true, |all, v| all & v.is_finite());
        if out.iter().all(finite) {
            return None;
        }
        let place = (0..points.len()).find(|k| out.iter().any(|column| !column[*k].is_finite()));
        place.map(|place| self.start + place)
    }
}

/// Columns of results: Phi and g, or the six of the gradient.
const fn width(gradient: bool) -> usize {
    if gradient { 6 } else { 4 }
}

/// Lists that a thread uses again and again. Those of points of a block fill whole lanes.
struct Room {
    points: [Vec<f64>; 3],
    out: [Vec<f64>; 6],
    /// Points in the frame and the unit of a part, and the forms that they need.
    local: [Vec<f64>; 3],
    levels: Vec<f64>,
    /// The same with those of a level together, each level filling whole lanes, and the results there.
    sorted: [Vec<f64>; 3],
    found: [Vec<f64>; 6],
    order: Vec<u16>,
}

impl Room {
    fn new(points: usize) -> Self {
        let lanes = points.next_multiple_of(BLOCK);
        let sorted = lanes + MOST_FORMS.min(points) * BLOCK;
        let list = |_| vec![0.0; lanes];
        Self {
            points: [(); 3].map(list),
            out: [(); 6].map(list),
            local: [(); 3].map(list),
            levels: list(()),
            sorted: [(); 3].map(|()| vec![0.0; sorted]),
            found: [(); 6].map(|()| vec![0.0; sorted]),
            order: vec![0; sorted],
        }
    }
}

/// What bodies do at the points of a block.
struct Block<'a, const GRADIENT: bool> {
    attractors: &'a [Attractor<'a>],
    points: &'a [[f64; 3]],
    room: &'a mut Room,
}

impl<const GRADIENT: bool> WithSimd for Block<'_, GRADIENT> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { attractors, points, room } = self;
        let count = points.len();
        let [x, y, z] = &mut room.points;
        for (((x, y), z), point) in x.iter_mut().zip(y).zip(z).zip(points) {
            (*x, *y, *z) = (point[0], point[1], point[2]);
        }
        // The last point fills the lanes.
        for column in &mut room.points {
            let last = column[count - 1];
            column[count..count.next_multiple_of(BLOCK)].fill(last);
        }
        room.out.iter_mut().take(width(GRADIENT)).for_each(|column| column.fill(0.0));
        for attractor in attractors {
            for part in &attractor.field.parts {
                let placed = part.placed(attractor);
                match &part.kind {
                    Kind::Ellipsoidal(kind) => {
                        add_ellipsoidal::<S, GRADIENT>(simd, kind, &placed, count, room);
                    }
                    Kind::Polyhedral(kind) => add_polyhedral::<GRADIENT>(kind, &placed, points, room),
                }
            }
        }
    }
}

/// Point by point: the lanes are at work within each.
fn add_polyhedral<const GRADIENT: bool>(
    polyhedral: &Polyhedral,
    (position, turn): &(Vec3, Mat3),
    points: &[[f64; 3]],
    room: &mut Room,
) {
    for (k, point) in points.iter().enumerate() {
        let x = turn * (Vec3::from(*point) - position);
        let mut f = polyhedral.at(&x);
        f.field = turn.tr_mul(&f.field);
        f.gradient = turn.tr_mul(&(f.gradient * turn));
        let all = if GRADIENT && polyhedral.is_surface(&x) { [f64::NAN; 10] } else { columns(&f) };
        let wanted = if GRADIENT { &all[4..] } else { &all[..4] };
        room.out.iter_mut().zip(wanted).for_each(|(column, value)| column[k] += value);
    }
}

#[inline(always)]
fn add_ellipsoidal<S: Simd, const GRADIENT: bool>(
    simd: S,
    ellipsoidal: &Ellipsoidal,
    (position, turn): &(Vec3, Mat3),
    count: usize,
    room: &mut Room,
) {
    let lanes = BLOCK / Lanes::<S>::PER_BLOCK;
    let centre = splat_vector(simd, position);
    let (mut nearest, mut farthest) = (Lanes::splat(simd, f64::INFINITY), Lanes::splat(simd, 0.0));
    for block in 0..count.div_ceil(lanes) {
        let x = load_vector(simd, &room.points, block);
        let from = ellipsoidal.in_unit(turned(minus(x, centre), turn));
        let level = ellipsoidal.level(dot(from, from));
        (nearest, farthest) = (nearest.min(level), farthest.max(level));
        level.store(&mut room.levels, block);
        for i in 0..3 {
            from[i].store(&mut room.local[i], block);
        }
    }
    let nearest = nearest.reduce_min();
    if nearest == farthest.reduce_max() {
        let blocks = 0..count.div_ceil(lanes);
        let Room { local, out, .. } = room;
        return evaluate::<S, GRADIENT>(simd, ellipsoidal, nearest as usize, turn, local, blocks, out);
    }
    let runs = sort(&room.levels[..count], lanes, &mut room.order);
    for (sorted, local) in room.sorted.iter_mut().zip(&room.local) {
        let order = &room.order[..runs[MOST_FORMS - 1].end.next_multiple_of(lanes)];
        sorted.iter_mut().zip(order).for_each(|(to, from)| *to = local[*from as usize]);
    }
    room.found.iter_mut().take(width(GRADIENT)).for_each(|column| column.fill(0.0));
    for (level, Range { start, end }) in runs.into_iter().enumerate() {
        let blocks = start / lanes..end.div_ceil(lanes);
        evaluate::<S, GRADIENT>(simd, ellipsoidal, level, turn, &room.sorted, blocks, &mut room.found);
        for (column, found) in room.out.iter_mut().zip(&room.found).take(width(GRADIENT)) {
            for (place, found) in room.order[start..end].iter().zip(&found[start..end]) {
                column[*place as usize] += found;
            }
        }
    }
}

/// Adds what there is at blocks of lanes, by one form.
#[inline(always)]
fn evaluate<S: Simd, const GRADIENT: bool>(
    simd: S,
    ellipsoidal: &Ellipsoidal,
    level: usize,
    turn: &Mat3,
    y: &[Vec<f64>; 3],
    blocks: Range<usize>,
    out: &mut [Vec<f64>; 6],
) {
    let Some(&(_, form)) = ellipsoidal.forms.get(level) else { return };
    let zero = Lanes::splat(simd, 0.0);
    for block in blocks {
        let Gravity { potential, field: [x, y, z], gradient } =
            ellipsoidal.by(form, load_vector(simd, y, block)).turned_back(turn);
        let found = if GRADIENT { gradient } else { [potential, x, y, z, zero, zero] };
        for k in 0..width(GRADIENT) {
            (Lanes::load(simd, &out[k], block) + found[k]).store(&mut out[k], block);
        }
    }
}

/// The order that brings the points of a level together, and their range. Each level fills whole lanes, by its first point.
fn sort(levels: &[f64], lanes: usize, order: &mut [u16]) -> [Range<usize>; MOST_FORMS] {
    let mut runs = [const { 0..0_usize }; MOST_FORMS];
    levels.iter().for_each(|level| runs[*level as usize].end += 1);
    let mut start = 0;
    for run in &mut runs {
        let count = run.end;
        (run.start, run.end) = (start, start);
        start += count.next_multiple_of(lanes);
    }
    for (place, level) in levels.iter().enumerate() {
        let next = &mut runs[*level as usize].end;
        order[*next] = place as u16;
        *next += 1;
    }
    for run in runs.iter().filter(|run| !run.is_empty()) {
        let first = order[run.start];
        order[run.end..run.end.next_multiple_of(lanes)].fill(first);
    }
    runs
}
