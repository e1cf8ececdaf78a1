//! A plan as a call that fills the rows that it is handed.

use super::engine;
use super::plan::Plan;
use crate::call::{AnswersMut, Solve};
use crate::lanes::{Kernel, Level, Real, dispatch, dispatch_single};

/// Up to this many targets are solved one after the other.
const FEW: usize = 2;

impl Solve for Plan<'_> {
    fn rows(&self) -> usize {
        self.request.len()
    }
    fn dof(&self) -> usize {
        self.request.chain().dof()
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
        if self.rows() <= FEW { dispatch_single(level, kernel) } else { dispatch(level, kernel) }
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
