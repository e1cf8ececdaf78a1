//! Batches: the rows of a call spread over threads, with a way to stop early.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};
use crate::lanes::Level;
use crate::solve::{Answers, AnswersMut, Solve};

mod pool;

pub use pool::{num_threads, set_num_threads};

/// Solves all targets of a call on `threads` threads (0: the number in force).
///
/// `poll` is asked now and then, on the calling thread, whether to go on; a no ends the
/// call with [`Error::Interrupted`]. Answers do not depend on the number of threads.
pub fn solve(call: &impl Solve, threads: usize, poll: &mut dyn FnMut() -> bool) -> Result<Answers> {
    solve_at(Level::in_use(), call, threads, poll)
}

/// [`solve`] with the instructions of a given level.
pub fn solve_at(
    level: Level,
    call: &impl Solve,
    threads: usize,
    poll: &mut dyn FnMut() -> bool,
) -> Result<Answers> {
    let mut answers = Answers::new(call.rows(), call.dof());
    let threads = if threads == 0 { num_threads() } else { threads };
    let runs = call.rows().div_ceil(call.run_length());
    let finished = if threads <= 1 || runs <= 1 {
        let mut all = Some(answers.as_mut()).filter(|rows| !rows.is_empty());
        call.run(level, &mut || all.take(), poll)
    } else {
        let mut queue = answers.as_mut().split(call.run_length());
        queue.reverse();
        in_parallel(level, call, threads.min(runs), Mutex::new(queue), poll)
    };
    if finished { Ok(answers) } else { Err(Error::Interrupted) }
}

fn in_parallel<'a>(
    level: Level,
    call: &impl Solve,
    threads: usize,
    queue: Mutex<Vec<AnswersMut<'a>>>,
    poll: &mut dyn FnMut() -> bool,
) -> bool {
    let stop = AtomicBool::new(false);
    // A thread that panicked with the lock held leaves the queue as it was: still sound.
    let next = || queue.lock().unwrap_or_else(std::sync::PoisonError::into_inner).pop();
    pool::scope(threads, |scope| {
        // The calling thread works too, and is the one that asks whether to go on.
        for _ in 1..threads {
            scope.spawn(|_| {
                call.run(level, &mut || next(), &mut || !stop.load(Ordering::Relaxed));
            });
        }
        let finished = call.run(level, &mut || next(), &mut || poll());
        if !finished {
            stop.store(true, Ordering::Relaxed);
        }
    });
    !stop.into_inner()
}
