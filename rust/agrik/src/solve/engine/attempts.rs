//! Which target a lane works on, and from where: attempts begin and end here.

use std::cmp::Ordering;

use smallvec::smallvec;

use super::feedback::Halt;
use super::nearest::{End, Search};
use super::runs::{Place, Runs};
use super::{Engine, LAW, SECOND};
use crate::call::{AnswersMut, Left, Outcome, Status};
use crate::chain::{JointKind, Variable};
use crate::kinematics::{PerJoint, Workspace, forward};
use crate::lanes::Real;
use crate::solve::limit::bring_near;
use crate::solve::step::squared_norm;
use crate::task::{Goal, Rows, TaskError};

/// Attempts after the first that start around the caller's start: its neighbourhood may hold a
/// solution that the way straight ahead, along a limit, does not lead to.
const AROUND: u32 = 2;
/// From this attempt on every second one starts near the best end so far.
const HOPS: u32 = 8;
/// Most starts from which a nearest posture is looked for; fewer where so many ends after the
/// best one bring the tool as near as it, but for this share of the length per radian, and this
/// angle, rad.
pub(super) const MOST_STARTS: u32 = 32;
const ENOUGH: u32 = 8;
const SAME: f64 = 1e-5;
/// Attempts after the first at a pose of which only the position has to be met.
pub(super) const POSES: u32 = 4;

/// What a lane is busy with.
#[derive(Debug, Clone)]
pub(super) struct Job {
    /// Where its answer goes; `None` for an idle lane.
    pub place: Option<Place>,
    /// Row in the whole call, and its goal.
    pub row: usize,
    pub goal: Goal<f64>,
    pub attempt: u32,
    /// Steps of this attempt, and of all before it.
    pub steps: u32,
    steps_before: u32,
    /// Proven out of reach: one attempt, for the nearest posture.
    unreachable: bool,
    /// The best end of an attempt so far.
    pub best: Option<Best>,
    pub best_q: PerJoint<f64>,
    /// What the call's guard finds the best end that it accepts, and the attempt that was the
    /// first to end with one.
    pub accepted: Option<(f64, u32)>,
    /// Ends that reached the goal and that the guard refused, one after the other.
    pub refused: Vec<f64>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Best {
    pub squared: f64,
    /// What the attempt ended with, where it is not told from all others.
    pub status: Status,
    pub position_error: f64,
    pub orientation_error: f64,
}

impl Job {
    /// A lane of an arm with `dof` joint values without a target.
    pub fn idle(dof: usize) -> Self {
        Self {
            place: None,
            row: 0,
            goal: Goal::zero(),
            attempt: 0,
            steps: 0,
            steps_before: 0,
            unreachable: false,
            best: None,
            best_q: smallvec![0.0; dof],
            accepted: None,
            refused: Vec::new(),
        }
    }
}

impl<R: Real, T: Rows<R, M>, const M: usize, const WAY: u8> Engine<'_, R, T, M, WAY> {
    /// How a lane's attempt ended.
    #[inline(always)]
    pub(super) fn status(&self, lane: usize, solved: bool, halt: Halt) -> Status {
        let plain = WAY == LAW || self.setup.settings.plain;
        if solved {
            Status::Converged
        } else if plain && halt.broken >> lane & 1 != 0 {
            Status::NonFinite
        } else if plain && halt.stalled >> lane & 1 != 0 {
            Status::Stalled
        } else {
            Status::NotFound
        }
    }

    /// Ends a lane's attempt; true where the target gets another one.
    #[inline(always)]
    pub(super) fn end_attempt(
        &mut self,
        lane: usize,
        status: Status,
        error: &TaskError<R, M>,
        runs: &mut Runs<'_>,
    ) -> bool {
        let solved = status == Status::Converged;
        let squared = squared_norm(&error.rows).lane(lane);
        let job = &mut self.jobs[lane];
        if solved || job.best.is_none_or(|best| squared < best.squared) {
            let position_error = error.position2.lane(lane).sqrt();
            let orientation_error = error.orientation2.lane(lane).sqrt();
            // An attempt that ran into numbers without meaning is no answer.
            if position_error.is_finite() && orientation_error.is_finite() {
                job.best = Some(Best { squared, status, position_error, orientation_error });
                for (to, from) in job.best_q.iter_mut().zip(&self.q) {
                    *to = from.lane(lane);
                }
            }
        }
        self.goes_on(lane, status, solved, runs)
    }

