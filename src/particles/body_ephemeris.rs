//! The ephemeris of the bodies: positions and attitudes at many times at once, from the polynomials of a
//! run's steps.

use crate::dynamics::{AttitudeChart, BarycentricFrame};
use crate::integrate::{MAX_TERMS, Segment};
use crate::math::lanes::BLOCK;
use crate::math::{Mat3, Vec3, rotation};
use pulp::Simd;
use std::ops::Range;

/// One number for each particle of a block.
pub type LaneBlock = [f64; BLOCK];

/// The number of columns of a body: position and quaternion.
pub const COLUMNS: usize = 7;

/// The steps of a run in the order of time, with a range of them packed for quick evaluation.
#[derive(Debug, Clone)]
pub struct BodyEphemeris<'a> {
    frame: &'a BarycentricFrame,
    segments: Vec<&'a Segment>,
    /// The earlier end of each step.
    from: Vec<f64>,
    /// The range of steps that is packed.
    step_range: Range<usize>,
    /// The length of a row: a multiple of the widest register.
    width: usize,
    /// The number of rows of a step: the vector at its start, the low part of that vector, and the
    /// coefficients.
    rows: usize,
    packed: Vec<f64>,
    /// Bounds over the packed range, one for each body.
    pub bounds: Vec<MotionBounds>,
}

/// Bounds of a body's motion over a range of steps.
#[derive(Debug, Clone, Copy, Default)]
pub struct MotionBounds {
    /// A bound of the speed of the centre.
    pub speed: f64,
    /// A bound of the acceleration of the centre.
    pub acceleration: f64,
    /// A bound of the spin.
    pub spin: f64,
    /// A bound of the rate of the spin, in the body frame.
    pub spin_rate: f64,
}

/// The motion of a body at a time, relative to the nominal barycentre.
#[derive(Debug, Clone, Copy)]
pub struct BodyMotion {
    /// The position of the centre.
    pub position: Vec3,
    /// The velocity of the centre.
    pub velocity: Vec3,
    /// The rotation matrix from the body frame to inertial axes.
    pub rotation: Mat3,
    /// The spin, body frame.
    pub spin: Vec3,
}

impl<'a> BodyEphemeris<'a> {
    /// Takes the steps of a run in its own direction, none of them empty.
    pub fn new(frame: &'a BarycentricFrame, segments: &'a [Segment]) -> Self {
        let mut segments: Vec<&Segment> = segments.iter().collect();
        if segments.first().is_some_and(|first| first.size() < 0.0) {
            segments.reverse();
        }
        let from = segments.iter().map(|s| s.start().min(s.end())).collect();
        let bodies = frame.layout.bodies;
        let terms = segments.first().map_or(0, |s| s.coefficients().len() / s.start_vector().0.len());
        Self {
            frame,
            segments,
            from,
            step_range: 0..0,
            width: (COLUMNS * bodies).next_multiple_of(8),
            rows: 2 + terms,
            packed: Vec::new(),
            bounds: vec![MotionBounds::default(); bodies],
        }
    }

    /// Returns the number of bodies.
    pub fn bodies(&self) -> usize {
        self.bounds.len()
    }

    /// Returns the index of the step that holds a time.
    pub fn index(&self, time: f64) -> usize {
        self.from.partition_point(|from| *from <= time).saturating_sub(1)
    }

    /// Returns the earlier and the later end of a step.
    pub fn ends(&self, index: usize) -> [f64; 2] {
        let segment = self.segments[index];
        let (a, b) = (segment.start(), segment.end());
        [a.min(b), a.max(b)]
    }

    /// Returns the range of at most `most` steps from a time towards another, and the time at which it ends.
    pub fn step_range(&self, time: f64, until: f64, max_steps: usize) -> (Range<usize>, f64) {
        let (index, count) = (self.index(time), self.segments.len());
        if until < time {
            let at_edge = index > 0 && self.ends(index)[0] == time;
            let last = index + usize::from(!at_edge);
            let first = last.saturating_sub(max_steps);
            // The last step may end before the run by a rounding error.
            let end = if first == 0 { until } else { self.ends(first)[0].max(until) };
            return (first..last, end);
        }
        let last = (index + max_steps).min(count);
        let end = if last == count { until } else { self.ends(last - 1)[1].min(until) };
        (index..last, end)
    }

    /// Packs a range of the steps.
    pub fn pack(&mut self, step_range: Range<usize>) {
        let layout = self.frame.layout;
        let wide = layout.chart.width();
        self.packed.clear();
        self.packed.resize(step_range.len() * self.rows * self.width, 0.0);
        self.bounds.fill(MotionBounds::default());
        for (segment, out) in
            self.segments[step_range.clone()].iter().zip(self.packed.chunks_exact_mut(self.rows * self.width))
        {
            let (high, low) = segment.start_vector();
            let vectors = [high, low].into_iter().chain(segment.coefficients().chunks_exact(high.len()));
            for (row, vector) in out.chunks_exact_mut(self.width).zip(vectors) {
                let offset = self.frame.barycentre_offset(vector).0;
                for body in 0..layout.bodies {
                    let columns = &mut row[COLUMNS * body..][..COLUMNS];
                    let (p, a) = (layout.position(body), layout.attitude(body));
                    (0..3).for_each(|c| columns[c] = vector[p + c] + offset[c]);
                    columns[3..3 + wide].copy_from_slice(&vector[a..a + wide]);
                }
            }
            let size = segment.size().abs();
            let offset_rate = if layout.forces > 0 {
                segment.derivative_bounds(layout.barycentre_offset() + 3, 3)[0]
            } else {
                0.0
            };
            let length = |index: usize| high[index..index + 3].iter().map(|x| x * x).sum::<f64>().sqrt();
            for (body, bounds) in self.bounds.iter_mut().enumerate() {
                let (v, s) = (layout.velocity(body), layout.spin(body));
                let (faster, faster_spin) =
                    (segment.derivative_bounds(v, 3)[0] + offset_rate, segment.derivative_bounds(s, 3)[0]);
                let drift = self.frame.barycentre_offset(high).1.norm();
                bounds.speed = bounds.speed.max(length(v) + drift + faster);
                bounds.acceleration = bounds.acceleration.max(faster / size);
                bounds.spin = bounds.spin.max(length(s) + faster_spin);
                bounds.spin_rate = bounds.spin_rate.max(faster_spin / size);
            }
        }
        self.step_range = step_range;
    }

