//! Many simulations in parallel.
//!
//! Takes members one after the other from a [`JobSource`], each a system, a state, an integrator and a time,
//! and returns each [`MemberOutcome`] to it as soon as the run has ended. A simulation is made, advanced and
//! dropped within one thread, and shares with others only data that none of them changes: records have the
//! same bits for any number of threads.

mod member;

pub use crate::workers::{JobProgress, JobSource, WorkerThread};
pub use member::{Member, MemberOutcome, MemberRun};

use crate::error::Result;
use crate::mutual::Store;
use crate::workers::with_workers;
use std::num::NonZeroUsize;
use std::sync::Arc;

/// Runs all members of a source in the given number of threads, or in as many as the machine runs at once.
/// The source knows each member by a tag of its own. If the source breaks, runs stop within 50 ms, and the
/// source receives their records up to there.
///
/// # Errors
/// Returns an error if the machine refuses to start the threads. The error of a member is part of its
/// outcome.
///
/// ```
/// use fullbody::dynamics::{Settings, State, System};
/// use fullbody::ensemble::{JobProgress, JobSource, Member, MemberOutcome, run};
/// use fullbody::integrate::Tolerance;
/// use fullbody::math::Vec3;
/// use fullbody::shape::{Body, Shape};
/// use fullbody::trajectory::{Integrator, Output, TangentOptions};
/// use std::ops::ControlFlow;
///
/// /// Ten pairs of points that start at different speeds.
/// struct Speeds {
///     next: usize,
///     separation: [f64; 10],
/// }
///
/// impl JobSource for Speeds {
///     type Job = (usize, Member);
///     type Answer = (usize, MemberOutcome);
///
///     fn next(&mut self) -> Option<(usize, Member)> {
///         let index = self.next;
///         self.next += 1;
///         let body = |name| Body::with_mass(name, Shape::Point, 0.5).unwrap();
///         let system = System::new(vec![body("A"), body("B")], 1.0, Settings::default()).unwrap();
///         let (at, by) = (Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0 + 0.01 * index as f64, 0.0));
///         let (upright, rest) = (vec![[1.0, 0.0, 0.0, 0.0]; 2], vec![Vec3::zeros(); 2]);
///         let (position, velocity) = (vec![-at / 2.0, at / 2.0], vec![-by / 2.0, by / 2.0]);
///         let state = State::new(0.0, position, velocity, upright, rest).unwrap();
///         let member = Member {
///             system,
///             state,
///             integrator: Integrator::Verner98(Tolerance::new(1e-12, 1e-12).unwrap()),
///             until: 1.0,
///             output: Output::Ends,
///             events: Vec::new(),
///             dense: false,
///             tangent_options: TangentOptions::default(),
///         };
///         (index < 10).then_some((index, member))
///     }
///
///     fn take(&mut self, (index, outcome): (usize, MemberOutcome)) -> ControlFlow<()> {
///         let run = outcome.unwrap().unwrap();
///         let end = run.record.state(run.record.len() - 1);
///         self.separation[index] = (end.position()[1] - end.position()[0]).norm();
///         ControlFlow::Continue(())
///     }
///
///     fn proceed(&mut self, _: JobProgress) -> ControlFlow<()> {
///         ControlFlow::Continue(())
///     }
/// }
///
/// let mut source = Speeds { next: 0, separation: [0.0; 10] };
/// run(&mut source, None)?;
/// assert!((source.separation[0] - 1.0).abs() < 1e-12); // a circle
/// assert!(source.separation.is_sorted());
/// # Ok::<(), fullbody::error::Error>(())
/// ```
pub fn run<T: Send>(
    source: &mut impl JobSource<Job = (T, Member), Answer = (T, MemberOutcome)>,
    threads: Option<NonZeroUsize>,
) -> Result<()> {
    run_within(source, threads, WorkerThread::run)
}

/// Runs all members as [`run`] does, each thread within a call of `life`, which has to run it.
///
/// # Errors
/// Returns the errors of [`run`].
pub fn run_within<T: Send>(
    source: &mut impl JobSource<Job = (T, Member), Answer = (T, MemberOutcome)>,
    threads: Option<NonZeroUsize>,
    life: impl Fn(WorkerThread) + Sync,
) -> Result<()> {
    let store = Arc::<Store>::default();
    with_workers(threads, life, |pool| {
        pool.run(source, |(tag, member), worker| {
            let answer = member.run(&store, &mut |part| worker.report(part));
            (tag, answer)
        });
    })
}
