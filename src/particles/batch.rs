//! A batch of particles, integrated over a range of the bodies' steps.
//!
//! A block has one particle in each of its lanes (SIMD). When a particle has reached the end of the range or
//! of its flight, its lane takes the next particle of the batch. Since lanes do not depend on each other,
//! results do not depend on how particles are divided into batches.

use super::body_ephemeris::COLUMNS;
use super::events::{Origin, ParticleEvent, ParticleOccurrence, scan};
use super::external_forces::ExternalForces;
use super::fate::{BEYOND, End, Fate, Particle, ParticleStatus, Rules};
use super::stage::{FlightModel, MotionBlock, Stages};
use super::surface::{BodySurface, SurfaceHit, motion_at};
use crate::error::{Error, Result};
use crate::integrate::{Segment, root};
use crate::math::Vec3;
use crate::math::lanes::BLOCK;
use crate::shape::least_distance;
use crate::workers::Worker;

/// The first step of a particle, in units of the time in which it would travel its distance from the nearest
/// centre of a body.
const FIRST_STEP: f64 = 0.01;

/// The allowance for rounding errors in bounds of distances, relative to the distances.
const MARGIN: f64 = 1e-9;

/// The data that all batches share.
pub struct BatchContext<'a> {
    /// The bodies' gravity and the integrator.
    pub model: FlightModel<'a>,
    /// The external forces on the particles.
    pub external_forces: &'a ExternalForces,
    /// The bodies' surfaces.
    pub surfaces: &'a [BodySurface],
    /// G times the mass of all bodies.
    pub mu: f64,
    /// The rules of the flight.
    pub rules: &'a Rules,
    /// The times at which particles are recorded, along the flight.
    pub output: &'a [f64],
    /// The events that are searched for.
    pub events: &'a [ParticleEvent],
    /// The position and velocity of the nominal barycentre, from which events measure.
    pub origin: &'a Origin<'a>,
    /// The end of the range.
    pub end: f64,
    /// The sign of the direction of the flight: 1 forwards, -1 backwards.
    pub direction: f64,
}

/// A batch of particles under integration.
pub struct Batch<'a, 'b> {
    pub(super) context: &'b BatchContext<'a>,
    stages: Stages<'a>,
    /// Stages for the acceleration of particles that lie on a surface.
    pub(super) probe: Stages<'a>,
    /// External forces for the functions of events.
    event_forces: ExternalForces,
    /// The index of the batch's first particle.
    first: usize,
    pub(super) particles: &'b mut [Particle],
    /// Six numbers for each output of each particle, particle by particle.
    samples: &'b mut [f64],
    /// The positions of the bodies' centres at the beginning of the steps.
    starts: Vec<[Vec3; BLOCK]>,
    /// The polynomial of a step.
    segment: Segment,
    /// The events that have happened to these particles.
    pub occurrences: Vec<ParticleOccurrence>,
}

impl<'a, 'b> Batch<'a, 'b> {
    pub fn new(
        context: &'b BatchContext<'a>,
        first: usize,
        particles: &'b mut [Particle],
        samples: &'b mut [f64],
    ) -> Self {
        let stages = Stages::new(context.model, context.external_forces.clone());
        Self {
            context,
            probe: stages.clone(),
            stages,
            event_forces: context.external_forces.clone(),
            first,
            particles,
            samples,
            starts: vec![[Vec3::zeros(); BLOCK]; context.surfaces.len()],
            segment: Segment::new(6, context.model.tableau.interpolant.terms()),
            occurrences: Vec::new(),
        }
    }

    /// Integrates all particles to the end of the range.
    pub fn run(&mut self, worker: &Worker) -> Result<()> {
        let mut lanes = [None; BLOCK];
        let mut next = 0;
        loop {
            for lane in 0..BLOCK {
                while lanes[lane].is_none() && next < self.particles.len() {
                    if self.advance_on_surface(next)? {
                        self.load(lane, next);
                        lanes[lane] = Some(next);
                    }
                    next += 1;
                }
            }
            let Some(active) = lanes.iter().position(Option::is_some) else { return Ok(()) };
            if worker.stopped() {
                return Err(Error::Interrupted { time: self.stages.time[active] });
            }
            // Lanes without a particle repeat the step of another lane.
            for lane in 0..BLOCK {
                if lanes[lane].is_none()
                    && let Some(particle) = lanes[active]
                {
                    self.load(lane, particle);
                }
            }
            self.step(&mut lanes)?;
        }
    }

