//! The flight of particles along a run: ranges of the bodies' steps one after the other, with batches of
//! particles spread over threads.

use super::attraction::ParticleAttractor;
use super::batch::{Batch, BatchContext};
use super::body_ephemeris::{BodyEphemeris, BodyMotion};
use super::events::{ParticleCondition, ParticleEvent, ParticleOccurrence};
use super::external_forces::{ExternalForces, Radiation};
use super::fate::{ContactResponse, Particle, ParticleStatus, Rules};
use super::stage::FlightModel;
use super::surface::BodySurface;
use crate::dynamics::System;
use crate::error::{Error, Result, require_finite};
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;
use crate::trajectory::{Dense, Output, Progress};
use crate::workers::{JobProgress, JobSource, WorkerPool, WorkerThread, with_workers};
use std::num::NonZeroUsize;
use std::ops::ControlFlow;

/// The number of the bodies' steps in a range.
const STEPS_PER_RANGE: usize = 256;

/// The largest number of particles in a batch.
const BATCH: usize = 512;

/// The caller's hook, which breaks to interrupt the flight.
type Hook<'h> = dyn FnMut(Progress) -> ControlFlow<()> + Send + 'h;

/// The plan of a flight of particles through the bodies' motion.
///
/// ```
/// use fullbody::dynamics::{Settings, State, System};
/// use fullbody::integrate::Tolerance;
/// use fullbody::math::Vec3;
/// use fullbody::particles::{FlightPlan, FlightRecord, Particle, Rules};
/// use fullbody::shape::{Body, Shape};
/// use fullbody::trajectory::{Integrator, Output, Run, Simulation, Trajectory};
/// use std::f64::consts::PI;
/// use std::ops::ControlFlow;
///
/// let ball = Body::with_mass("ball", Shape::ellipsoid([1.0, 1.0, 1.0])?, 1.0)?;
/// let system = System::new(vec![ball], 1.0, Settings::default())?;
/// let zero = vec![Vec3::zeros()];
/// let state = State::from_tait_bryan(0.0, zero.clone(), zero.clone(), &[[0.0; 3]], zero)?;
/// let tolerance = Tolerance::new(1e-13, 1e-13)?;
///
/// // The flight reads the bodies' motion from the continuous solution of a run.
/// let period = 2.0 * PI * 8.0_f64.sqrt();
/// let mut run = Trajectory::new(1);
/// let options = Run { dense: true, ..Run::new(&Output::Ends) };
/// Simulation::new(&system, &state, Integrator::Verner98(tolerance))?
///     .run(period, options, &mut run, &mut |_, _| ControlFlow::Continue(()))?;
///
/// // A circle of radius 2 about a mass of 1 closes after its period.
/// let start = Vec3::new(2.0, 0.0, 0.0);
/// let mut particles = [Particle::new(0.0, &start, &Vec3::new(0.0, 0.5_f64.sqrt(), 0.0), 0.0)];
/// let rules = Rules::new(tolerance);
/// let mut record = FlightRecord::default();
/// let dense = run.dense.as_ref().expect("the run was asked for its continuous solution");
/// let plan = FlightPlan { output: &[period], ..FlightPlan::new(&system, dense, period, &rules) };
/// plan.fly(&mut particles, &mut record, &mut |_| ControlFlow::Continue(()))?;
/// assert!((record.samples[0] - 2.0).abs() < 1e-11 && record.samples[1].abs() < 1e-11);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug)]
pub struct FlightPlan<'a> {
    /// The system.
    pub system: &'a System,
    /// The continuous solution of the bodies' motion.
    pub dense: &'a Dense,
    /// The end of the flight, before or after the particles' time.
    pub until: f64,
    /// The times at which particles are recorded, along the flight.
    pub output: &'a [f64],
    /// The rules of the flight.
    pub rules: &'a Rules,
    /// The radiation of a third body, if there is any.
    pub radiation: Option<&'a Radiation>,
    /// The events that are searched for.
    pub events: &'a [ParticleEvent],
    /// The number of threads; `None` for as many as the machine runs at once.
    pub threads: Option<NonZeroUsize>,
}

