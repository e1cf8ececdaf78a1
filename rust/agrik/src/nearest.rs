//! Of all solutions of a target the one nearest to its start values.
//!
//! Arms whose branches are known are asked for all of them. Of arms with one joint to spare whose
//! branches are known at each value of the free quantity, that quantity is swept over its range,
//! and the postures that are nearer than their neighbours are moved to where they are nearest.
//! Others are solved from several starts, and each solution is moved likewise.

mod sweep;

use crate::call::{AnswersMut, Merit, Outcome, Request, Second, Solve, Starts, Status};
use crate::chain::Chain;
use crate::closed_form::{ArmAngle, Ask, can_sweep, every, reason};
use crate::error::{Error, Result};
use crate::kinematics::{Workspace, forward};
use crate::lanes::Level;
use crate::solve::{Plan, Settings};

/// Starts where the branches are not known, unless the caller says how many.
pub const STARTS: usize = 32;
/// Starts beside a sweep: near a singularity it may have nothing.
const BESIDE_SWEEP: usize = 8;
/// The nearest postures, which are moved twice.
const AGAIN: usize = 4;
/// Rows that a thread takes at a time.
const RUN: usize = 32;

/// What nearest answers are asked by.
#[derive(Debug, Clone)]
pub struct Nearness {
    second: Second,
    weights: Vec<f64>,
    starts: Option<usize>,
}

impl Nearness {
    /// Weights of the squared changes of the joints, 1 each without any, and the number of starts
    /// of arms with joints to spare: without one sweeps, and [`STARTS`] where there are none.
    pub fn new(chain: &Chain, weights: Option<Vec<f64>>, starts: Option<usize>) -> Result<Self> {
        if starts == Some(0) {
            return Err(Error::argument("nearest", "at least one start", 0));
        }
        let weights = weights.unwrap_or_else(|| vec![1.0; chain.dof()]);
        let second = Second::new(chain, Merit::Near, None, Some(weights.clone()))?;
        Ok(Self { second, weights, starts })
    }
}

/// A call, whose answers are replaced by nearer ones.
#[derive(Debug, Clone)]
pub struct Nearest<'a, C> {
    call: C,
    request: Request<'a>,
    nearness: &'a Nearness,
    plan: Plan<'a>,
    way: Way,
}

/// Where the postures to choose from come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// All branches.
    Branches,
    /// The branches at each value of the free quantity.
    Sweep,
    /// So many starts.
    Starts(usize),
}

impl<'a, C> Nearest<'a, C> {
    /// A call for a request with start values.
    pub fn new(request: Request<'a>, nearness: &'a Nearness, call: C) -> Result<Self> {
        if matches!(request.starts(), Starts::Free) {
            return Err(Error::argument("q0", "what the answers are to be nearest to", "none"));
        }
        let count = request.aim().weights().iter().filter(|w| **w != 0.0).count();
        let spare = request.chain().dof().saturating_sub(count);
        let way = match nearness.starts {
            _ if spare == 0 && reason(&request).is_none() => Way::Branches,
            Some(starts) => Way::Starts(starts),
            // What is not free of collisions has free neighbours that a sweep leaves out.
            None if spare == 1 && request.guard().is_none() && can_sweep(&request) => Way::Sweep,
            None => Way::Starts(STARTS),
        };
        let plan = Plan::new(request, Settings::default())?;
        Ok(Self { call, request, nearness, plan, way })
    }

    fn far(&self, q: &[f64], q0: &[f64]) -> f64 {
        let ways = q.iter().zip(q0).zip(&self.nearness.weights);
        ways.map(|((a, b), weight)| weight * (a - b) * (a - b)).sum()
    }

    /// Postures of each row of a run that reach its target, one after the other, and how many were
    /// moved on.
    fn postures(&self, level: Level, first: usize, count: usize) -> Result<Vec<(Vec<f64>, u32)>> {
        let dof = self.request.chain().dof();
        let ask = Ask { locks: &[], angle: ArmAngle::Free, sweep: None, wrap: false };
        let rows = first..first + count;
        match self.way {
            Way::Starts(starts) => {
                let of = |row| self.moved(level, row, &self.plan.starts(row, starts));
                Ok(rows.map(of).collect())
            }
            Way::Sweep => {
                let ask = Ask { sweep: Some(sweep::VALUES), ..ask };
                let found = every(&self.request.part(first, count), &ask, 1, &mut || true)?;
                let of = |row| {
                    let mut starts = self.least_of_sweep(&found, row - first, row);
                    starts.extend(self.plan.starts(row, BESIDE_SWEEP));
                    self.moved(level, row, &starts)
                };
                Ok(rows.map(of).collect())
            }
            Way::Branches => {
                let found = every(&self.request.part(first, count), &ask, 1, &mut || true)?;
                let of = |row: usize| {
                    let all = row * found.branches..(row + 1) * found.branches;
                    let valid = all.filter(|b| found.valid[*b]);
                    (valid.flat_map(|b| found.q[b * dof..(b + 1) * dof].to_vec()).collect(), 1)
                };
                Ok((0..count).map(of).collect())
            }
        }
    }

