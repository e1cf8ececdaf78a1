//! A path of targets, one after the other: every posture continues the one before.

mod front;

use super::Settings;
use super::limit::wound;
use super::pieces::between;
use super::plan::Plan;
use super::start::range;
use super::tracker::{bounds_around, check_steps, is_step, ticks};
use crate::allowed::is_measure;
use crate::call::{Answers, Copies, Outcome, Request, Solve, Status};
use crate::chain::{Chain, JointKind};
use crate::error::{Error, Result};
use crate::kinematics::{Workspace, forward};
use crate::lanes::Level;
use crate::random::Stream;

/// The steps of one attempt to continue.
const CONTINUE: Settings =
    Settings { max_iterations: 30, max_restarts: 0, ..Settings::LEVENBERG_MARQUARDT };
/// The steps of the search for a new beginning.
const BEGIN: Settings = Settings { max_restarts: 20, ..Settings::LEVENBERG_MARQUARDT };
/// One attempt from a start.
const ONE: Settings = Settings { max_restarts: 0, ..Settings::LEVENBERG_MARQUARDT };
/// Starts that are tried side by side where the plain continuation fails, and for the postures
/// that a path can begin from.
const OTHERS: usize = 16;
const STARTS: usize = 96;
/// No more postures of a target than this are looked at.
const MOST_POSTURES: usize = 32;
/// Steps into which the way to a target is cut at most to see whether it goes on.
const MOST_PIECES: usize = 512;
/// Start values that are outside of their limits by no more are put onto them, rad or m.
const HAIR: f64 = 1e-3;

/// A plan whose targets are to be followed in order.
#[derive(Debug, Clone)]
pub struct Follow<'a> {
    plan: Plan<'a>,
    q0: Option<Vec<f64>>,
    max_joint_step: Vec<f64>,
    pull: f64,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// One answer a target. Where a target was not reached the arm stays where it was.
    pub answers: Answers,
    /// True where a posture is no continuation of the one before, or there is none.
    pub jumps: Vec<bool>,
    /// The largest share of its step that a joint takes to a posture from the one before; above 1
    /// where a path that goes on is too fast by that factor. 0 in the first row.
    pub speeds: Vec<f64>,
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
        check_steps("max_joint_step", &max_joint_step, dof)?;
        if !(0.0..=1.0).contains(&pull) {
            return Err(Error::argument("pull", "a number, 0 to 1", pull));
        }
        let q0 = q0.map(|q0| inside(chain, q0)).transpose()?;
        let plan = Plan::new(request, CONTINUE)?;
        Ok(Self { plan, q0, max_joint_step, pull })
    }

    /// Follows the path; `poll` is asked at every target whether to go on.
    pub fn run(&self, level: Level, poll: &mut dyn FnMut() -> bool) -> Result<Path> {
        let (request, dof) = (&self.plan.request, self.plan.request.chain().dof());
        let count = request.len();
        let rows = Vec::with_capacity(count);
        let mut walker = Walker { follow: self, level, rows, piece: 0, poll, stopped: false };
        // A way round a dead end goes on to targets behind it.
        while walker.rows.len() < count {
            walker.stopped = walker.stopped || !(walker.poll)();
            if walker.stopped {
                return Err(Error::Interrupted);
            }
            walker.advance(walker.rows.len());
        }
        if walker.stopped {
            return Err(Error::Interrupted);
        }
        let mut answers = Answers::new(count, dof);
        let mut rows = answers.as_mut();
        let mut workspace = Workspace::new(request.chain().compiled());
        let mut speeds = vec![0.0; count];
        for (i, row) in walker.rows.iter().enumerate() {
            let mut outcome = row.outcome;
            if outcome.status != Status::BadInput
                && let Some(goal) = request.goal(i)
            {
                forward(request.chain().compiled(), &row.q, &mut workspace);
                let left = request.left(&workspace, &goal);
                outcome.position_error = left.position2.sqrt();
                outcome.orientation_error = left.orientation2.sqrt();
            }
            rows.finish(i, outcome).copy_from_slice(&row.q);
            if i > 0 {
                speeds[i] = ticks(&walker.rows[i - 1].q, &row.q, &self.max_joint_step);
            }
        }
        let jumps = walker.rows.iter().map(|row| row.jump).collect();
        Ok(Path { answers, jumps, speeds })
    }
}

