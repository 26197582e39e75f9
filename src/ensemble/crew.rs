//! The threads that run members, and the one that hands them out.

use super::{Answer, Member};
use crate::error::{Error, Result};
use crate::mutual::Store;
use rayon::{ThreadBuilder, ThreadPoolBuilder};
use std::any::Any;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, mpsc};
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

/// How often the caller is asked: with the time until its answer is heard within a run, less than 100 ms.
const LOOK: Duration = Duration::from_millis(25);

/// Members that are waiting or under way for each thread: enough for all of them to have work while the caller is busy.
const AHEAD: usize = 8;

/// How far the members are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Members whose answers are there.
    pub done: usize,
    /// What is done of those under way, in members.
    pub under_way: f64,
}

/// Who wants the runs. All but [`Self::thread`] is called in the caller's own thread.
pub trait Caller {
    /// What the caller knows a member by.
    type Tag: Send;

    /// The next member, asked for when one is needed soon.
    fn next(&mut self) -> Option<(Self::Tag, Member)>;

    /// Takes an answer, in the order in which they come.
    fn take(&mut self, tag: Self::Tag, answer: Answer);

    /// Whether to go on, asked about every 25 ms and after the last answer.
    fn proceed(&mut self, progress: Progress) -> ControlFlow<()>;

    /// The life of a thread that runs members, in itself.
    fn thread(life: ThreadBuilder) {
        life.run();
    }
}

/// Runs all members of a caller in so many threads, or in as many as the machine runs at once.
///
/// Where the caller does not want to go on, runs stop within 50 ms, and the caller is given what there is of them.
pub fn run<C: Caller>(caller: &mut C, threads: Option<NonZeroUsize>) -> Result<()> {
    let threads =
        threads.map_or_else(|| available_parallelism().map_or(1, NonZeroUsize::get), NonZeroUsize::get);
    let crew = Crew {
        store: Arc::default(),
        stop: AtomicBool::new(false),
        parts: (0..threads).map(|_| AtomicU64::new(0)).collect(),
    };
    let pool = ThreadPoolBuilder::new().num_threads(threads);
    let done = pool.build_scoped(C::thread, |pool| pool.in_place_scope(|scope| crew.serve(caller, scope)));
    match done {
        Ok(None) => Ok(()),
        Ok(Some(panic)) => resume_unwind(panic),
        Err(error) => {
            Err(Error::invalid("threads", threads, format!("as many as the system can start ({error})")))
        }
    }
}

/// What the threads have in common.
struct Crew {
    store: Arc<Store>,
    stop: AtomicBool,
    /// The part that is done of what each thread has at hand, as bits.
    parts: Vec<AtomicU64>,
}

type Panic = Box<dyn Any + Send>;

impl Crew {
    /// Hands out the members and gives back their answers. A panic is kept until all threads have come to rest.
    fn serve<'s, C: Caller>(&'s self, caller: &mut C, scope: &rayon::Scope<'s>) -> Option<Panic>
    where
        C::Tag: 's,
    {
        let (sender, receiver) = mpsc::channel();
        let (mut done, mut out, mut more) = (0, 0, true);
        let (mut asked, mut panic) = (Instant::now(), None);
        loop {
            let room = out < AHEAD * self.parts.len();
            if more
                && room
                && let Some((tag, member)) = caller.next()
            {
                out += 1;
                let sender = sender.clone();
                scope.spawn(move |_| {
                    let answer = catch_unwind(AssertUnwindSafe(|| self.run(member)));
                    // The receiver lives as long as there are members out.
                    let _ = sender.send((tag, answer));
                });
            } else if room {
                more = false;
            }
            let wait = if more && room { Duration::ZERO } else { LOOK.saturating_sub(asked.elapsed()) };
            if out > 0
                && let Ok((tag, answer)) = receiver.recv_timeout(wait)
            {
                (out, done) = (out - 1, done + 1);
                match answer {
                    Ok(answer) => caller.take(tag, answer),
                    Err(fault) => panic = Some(fault),
                }
            }
            if out == 0 && !more || asked.elapsed() >= LOOK {
                asked = Instant::now();
                let proceed = caller.proceed(Progress { done, under_way: self.under_way() });
                if proceed.is_break() || panic.is_some() {
                    self.stop.store(true, Relaxed);
                    more = false;
                }
            }
            if out == 0 && !more {
                return panic;
            }
        }
    }

    /// Runs a member in the present thread.
    fn run(&self, member: Member) -> Answer {
        let own = rayon::current_thread_index().and_then(|index| self.parts.get(index));
        let tell = |part: f64| {
            if let Some(own) = own {
                own.store(part.to_bits(), Relaxed);
            }
        };
        let answer = member.run(&self.store, &mut |part| {
            tell(part);
            if self.stop.load(Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        tell(0.0);
        answer
    }

    fn under_way(&self) -> f64 {
        self.parts.iter().map(|part| f64::from_bits(part.load(Relaxed))).sum()
    }
}
