//! A plan as a call that fills the rows that it is handed.

use smallvec::{SmallVec, smallvec};

use super::Settings;
use super::engine;
use super::limit::{limits, wound};
use super::plan::Plan;
use crate::call::{Answers, AnswersMut, Outcome, Solve, Status};
use crate::chain::Variable;
use crate::lanes::{Kernel, Level, Real, dispatch, dispatch_single};

/// Up to this many targets are solved one after the other.
const FEW: usize = 2;
/// Starts from which a solution off limits is looked for, one after the other, and the number of
/// the first among the attempts at a target.
const ELSEWHERE: u32 = 8;
const FAR: u32 = 1 << 16;

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
        let aims = self.second_aim().is_some();
        if !aims && !self.keeps_off_limits() {
            return self.reach(level, next, keep_going);
        }
        // A run is moved on when all of it is reached.
        while let Some(mut rows) = next() {
            let mut all = Some(rows.reborrow());
            if !self.reach(level, &mut || all.take(), keep_going) {
                return false;
            }
            if !aims {
                self.leave_limits(level, rows);
            } else if !self.refine(level, rows, keep_going) {
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
        if self.is_single() { dispatch_single(level, kernel) } else { dispatch(level, kernel) }
    }

    /// Rows come one after the other.
    fn is_single(&self) -> bool {
        self.limited || self.rows() <= FEW
    }

    /// Moves the answers of a run to where the second aim is best, if there is one.
    pub(super) fn refine(
        &self,
        level: Level,
        rows: AnswersMut<'_>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        if self.second_aim().is_none() {
            return true;
        }
        let mut all = Some(rows);
        let next = &mut || all.take();
        let kernel = Refinement { plan: self, next, keep_going };
        if self.is_single() { dispatch_single(level, kernel) } else { dispatch(level, kernel) }
    }

    /// Looks for other solutions in place of answers with a joint exactly at a limit.
    fn leave_limits(&self, level: Level, rows: AnswersMut<'_>) {
        // Arms with a joint that their own limits hold keep the answers that they had.
        let held = |v: &Variable| !self.limited && v.lower >= v.upper;
        let held = self.request.chain().variables().iter().any(held);
        if held || !(0..rows.len()).any(|i| self.stands_at_a_limit(&rows, i)) {
            return;
        }
        let mut single: SmallVec<[_; 1]> = match rows.len() {
            1 => smallvec![rows],
            _ => rows.split(1).into(),
        };
        let most = self.setup().settings.max_restarts;
        for round in 0..ELSEWHERE {
            // Each start is one of the restarts that the caller allows.
            let allowed = |row: &AnswersMut<'_>| row.outcome(0).restarts + round < most;
            single.retain(|row| self.stands_at_a_limit(row, 0) && allowed(row));
            if single.is_empty() {
                break;
            }
            self.elsewhere(level, round, &mut single);
        }
    }

    /// Puts another solution in place of answers, where one start each leads to one with no joint
    /// at a limit.
    fn elsewhere(&self, level: Level, round: u32, rows: &mut [AnswersMut<'_>]) {
        let (chain, dof) = (self.request.chain(), self.dof());
        let mut starts = vec![0.0; rows.len() * dof];
        for (row, start) in rows.iter().zip(starts.chunks_exact_mut(dof)) {
            if let Some(goal) = self.request.goal(row.first) {
                let there = self.setup().at_point(goal);
                self.sampler.sample(row.first, FAR + round, &there, start);
            }
            if self.limited {
                // Starts of the arm's own limits, as those of attempts.
                let joints = start.iter_mut().zip(limits(self)).zip(chain.variables());
                joints.for_each(|((x, v), own)| *x = v.inside(*x, (own.lower, own.upper)));
            }
        }
        let chosen: Vec<usize> = rows.iter().map(|row| row.first).collect();
        let targets = self.request.chosen(chosen.iter().copied());
        let one = Settings { max_restarts: 0, ..self.setup().settings.clone() };
        let mut plan = self.with(&targets, &starts, one);
        // What else is drawn for a row depends on that row, whatever other rows there are.
        plan.sampler.chosen = Some(&chosen);
        let mut answers = Answers::new(rows.len(), dof);
        let mut all = Some(answers.as_mut());
        plan.reach(level, &mut || all.take(), &mut || true);
        let found = answers.as_mut();
        let guard = self.request.guard();
        for (i, row) in rows.iter_mut().enumerate() {
            let free = found.ended(i, Status::Converged) && !plan.stands_at_a_limit(&found, i);
            if !free || guard.is_some_and(|guard| guard.accept.accepts(found.q(i)) & 1 == 0) {
                continue;
            }
            let (before, new) = (row.outcome(0), found.outcome(i));
            let outcome = Outcome {
                iterations: before.iterations + new.iterations,
                restarts: before.restarts + round + 1,
                ..new
            };
            let joints = found.q(i).iter().zip(chain.variables());
            for (to, (x, v)) in row.finish(0, outcome).iter_mut().zip(joints) {
                *to = if self.limited { *x } else { wound(v, *x, v.middle()) };
            }
        }
    }

    /// Row `i` of a run has an answer with a joint exactly at a limit; one that is held, its limits
    /// being the same, cannot leave them.
    fn stands_at_a_limit(&self, rows: &AnswersMut<'_>, i: usize) -> bool {
        let at = |(i, x): (usize, &f64)| {
            let (lower, upper) = self.ends(i);
            lower < upper && (*x <= lower || upper <= *x)
        };
        rows.ended(i, Status::Converged) && rows.q(i).iter().enumerate().any(at)
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