    /// True where the job in a place gets another attempt after one that ended with a status;
    /// otherwise its answer is written. `solved` tells that nothing more needs to be looked for.
    #[inline(always)]
    pub(super) fn goes_on(
        &mut self,
        place: usize,
        status: Status,
        solved: bool,
        runs: &mut Runs<'_>,
    ) -> bool {
        let job = &mut self.jobs[place];
        if !solved && !job.unreachable && job.attempt < self.most_restarts {
            job.attempt += 1;
            job.steps_before += job.steps;
            job.steps = 0;
            return true;
        }
        let judged = job.accepted.is_some() || !job.refused.is_empty();
        if !solved && self.completes && !judged {
            self.complete(place);
        }
        if self.jobs[place].refused.len() > self.q.len() && self.jobs[place].accepted.is_none() {
            self.choose_refused(place);
        }
        let job = &mut self.jobs[place];
        let mut best = job.best.unwrap_or_else(|| {
            let given = self.plan.request.start(job.row);
            let most = self.setup.well_known(&job.goal);
            for (x, v) in job.best_q.iter_mut().zip(self.variables) {
                *x = v.near_zero();
            }
            bring_near(&self.limits, &mut job.best_q, given, most);
            let request = &self.plan.request;
            let mut at = Workspace::new(request.chain().compiled());
            forward(request.chain().compiled(), &job.best_q, &mut at);
            let goal = request.goal(job.row);
            let left = goal.map_or(Left::UNKNOWN, |goal| request.left(&at, &goal));
            // A solution is one however it came about.
            let solved = request.aim().is_met(&left);
            Best {
                squared: f64::INFINITY,
                status: if solved { Status::Converged } else { status },
                position_error: left.position2.sqrt(),
                orientation_error: left.orientation2.sqrt(),
            }
        });
        if best.status != Status::Converged && self.setup.aim.puts_position_first() {
            // An end that was no solution when it came has not been brought near the start.
            let given = self.plan.request.start(job.row);
            let most = self.setup.well_known(&job.goal);
            bring_near(&self.limits, &mut job.best_q, given, most);
            let mut at = Workspace::new(self.plan.request.chain().compiled());
            forward(self.plan.request.chain().compiled(), &job.best_q, &mut at);
            let goal = self.plan.request.goal(job.row);
            if goal.is_some_and(|goal| self.setup.aim.is_met(&self.setup.aim.left(&at, &goal))) {
                let guard = self.plan.request.guard();
                let free = guard.is_none_or(|guard| guard.accept.accepts(&job.best_q) & 1 != 0);
                best.status = if free { Status::Converged } else { Status::InCollision };
            }
        }
        let proven = job.unreachable && best.status != Status::Converged;
        let status = if proven { Status::OutOfReach } else { best.status };
        let outcome = Outcome {
            status,
            position_error: best.position_error,
            orientation_error: best.orientation_error,
            iterations: job.steps_before + job.steps,
            restarts: job.attempt,
        };
        if let Some(place) = job.place.take() {
            runs.finish(place, outcome, job.best_q.iter().copied());
        }
        false
    }

    /// Looks for a row's nearest posture where attempts did not solve it: from the best end, and
    /// from other starts. Solved after all is solved.
    #[inline(never)]
    fn complete(&mut self, place: usize) {
        let job = &mut self.jobs[place];
        let Some(goal) = self.plan.request.goal(job.row) else { return };
        let (plan, limits) = (self.plan, &self.limits[..]);
        let scale = self.setup.rotation_scale;
        let whole = Search { plan, limits, goal, scale };
        let mut best: Option<(End, PerJoint<f64>)> = None;
        // Ends that are as near as the best one.
        let mut agree = 0;
        for start in 0..MOST_STARTS.min(self.setup.settings.max_restarts.saturating_add(1)) {
            let mut q = job.best_q.clone();
            if start > 0 || job.best.is_none() {
                let attempt = job.attempt + start;
                self.plan.sampler.sample(job.row, attempt, &job.goal, &mut q);
                for (x, v) in q.iter_mut().zip(limits) {
                    *x = x.max(v.lower).min(v.upper);
                }
            }
            let mut end = None;
            if start == 0 || !job.unreachable && start % 2 == 0 {
                end = Some(whole.run(&mut q));
            }
            job.steps += end.map_or(0, |end| end.steps);
            // First the place, then how the tool is turned.
            let mut end = end.filter(|end| end.best).unwrap_or_else(|| whole.place_first(&mut q));
            job.steps += end.steps;
            if !end.best && end.is_close(scale) {
                // From the right place the rest of the way may be open.
                let mut there = q.clone();
                let again = whole.run(&mut there);
                job.steps += again.steps;
                if again.best {
                    (end, q) = (again, there);
                }
            }
            let order = best.as_ref().map(|(before, _)| end.compare(before, SAME, scale));
            match order {
                None | Some(Ordering::Less) => agree = 0,
                Some(Ordering::Equal) => agree += 1,
                Some(Ordering::Greater) => {}
            }
            if best.as_ref().is_none_or(|(before, _)| end.is_nearer(before)) {
                best = Some((end, q));
            }
            if end.best || agree >= ENOUGH {
                break;
            }
        }
        if let Some((end, mut q)) = best {
            let given = self.plan.request.start(self.jobs[place].row);
            let most = self.setup.well_known(&goal);
            bring_near(&self.limits, &mut q, given, most);
            if end.solved
                && let Some(guard) = self.plan.request.guard()
            {
                let errors = (end.position_error.powi(2), end.orientation_error.powi(2));
                let is_accepted = guard.accept.accepts(&q) & 1 != 0;
                self.judge(place, guard, &q, errors, is_accepted);
                return;
            }
            let job = &mut self.jobs[place];
            let status = if end.solved { Status::Converged } else { Status::NotFound };
            job.best = Some(Best {
                squared: 2.0 * end.cost,
                status,
                position_error: end.position_error,
                orientation_error: end.orientation_error,
            });
            job.best_q = q;
        }
    }