/// The record of a flight.
#[derive(Debug, Clone, Default)]
pub struct FlightRecord {
    /// Position and velocity for each output of each particle, particle by particle; NaN for outputs that
    /// were not reached.
    pub samples: Vec<f64>,
    /// Events, ordered by particle and along the flight of each particle.
    pub occurrences: Vec<ParticleOccurrence>,
}

impl<'a> FlightPlan<'a> {
    /// Plans a flight without outputs, radiation and events, on all cores.
    pub fn new(system: &'a System, dense: &'a Dense, until: f64, rules: &'a Rules) -> Self {
        Self { system, dense, until, output: &[], rules, radiation: None, events: &[], threads: None }
    }

    /// Flies particles that are all at one time, in the coordinates of the states. What the record held
    /// before is replaced.
    ///
    /// On an error, particles stay where they are. The hook is called at the start, about every 25 ms and at
    /// the end, in the caller's thread, and stops the flight by [`ControlFlow::Break`].
    ///
    /// # Errors
    /// [`Error::InvalidInput`](crate::error::Error::InvalidInput) names the particle, rule or time at fault,
    /// [`Error::Interrupted`](crate::error::Error::Interrupted) follows a break, and errors of an event's
    /// function are returned.
    pub fn fly(&self, particles: &mut [Particle], record: &mut FlightRecord, hook: &mut Hook) -> Result<()> {
        *record = FlightRecord::default();
        let start = particles.first().map_or(self.until, |particle| particle.time);
        let frame = self.dense.frame();
        let origin = |time: f64| (frame.nominal_at(time), Vec3::from(frame.barycentre_velocity));
        let shift = |particles: &mut [Particle], sign: f64| {
            for particle in particles {
                let (position, velocity) = origin(particle.time);
                let (x, v) = (particle.position() + position * sign, particle.velocity() + velocity * sign);
                let low = particle.low;
                particle.set_motion(particle.time, &x, &v);
                particle.low = low;
            }
        };
        shift(particles, -1.0);
        let outcome = self.fly_from(start, particles, record, hook);
        shift(particles, 1.0);
        let count = self.output.len();
        if count > 0 {
            for (at, sample) in record.samples.chunks_exact_mut(6).enumerate() {
                let (position, velocity) = origin(self.output[at % count]);
                for c in 0..3 {
                    sample[c] += position[c];
                    sample[3 + c] += velocity[c];
                }
            }
        }
        for occurrence in &mut record.occurrences {
            let (position, velocity) = origin(occurrence.time);
            occurrence.position += position;
            occurrence.velocity += velocity;
        }
        record.occurrences.sort_by_key(|occurrence| occurrence.particle);
        outcome
    }

    /// Flies particles whose motion is given relative to the nominal barycentre.
    fn fly_from(
        &self,
        start: f64,
        particles: &mut [Particle],
        record: &mut FlightRecord,
        hook: &mut Hook,
    ) -> Result<()> {
        // The record has a row for each particle even if the flight is refused.
        record.samples.resize(6 * self.output.len() * particles.len(), f64::NAN);
        let external_forces = self.check(start)?;
        self.call_hook(hook, start, start)?;
        let bodies = self.prepare(start, particles, hook)?;
        if self.output.first() == Some(&start) {
            let rows = record.samples.chunks_exact_mut(6 * self.output.len());
            for (particle, row) in particles.iter_mut().zip(rows) {
                row[..6].copy_from_slice(&particle.motion);
                particle.recorded = 1;
            }
        }
        if self.until == start {
            return Ok(());
        }
        with_workers(self.threads, WorkerThread::run, |pool| {
            self.fly_steps(start, &bodies, &external_forces, particles, record, hook, pool)
        })??;
        self.call_hook(hook, start, self.until)
    }

