//! Ends of attempts that the call's guard is asked about, several at a time.
//!
//! Of a question about eight postures each costs less than half of what it costs alone. So a
//! target whose attempt has reached it waits aside until there are enough of them, and its lane
//! works on another one. What becomes of a target depends on its own attempts alone: all answers
//! are what they would be if each were asked about at once.

use super::Engine;
use super::attempts::Best;
use super::runs::Runs;
use crate::call::{Guard, Prefer, Status, TOGETHER};
use crate::kinematics::{PerJoint, Workspace, forward};
use crate::lanes::Real;
use crate::task::{Rows, TaskError};

/// Attempts after the first whose end may be the answer, where the best of several is wanted.
const LOOKS: u32 = 7;
/// Refused ends from which on no more are looked for.
const MOST_REFUSED: usize = 64;

/// The targets beside those that lanes work on, by their places among the engine's jobs.
#[derive(Debug)]
pub(super) struct Aside {
    /// So many wait at most.
    most: usize,
    /// Places without a target.
    free: Vec<usize>,
    /// Targets that get another attempt.
    ready: Vec<usize>,
    /// Targets whose ends wait for an answer.
    waiting: Vec<usize>,
    /// Their joint values, one after the other, and the squares of what is left, m^2 and rad^2.
    q: Vec<f64>,
    errors: Vec<(f64, f64)>,
}

impl Aside {
    /// Behind so many lanes, for a call of so many targets.
    pub fn new(lanes: usize, rows: usize) -> Self {
        let most = rows.clamp(1, TOGETHER);
        // A target steps aside before its lane takes one of those here.
        let free = (lanes..=lanes + most).collect();
        let (ready, waiting) = (Vec::new(), Vec::with_capacity(most));
        Self { most, free, ready, waiting, q: Vec::new(), errors: Vec::with_capacity(most) }
    }

    /// How many places there are.
    pub fn places(&self) -> usize {
        self.most + 1
    }
}

impl<R: Real, T: Rows<R, M>, const M: usize, const WAY: u8> Engine<'_, R, T, M, WAY> {
    /// Puts a lane's target, which is reached, aside; true where enough of them wait.
    #[inline(never)]
    pub(super) fn step_aside(&mut self, lane: usize, error: &TaskError<R, M>) -> bool {
        let Some(aside) = &mut self.aside else { return false };
        let Some(place) = aside.free.pop() else { return false };
        aside.waiting.push(place);
        aside.q.extend(self.q.iter().map(|x| x.lane(lane)));
        aside.errors.push((error.position2.lane(lane), error.orientation2.lane(lane)));
        self.jobs.swap(lane, place);
        aside.waiting.len() >= aside.most
    }

    /// Some targets aside wait for an answer, or for a lane.
    #[inline(always)]
    pub(super) fn some_wait(&self) -> bool {
        let waits = |aside: &Aside| !aside.waiting.is_empty() || !aside.ready.is_empty();
        self.aside.as_deref().is_some_and(waits)
    }

    /// Gives an idle lane a target from aside that gets another attempt, if there is one.
    #[inline(always)]
    pub(super) fn take_back(&mut self, lane: usize) -> bool {
        let Some(aside) = &mut self.aside else { return false };
        let Some(place) = aside.ready.pop() else { return false };
        aside.free.push(place);
        self.jobs.swap(lane, place);
        self.goal.set_lane(lane, &self.jobs[lane].goal);
        true
    }

    /// The same for all lanes that are not busy, a bit each; returns those that have one now, at
    /// the start of its attempt.
    #[inline(never)]
    pub(super) fn take_back_all(&mut self, busy: u32) -> u32 {
        let mut started = 0;
        for lane in 0..R::WIDTH {
            if busy >> lane & 1 == 0 && self.take_back(lane) {
                self.start_next(lane);
                started |= 1 << lane;
            }
        }
        started
    }

    /// Asks about all that wait, and ends or goes on with each.
    #[inline(never)]
    pub(super) fn ask(&mut self, runs: &mut Runs<'_>) {
        let Some(guard) = self.plan.request.guard() else { return };
        let Some(mut aside) = self.aside.take_if(|aside| !aside.waiting.is_empty()) else { return };
        let dof = self.q.len();
        let accepted = guard.accept.accepts(&aside.q);
        for (i, place) in aside.waiting.drain(..).enumerate() {
            let q = &aside.q[i * dof..(i + 1) * dof];
            let is_accepted = accepted >> i & 1 != 0;
            let solved = self.judge(place, guard, q, aside.errors[i], is_accepted);
            if self.goes_on(place, Status::Converged, solved, runs) {
                aside.ready.push(place);
            } else {
                aside.free.push(place);
            }
        }
        aside.q.clear();
        aside.errors.clear();
        self.aside = Some(aside);
    }

    /// Keeps an end that reached the goal of the job in a place where it is the best so far; true
    /// where no other needs to be looked for.
    #[inline(never)]
    pub(super) fn judge(
        &mut self,
        place: usize,
        guard: Guard<'_>,
        q: &[f64],
        (position2, orientation2): (f64, f64),
        is_accepted: bool,
    ) -> bool {
        let start = self.plan.start(self.jobs[place].row);
        let job = &mut self.jobs[place];
        let about = |i: usize| start.map_or(self.variables[i].middle(), |start| start[i]);
        let score = is_accepted.then(|| guard.score(q, 0.0, about));
        let better = match (score, job.accepted) {
            (Some(score), before) => before.is_none_or(|before| score > before.0),
            // The first of those refused stands in for all of them.
            (None, before) => before.is_none() && job.refused.is_empty(),
        };
        if score.is_none() {
            job.refused.extend_from_slice(q);
        }
        if better {
            job.best = Some(Best {
                // Nothing that does not reach the goal is better.
                squared: f64::NEG_INFINITY,
                status: if is_accepted { Status::Converged } else { Status::InCollision },
                position_error: position2.sqrt(),
                orientation_error: orientation2.sqrt(),
            });
            job.best_q = PerJoint::from_slice(q);
        }
        if let Some(score) = score {
            let (best, first) = job.accepted.unwrap_or((score, job.attempt));
            job.accepted = Some((best.max(score), first));
        }
        let looks = if guard.prefer == Prefer::First { 0 } else { LOOKS };
        match job.accepted {
            Some((_, first)) => job.attempt >= first + looks,
            None => job.refused.len() >= MOST_REFUSED * self.q.len(),
        }
    }

    /// Makes the least bad of the ends that the guard refused the answer of the job in a place.
    #[inline(never)]
    pub(super) fn choose_refused(&mut self, place: usize) {
        let request = &self.plan.request;
        let job = &mut self.jobs[place];
        let (Some(guard), Some(goal)) = (request.guard(), request.goal(job.row)) else { return };
        let dof = job.best_q.len();
        let chosen = guard.best_margin(job.refused.chunks_exact(dof));
        job.best_q.copy_from_slice(&job.refused[chosen * dof..(chosen + 1) * dof]);
        let mut at = Workspace::new(request.chain().compiled());
        forward(request.chain().compiled(), &job.best_q, &mut at);
        let left = request.left(&at, &goal);
        if let Some(best) = &mut job.best {
            best.position_error = left.position2.sqrt();
            best.orientation_error = left.orientation2.sqrt();
        }
    }
}