    /// What starts lead to, each moved to where it is nearest; the best of them once more, since
    /// the steps of a move are numbered.
    fn moved(&self, level: Level, row: usize, starts: &[f64]) -> (Vec<f64>, u32) {
        let dof = self.request.chain().dof();
        let Some(q0) = self.request.start(row) else { return (Vec::new(), 0) };
        let move_on = |starts: &[f64]| {
            let found = self.plan.moved(level, row, starts, &self.nearness.second);
            let q = found.q.chunks_exact(dof).enumerate();
            let reached: Vec<Vec<f64>> =
                q.filter(|(i, _)| found.success(*i)).map(|(_, q)| q.to_vec()).collect();
            reached
        };
        let mut reached = move_on(starts);
        reached.sort_by(|a, b| self.far(a, q0).total_cmp(&self.far(b, q0)));
        let best = reached[..reached.len().min(AGAIN)].concat();
        reached.extend(move_on(&best));
        (reached.concat(), (starts.len() / dof) as u32)
    }

    /// Puts the nearest posture of each row in place of its answer.
    fn choose(&self, level: Level, rows: &mut AnswersMut<'_>) -> Result<()> {
        let chain = self.request.chain();
        let mut workspace = Workspace::new(chain.compiled());
        let all = self.postures(level, rows.first, rows.len())?;
        for (i, (postures, tried)) in all.iter().enumerate() {
            let row = rows.first + i;
            let (Some(goal), Some(q0)) = (self.request.goal(row), self.request.start(row)) else {
                continue;
            };
            let mut best: Option<(f64, &[f64], (f64, f64))> = None;
            if rows.ended(i, Status::Converged) {
                best = Some((self.far(rows.q(i), q0), &[], (0.0, 0.0)));
            }
            for q in postures.chunks_exact(chain.dof()) {
                let way = self.far(q, q0);
                if best.is_some_and(|(least, _, _)| least <= way) || !chain.within_limits(q) {
                    continue;
                }
                forward(chain.compiled(), q, &mut workspace);
                let left = self.request.left(&workspace, &goal);
                let guard = self.request.guard();
                let free = guard.is_none_or(|guard| guard.accept.accepts(q) & 1 != 0);
                if self.request.aim().is_met(&left) && free {
                    best = Some((way, q, (left.position2.sqrt(), left.orientation2.sqrt())));
                }
            }
            let Some((_, q, (position_error, orientation_error))) = best else { continue };
            let before = rows.outcome(i);
            let restarts = before.restarts + tried.saturating_sub(1);
            if q.is_empty() {
                let same = rows.q(i).to_vec();
                rows.finish(i, Outcome { restarts, ..before }).copy_from_slice(&same);
                continue;
            }
            let outcome = Outcome {
                status: Status::Converged,
                position_error,
                orientation_error,
                iterations: before.iterations,
                restarts,
            };
            rows.finish(i, outcome).copy_from_slice(q);
        }
        Ok(())
    }
}

impl<C: Solve> Solve for Nearest<'_, C> {
    fn rows(&self) -> usize {
        self.call.rows()
    }
    fn dof(&self) -> usize {
        self.call.dof()
    }
    fn run_length(&self) -> usize {
        self.call.run_length().min(RUN)
    }
    fn run<'b>(
        &self,
        level: Level,
        next: &mut dyn FnMut() -> Option<AnswersMut<'b>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        while let Some(mut rows) = next() {
            let mut all = Some(rows.reborrow());
            if !self.call.run(level, &mut || all.take(), keep_going) || !keep_going() {
                return false;
            }
            // Rows of which the branches cannot be had keep the answers that they have.
            let _ = self.choose(level, &mut rows);
        }
        true
    }
}
