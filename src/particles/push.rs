//! Particles of a batch, pushed over a stretch of the bodies' course.
//!
//! Each lane of a block has a particle until that has come to the end of the stretch or of its flight; then it takes the next
//! one of the batch. Since lanes do not depend on each other, neither do results on how particles are batched.

use super::course::COLUMNS;
use super::fate::{BEYOND, End, Fate, Particle, Place, Rules};
use super::outside::Outside;
use super::stage::{Stages, World};
use super::surface::{Meeting, Surface, motion_at};
use super::watch::{Happened, Origin, Watch, scan};
use crate::error::{Error, Result};
use crate::integrate::{Segment, root};
use crate::math::Vec3;
use crate::math::lanes::BLOCK;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// First step, in units of the time in which a particle would pass the distance from the nearest centre.
const FIRST: f64 = 0.01;

/// By how much rounding may exceed what bounds are made for, relative to distances.
const MARGIN: f64 = 1e-9;

/// What all batches share.
pub struct Flying<'a> {
    /// What moves particles.
    pub world: World<'a>,
    /// What else does.
    pub outside: &'a Outside,
    /// The bodies' surfaces.
    pub surfaces: &'a [Surface],
    /// G times the mass of all bodies.
    pub mu: f64,
    /// How they fly.
    pub rules: &'a Rules,
    /// Times at which they are recorded, along the flight.
    pub output: &'a [f64],
    /// What is watched for.
    pub watches: &'a [Watch],
    /// The nominal barycentre.
    pub origin: &'a Origin<'a>,
    /// End of the stretch.
    pub end: f64,
    /// 1 forwards, -1 backwards.
    pub direction: f64,
    /// Set where the caller does not want to go on.
    pub stop: &'a AtomicBool,
}

/// A batch under way.
pub struct Batch<'a, 'b> {
    pub(super) flying: &'b Flying<'a>,
    stages: Stages<'a>,
    /// For the acceleration of particles at rest.
    pub(super) probe: Stages<'a>,
    watcher: Outside,
    /// Number of the first particle.
    first: usize,
    pub(super) particles: &'b mut [Particle],
    /// Six numbers an output and particle, particle by particle.
    samples: &'b mut [f64],
    /// Centres of the bodies where the steps begin.
    starts: Vec<[Vec3; BLOCK]>,
    /// Polynomial of a step.
    segment: Segment,
    /// What happened.
    pub happened: Vec<Happened>,
}

impl<'a, 'b> Batch<'a, 'b> {
    pub fn new(
        flying: &'b Flying<'a>,
        first: usize,
        particles: &'b mut [Particle],
        samples: &'b mut [f64],
    ) -> Self {
        let stages = Stages::new(flying.world, flying.outside.clone());
        Self {
            flying,
            probe: stages.clone(),
            stages,
            watcher: flying.outside.clone(),
            first,
            particles,
            samples,
            starts: vec![[Vec3::zeros(); BLOCK]; flying.surfaces.len()],
            segment: Segment::new(6, flying.world.tableau.interpolant.terms()),
            happened: Vec::new(),
        }
    }

