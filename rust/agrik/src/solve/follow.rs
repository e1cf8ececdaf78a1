//! A path of targets, one after the other: every posture continues the one before.

use super::Settings;
use super::plan::Plan;
use super::start::range;
use crate::allowed::is_measure;
use crate::call::{Answers, INSIDE, Outcome, Request, Solve, Status};
use crate::chain::JointKind;
use crate::error::{Error, Result};
use crate::kinematics::{Workspace, forward};
use crate::lanes::Level;
use crate::random::Stream;
use crate::task::Goal;

/// The steps of one attempt to continue.
const CONTINUE: Settings =
    Settings { max_iterations: 30, max_restarts: 0, ..Settings::LEVENBERG_MARQUARDT };
/// The steps of the search for a new beginning.
const BEGIN: Settings = Settings { max_restarts: 20, ..Settings::LEVENBERG_MARQUARDT };
/// Starts that are tried side by side where the plain continuation fails.
const OTHERS: usize = 16;

/// A plan whose targets are to be followed in order.
#[derive(Debug, Clone)]
pub struct Follow<'a> {
    plan: Plan<'a>,
    q0: Option<&'a [f64]>,
    max_joint_step: Vec<f64>,
    pull: f64,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// One answer a target. Where a target was not reached the arm stays where it was.
    pub answers: Answers,
    /// True where a posture is no continuation of the one before: it lies farther away than
    /// a joint step, or there is none.
    pub jumps: Vec<bool>,
}

impl<'a> Follow<'a> {
    /// A checked path through the targets of a request, whose starts are of no account.
    ///
    /// `q0` is where the arm stands before the first target (without it, the first posture
    /// is free); `max_joint_step` (rad or m, one number a joint) bounds the change of each
    /// joint from one target to the next; `pull` (0 to 1) is the share of the way back to
    /// the posture before that each step goes inside the null space of the task.
    pub fn new(
        request: Request<'a>,
        q0: Option<&'a [f64]>,
        max_joint_step: Vec<f64>,
        pull: f64,
    ) -> Result<Self> {
        let (chain, dof) = (request.chain(), request.chain().dof());
        if max_joint_step.len() != dof {
            let got = max_joint_step.len();
            return Err(Error::argument("max_joint_step", format!("{dof} numbers"), got));
        }
        if let Some(bad) = max_joint_step.iter().find(|x| !(x.is_finite() && **x > 0.0)) {
            return Err(Error::argument("max_joint_step", "finite numbers above 0", bad));
        }
        if !(0.0..=1.0).contains(&pull) {
            return Err(Error::argument("pull", "a number, 0 to 1", pull));
        }
        if let Some(q0) = q0
            && (q0.len() != dof || q0.iter().any(|x| !is_measure(*x)) || !chain.within_limits(q0))
        {
            let expected = format!("{dof} finite numbers within the limits");
            return Err(Error::argument("q0", expected, format!("{q0:?}")));
        }
        let plan = Plan::new(request, CONTINUE)?;
        Ok(Self { plan, q0, max_joint_step, pull })
    }

    /// Follows the path; `poll` is asked at every target whether to go on.
    pub fn run(&self, level: Level, poll: &mut dyn FnMut() -> bool) -> Result<Path> {
        let (plan, dof) = (&self.plan, self.plan.request.chain().dof());
        let mut walker = Walker {
            follow: self,
            level,
            at: self.q0.map(<[f64]>::to_vec),
            workspace: Workspace::new(plan.request.chain().compiled()),
        };
        let mut answers = Answers::new(plan.request.len(), dof);
        let mut jumps = vec![false; plan.request.len()];
        let mut rows = answers.as_mut();
        for (row, jump) in jumps.iter_mut().enumerate() {
            if !poll() {
                return Err(Error::Interrupted);
            }
            let (outcome, jumped) = walker.advance(row);
            *jump = jumped;
            let q = rows.finish(row, outcome);
            match &walker.at {
                Some(at) => q.copy_from_slice(at),
                None => {
                    for (x, v) in q.iter_mut().zip(plan.request.chain().variables()) {
                        *x = v.near_zero();
                    }
                }
            }
        }
        Ok(Path { answers, jumps })
    }
}

/// The arm on its way.
struct Walker<'f> {
    follow: &'f Follow<'f>,
    level: Level,
    at: Option<Vec<f64>>,
    workspace: Workspace<f64>,
}