    /// Copies the time and the motion of a particle to a lane.
    fn load(&mut self, lane: usize, index: usize) {
        let particle = &self.particles[index];
        let stages = &mut self.stages;
        stages.time[lane] = particle.time;
        stages.area_to_mass[lane] = particle.area_to_mass;
        for c in 0..6 {
            (stages.motion[c][lane], stages.low[c][lane]) = (particle.motion[c], particle.low[c]);
        }
    }

    /// Takes one step in every lane.
    fn step(&mut self, lanes: &mut [Option<usize>; BLOCK]) -> Result<()> {
        let BatchContext { rules, end, direction, surfaces, .. } = *self.context;
        self.stages.begin()?;
        for body in 0..surfaces.len() {
            (0..BLOCK).for_each(|lane| self.starts[body][lane] = self.centre(body, lane));
        }
        let mut ends = [0.0; BLOCK];
        for lane in 0..BLOCK {
            let planned = lanes[lane].map_or(0.0, |index| self.plan(index, lane));
            let time = self.stages.time[lane];
            let remaining = end - time;
            ends[lane] = if planned < remaining.abs() { time + direction * planned } else { end };
            self.stages.size[lane] = ends[lane] - time;
        }
        self.stages.attempt()?;
        let errors = self.stages.errors();
        let (high, low) = self.stages.end();
        let mut accepted = [false; BLOCK];
        let mut must_examine = [false; BLOCK];
        for lane in 0..BLOCK {
            let Some(index) = lanes[lane] else { continue };
            if !self.accept(index, lane, [errors[0][lane], errors[1][lane]]) {
                if self.particles[index].status == ParticleStatus::Gone {
                    lanes[lane] = None;
                }
                continue;
            }
            let (x, v) = (vector(&high, 0, lane), vector(&high, 3, lane));
            if x.amax().max(v.amax()) > BEYOND {
                self.mark_lost(index, lane);
                lanes[lane] = None;
                continue;
            }
            accepted[lane] = true;
            let escaping = rules.escape.is_some_and(|escape| escape.value(self.context.mu, &x, &v) > 0.0);
            must_examine[lane] = escaping
                || !self.context.events.is_empty()
                || self.due(index, ends[lane], false).is_some()
                || !self.certainly_clear(lane, &x);
        }
        if must_examine.contains(&true) {
            self.stages.complete()?;
        }
        for lane in 0..BLOCK {
            let (Some(index), true) = (lanes[lane], accepted[lane]) else { continue };
            let step_end = (ends[lane], vector(&high, 0, lane), vector(&high, 3, lane));
            let stopped = must_examine[lane] && self.examine(index, lane, step_end)?;
            if !stopped {
                let particle = &mut self.particles[index];
                particle.time = ends[lane];
                particle.status = ParticleStatus::Flying { leaving: false };
                for c in 0..6 {
                    (particle.motion[c], particle.low[c]) = (high[c][lane], low[c][lane]);
                }
                if self.due(index, ends[lane], true).is_some() {
                    let particle = &self.particles[index];
                    let (x, v) = (particle.position(), particle.velocity());
                    self.record(index, &x, &v);
                }
            }
            if self.particles[index].time == end || !self.advance_on_surface(index)? {
                lanes[lane] = None;
            } else {
                self.load(lane, index);
            }
        }
        Ok(())
    }

    /// Returns the centre of a body at the time at which the rates of a lane were last evaluated.
    fn centre(&self, body: usize, lane: usize) -> Vec3 {
        let columns = &self.stages.columns()[COLUMNS * body..];
        Vec3::from([0, 1, 2].map(|c| columns[c][lane]))
    }