    /// Pushes all to the end of the stretch.
    pub fn run(&mut self) -> Result<()> {
        let mut lanes = [None; BLOCK];
        let mut next = 0;
        loop {
            for lane in 0..BLOCK {
                while lanes[lane].is_none() && next < self.particles.len() {
                    if self.carry(next)? {
                        self.load(lane, next);
                        lanes[lane] = Some(next);
                    }
                    next += 1;
                }
            }
            let Some(active) = lanes.iter().position(Option::is_some) else { return Ok(()) };
            if self.flying.stop.load(Relaxed) {
                return Err(Error::Interrupted { time: self.stages.time[active] });
            }
            // Lanes without a particle repeat another one's step.
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

    fn load(&mut self, lane: usize, index: usize) {
        let particle = &self.particles[index];
        let stages = &mut self.stages;
        stages.time[lane] = particle.time;
        stages.area_to_mass[lane] = particle.area_to_mass;
        for c in 0..6 {
            (stages.motion[c][lane], stages.low[c][lane]) = (particle.motion[c], particle.low[c]);
        }
    }

    /// One step of every lane.
    fn step(&mut self, lanes: &mut [Option<usize>; BLOCK]) -> Result<()> {
        let Flying { rules, end, direction, surfaces, .. } = *self.flying;
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
        let mut inside = [false; BLOCK];
        for lane in 0..BLOCK {
            let Some(index) = lanes[lane] else { continue };
            if !self.judge(index, lane, [errors[0][lane], errors[1][lane]]) {
                if self.particles[index].place == Place::Gone {
                    lanes[lane] = None;
                }
                continue;
            }
            let x = Vec3::from([0, 1, 2].map(|c| high[c][lane]));
            let v = Vec3::from([3, 4, 5].map(|c| high[c][lane]));
            if x.amax().max(v.amax()) > BEYOND {
                self.lose(index, lane);
                lanes[lane] = None;
                continue;
            }
            accepted[lane] = true;
            let escaping = rules.escape.is_some_and(|escape| escape.value(self.flying.mu, &x, &v) > 0.0);
            inside[lane] = escaping
                || !self.flying.watches.is_empty()
                || self.due(index, ends[lane], false).is_some()
                || !self.apart(lane, &x);
        }
        if inside.contains(&true) {
            self.stages.complete()?;
        }
        for lane in 0..BLOCK {
            let (Some(index), true) = (lanes[lane], accepted[lane]) else { continue };
            let stopped = inside[lane] && self.look(index, lane, ends[lane])?;
            if !stopped {
                let particle = &mut self.particles[index];
                particle.time = ends[lane];
                particle.place = Place::Flying { departing: false };
                for c in 0..6 {
                    (particle.motion[c], particle.low[c]) = (high[c][lane], low[c][lane]);
                }
                if self.due(index, ends[lane], true).is_some() {
                    let particle = &self.particles[index];
                    let (x, v) = (particle.position(), particle.velocity());
                    self.record(index, &x, &v);
                }
            }
            if self.particles[index].time == end || !self.carry(index)? {
                lanes[lane] = None;
            } else {
                self.load(lane, index);
            }
        }
        Ok(())
    }

    /// The centre of a body where rates of a lane were last taken.
    fn centre(&self, body: usize, lane: usize) -> Vec3 {
        let columns = &self.stages.columns()[COLUMNS * body..];
        Vec3::from([0, 1, 2].map(|c| columns[c][lane]))
    }

    /// The step that is planned for a particle at the beginning of which rates have been taken.
    fn plan(&mut self, index: usize, lane: usize) -> f64 {
        let [distance, speed] = self.sizes(lane);
        let particle = &mut self.particles[index];
        particle.scales.get_or_insert([distance, speed]);
        if particle.next == 0.0 {
            particle.next = FIRST * distance / speed;
        }
        particle.next
    }

    /// Distance from the nearest centre, and sqrt(v^2 + Phi).
    fn sizes(&self, lane: usize) -> [f64; 2] {
        let [square, potential] = [0, 1].map(|k| self.stages.nearness[k][lane]);
        let speed: f64 = [3, 4, 5].map(|c| self.stages.motion[c][lane]).iter().map(|v| v * v).sum();
        [square.sqrt(), (speed + potential).sqrt()]
    }

    /// Whether a step is accepted; plans the next one.
    fn judge(&mut self, index: usize, lane: usize, errors: [f64; 2]) -> bool {
        let Rules { tableau, tolerance, .. } = self.flying.rules;
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
            // A step that was cut says little of the next one.
            particle.next =
                if size < particle.next { particle.next.max(size * factor) } else { size * factor };
            return true;
        }
        particle.next = size * particle.controller.rejected(error, tableau.error_order);
        if particle.next <= 4.0 * f64::EPSILON * time.abs() || particle.next <= f64::MIN_POSITIVE {
            self.lose(index, lane);
        }
        false
    }

    /// Ends a flight that cannot be followed, at the beginning of the step.
    fn lose(&mut self, index: usize, lane: usize) {
        let particle = &mut self.particles[index];
        particle.end = End { fate: Fate::Lost, time: self.stages.time[lane], ..End::default() };
        particle.place = Place::Gone;
    }

    /// Whether a particle cannot have met a body in its step.
    ///
    /// While it is no nearer to each body than half way from the nearest place on the chord to contact, that attracts it by at
    /// most G m / (d - p)^2, p how far the mass reaches that attracts like the body. If with these accelerations its path
    /// bends nowhere from a chord by half the gap, it has not been nearer. What acts beside the bodies may double on the way.
    fn apart(&self, lane: usize, end: &Vec3) -> bool {
        let Flying { surfaces, world, .. } = *self.flying;
        let x = Vec3::from([0, 1, 2].map(|c| self.stages.motion[c][lane]));
        let near = |body: usize| nearest(&(x - self.starts[body][lane]), &(end - self.centre(body, lane)));
        let mut pull =
            if self.flying.outside.is_empty() { 0.0 } else { 2.0 * self.stages.first(lane).norm() };
        for (body, (surface, puller)) in surfaces.iter().zip(world.pullers).enumerate() {
            let inner = 0.5 * (near(body) + surface.radius) - surface.focal;
            // Written so that a NaN leaves a doubt.
            let outside = inner > 0.0;
            if !outside {
                return false;
            }
            pull += puller.strength / (inner * inner);
        }
        let size = self.stages.size[lane];
        surfaces.iter().zip(&world.course.bounds).enumerate().all(|(body, (surface, bounds))| {
            let bend = 0.125 * size * size * (pull + bounds.acceleration);
            let near = near(body);
            bend + MARGIN * near <= 0.5 * (near - surface.radius)
        })
    }

    /// Looks into an accepted step: outputs, events, and what ends the flight or turns it. Whether that has placed the particle.
    fn look(&mut self, index: usize, lane: usize, end: f64) -> Result<bool> {
        let Flying { world, rules, surfaces, direction, mu, .. } = *self.flying;
        self.stages.segment(lane, &mut self.segment);
        let start = self.segment.start();
        let departing = self.particles[index].place == Place::Flying { departing: true };
        let mut stop = end;
        let mut met: Option<(usize, Meeting)> = None;
        for (body, surface) in surfaces.iter().enumerate() {
            if let Some(meeting) = surface.search(world.course, body, &self.segment, stop, departing) {
                stop = meeting.time;
                met = Some((body, meeting));
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
                let gone = |time: f64| Ok::<_, Error>(value(time));
                stop = if first > 0.0 { start } else { root(gone, (start, first), (stop, last))? };
            }
        }
        while let Some(time) = self.due(index, stop, escaped || met.is_some()) {
            let (x, v) = motion_at(&self.segment, time);
            self.record(index, &x, &v);
        }
        let (watches, number) = (self.flying.watches, self.first + index);
        if !watches.is_empty() && stop != start {
            let seen = (world.course, &mut self.watcher, self.flying.origin);
            scan(watches, seen, number, &self.segment, stop, &mut self.happened)?;
        }
        let (x, v) = motion_at(&self.segment, stop);
        if escaped {
            let particle = &mut self.particles[index];
            particle.put(stop, &x, &v);
            particle.place = Place::Gone;
            particle.end = End { fate: Fate::Escape, time: stop, ..End::default() };
            return Ok(true);
        }
        let Some((body, meeting)) = met else { return Ok(false) };
        debug_assert!((stop - start) * direction >= 0.0);
        self.strike(index, body, meeting, &x, &v)?;
        Ok(true)
    }

    /// The next output of a particle, if it is before a time along the flight, or then.
    pub(super) fn due(&self, index: usize, time: f64, then: bool) -> Option<f64> {
        let next = *self.flying.output.get(self.particles[index].recorded)?;
        let before = (time - next) * self.flying.direction;
        (before > 0.0 || (then && before == 0.0)).then_some(next)
    }

    pub(super) fn record(&mut self, index: usize, x: &Vec3, v: &Vec3) {
        let particle = &mut self.particles[index];
        let at = 6 * (index * self.flying.output.len() + particle.recorded);
        particle.recorded += 1;
        self.samples[at..at + 6].copy_from_slice(&[x.x, x.y, x.z, v.x, v.y, v.z]);
    }
}

/// How near the straight way between two places comes to the origin.
fn nearest(from: &Vec3, to: &Vec3) -> f64 {
    let path = to - from;
    let square = path.norm_squared();
    let part = if square > 0.0 { (-from.dot(&path) / square).clamp(0.0, 1.0) } else { 0.0 };
    (from + path * part).norm()
}