/// Start values within the limits; those outside by a hair are put onto them.
fn inside(chain: &Chain, q0: &[f64]) -> Result<Vec<f64>> {
    let dof = chain.dof();
    if q0.len() != dof || q0.iter().any(|x| !is_measure(*x)) {
        return Err(Error::argument("q0", format!("{dof} finite numbers"), format!("{q0:?}")));
    }
    let held = |(x, v): (&f64, &crate::chain::Variable)| {
        let there = x.max(v.lower).min(v.upper);
        if (x - there).abs() <= HAIR {
            return Ok(there);
        }
        let (name, lower, upper) = (&v.name, v.lower, v.upper);
        let expected = format!("joint '{name}' within its limits, {lower} to {upper}");
        Err(Error::argument("q0", expected, x))
    };
    q0.iter().zip(chain.variables()).map(held).collect()
}

/// Where the arm is at a target.
struct Row {
    q: Vec<f64>,
    outcome: Outcome,
    jump: bool,
}

/// Bounds of the joint values, and the posture that steps are drawn to by a share of the way.
type Inside<'a> = (&'a [(f64, f64)], Option<(f64, &'a [f64])>);

/// The arm on its way.
struct Walker<'f> {
    follow: &'f Follow<'f>,
    level: Level,
    rows: Vec<Row>,
    /// Row of the first posture from which on every one continues the one before.
    piece: usize,
    /// Asked whether to go on, and whether it said no.
    poll: &'f mut dyn FnMut() -> bool,
    stopped: bool,
}

