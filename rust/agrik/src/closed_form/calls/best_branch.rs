//! The best branch of every target, as a call of [`crate::call::solve`].

use super::accepted_branch;
use super::arm_angle::ArmAngle;
use super::last_resort;
use super::one_pose::{Alone, Left};
use super::query::{FEW, Query, RUN, Target};
use crate::call::{Aim, AnswersMut, Outcome, Solve, Status};
use crate::closed_form::arm_angle::search;
use crate::closed_form::branch::check::least_outside;
use crate::closed_form::branch::group::{Group, Job};
use crate::closed_form::branch::polish::Polished;
use crate::closed_form::branch::unreachable::is_out_of_reach;
use crate::closed_form::families::{ClosedForm, Srs};
use crate::closed_form::geometry::candidate::{JOINTS, MOST_BRANCHES};
use crate::lanes::{Kernel, Level, Real, dispatch, dispatch_single};
use crate::task::Goal;

impl Solve for Query<'_> {
    fn rows(&self) -> usize {
        self.request.len()
    }
    fn dof(&self) -> usize {
        self.chain().dof()
    }
    fn run_length(&self) -> usize {
        RUN
    }
    /// The best branch of every target.
    fn run<'a>(
        &self,
        level: Level,
        next: &mut dyn FnMut() -> Option<AnswersMut<'a>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        while let Some(mut rows) = next() {
            // One call may hand out all of its rows at once.
            let mut done = 0;
            while done < rows.len() {
                let end = rows.len().min(done + RUN);
                let (query, rows) = (self, &mut rows);
                match self.free() {
                    None if end - done <= FEW => {
                        dispatch(level, OneByOne { query, rows, begin: done, end });
                    }
                    Some(_) if end - done <= FEW => {
                        dispatch_single(level, InLanes { query, rows, begin: done, end });
                    }
                    _ => dispatch(level, InLanes { query, rows, begin: done, end }),
                }
                if let Some(guard) = self.request.guard() {
                    accepted_branch::guarded(self, guard, level, rows, done..end);
                }
                let (request, aim) = (&self.request, self.request.aim());
                if aim.tolerance().axes.is_some() {
                    // Branches are found by whole errors; what is told is of the axes that count.
                    rows.tell_anew(done, end, |row, q| {
                        let left = aim.left(&self.job().at(q), &request.goal(row)?);
                        Some((left.position2.sqrt(), left.orientation2.sqrt()))
                    });
                }
                done = end;
                if !keep_going() {
                    return false;
                }
            }
        }
        true
    }
}

impl<'a> Query<'a> {
    /// The arm, where its arm angle is free and the best one wanted.
    pub(super) fn free(&self) -> Option<&'a Srs> {
        match (self.form, self.angle) {
            (ClosedForm::Srs(arm), ArmAngle::Free) => Some(arm),
            _ => None,
        }
    }
}

/// Rows `begin..end` of a run, each with its branches in the lanes.
struct OneByOne<'k, 'a> {
    query: &'k Query<'k>,
    rows: &'k mut AnswersMut<'a>,
    begin: usize,
    end: usize,
}

impl Kernel for OneByOne<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let (query, rows) = (self.query, self.rows);
        let job = query.job();
        for i in self.begin..self.end {
            let target = query.alone::<R>(&job, rows.first + i);
            alone_best(query, &job, target, rows, i);
        }
    }
}

/// Writes the best branch of one target, which is `None` where it is no pose.
#[inline(always)]
fn alone_best<R: Real>(
    query: &Query<'_>,
    job: &Job<'_>,
    target: Option<Target<R>>,
    rows: &mut AnswersMut<'_>,
    i: usize,
) {
    let (choice, aim) = (query.choice, query.request.aim());
    let Some(mut target) = target else {
        job.stand_in(rows.finish(i, Outcome::unanswered(Status::BadInput)));
        return;
    };
    target.near.judged_by(choice, job.geometry);
    let mut found = Alone::new(job);
    let mut left = Left::new();
    found.solve(job, &target, true, Some((&mut left, choice)));
    if let Some(b) = found.best(&left) {
        let outcome = reached(left.position2[b], left.chord2[b]);
        rows.finish(i, outcome).copy_from_slice(found.branch(b));
    } else {
        let branches = (0..found.branches()).map(|b| found.branch(b));
        nearest((job, aim), &target.goal, branches, found.status(), rows, i);
    }
}

/// Rows `begin..end` of a run, one in each lane.
struct InLanes<'k, 'a> {
    query: &'k Query<'k>,
    rows: &'k mut AnswersMut<'a>,
    begin: usize,
    end: usize,
}