    /// Returns the step that is planned for a particle, after the rates at its beginning have been evaluated.
    fn plan(&mut self, index: usize, lane: usize) -> f64 {
        let [distance, speed] = self.sizes(lane);
        let particle = &mut self.particles[index];
        particle.scales.get_or_insert([distance, speed]);
        if particle.next == 0.0 {
            particle.next = FIRST_STEP * distance / speed;
        }
        particle.next
    }

    /// Returns the scales of a particle's position and velocity: the distance from the nearest centre, and
    /// sqrt(v^2 + Phi) with the speed v and the potential Phi, taken positive.
    fn sizes(&self, lane: usize) -> [f64; 2] {
        let [square_of_distance, potential] = [0, 1].map(|k| self.stages.nearness[k][lane]);
        let square_of_speed: f64 = [3, 4, 5].map(|c| self.stages.motion[c][lane]).iter().map(|v| v * v).sum();
        [square_of_distance.sqrt(), (square_of_speed + potential).sqrt()]
    }

    /// Returns whether a step is accepted, and plans the next one.
    fn accept(&mut self, index: usize, lane: usize, errors: [f64; 2]) -> bool {
        let Rules { tableau, tolerance, .. } = self.context.rules;
        let sizes = self.sizes(lane);
        let (time, size) = (self.stages.time[lane], self.stages.size[lane].abs());
        let particle = &mut self.particles[index];
        let initial = particle.scales.unwrap_or(sizes);
        let mut error: f64 = 0.0;
        for k in 0..2 {
            let ratio = errors[k] / (tolerance.relative * sizes[k] + tolerance.absolute * initial[k]);
            error = if ratio > error || ratio.is_nan() { ratio } else { error };
        }
        if error <= 1.0 {
            let factor = particle.controller.accepted(error, tableau.error_order);
            // A step that was cut short does not reduce the planned size.
            particle.next =
                if size < particle.next { particle.next.max(size * factor) } else { size * factor };
            return true;
        }
        particle.next = size * particle.controller.rejected(error, tableau.error_order);
        if particle.next <= 4.0 * f64::EPSILON * time.abs() || particle.next <= f64::MIN_POSITIVE {
            self.mark_lost(index, lane);
        }
        false
    }

    /// Ends the flight of a particle that cannot be integrated further, at the beginning of its step.
    fn mark_lost(&mut self, index: usize, lane: usize) {
        let particle = &mut self.particles[index];
        particle.end = End { fate: Fate::Lost, time: self.stages.time[lane], ..End::default() };
        particle.status = ParticleStatus::Gone;
    }

    /// Returns whether a particle certainly has not touched a body in its step.
    ///
    /// Let g be the smallest gap between the chord of the step and a body's circumscribed sphere, and assume
    /// that the path nowhere comes nearer to the body than half that gap, at the distance d from its centre.
    /// Then the body attracts the particle by at most G m / (d - p)^2, where p is the extent of an equivalent
    /// mass distribution. If with these accelerations the path departs from the chord by no more than g / 2,
    /// the assumption holds. Forces other than the bodies' gravity are assumed to no more than double in the
    /// step.
    fn certainly_clear(&self, lane: usize, end: &Vec3) -> bool {
        let BatchContext { surfaces, model, .. } = *self.context;
        let x = Vec3::from([0, 1, 2].map(|c| self.stages.motion[c][lane]));
        let chord_distance = |body: usize| {
            let start = x - self.starts[body][lane];
            least_distance(&start, &(end - self.centre(body, lane) - start))
        };
        let mut attraction =
            if self.context.external_forces.is_empty() { 0.0 } else { 2.0 * self.stages.first(lane).norm() };
        for (body, (surface, attractor)) in surfaces.iter().zip(model.attractors).enumerate() {
            let inner = 0.5 * (chord_distance(body) + surface.radius) - surface.focal;
            // The comparison is written so that NaN gives false.
            let bounded = inner > 0.0;
            if !bounded {
                return false;
            }
            attraction += attractor.strength / (inner * inner);
        }
        let size = self.stages.size[lane];
        surfaces.iter().zip(&model.ephemeris.bounds).enumerate().all(|(body, (surface, bounds))| {
            let sagitta = 0.125 * size * size * (attraction + bounds.acceleration);
            let distance = chord_distance(body);
            sagitta + MARGIN * distance <= 0.5 * (distance - surface.radius)
        })
    }

