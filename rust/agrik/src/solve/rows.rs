//! A plan as a call that fills the rows that it is handed.

use super::engine;
use super::plan::Plan;
use crate::call::{AnswersMut, Merit, Second, Solve, Status};
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
        let Some(second) = self.second_aim() else {
            return self.reach(level, next, keep_going);
        };
        // A run is moved on when all of it is reached.
        while let Some(mut rows) = next() {
            let mut all = Some(rows.reborrow());
            if !self.reach(level, &mut || all.take(), keep_going) {
                return false;
            }
            if !self.refine(second, level, rows, keep_going) {
                return false;
            }
        }
        true
    }
}

impl Plan<'_> {
    /// Solves rows.
    fn reach<'a>(
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

    /// Moves the answers of a run to where the second aim is best.
    pub(super) fn refine(
        &self,
        second: &Second,
        level: Level,
        rows: AnswersMut<'_>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        if self.second_aim().is_none() {
            return true;
        }
        let few = self.rows() <= FEW;
        let mut open = if second.measure == Merit::OffLimits {
            let chain = self.request.chain();
            let stands = |row: &AnswersMut<'_>| {
                let variables = chain.variables().iter();
                row.ended(0, Status::Converged)
                    && row.q(0).iter().zip(variables).any(|(x, v)| *x <= v.lower || v.upper <= *x)
            };
            if !(0..rows.len()).any(|i| rows.ended(i, Status::Converged)) {
                return true;
            }
            rows.split(1).into_iter().filter(stands).collect()
        } else {
            vec![rows]
        };
        if open.is_empty() {
            return true;
        }
        let kernel = Refinement { plan: self, next: &mut || open.pop(), keep_going };
        if few { dispatch_single(level, kernel) } else { dispatch(level, kernel) }
    }
}

/// The loop of the second aim as a kernel.
struct Refinement<'k, 'a> {
    plan: &'k Plan<'k>,
    next: &'k mut dyn FnMut() -> Option<AnswersMut<'a>>,
    keep_going: &'k mut dyn FnMut() -> bool,
}

impl Kernel for Refinement<'_, '_> {
    type Output = bool;
    #[inline(always)]
    fn run<R: Real>(self) -> bool {
        engine::run_second::<R>(self.plan, self.next, self.keep_going)
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