    /// Returns an error for a flight that is not possible, and otherwise the external forces on the
    /// particles.
    fn check(&self, start: f64) -> Result<ExternalForces> {
        let (bodies, flown) = (self.system.bodies().len(), self.dense.frame().layout.bodies);
        if bodies != flown {
            let expected = format!("{bodies}, as in the system");
            return Err(Error::invalid("number of bodies of the run", flown, expected));
        }
        let (first, last) = self.dense.range();
        for (what, time) in [("until", self.until), ("time of the particles", start)] {
            require_finite(what, &[time])?;
            if !(first.min(last)..=first.max(last)).contains(&time) {
                let expected =
                    format!("a time from {} to {}, which the run covers", first.min(last), first.max(last));
                return Err(Error::invalid(what, time, expected));
            }
        }
        if self.dense.pieces().is_empty() {
            return Err(Error::invalid("the run", "of no length", "one along which particles can fly"));
        }
        Output::Times(self.output.to_vec()).times(start, self.until)?;
        self.rules.contact.check()?;
        if self.until < start && matches!(self.rules.contact, ContactResponse::Bounce { .. }) {
            let expected = "'stop' or 'remove' in a flight backwards: a bounce cannot be undone";
            return Err(Error::invalid("contact", "Bounce", expected));
        }
        self.rules.escape.map_or(Ok(()), |escape| escape.check())?;
        let external_forces =
            ExternalForces::new(self.system.force_model(), self.radiation, self.system.bodies())?;
        external_forces.covers(start, self.until)?;
        for event in self.events {
            if matches!(event.condition, ParticleCondition::Shadow { .. }) && !external_forces.is_lit() {
                let expected = "the radiation of a third body to be given";
                return Err(Error::invalid("an event of the particles", "Shadow", expected));
            }
            if let ParticleCondition::Periapsis { body } = event.condition
                && body >= bodies
            {
                let expected = format!("0 to {}", bodies - 1);
                return Err(Error::invalid("body of Periapsis", body, expected));
            }
        }
        Ok(external_forces)
    }

    /// Places the particles among the bodies, and prepares the bodies' surfaces and gravity.
    fn prepare(&self, start: f64, particles: &mut [Particle], hook: &mut Hook) -> Result<FlightBodies> {
        let mut inside = || hook(Progress { start, time: start, end: self.until });
        let interrupt = &mut InterruptCheck::new(&mut inside);
        let bodies = self.system.bodies();
        let ephemeris = BodyEphemeris::new(self.dense.frame(), self.dense.pieces());
        let surfaces: Vec<BodySurface> = bodies.iter().map(BodySurface::new).collect();
        let poses: Vec<BodyMotion> = (0..surfaces.len()).map(|body| ephemeris.pose(body, start)).collect();
        let work: u64 = surfaces.iter().map(BodySurface::work).sum();
        for (index, particle) in particles.iter_mut().enumerate() {
            interrupt.charge(work, start)?;
            particle.check(index)?;
            if particle.time != start {
                let expected = format!("{start}, as of the first particle");
                return Err(Error::invalid(format!("time of particle {index}"), particle.time, expected));
            }
            begin(&poses, &surfaces, self.system, index, particle)?;
        }
        let (constant, arch) = (self.system.gravitational_constant(), self.system.arch());
        let attractor = |body| ParticleAttractor::new(body, constant, arch, interrupt);
        Ok(FlightBodies { attractors: bodies.iter().map(attractor).collect::<Result<_>>()?, surfaces })
    }

    /// Integrates the particles along the run, range by range.
    #[expect(clippy::too_many_arguments)]
    fn fly_steps(
        &self,
        start: f64,
        FlightBodies { surfaces, attractors }: &FlightBodies,
        external_forces: &ExternalForces,
        particles: &mut [Particle],
        record: &mut FlightRecord,
        hook: &mut Hook,
        pool: &WorkerPool,
    ) -> Result<()> {
        let Self { dense, rules, until, .. } = *self;
        let origin =
            |time: f64| (dense.frame().nominal_at(time), Vec3::from(dense.frame().barycentre_velocity));
        let size = particles.len().div_ceil(4 * pool.threads()).next_multiple_of(16).min(BATCH);
        let mut ephemeris = BodyEphemeris::new(dense.frame(), dense.pieces());
        let mut time = start;
        while time != until {
            let (step_range, end) = ephemeris.step_range(time, until, STEPS_PER_RANGE);
            ephemeris.pack(step_range);
            let context = BatchContext {
                model: FlightModel {
                    ephemeris: &ephemeris,
                    attractors,
                    tableau: rules.tableau,
                    arch: self.system.arch(),
                },
                external_forces,
                surfaces,
                mu: attractors.iter().map(ParticleAttractor::gm).sum(),
                rules,
                output: self.output,
                events: self.events,
                origin: &origin,
                end,
                direction: if until < start { -1.0 } else { 1.0 },
            };
            let mut proceed = |part: f64| self.call_hook(hook, start, time + part * (end - time));
            let mut batches = Batches {
                number: 0,
                size,
                count: particles.len().div_ceil(size),
                particles: &mut *particles,
                samples: &mut record.samples,
                occurrences: Vec::new(),
                failed: None,
                proceed: &mut proceed,
            };
            pool.run(&mut batches, |(number, particles, samples), worker| {
                let mut batch = Batch::new(&context, number * size, particles, samples);
                let outcome = batch.run(worker);
                (number, batch.occurrences, outcome)
            });
            batches.occurrences.sort_by_key(|(number, _)| *number);
            record
                .occurrences
                .extend(batches.occurrences.into_iter().flat_map(|(_, occurrences)| occurrences));
            batches.failed.map_or(Ok(()), Err)?;
            time = end;
        }
        Ok(())
    }

