//! Which target a lane works on, and from where: attempts begin and end here.

use smallvec::smallvec;

use super::feedback::Halt;
use super::runs::{Place, Runs};
use super::{Engine, wound};
use crate::call::{AnswersMut, Outcome, Status};
use crate::chain::{JointKind, Variable};
use crate::kinematics::PerJoint;
use crate::lanes::Real;
use crate::solve::step::squared_norm;
use crate::task::{Goal, Rows, TaskError};

/// What a lane is busy with.
#[derive(Debug, Clone)]
pub(super) struct Job {
    /// Where its answer goes; `None` for an idle lane.
    place: Option<Place>,
    /// Row in the whole call, and its goal.
    row: usize,
    goal: Goal<f64>,
    attempt: u32,
    /// Steps of this attempt, and of all before it.
    pub steps: u32,
    steps_before: u32,
    /// Proven out of reach: one attempt, for the nearest posture.
    unreachable: bool,
    /// The best end of an attempt so far.
    best: Option<Best>,
    best_q: PerJoint<f64>,
}

#[derive(Debug, Clone, Copy)]
struct Best {
    squared: f64,
    /// What the attempt ended with, where it is not told from all others.
    status: Status,
    position_error: f64,
    orientation_error: f64,
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
        }
    }
}

impl<R: Real, T: Rows<R, M>, const M: usize, const FEEDBACK: bool> Engine<'_, R, T, M, FEEDBACK> {
    /// How a lane's attempt ended.
    #[inline(always)]
    pub(super) fn status(&self, lane: usize, solved: bool, halt: Halt) -> Status {
        let plain = FEEDBACK || self.setup.settings.plain;
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
        let settings = &self.setup.settings;
        let solved = status == Status::Converged;
        let job = &mut self.jobs[lane];
        let squared = squared_norm(&error.rows).lane(lane);
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
        if !solved && !job.unreachable && job.attempt < settings.max_restarts {
            job.attempt += 1;
            job.steps_before += job.steps;
            job.steps = 0;
            let (row, attempt, goal) = (job.row, job.attempt, job.goal);
            self.start(lane, row, attempt, &goal);
            return true;
        }
        let best = job.best.unwrap_or_else(|| {
            job.best_q.iter_mut().zip(self.variables).for_each(|(x, v)| *x = v.near_zero());
            Best {
                squared: f64::INFINITY,
                status,
                position_error: f64::INFINITY,
                orientation_error: f64::INFINITY,
            }
        });
        let status = if !solved && job.unreachable { Status::OutOfReach } else { best.status };
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
            let Some(goal) = self.plan.request.goal(row) else {
                let outcome = Outcome::unanswered(Status::BadInput);
                runs.finish(place, outcome, self.variables.iter().map(Variable::near_zero));
                continue;
            };
            self.goal.set_lane(lane, &goal);
            let job = &mut self.jobs[lane];
            job.place = Some(place);
            job.row = row;
            job.goal = goal;
            job.attempt = 0;
            job.steps = 0;
            job.steps_before = 0;
            job.unreachable = self.plan.proven_unreachable(&goal);
            job.best = None;
            self.start(lane, row, 0, &goal);
            return true;
        }
    }

    /// Puts a lane at the start of an attempt.
    #[inline(always)]
    fn start(&mut self, lane: usize, row: usize, attempt: u32, goal: &Goal<f64>) {
        let given = self.plan.start(row);
        let begin: &[f64] = match given {
            Some(start) if attempt == 0 => start,
            _ => {
                self.plan.sampler.sample(row, attempt, goal, &mut self.begin);
                &self.begin
            }
        };
        for ((q, x), v) in self.q.iter_mut().zip(begin).zip(&self.limits) {
            q.set_lane(lane, x.max(v.lower).min(v.upper));
        }
        if self.has_continuous {
            for (i, v) in self.variables.iter().enumerate() {
                let reference = given.map_or(0.0, |start| start[i]);
                self.reference[i].set_lane(lane, reference);
                // What was sampled lies about zero.
                if v.kind == JointKind::Continuous {
                    let begin = R::Single::splat(self.q[i].lane(lane));
                    let near = wound(begin, R::Single::splat(reference));
                    self.q[i].set_lane(lane, near.lane(0));
                }
            }
        }
        if FEEDBACK {
            self.memory.reset(self.setup.feedback.as_ref(), lane);
        }
    }
}