impl Walker<'_> {
    /// Goes to a target: the answer, and whether it is no continuation.
    fn advance(&mut self, row: usize) -> (Outcome, bool) {
        let plan = &self.follow.plan;
        let mut outcome = Outcome::unanswered(Status::BadInput);
        let Some(goal) = plan.request.goal(row) else { return (outcome, true) };
        let mut stream = Stream::new(plan.sampler.key(row, 0));
        let mut found = None;
        if let Some(at) = self.at.clone() {
            let bounds = self.bounds(&at);
            found = self.attempt(row, &goal, &at, Some(&bounds), CONTINUE, &at, &mut outcome);
            if found.is_none() {
                outcome.restarts += 1;
                let mut starts = Vec::new();
                for _ in 0..OTHERS {
                    starts.extend(bounds.iter().map(|(a, b)| a + (b - a) * stream.uniform()));
                }
                found =
                    self.attempt(row, &goal, &starts, Some(&bounds), CONTINUE, &at, &mut outcome);
            }
        }
        let mut jumped = false;
        if found.is_none() {
            let middle: Vec<f64> = match &self.at {
                Some(at) => at.clone(),
                None => plan.request.chain().near_zero(),
            };
            let mut starts = middle.clone();
            for _ in 1..OTHERS {
                for (v, x) in plan.request.chain().variables().iter().zip(&middle) {
                    let (low, high) = match v.kind {
                        JointKind::Continuous => {
                            (x - std::f64::consts::PI, x + std::f64::consts::PI)
                        }
                        _ if (v.upper - v.lower).is_infinite() => {
                            let (lower, width) = range(plan.request.chain(), v);
                            (lower, lower + width)
                        }
                        _ => (v.lower, v.upper),
                    };
                    starts.push(low + (high - low) * stream.uniform());
                }
            }
            found = self.attempt(row, &goal, &starts, None, BEGIN, &middle, &mut outcome);
            jumped = match (&self.at, &found) {
                (Some(at), Some(q)) => !self.is_step(at, q),
                (None, Some(_)) => false,
                (_, None) => true,
            };
        }
        match found {
            Some(q) => {
                outcome.status = Status::Converged;
                self.at = Some(q);
            }
            None if plan.proven_unreachable(&goal) => outcome.status = Status::OutOfReach,
            None => outcome.status = Status::NotFound,
        }
        if let Some(at) = &self.at {
            forward(plan.request.chain().compiled(), at, &mut self.workspace);
            let left = plan.request.left(&self.workspace, &goal);
            outcome.position_error = left.position2.sqrt();
            outcome.orientation_error = left.orientation2.sqrt();
        }
        (outcome, jumped)
    }

    /// The joints' ranges one step around a posture, within the limits.
    fn bounds(&self, at: &[f64]) -> Vec<(f64, f64)> {
        let variables = self.follow.plan.request.chain().variables().iter();
        variables
            .zip(at)
            .zip(&self.follow.max_joint_step)
            // A little less, so that rounding does not make a step too long.
            .map(|((v, x), step)| (x, step * INSIDE, v))
            .map(|(x, step, v)| ((x - step).max(v.lower), (x + step).min(v.upper)))
            .collect()
    }

    fn is_step(&self, from: &[f64], to: &[f64]) -> bool {
        let steps = from.iter().zip(to).zip(&self.follow.max_joint_step);
        steps.into_iter().all(|((a, b), step)| (a - b).abs() <= *step)
    }

    /// The reached posture nearest to `near`, from one or several starts.
    #[allow(clippy::too_many_arguments)]
    fn attempt(
        &mut self,
        row: usize,
        goal: &Goal<f64>,
        starts: &[f64],
        bounds: Option<&[(f64, f64)]>,
        settings: Settings,
        near: &[f64],
        outcome: &mut Outcome,
    ) -> Option<Vec<f64>> {
        let plan = &self.follow.plan;
        let dof = plan.request.chain().dof();
        let count = starts.len() / dof;
        let target = plan.request.copies(row, count);
        let mut copies = plan.with(&target, starts, settings);
        copies.bounds = bounds.map(<[_]>::to_vec);
        // A free search goes where it gets; only its choice is for what is near.
        copies.pull =
            bounds.filter(|_| self.follow.pull > 0.0).map(|_| (self.follow.pull, near.to_vec()));
        let mut answers = Answers::new(count, dof);
        let mut all = Some(answers.as_mut());
        copies.run(self.level, &mut || all.take(), &mut || true);
        outcome.iterations += answers.iterations.iter().sum::<u32>();
        let mut best: Option<(f64, &[f64])> = None;
        for q in answers.q.chunks_exact(dof) {
            let way2: f64 = q.iter().zip(near).map(|(a, b)| (a - b) * (a - b)).sum();
            let nearer = best.is_none_or(|(least, _)| way2 < least);
            let inside = plan.request.chain().within_limits(q)
                && (bounds.is_none() || self.is_step(near, q));
            if nearer && inside {
                forward(plan.request.chain().compiled(), q, &mut self.workspace);
                if plan.request.aim().is_met(&plan.request.left(&self.workspace, goal)) {
                    best = Some((way2, q));
                }
            }
        }
        best.map(|(_, q)| q.to_vec())
    }
}
