//! What a batch asks of a solver: to fill the rows that it is handed.

use super::answers::AnswersMut;
use super::engine;
use super::plan::Plan;
use crate::lanes::{Kernel, Level, Real, dispatch, dispatch_single};

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

/// Up to this many targets are solved one after the other.
const FEW: usize = 2;

impl Solve for Plan<'_> {
    fn rows(&self) -> usize {
        self.len()
    }
    fn dof(&self) -> usize {
        self.chain.dof()
    }
    fn run_length(&self) -> usize {
        256
    }
    fn run<'a>(
        &self,
        level: Level,
        next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        let kernel = Loop { plan: self, next, keep_going };
        // A pass over all lanes costs more than one over a number; below a few targets most
        // lanes would be idle.
        if self.len() <= FEW { dispatch_single(level, kernel) } else { dispatch(level, kernel) }
    }
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
        engine::run::<R>(self.plan, self.next, self.keep_going)
    }
}
