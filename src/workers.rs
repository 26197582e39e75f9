//! A pool of worker threads for many jobs of one kind.
//!
//! It takes jobs one after the other from a [`JobSource`] and returns each answer to it as soon as the job is
//! done. The source is called in the caller's own thread only, about every 25 ms also to ask whether to go
//! on.

use crate::error::{Error, Result};
use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::mpsc;
use std::thread::available_parallelism;
use std::time::Duration;
use web_time::Instant;

/// How often the source is asked whether to go on. Together with the time until a job asks its worker, an
/// interrupt takes less than 100 ms.
const ASK_INTERVAL: Duration = Duration::from_millis(25);

/// The number of jobs that are waiting or under way for each thread: enough for all threads to have work
/// while the source is busy.
const AHEAD: usize = 8;

/// The progress of the jobs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JobProgress {
    /// The number of jobs that are done.
    pub done: usize,
    /// The sum of the finished parts of the jobs under way.
    pub under_way: f64,
}

/// A source of jobs, which takes their answers.
pub trait JobSource {
    /// The description of a job.
    type Job: Send;
    /// The result of a job.
    type Answer: Send;

    /// Returns the next job when a thread will need one soon; `None` when there are no more.
    fn next(&mut self) -> Option<Self::Job>;

    /// Takes an answer, in the order in which jobs are done. A break stops the other jobs.
    fn take(&mut self, answer: Self::Answer) -> ControlFlow<()>;

    /// Decides whether to go on. It is called about every 25 ms and after the last answer.
    fn proceed(&mut self, progress: JobProgress) -> ControlFlow<()>;
}

/// A thread of a pool that is about to start.
#[derive(Debug)]
pub struct WorkerThread(ThreadBuilder);

impl WorkerThread {
    /// Runs the thread until the pool ends.
    pub fn run(self) {
        self.0.run();
    }
}

/// A number of threads that run jobs.
pub struct WorkerPool<'p> {
    threads: &'p ThreadPool,
}

/// The data that all jobs of a run share.
struct Shared {
    stop: AtomicBool,
    /// The finished part of the job of each thread, as bits.
    parts: Vec<AtomicU64>,
}

/// A job's view of the thread that runs it.
pub struct Worker<'s> {
    shared: &'s Shared,
    part: Option<&'s AtomicU64>,
}

impl Worker<'_> {
    /// Returns whether the job must stop.
    pub fn stopped(&self) -> bool {
        self.shared.stop.load(Relaxed)
    }

    /// Reports the finished part of the job, from 0 to 1; breaks where the job must stop.
    pub fn report(&self, part: f64) -> ControlFlow<()> {
        if let Some(finished) = self.part {
            finished.store(part.to_bits(), Relaxed);
        }
        if self.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Makes a pool of this many threads, or of as many as the machine runs at once, and passes it to `inside`.
/// Each thread lives within a call of `life`, which runs it.
pub fn with_workers<R>(
    threads: Option<NonZeroUsize>,
    life: impl Fn(WorkerThread) + Sync,
    inside: impl FnOnce(&WorkerPool) -> R,
) -> Result<R> {
    let threads =
        threads.map_or_else(|| available_parallelism().map_or(1, NonZeroUsize::get), NonZeroUsize::get);
    let pool = ThreadPoolBuilder::new().num_threads(threads);
    let outcome =
        pool.build_scoped(|thread| life(WorkerThread(thread)), |threads| inside(&WorkerPool { threads }));
    outcome.map_err(|error| {
        Error::invalid("threads", threads, format!("as many as the system can start ({error})"))
    })
}

impl WorkerPool<'_> {
    /// Returns the number of threads.
    pub fn threads(&self) -> usize {
        self.threads.current_num_threads()
    }

    /// Runs all jobs of a source. After a break of the source no further job begins and the others must stop;
    /// the source still receives their answers. A panic of a job continues in the caller's thread once all
    /// threads are idle.
    pub fn run<S: JobSource>(&self, source: &mut S, work: impl Fn(S::Job, &Worker) -> S::Answer + Sync) {
        let shared = Shared {
            stop: AtomicBool::new(false),
            parts: (0..self.threads()).map(|_| AtomicU64::new(0)).collect(),
        };
        let panic = self.threads.in_place_scope(|scope| shared.serve(source, &work, scope));
        if let Some(panic) = panic {
            resume_unwind(panic);
        }
    }
}

type Panic = Box<dyn std::any::Any + Send>;

impl Shared {
    /// Hands out the jobs and returns their answers to the source. Returns a job's panic when all jobs are
    /// done.
    fn serve<'s, S: JobSource>(
        &'s self,
        source: &mut S,
        work: &'s (impl Fn(S::Job, &Worker) -> S::Answer + Sync),
        scope: &rayon::Scope<'s>,
    ) -> Option<Panic>
    where
        S::Job: 's,
        S::Answer: 's,
    {
        let (sender, receiver) = mpsc::channel();
        let (mut done, mut out, mut more) = (0, 0, true);
        let (mut last_call, mut panic) = (Instant::now(), None);
        loop {
            let room = out < AHEAD * self.parts.len();
            if more
                && room
                && let Some(job) = source.next()
            {
                out += 1;
                let sender = sender.clone();
                scope.spawn(move |_| {
                    let answer = catch_unwind(AssertUnwindSafe(|| self.work(job, work)));
                    // The receiver lives as long as jobs are under way.
                    let _ = sender.send(answer);
                });
            } else if room {
                more = false;
            }
            let wait =
                if more && room { Duration::ZERO } else { ASK_INTERVAL.saturating_sub(last_call.elapsed()) };
            let mut stop = false;
            if out > 0
                && let Ok(answer) = receiver.recv_timeout(wait)
            {
                (out, done) = (out - 1, done + 1);
                match answer {
                    Ok(answer) => stop = source.take(answer).is_break(),
                    Err(fault) => {
                        (panic, stop) = (Some(fault), true);
                    }
                }
            }
            if out == 0 && !more || last_call.elapsed() >= ASK_INTERVAL {
                last_call = Instant::now();
                stop |= source.proceed(JobProgress { done, under_way: self.under_way() }).is_break();
            }
            if stop {
                self.stop.store(true, Relaxed);
                more = false;
            }
            if out == 0 && !more {
                return panic;
            }
        }
    }

    /// Runs a job in the present thread.
    fn work<J, A>(&self, job: J, work: &impl Fn(J, &Worker) -> A) -> A {
        let part = rayon::current_thread_index().and_then(|index| self.parts.get(index));
        let worker = Worker { shared: self, part };
        let answer = work(job, &worker);
        // A thread without a job has no finished part.
        let _ = worker.report(0.0);
        answer
    }

    fn under_way(&self) -> f64 {
        self.parts.iter().map(|part| f64::from_bits(part.load(Relaxed))).sum()
    }
}