    /// Calls the hook, and returns an error for an interrupt.
    fn call_hook(&self, hook: &mut Hook, start: f64, time: f64) -> Result<()> {
        match hook(Progress { start, time, end: self.until }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Interrupted { time }),
        }
    }
}

/// The surfaces and the gravity of the bodies.
struct FlightBodies {
    surfaces: Vec<BodySurface>,
    attractors: Vec<ParticleAttractor>,
}

/// Places a particle at the start. Returns an error for one that is inside a body.
fn begin(
    poses: &[BodyMotion],
    surfaces: &[BodySurface],
    system: &System,
    index: usize,
    particle: &mut Particle,
) -> Result<()> {
    let (x, v) = (particle.position(), particle.velocity());
    for (body, (surface, pose)) in surfaces.iter().zip(poses).enumerate() {
        let (point, _) = pose.in_body_frame(&x, &v);
        if surface.contains(&point) {
            let name = &system.bodies()[body].name;
            let value = format!("inside {name}");
            return Err(Error::invalid(
                format!("position of particle {index}"),
                value,
                "a place outside all bodies",
            ));
        }
        if surface.contains(&(point * (1.0 - 1e-10))) {
            particle.status = ParticleStatus::Flying { leaving: true };
        }
    }
    Ok(())
}

/// Hands out the particles in batches, with their rows of samples, and collects their events.
struct Batches<'a, 'h> {
    /// The index of the next batch.
    number: usize,
    /// The number of particles in a batch.
    size: usize,
    /// The number of batches.
    count: usize,
    /// The particles of the batches that remain.
    particles: &'a mut [Particle],
    samples: &'a mut [f64],
    occurrences: Vec<(usize, Vec<ParticleOccurrence>)>,
    failed: Option<Error>,
    proceed: &'h mut dyn FnMut(f64) -> Result<()>,
}

impl Batches<'_, '_> {
    /// Keeps the first error. An error replaces interruptions, which are its consequence in other batches.
    fn fail(&mut self, error: Error) -> ControlFlow<()> {
        if matches!(self.failed, None | Some(Error::Interrupted { .. })) {
            self.failed = Some(error);
        }
        ControlFlow::Break(())
    }
}

impl<'a> JobSource for Batches<'a, '_> {
    type Job = (usize, &'a mut [Particle], &'a mut [f64]);
    type Answer = (usize, Vec<ParticleOccurrence>, Result<()>);

    fn next(&mut self) -> Option<Self::Job> {
        let remaining = self.particles.len();
        if remaining == 0 {
            return None;
        }
        let (size, width) = (self.size.min(remaining), self.samples.len() / remaining);
        let (particles, others) = std::mem::take(&mut self.particles).split_at_mut(size);
        let (samples, other_samples) = std::mem::take(&mut self.samples).split_at_mut(width * size);
        (self.particles, self.samples) = (others, other_samples);
        self.number += 1;
        Some((self.number - 1, particles, samples))
    }

    fn take(&mut self, (number, occurrences, outcome): Self::Answer) -> ControlFlow<()> {
        self.occurrences.push((number, occurrences));
        outcome.map_or_else(|error| self.fail(error), ControlFlow::Continue)
    }

    fn proceed(&mut self, progress: JobProgress) -> ControlFlow<()> {
        let part = (progress.done as f64 + progress.under_way) / self.count as f64;
        (self.proceed)(part).map_or_else(|error| self.fail(error), ControlFlow::Continue)
    }
}
