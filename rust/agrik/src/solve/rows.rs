//! A plan as a call that fills the rows that it is handed.

use smallvec::{SmallVec, smallvec};

use super::Settings;
use super::engine;
use super::limit::wound;
use super::plan::Plan;
use crate::call::{Answers, AnswersMut, Merit, Outcome, Second, Solve, Status};
use crate::lanes::{Kernel, Level, Real, dispatch, dispatch_single};

/// Up to this many targets are solved one after the other.
const FEW: usize = 2;
/// Starts from which a solution off limits is looked for, and the number of the first among the
/// attempts at a target.
const ELSEWHERE: usize = 8;
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
        if second.merit() != Merit::OffLimits {
            let mut all = Some(rows);
            return self.better(level, &mut || all.take(), keep_going);
        }
        if !(0..rows.len()).any(|i| self.stands_at_a_limit(&rows, i)) {
            return true;
        }
        let mut single: SmallVec<[_; 1]> = match rows.len() {
            1 => smallvec![rows],
            _ => rows.split(1).into(),
        };
        single.retain(|row| self.stands_at_a_limit(row, 0));
        let mut open = single.iter_mut().map(AnswersMut::reborrow);
        if !self.better(level, &mut || open.next(), keep_going) {
            return false;
        }
        // What a few small steps do not get off a limit may be had by larger ones.
        single.retain(|row| self.stands_at_a_limit(row, 0));
        let Some(wider) = self.setup().wider.as_ref().filter(|_| !single.is_empty()) else {
            return true;
        };
        let mut plan = self.clone();
        plan.request = plan.request.with_second(wider);
        let mut open = single.iter_mut().map(AnswersMut::reborrow);
        if !plan.better(level, &mut || open.next(), keep_going) {
            return false;
        }
        // And some only by another solution.
        for mut row in single {
            if self.stands_at_a_limit(&row, 0) {
                self.elsewhere(level, second, &mut row);
            }
        }
        true
    }

    /// Puts another solution in place of an answer, one with no joint at a limit, if one of a few
    /// starts leads to one.
    fn elsewhere(&self, level: Level, second: &Second, row: &mut AnswersMut<'_>) {
        let (chain, dof) = (self.request.chain(), self.dof());
        let Some(goal) = self.request.goal(row.first) else { return };
        let there = self.setup().at_point(goal);
        let mut starts = vec![0.0; ELSEWHERE * dof];
        for (k, start) in starts.chunks_exact_mut(dof).enumerate() {
            self.sampler.sample(row.first, FAR + k as u32, &there, start);
        }
        let copies = self.request.copies(row.first, ELSEWHERE);
        let one = Settings { max_restarts: 0, ..self.setup().settings.clone() };
        let mut plan = self.with(&copies, &starts, one);
        plan.request = plan.request.with_second(second);
        let mut answers = Answers::new(ELSEWHERE, dof);
        let mut all = Some(answers.as_mut());
        // Not `run`, which would look elsewhere for each of these in turn.
        plan.reach(level, &mut || all.take(), &mut || true);
        let at_limits = answers.as_mut().split(1).into_iter();
        let mut open = at_limits.filter(|row| plan.stands_at_a_limit(row, 0));
        plan.better(level, &mut || open.next(), &mut || true);
        let rows = answers.as_mut();
        let guard = self.request.guard();
        let accepted = |q: &[f64]| guard.is_none_or(|guard| guard.accept.accepts(q) & 1 != 0);
        let free = |i: &usize| answers_free(&plan, &rows, *i) && accepted(rows.q(*i));
        let Some(found) = (0..ELSEWHERE).find(free) else { return };
        let (before, new) = (row.outcome(0), rows.outcome(found));
        let outcome = Outcome {
            iterations: before.iterations + new.iterations,
            restarts: before.restarts + found as u32 + 1,
            ..new
        };
        let variables = chain.variables().iter();
        for ((to, x), v) in row.finish(0, outcome).iter_mut().zip(rows.q(found)).zip(variables) {
            *to = wound(v, *x, v.middle());
        }
    }

    /// Row `i` of a run has an answer with a joint exactly at a limit.
    fn stands_at_a_limit(&self, rows: &AnswersMut<'_>, i: usize) -> bool {
        let variables = self.request.chain().variables().iter();
        rows.ended(i, Status::Converged)
            && rows.q(i).iter().zip(variables).any(|(x, v)| *x <= v.lower || v.upper <= *x)
    }

    /// Moves answers to where the plan's second aim is best.
    fn better<'a>(
        &self,
        level: Level,
        next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        let kernel = Refinement { plan: self, next, keep_going };
        if self.rows() <= FEW { dispatch_single(level, kernel) } else { dispatch(level, kernel) }
    }
}

/// Row `i` has an answer, and no joint of it at a limit.
fn answers_free(plan: &Plan<'_>, rows: &AnswersMut<'_>, i: usize) -> bool {
    rows.ended(i, Status::Converged) && !plan.stands_at_a_limit(rows, i)
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