    /// Gives a lane the next target that needs solving; false where none is left.
    #[inline(always)]
    pub(super) fn refill<'a>(
        &mut self,
        lane: usize,
        runs: &mut Runs<'a>,
        next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
    ) -> bool {
        loop {
            let Some((place, row)) = runs.next_row(next) else { return false };
            if WAY == SECOND && !runs.is_reached(place) {
                runs.keep(place);
                continue;
            }
            let Some(goal) = self.plan.request.goal(row) else {
                let outcome = Outcome::unanswered(Status::BadInput);
                runs.finish(place, outcome, self.variables.iter().map(Variable::near_zero));
                continue;
            };
            let there = self.setup.at_point(goal);
            self.goal.set_lane(lane, &there);
            let job = &mut self.jobs[lane];
            job.place = Some(place);
            job.row = row;
            job.goal = there;
            job.attempt = 0;
            job.steps = 0;
            job.steps_before = 0;
            job.unreachable = self.plan.proven_unreachable(&goal);
            job.best = None;
            job.accepted = None;
            job.refused.clear();
            if WAY == SECOND {
                self.begin.copy_from_slice(runs.q(place));
            }
            self.start(lane, row, 0, &goal);
            return true;
        }
    }

    /// Puts a lane at the start of its target's next attempt.
    #[inline(always)]
    pub(super) fn start_next(&mut self, lane: usize) {
        let job = &self.jobs[lane];
        let (row, attempt, goal) = (job.row, job.attempt, job.goal);
        self.start(lane, row, attempt, &goal);
    }

    /// Puts a lane at the start of an attempt.
    #[inline(always)]
    fn start(&mut self, lane: usize, row: usize, attempt: u32, goal: &Goal<f64>) {
        let given = self.plan.start(row);
        let begin: &[f64] = match given {
            _ if WAY == SECOND => &self.begin,
            Some(start) if attempt == 0 => start,
            Some(start)
                if WAY != LAW && attempt <= AROUND && self.plan.request.start(row).is_some() =>
            {
                self.begin.copy_from_slice(start);
                self.plan.sampler.around(row, attempt, &mut self.begin);
                &self.begin
            }
            _ if attempt >= HOPS && attempt % 2 == 1 && self.jobs[lane].best.is_some() => {
                self.begin.clone_from(&self.jobs[lane].best_q);
                self.plan.sampler.hop(row, attempt, &mut self.begin);
                &self.begin
            }
            _ => {
                self.plan.sampler.sample(row, attempt, goal, &mut self.begin);
                &self.begin
            }
        };
        let joints = self.q.iter_mut().zip(begin).zip(&self.limits).zip(self.variables);
        for (((q, x), v), own) in joints {
            // Sampled between the joint's own limits.
            let sampled = self.plan.limited && (attempt > 0 || given.is_none());
            let x = if sampled { v.inside(*x, (own.lower, own.upper)) } else { *x };
            q.set_lane(lane, x.max(v.lower).min(v.upper));
        }
        if self.has_continuous || self.winds {
            // Where a solver's attempts begin by themselves is nothing to stay near.
            let given = self.plan.request.start(row);
            let most = self.setup.well_known(goal);
            for (i, (reference, v)) in self.reference.iter_mut().zip(&self.limits).enumerate() {
                // Limits given to a joint that turns freely end its turns where they are.
                let ends = self.plan.limited && (v.upper - v.lower).is_finite();
                let ends = ends && self.variables[i].kind == JointKind::Continuous;
                let given = given.filter(|_| !ends);
                let about = given.map_or(v.middle, |start| v.reference(start[i], most));
                reference.set_lane(lane, about);
                if v.turns && !v.winds {
                    let x = self.q[i].lane(lane);
                    self.q[i].set_lane(lane, v.wound(x, about));
                }
            }
        }
        if WAY == SECOND {
            self.begin_second(lane, row);
        }
        if WAY == LAW {
            self.memory.reset(self.setup.feedback.as_ref(), lane);
        }
    }
}
