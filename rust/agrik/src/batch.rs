//! Batches: the rows of a call spread over threads, with a way to stop early.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::error::{Error, Result};
use crate::lanes::{Kernel, Level, Real, dispatch, dispatch_single};
use crate::solve::{Answers, AnswersMut, Plan, run};

mod pool;

pub use pool::{num_threads, set_num_threads};

/// Rows handed out at a time: few enough to balance the threads, many enough that taking
/// the next run costs nothing.
const RUN: usize = 256;
/// Time between two questions whether to go on, once the caller only waits for others.
const BETWEEN_POLLS: Duration = Duration::from_millis(10);
/// Up to this many targets are solved one after the other.
const FEW: usize = 2;

/// Solves all targets of a plan on `threads` threads (0: the number in force).
///
/// `poll` is asked now and then, on the calling thread, whether to go on; a no ends the
/// call with [`Error::Interrupted`]. Answers do not depend on the number of threads.
pub fn solve(plan: &Plan<'_>, threads: usize, poll: &mut dyn FnMut() -> bool) -> Result<Answers> {
    solve_at(Level::in_use(), plan, threads, poll)
}

/// [`solve`] with the instructions of a given level.
pub fn solve_at(
    level: Level,
    plan: &Plan<'_>,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Answers> {
    let mut answers = Answers::new(plan.len(), plan.chain().dof());
    let threads = if threads == 0 { num_threads() } else { threads };
    let runs = plan.len().div_ceil(RUN);
    let finished = if threads <= 1 || runs <= 1 {
        let mut all = Some(answers.as_mut()).filter(|rows| !rows.is_empty());
        run_at(level, plan, &mut || all.take(), poll)
    } else {
        let mut queue = answers.as_mut().split(RUN);
        queue.reverse();
        in_parallel(level, plan, threads.min(runs), Mutex::new(queue), poll)
    };
    if finished { Ok(answers) } else { Err(Error::Interrupted) }
}

/// Hands runs of rows to `work` on `threads` threads (0: the number in force); false
/// where `poll`, asked now and then on the calling thread, said to stop.
pub(crate) fn share<T: Send>(
    mut runs: Vec<T>,
    threads: usize,
    work: &(dyn Fn(T) + Sync),
    poll: &mut dyn FnMut() -> bool,
) -> bool {
    let threads = if threads == 0 { num_threads() } else { threads };
    let threads = threads.min(runs.len());
    runs.reverse();
    if threads <= 1 {
        while let Some(run) = runs.pop() {
            work(run);
            if !runs.is_empty() && !poll() {
                return false;
            }
        }
        return true;
    }
    let stop = AtomicBool::new(false);
    let queue = Mutex::new(runs);
    // A thread that panicked with the lock held leaves the queue as it was: still sound.
    let next = || queue.lock().unwrap_or_else(std::sync::PoisonError::into_inner).pop();
    pool::scope(threads, |scope| {
        for _ in 1..threads {
            scope.spawn(|_| {
                while !stop.load(Ordering::Relaxed)
                    && let Some(run) = next()
                {
                    work(run);
                }
            });
        }
        while let Some(run) = next() {
            work(run);
            if !poll() {
                stop.store(true, Ordering::Relaxed);
                break;
            }
        }
    });
    !stop.into_inner()
}

fn in_parallel<'a>(
    level: Level,
    plan: &Plan<'_>,
    threads: usize,
    queue: Mutex<Vec<AnswersMut<'a>>>,
    poll: &mut dyn FnMut() -> bool,
) -> bool {
    let stop = AtomicBool::new(false);
    let working = Working::new(threads - 1);
    let next = || lock(&queue).pop();
    pool::scope(threads, |scope| {
        // The calling thread works too, and is the one that asks whether to go on: while it
        // has rows of its own, and after that until the others are done.
        for _ in 1..threads {
            scope.spawn(|_| {
                let _done = Done(&working);
                run_at(level, plan, &mut || next(), &mut || !stop.load(Ordering::Relaxed));
            });
        }
        let mut go_on = run_at(level, plan, &mut || next(), &mut || poll());
        while go_on && working.wait() {
            go_on = poll();
        }
        stop.store(!go_on, Ordering::Relaxed);
    });
    !stop.into_inner()
}

/// A lock whose holder panicked guards data that is still whole: counts and whole runs.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How many helpers have not finished yet.
struct Working {
    count: Mutex<usize>,
    changed: Condvar,
}

impl Working {
    fn new(count: usize) -> Self {
        Self { count: Mutex::new(count), changed: Condvar::new() }
    }

    /// Waits until none is working, but not long; true while some are.
    fn wait(&self) -> bool {
        let count = lock(&self.count);
        let (count, _) = self
            .changed
            .wait_timeout_while(count, BETWEEN_POLLS, |count| *count > 0)
            .unwrap_or_else(PoisonError::into_inner);
        *count > 0
    }
}

/// Counts a helper out, whichever way it ends.
struct Done<'w>(&'w Working);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        *lock(&self.0.count) -= 1;
        self.0.changed.notify_all();
    }
}

fn run_at<'a>(
    level: Level,
    plan: &Plan<'_>,
    next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
    keep_going: &mut dyn FnMut() -> bool,
) -> bool {
    let kernel = Loop { plan, next, keep_going };
    // A pass over all lanes costs more than one over a number; below a few targets most
    // lanes would be idle.
    if plan.len() <= FEW { dispatch_single(level, kernel) } else { dispatch(level, kernel) }
}

/// The solver loop as a kernel.
struct Loop<'k, 'a> {
    plan: &'k Plan<'k>,
    next: &'k mut dyn FnMut() -> Option<AnswersMut<'a>>,
    keep_going: &'k mut dyn FnMut() -> bool,
}

impl Kernel for Loop<'_, '_> {
    type Output = bool;
    #[inline(always)]
    fn run<R: Real>(self) -> bool {
        run::<R>(self.plan, self.next, self.keep_going)
    }
}