    /// Examines the interior of an accepted step, which ends with the time, position and velocity `end`, for
    /// outputs, events, contacts and escapes. Returns whether one of these has set the particle's time and
    /// motion.
    fn examine(&mut self, index: usize, lane: usize, end: (f64, Vec3, Vec3)) -> Result<bool> {
        let BatchContext { model, rules, surfaces, direction, mu, .. } = *self.context;
        self.stages.segment(lane, &mut self.segment);
        let start = self.segment.start();
        let leaving = self.particles[index].status == ParticleStatus::Flying { leaving: true };
        let mut stop = end.0;
        let mut impact: Option<(usize, SurfaceHit)> = None;
        for (body, surface) in surfaces.iter().enumerate() {
            if let Some(hit) = surface.search(model.ephemeris, body, &self.segment, stop, leaving) {
                stop = hit.time;
                impact = Some((body, hit));
            }
        }
        let mut escaped = false;
        if let Some(escape) = rules.escape {
            let value = |time: f64| {
                let (x, v) = motion_at(&self.segment, time);
                escape.value(mu, &x, &v)
            };
            let (first, last) = (value(start), value(stop));
            if first > 0.0 || last > 0.0 {
                escaped = true;
                let function = |time: f64| Ok::<_, Error>(value(time));
                stop = if first > 0.0 { start } else { root(function, (start, first), (stop, last))? };
            }
        }
        while let Some(time) = self.due(index, stop, escaped || impact.is_some()) {
            let (x, v) = motion_at(&self.segment, time);
            self.record(index, &x, &v);
        }
        let (x, v) = motion_at(&self.segment, stop);
        let (events, particle_index) = (self.context.events, self.first + index);
        if !events.is_empty() && stop != start {
            let context = (model.ephemeris, &mut self.event_forces, self.context.origin);
            let after = if stop == end.0 { end } else { (stop, x, v) };
            scan(events, context, particle_index, &self.segment, after, &mut self.occurrences)?;
        }
        if escaped {
            let particle = &mut self.particles[index];
            particle.set_motion(stop, &x, &v);
            particle.status = ParticleStatus::Gone;
            particle.end = End { fate: Fate::Escape, time: stop, ..End::default() };
            return Ok(true);
        }
        let Some((body, hit)) = impact else { return Ok(false) };
        debug_assert!((stop - start) * direction >= 0.0);
        self.strike(index, body, hit, &x, &v)?;
        Ok(true)
    }

    /// Returns the next output time of a particle if it is before `time` along the flight, or equal to it if
    /// `inclusive`.
    pub(super) fn due(&self, index: usize, time: f64, inclusive: bool) -> Option<f64> {
        let next = *self.context.output.get(self.particles[index].recorded)?;
        let remaining = (time - next) * self.context.direction;
        (remaining > 0.0 || (inclusive && remaining == 0.0)).then_some(next)
    }

    /// Writes a position and a velocity as the next output of a particle.
    pub(super) fn record(&mut self, index: usize, x: &Vec3, v: &Vec3) {
        let particle = &mut self.particles[index];
        let offset = 6 * (index * self.context.output.len() + particle.recorded);
        particle.recorded += 1;
        self.samples[offset..offset + 6].copy_from_slice(&[x.x, x.y, x.z, v.x, v.y, v.z]);
    }
}

/// Returns the vector of a lane whose components are the rows `first` to `first + 2`.
fn vector(motion: &MotionBlock, first: usize, lane: usize) -> Vec3 {
    Vec3::new(motion[first][lane], motion[first + 1][lane], motion[first + 2][lane])
}