impl Kernel for InLanes<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let (query, rows) = (self.query, self.rows);
        let mut group = Group::<R>::new(query.job());
        let free = query.free();
        let mut i = self.begin;
        while i < self.end {
            let (used, bad) = query.load(&mut group, rows.first + i, rows.first + self.end);
            let mut left = used;
            if let Some(arm) = free {
                let found = search::search(arm, &mut group, query.choice, query.proof, used & !bad);
                if found.known != 0 {
                    group.solve_one(arm, &found.line, &found.elbow, found.sides);
                    let mut done = found.known & group.valid(0);
                    left &= !done;
                    while done != 0 {
                        let lane = done.trailing_zeros() as usize;
                        done &= done - 1;
                        answer(&group, lane, 0, rows, i + lane);
                    }
                }
            }
            if left == 0 {
                i += R::WIDTH;
                continue;
            }
            group.solve();
            let mut valid = [0; MOST_BRANCHES];
            for (b, lanes) in valid.iter_mut().enumerate() {
                *lanes = group.valid(b);
            }
            let best = group.pick(query.choice, &valid);
            for lane in 0..R::WIDTH {
                if left >> lane & 1 == 0 {
                    continue;
                }
                let row = i + lane;
                if bad >> lane & 1 != 0 {
                    group.job.stand_in(rows.finish(row, Outcome::unanswered(Status::BadInput)));
                } else if best.found >> lane & 1 != 0 {
                    answer(&group, lane, best.branch.lane(lane) as usize, rows, row);
                } else {
                    none(query, &group, lane, rows, row);
                }
            }
            i += R::WIDTH;
        }
    }
}

/// The outcome of a branch from the squares of what is left.
#[inline(always)]
fn reached(position2: f64, chord2: f64) -> Outcome {
    Outcome {
        position_error: position2.sqrt(),
        orientation_error: 2.0 * (0.125 * chord2).sqrt().min(1.0).asin(),
        ..Outcome::unanswered(Status::Converged)
    }
}

/// Writes the chosen branch of a lane.
#[inline(always)]
fn answer<R: Real>(
    group: &Group<'_, R>,
    lane: usize,
    b: usize,
    rows: &mut AnswersMut<'_>,
    i: usize,
) {
    let outcome = reached(group.position2[b].lane(lane), group.chord2[b].lane(lane));
    let q = rows.finish(i, outcome);
    for (x, variable) in group.candidates[b].q.iter().zip(group.job.variables()) {
        q[*variable] = x.lane(lane);
    }
}

/// Writes a lane without any valid branch, after a last search; of a free arm angle at all.
#[inline(never)]
fn none<R: Real>(
    query: &Query<'_>,
    group: &Group<'_, R>,
    lane: usize,
    rows: &mut AnswersMut<'_>,
    i: usize,
) {
    let (free, aim) = (query.free(), query.request.aim());
    let (job, goal) = (&group.job, group.goal.of_lane(lane));
    let branches = group.candidates.map(|candidate| candidate.q.map(|x| x.lane(lane)));
    let centre = group.near.centre.map(|x| x.lane(lane));
    // Mostly there is a proof, and it costs less than the search.
    let none = is_out_of_reach(job, &goal, free.is_some());
    let posture = match free {
        _ if none => None,
        Some(arm) => last_resort::found_at_any_angle(arm, &mut group.one_lane(lane)),
        None => last_resort::found(job, &goal, &centre, &branches).map(|found| found.1),
    };
    if let Some(Polished { q, position2, chord2, .. }) = posture {
        let answer = rows.finish(i, reached(position2, chord2));
        for (x, variable) in q.iter().zip(job.variables()) {
            answer[*variable] = *x;
        }
        return;
    }
    let status = if none { Status::OutOfReach } else { Status::NotFound };
    let mut ordered = [[0.0; JOINTS]; MOST_BRANCHES];
    for (to, q) in ordered.iter_mut().zip(&branches) {
        for (x, variable) in q.iter().zip(job.variables()) {
            to[*variable] = *x;
        }
    }
    let joints = job.variables().len();
    nearest((job, aim), &goal, ordered.iter().map(|q| &q[..joints]), status, rows, i);
}

/// Writes, in place of an answer, the branch that violates the limits least, held inside
/// them.
fn nearest<'q>(
    (job, aim): (&Job<'_>, &Aim),
    goal: &Goal<f64>,
    branches: impl Iterator<Item = &'q [f64]>,
    status: Status,
    rows: &mut AnswersMut<'_>,
    i: usize,
) {
    let mut best = (f64::INFINITY, [0.0; JOINTS]);
    for branch in branches {
        let mut q = [0.0; JOINTS];
        for (x, variable) in q.iter_mut().zip(job.variables()) {
            *x = branch[*variable];
        }
        least_outside(job.limits(), &mut q);
        let outside = q.iter().zip(job.limits());
        let outside = outside.map(|(x, limit)| (limit.lower - x).max(x - limit.upper).max(0.0));
        let total: f64 = outside.sum();
        if total < best.0 {
            best.0 = total;
            for ((x, limit), variable) in q.iter().zip(job.limits()).zip(job.variables()) {
                best.1[*variable] = x.clamp(limit.lower, limit.upper);
            }
        }
    }
    let q = &best.1[..job.variables().len()];
    let left = aim.left(&job.at(q), goal);
    // With wide tolerances a posture held at its limits may be near enough.
    let outcome = Outcome {
        position_error: left.position2.sqrt(),
        orientation_error: left.orientation2.sqrt(),
        ..Outcome::unanswered(if aim.is_met(&left) { Status::Converged } else { status })
    };
    rows.finish(i, outcome).copy_from_slice(q);
}
