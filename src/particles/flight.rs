//! The flight of particles along a run: stretches of the bodies' course one after the other, batches of particles over threads.

use super::course::{Course, Pose};
use super::fate::{Contact, Particle, Place, Rules};
use super::outside::{Outside, Radiation};
use super::pull::Puller;
use super::push::{Batch, Flying};
use super::stage::World;
use super::surface::Surface;
use super::watch::{Condition, Happened, Watch};
use crate::dynamics::System;
use crate::error::{Error, Result, require_finite};
use crate::math::Vec3;
use crate::patience::Patience;
use crate::trajectory::{Dense, Progress};
use rayon::ThreadPoolBuilder;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc;
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

/// Steps of the bodies in a stretch.
const STRETCH: usize = 256;

/// Most particles of a batch.
const BATCH: usize = 512;

/// How often the caller is asked.
const LOOK: Duration = Duration::from_millis(25);

/// What is asked of a flight.
pub struct Plan<'a> {
    /// The system.
    pub system: &'a System,
    /// The bodies' motion.
    pub dense: &'a Dense,
    /// The end, before or after the particles' time.
    pub until: f64,
    /// Times at which particles are recorded, along the flight.
    pub output: &'a [f64],
    /// How they fly.
    pub rules: &'a Rules,
    /// Radiation of a third body.
    pub radiation: Option<&'a Radiation>,
    /// What is watched for.
    pub watches: &'a [Watch],
    /// Number of threads; as many as the machine runs at once unless given.
    pub threads: Option<NonZeroUsize>,
}

/// What is recorded of a flight.
#[derive(Debug, Clone, Default)]
pub struct Flown {
    /// Six numbers an output and particle, particle by particle: position, velocity. Those that were not reached are NaN.
    pub samples: Vec<f64>,
    /// Events, by particle and along the flight of each.
    pub happened: Vec<Happened>,
}