impl Walker<'_> {
    /// Goes to a target.
    fn advance(&mut self, row: usize) {
        let (plan, chain) = (&self.follow.plan, self.follow.plan.request.chain());
        let before = self.rows.last().map(|row| row.q.clone());
        let stays = before.clone().or_else(|| self.follow.q0.clone());
        let stays = stays.unwrap_or_else(|| chain.near_zero());
        let mut outcome = Outcome::unanswered(Status::BadInput);
        let Some(goal) = plan.request.goal(row) else {
            self.rows.push(Row { q: stays, outcome, jump: true });
            self.piece = row + 1;
            return;
        };
        let reached = self.rows.last().is_some_and(|r| r.outcome.status == Status::Converged);
        let mut jump = false;
        let mut found = match &before {
            None => self.begin(row, &mut outcome),
            Some(at) => self.continued(row, at, &mut outcome),
        };
        if found.is_none() && reached {
            if self.go_round(row, &mut outcome) {
                return;
            }
            found = self.in_pieces(row, &stays, &mut outcome);
        }
        if found.is_none() && before.is_some() {
            found = self.anywhere(row, &stays, &mut outcome);
            jump = found.as_ref().is_none_or(|q| !is_step(&stays, q, &self.follow.max_joint_step));
        }
        outcome.status = match &found {
            Some(_) => Status::Converged,
            None if plan.proven_unreachable(&goal) => Status::OutOfReach,
            None => Status::NotFound,
        };
        jump |= found.is_none();
        self.piece = if found.is_none() {
            row + 1
        } else if jump {
            row
        } else {
            self.piece
        };
        self.rows.push(Row { q: found.unwrap_or(stays), outcome, jump });
    }

    /// The first posture: the nearest one to the start values.
    fn begin(&self, row: usize, outcome: &mut Outcome) -> Option<Vec<f64>> {
        let plan = &self.follow.plan;
        let Some(q0) = &self.follow.q0 else {
            return self.anywhere(row, &plan.request.chain().near_zero(), outcome);
        };
        let starts = self.starts(row, q0, STARTS);
        let found = self.attempts(row, &starts, None, q0, ONE, outcome);
        found.into_iter().next().or_else(|| self.anywhere(row, q0, outcome))
    }

    /// A posture for a target from one before, no farther away than a step.
    fn continued(&self, row: usize, at: &[f64], outcome: &mut Outcome) -> Option<Vec<f64>> {
        let chain = self.follow.plan.request.chain();
        let bounds = bounds_around(chain, at, &self.follow.max_joint_step);
        let inside = Some((&bounds[..], Some((self.follow.pull, at))));
        let first = self.attempts(row, at, inside, at, CONTINUE, outcome);
        if let Some(q) = first.into_iter().next() {
            return Some(q);
        }
        outcome.restarts += 1;
        let mut stream = Stream::new(self.follow.plan.sampler.key(row, 0));
        let mut starts = Vec::new();
        for _ in 0..OTHERS {
            starts.extend(bounds.iter().map(|(a, b)| a + (b - a) * stream.uniform()));
        }
        self.attempts(row, &starts, inside, at, CONTINUE, outcome).into_iter().next()
    }

    /// The posture for a target at the end of a way that goes on, but faster than the joints may:
    /// the way from the target before, cut into pieces.
    fn in_pieces(&self, row: usize, at: &[f64], outcome: &mut Outcome) -> Option<Vec<f64>> {
        let plan = &self.follow.plan;
        let free = self.attempts(row, at, None, at, ONE, outcome).into_iter().next()?;
        let steps = ticks(at, &free, &self.follow.max_joint_step);
        if steps >= 0.5 * MOST_PIECES as f64 {
            return None;
        }
        let count = (1.5 * steps).ceil() as usize + 2;
        let mut q = at.to_vec();
        for piece in 1..=count {
            let share = piece as f64 / count as f64;
            let target = between(&plan.request, row - 1, row, share);
            let bounds = bounds_around(plan.request.chain(), &q, &self.follow.max_joint_step);
            let inside = Some((&bounds[..], Some((self.follow.pull, &q[..]))));
            let found = self.attempts_at(&target, &q, inside, &q, CONTINUE, outcome);
            q = found.into_iter().next()?;
        }
        Some(q)
    }

    /// The posture nearest to one, of those that a search of the whole range finds.
    fn anywhere(&self, row: usize, near: &[f64], outcome: &mut Outcome) -> Option<Vec<f64>> {
        let starts = self.starts(row, near, OTHERS);
        self.attempts(row, &starts, None, near, BEGIN, outcome).into_iter().next()
    }

    /// Starts for a target: a posture, and others from the whole range about it.
    fn starts(&self, row: usize, near: &[f64], count: usize) -> Vec<f64> {
        use std::f64::consts::PI;
        let chain = self.follow.plan.request.chain();
        let mut stream = Stream::new(self.follow.plan.sampler.key(row, 1));
        let mut starts = near.to_vec();
        for _ in 1..count {
            for (v, x) in chain.variables().iter().zip(near) {
                let (low, high) = match v.kind {
                    JointKind::Continuous => (x - PI, x + PI),
                    _ if (v.upper - v.lower).is_infinite() => {
                        let (lower, width) = range(chain, v);
                        (lower, lower + width)
                    }
                    _ => (v.lower, v.upper),
                };
                starts.push(low + (high - low) * stream.uniform());
            }
        }
        starts
    }

    fn attempts(
        &self,
        row: usize,
        starts: &[f64],
        inside: Option<Inside<'_>>,
        near: &[f64],
        settings: Settings,
        outcome: &mut Outcome,
    ) -> Vec<Vec<f64>> {
        let request = &self.follow.plan.request;
        let target = request.copies(row, starts.len() / request.chain().dof());
        self.attempts_at(&target, starts, inside, near, settings, outcome)
    }

    /// The postures that several starts lead to, those nearest to `near` first; within bounds
    /// with a pull to a posture.
    fn attempts_at(
        &self,
        target: &Copies,
        starts: &[f64],
        inside: Option<Inside<'_>>,
        near: &[f64],
        settings: Settings,
        outcome: &mut Outcome,
    ) -> Vec<Vec<f64>> {
        let plan = &self.follow.plan;
        let chain = plan.request.chain();
        let dof = chain.dof();
        let count = starts.len() / dof;
        let mut copies = plan.with(target, starts, settings);
        let bounds = inside.map(|(bounds, _)| bounds);
        copies.bounds = bounds.map(<[_]>::to_vec);
        // A free search goes where it gets; only its order is for what is near.
        let drawn = inside.and_then(|(_, drawn)| drawn).filter(|(pull, _)| *pull > 0.0);
        copies.pull = drawn.map(|(pull, toward)| (pull, toward.to_vec()));
        let mut answers = Answers::new(count, dof);
        let mut all = Some(answers.as_mut());
        copies.run(self.level, &mut || all.take(), &mut || true);
        outcome.iterations += answers.iterations.iter().sum::<u32>();
        let allowed = |q: &[f64]| {
            chain.within_limits(q)
                && bounds.is_none_or(|bounds| {
                    q.iter().zip(bounds).all(|(x, (low, high))| low <= x && x <= high)
                })
        };
        let mut found: Vec<Vec<f64>> = Vec::new();
        for (i, q) in answers.q.chunks_exact(dof).enumerate() {
            if answers.success(i) && allowed(q) {
                let variables = chain.variables().iter();
                let turned = |((x, v), near): ((&f64, _), &f64)| match bounds {
                    None => wound(v, *x, *near),
                    Some(_) => *x,
                };
                found.push(q.iter().zip(variables).zip(near).map(turned).collect());
            }
        }
        let away = |q: &[f64]| ticks(near, q, &self.follow.max_joint_step);
        found.sort_by(|a, b| away(a).total_cmp(&away(b)));
        found
    }
}
