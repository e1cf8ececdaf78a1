//! Batches: the rows of a call, taken run by run by any number of threads.

use std::sync::Mutex;

use super::answers::{Answers, AnswersMut};
use crate::error::{Error, Result};
use crate::lanes::Level;
use crate::threads::{lock, num_threads, together};

/// A call ready to be solved, run by run of its rows, on any number of threads.
pub trait Solve: Sync {
    /// How many targets.
    fn rows(&self) -> usize;
    /// Joint values of an answer.
    fn dof(&self) -> usize;
    /// Rows handed out at a time: few enough to balance the threads, many enough that
    /// taking the next run costs nothing.
    fn run_length(&self) -> usize;
    /// Solves the rows of every run that `next` hands out, until it hands out none or
    /// `keep_going` says no; false in the latter case.
    fn run<'a>(
        &self,
        level: Level,
        next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool;
}

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
    solve_into(level, call, threads, &mut answers, poll)?;
    Ok(answers)
}

/// [`solve_at`] into answers that are there already, of as many rows as the call; with one
/// target, a chain of up to 16 joints and a [`Setup`](crate::solve::Setup) made before nothing is
/// allocated.
pub fn solve_into(
    level: Level,
    call: &impl Solve,
    threads: usize,
    answers: &mut Answers,
    poll: &mut dyn FnMut() -> bool,
) -> Result<()> {
    if answers.len() != call.rows() || answers.q.len() != call.rows() * call.dof() {
        return Err(Error::argument("answers", format!("{} rows", call.rows()), answers.len()));
    }
    let threads = if threads == 0 { num_threads() } else { threads };
    let runs = call.rows().div_ceil(call.run_length());
    let finished = if threads <= 1 || runs <= 1 {
        let mut all = Some(answers.as_mut()).filter(|rows| !rows.is_empty());
        call.run(level, &mut || all.take(), poll)
    } else {
        let mut queue = answers.as_mut().split(call.run_length());
        queue.reverse();
        let queue = Mutex::new(queue);
        let work = |keep_going: &mut dyn FnMut() -> bool| {
            call.run(level, &mut || lock(&queue).pop(), keep_going)
        };
        together(threads.min(runs), &work, poll)
    };
    if finished { Ok(()) } else { Err(Error::Interrupted) }
}