impl Plan<'_> {
    /// Flies particles that are all at one time, in the coordinates of the states.
    ///
    /// On an error, particles stay where they have come to. The hook is called at the start, about every 25 ms and at the end, in the
    /// caller's thread, and stops the flight by [`ControlFlow::Break`].
    pub fn fly(
        &self,
        particles: &mut [Particle],
        flown: &mut Flown,
        hook: &mut (dyn FnMut(Progress) -> ControlFlow<()> + Send),
    ) -> Result<()> {
        let start = particles.first().map_or(self.until, |particle| particle.time);
        let frame = self.dense.frame();
        let origin = |time: f64| (frame.nominal_at(time), Vec3::from(frame.barycentre_velocity));
        let moved = |particles: &mut [Particle], sign: f64| {
            for particle in particles {
                let (position, velocity) = origin(particle.time);
                let (x, v) = (particle.position() + position * sign, particle.velocity() + velocity * sign);
                let low = particle.low;
                particle.put(particle.time, &x, &v);
                particle.low = low;
            }
        };
        moved(particles, -1.0);
        let outcome = self.push(start, particles, flown, hook);
        moved(particles, 1.0);
        let count = self.output.len();
        if count > 0 {
            for (at, sample) in flown.samples.chunks_exact_mut(6).enumerate() {
                let (position, velocity) = origin(self.output[at % count]);
                for c in 0..3 {
                    sample[c] += position[c];
                    sample[3 + c] += velocity[c];
                }
            }
        }
        for happened in &mut flown.happened {
            let (position, velocity) = origin(happened.time);
            happened.position += position;
            happened.velocity += velocity;
        }
        flown.happened.sort_by_key(|happened| happened.particle);
        outcome
    }

    fn push(
        &self,
        start: f64,
        particles: &mut [Particle],
        flown: &mut Flown,
        hook: &mut (dyn FnMut(Progress) -> ControlFlow<()> + Send),
    ) -> Result<()> {
        // Before anything is refused: the record has a row of each particle.
        flown.samples.resize(6 * self.output.len() * particles.len(), f64::NAN);
        let (system, dense, until, rules) = (self.system, self.dense, self.until, self.rules);
        let (first, last) = dense.range();
        for (what, time) in [("until", until), ("time of the particles", start)] {
            require_finite(what, &[time])?;
            if !(first.min(last)..=first.max(last)).contains(&time) {
                let expected =
                    format!("a time from {} to {}, which the run covers", first.min(last), first.max(last));
                return Err(Error::invalid(what, time, expected));
            }
        }
        if dense.pieces().is_empty() {
            return Err(Error::invalid("the run", "of no length", "one along which particles can fly"));
        }
        let backwards = until < start;
        rules.contact.check()?;
        if backwards && matches!(rules.contact, Contact::Bounce { .. }) {
            let expected = "Stop or Remove in a flight backwards: a bounce cannot be undone";
            return Err(Error::invalid("contact", "Bounce", expected));
        }
        rules.escape.map_or(Ok(()), |escape| escape.check())?;
        let outside = Outside::new(&system.environment()?, self.radiation, system.bodies())?;
        outside.covers(start, until)?;
        for watch in self.watches {
            if matches!(watch.condition, Condition::Shadow { .. }) && !outside.is_lit() {
                let expected = "the radiation of a third body to be given";
                return Err(Error::invalid("an event of the particles", "Shadow", expected));
            }
        }
        let constant = system.gravitational_constant();
        let mut course = Course::new(dense.frame(), dense.pieces());
        let surfaces: Vec<Surface> = system.bodies().iter().map(Surface::new).collect();
        let pullers = {
            let mut inside = || hook(Progress { start, time: start, end: until });
            let patience = &mut Patience::new(&mut inside);
            let poses: Vec<Pose> = (0..surfaces.len()).map(|body| course.pose(body, start)).collect();
            for (index, particle) in particles.iter_mut().enumerate() {
                let work: u64 = surfaces.iter().map(Surface::work).sum();
                patience.spend(work, start)?;
                particle.check(index)?;
                begin(&poses, &surfaces, system, index, particle)?;
            }
            let puller = |body| Puller::new(body, constant, system.arch(), patience);
            system.bodies().iter().map(puller).collect::<Result<Vec<_>>>()
        }?;
        if self.output.first() == Some(&start) {
            let rows = flown.samples.chunks_exact_mut(6 * self.output.len());
            for (particle, row) in particles.iter_mut().zip(rows) {
                row[..6].copy_from_slice(&particle.motion);
                particle.recorded = 1;
            }
        }
        if until == start {
            return Ok(());
        }
        let direction = if backwards { -1.0 } else { 1.0 };
        let threads = self
            .threads
            .map_or_else(|| available_parallelism().map_or(1, NonZeroUsize::get), NonZeroUsize::get);
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| {
            Error::invalid("threads", threads, format!("as many as the system can start ({error})"))
        })?;
        let origin =
            |time: f64| (dense.frame().nominal_at(time), Vec3::from(dense.frame().barycentre_velocity));
        let stop = AtomicBool::new(false);
        let mut time = start;
        loop {
            let index = course.index(time);
            let at_edge = backwards && index > 0 && course.ends(index)[0] == time;
            let index = index - usize::from(at_edge);
            let count = dense.pieces().len();
            let stretch = if backwards {
                (index + 1).saturating_sub(STRETCH)..index + 1
            } else {
                index..(index + STRETCH).min(count)
            };
            let end = if backwards {
                course.ends(stretch.start)[0].max(until)
            } else {
                course.ends(stretch.end - 1)[1].min(until)
            };
            // The last step may end a rounding before the run.
            let whole = if backwards { stretch.start == 0 } else { stretch.end == count };
            let end = if whole { until } else { end };
            course.pack(stretch);
            let flying = Flying {
                world: World {
                    course: &course,
                    pullers: &pullers,
                    tableau: rules.tableau,
                    arch: system.arch(),
                },
                outside: &outside,
                surfaces: &surfaces,
                mu: pullers.iter().map(|puller| puller.gm).sum(),
                rules,
                output: self.output,
                watches: self.watches,
                origin: &origin,
                end,
                direction,
                stop: &stop,
            };
            let size = particles.len().div_ceil(4 * threads).next_multiple_of(16).min(BATCH);
            let mut report =
                |part: f64| hook(Progress { start, time: time + part * (end - time), end: until });
            let Flown { samples, happened } = flown;
            let all = (&mut *particles, size);
            pool.in_place_scope(|scope| push_all(scope, &flying, all, samples, happened, &mut report))?;
            time = end;
            if time == until {
                break;
            }
        }
        match hook(Progress { start, time: until, end: until }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Interrupted { time: until }),
        }
    }
}