    /// Writes the columns of all bodies at the times of a block's lanes, which must be within the packed
    /// range. `cursors` are the steps in which the lanes were last.
    #[inline(always)]
    pub fn columns_at<S: Simd>(
        &self,
        simd: S,
        times: &LaneBlock,
        cursors: &mut [usize; BLOCK],
        out: &mut [LaneBlock],
    ) {
        let mut numbers = [0.0; GROUP];
        for lane in 0..BLOCK {
            let time = times[lane];
            let mut at = cursors[lane].clamp(self.step_range.start, self.step_range.end - 1);
            while at > self.step_range.start && self.from[at] > time {
                at -= 1;
            }
            while at + 1 < self.step_range.end && self.from[at + 1] <= time {
                at += 1;
            }
            cursors[lane] = at;
            let segment = self.segments[at];
            let basis = segment.basis(segment.fraction(time));
            let step = &self.packed[(at - self.step_range.start) * self.rows * self.width..]
                [..self.rows * self.width];
            let mut first = 0;
            for columns in out.chunks_mut(GROUP) {
                sum(simd, step, self.width, first, &basis, &mut numbers);
                first += GROUP;
                for column in 0..columns.len() {
                    columns[column][lane] = numbers[column];
                }
            }
            if self.frame.layout.chart == AttitudeChart::TaitBryan {
                for body in 0..self.bodies() {
                    let at = COLUMNS * body + 3;
                    let angles = [out[at][lane], out[at + 1][lane], out[at + 2][lane]];
                    let q = rotation::from_tait_bryan(angles);
                    (0..4).for_each(|c| out[at + c][lane] = q[c]);
                }
            }
        }
    }

    /// Returns the motion of a body at a time of the run.
    pub fn pose(&self, body: usize, time: f64) -> BodyMotion {
        let segment = self.segments[self.index(time)];
        let basis = segment.basis(segment.fraction(time));
        let layout = self.frame.layout;
        let vector = |index: usize| Vec3::from([0, 1, 2].map(|c| segment.number(&basis, index + c)));
        let (p, v, a, s) =
            (layout.position(body), layout.velocity(body), layout.attitude(body), layout.spin(body));
        let (mut position, mut velocity) = (vector(p), vector(v));
        if layout.forces > 0 {
            position += vector(layout.barycentre_offset());
            velocity += vector(layout.barycentre_offset() + 3);
        }
        let number = |c: usize| segment.number(&basis, a + c);
        let rotation = match layout.chart {
            AttitudeChart::Quaternion => rotation::matrix([0, 1, 2, 3].map(number)),
            AttitudeChart::TaitBryan => rotation::tait_bryan_matrix([0, 1, 2].map(number)),
        };
        BodyMotion { position, velocity, rotation, spin: vector(s) }
    }

    /// Returns the acceleration of a body's centre at a time, and the rate of its spin in the body frame.
    pub fn rates(&self, body: usize, time: f64) -> (Vec3, Vec3) {
        let segment = self.segments[self.index(time)];
        let layout = self.frame.layout;
        let mut rate = vec![0.0; layout.dimension()];
        segment.rate(segment.fraction(time), &mut rate);
        let vector = |index: usize| Vec3::from_column_slice(&rate[index..index + 3]);
        let offset_rate =
            if layout.forces > 0 { vector(layout.barycentre_offset() + 3) } else { Vec3::zeros() };
        (vector(layout.velocity(body)) + offset_rate, vector(layout.spin(body)))
    }
}

/// The number of columns that are summed at once: two of the widest registers.
const GROUP: usize = 16;

/// Evaluates a group of columns of a step's polynomial. Columns beyond the end of a row are unspecified.
#[inline(always)]
fn sum<S: Simd>(
    simd: S,
    step: &[f64],
    width: usize,
    first: usize,
    basis: &[f64; MAX_TERMS],
    out: &mut [f64; GROUP],
) {
    let (registers, out) = (S::as_simd_f64s(step).0, S::as_mut_simd_f64s(out).0);
    let (row, first) = (width / S::F64_LANES, first / S::F64_LANES);
    let count = out.len().min(row - first);
    let out = &mut out[..count];
    out.copy_from_slice(&registers[row + first..][..count]);
    let mut offset = 2 * row + first;
    for term in 0..registers.len() / row - 2 {
        let value = simd.splat_f64s(basis[term]);
        let part = &registers[offset..][..count];
        for k in 0..count {
            out[k] = simd.mul_add_e_f64s(value, part[k], out[k]);
        }
        offset += row;
    }
    let part = &registers[first..][..count];
    for k in 0..count {
        out[k] = simd.add_f64s(part[k], out[k]);
    }
}