/// Places a particle at the start. Refuses one that is inside a body.
fn begin(
    poses: &[Pose],
    surfaces: &[Surface],
    system: &System,
    index: usize,
    particle: &mut Particle,
) -> Result<()> {
    let (x, v) = (particle.position(), particle.velocity());
    for (body, (surface, pose)) in surfaces.iter().zip(poses).enumerate() {
        let (place, _) = pose.within(&x, &v);
        if surface.contains(&place) {
            let name = &system.bodies()[body].name;
            let value = format!("inside {name}");
            return Err(Error::invalid(
                format!("position of particle {index}"),
                value,
                "a place outside all bodies",
            ));
        }
        if surface.contains(&(place * (1.0 - 1e-10))) {
            particle.place = Place::Flying { departing: true };
        }
    }
    Ok(())
}

/// Pushes all particles over a stretch.
fn push_all<'s>(
    scope: &rayon::Scope<'s>,
    flying: &'s Flying<'s>,
    (particles, size): (&'s mut [Particle], usize),
    mut samples: &'s mut [f64],
    happened: &mut Vec<Happened>,
    report: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<()> {
    let (sender, receiver) = mpsc::channel();
    let mut left = 0;
    for (number, batch) in particles.chunks_mut(size).enumerate() {
        let (own, others) = samples.split_at_mut(6 * flying.output.len() * batch.len());
        samples = others;
        let sender = sender.clone();
        left += 1;
        scope.spawn(move |_| {
            let pushed = catch_unwind(AssertUnwindSafe(|| {
                let mut batch = Batch::new(flying, number * size, batch, own);
                let outcome = batch.run();
                (batch.happened, outcome)
            }));
            // The receiver lives as long as there are batches out.
            let _ = sender.send((number, pushed));
        });
    }
    let (all, mut asked) = (left, Instant::now());
    let (mut panic, mut failed) = (None, None);
    let mut found = Vec::new();
    if report(0.0).is_break() {
        flying.stop.store(true, Relaxed);
    }
    while left > 0 {
        if let Ok((number, pushed)) = receiver.recv_timeout(LOOK.saturating_sub(asked.elapsed())) {
            left -= 1;
            match pushed {
                Err(fault) => panic = Some(fault),
                Ok((happened, outcome)) => {
                    found.push((number, happened));
                    if let Err(error) = outcome {
                        // What stops the others is no reason of its own.
                        if !matches!(failed, Some(ref error) if !matches!(error, Error::Interrupted { .. })) {
                            failed = Some(error);
                        }
                        flying.stop.store(true, Relaxed);
                    }
                }
            }
        }
        if asked.elapsed() >= LOOK {
            asked = Instant::now();
            if report((all - left) as f64 / all as f64).is_break() {
                flying.stop.store(true, Relaxed);
            }
        }
    }
    found.sort_by_key(|(number, _)| *number);
    happened.extend(found.into_iter().flat_map(|(_, happened)| happened));
    if let Some(fault) = panic {
        resume_unwind(fault);
    }
    failed.map_or(Ok(()), Err)
}
