//! After a target is reached: more distance from what must not be hit, with the freedom that a
//! redundant arm has left.
//!
//! Each step goes along the part of the margin's slope that leaves the tool where it is, as
//! far as the way is sure to be free, and back to the target by the default step solver.

use nalgebra::{DMatrix, DVector};

use super::plan::Plan;
use super::step::Settings;
use crate::call::{Answers, AnswersMut, Guard, Measure, Outcome, Request, Solve, Status};
use crate::chain::JointKind;
use crate::error::Result;
use crate::kinematics::{Workspace, columns, forward};
use crate::lanes::Level;
use crate::task::{Goal, Rows};

/// Most steps for one target, and halvings of one step.
const STEPS: u32 = 30;
const HALVINGS: u32 = 6;
/// Longest change of a joint in one step, rad, or m by the size of the robot.
const LONGEST: f64 = 0.3;
/// Shares of the size of the robot: a margin that is enough, and a gain that is none.
const ENOUGH: f64 = 0.1;
const NOTHING: f64 = 1e-5;
/// Damping of the projection, by the size of the rows.
const DAMPING: f64 = 1e-10;
/// The way back to the target: one attempt, with some patience.
const BACK: Settings =
    Settings { max_iterations: 20, max_restarts: 0, ..Settings::LEVENBERG_MARQUARDT };

/// A call whose answers are moved away from what they must not hit.
#[derive(Debug, Clone)]
pub struct Climb<'a, C> {
    call: C,
    guard: Guard<'a>,
    plan: Plan<'a>,
}

impl<'a, C> Climb<'a, C> {
    /// A call for a request with a guard.
    pub fn new(request: Request<'a>, guard: Guard<'a>, call: C) -> Result<Self> {
        Ok(Self { call, guard, plan: Plan::new(request, BACK)? })
    }

    /// Moves the answer in row `i` of a run.
    fn climb(&self, level: Level, rows: &mut AnswersMut<'_>, i: usize) {
        let (plan, accept) = (&self.plan, self.guard.accept);
        let chain = plan.request.chain();
        let Some(goal) = plan.request.goal(rows.first + i) else { return };
        let copy = plan.request.copies(rows.first + i, 1);
        let size = chain.reach().size;
        let mut q = rows.q(i).to_vec();
        let mut rates = vec![0.0; q.len()];
        let mut margin = accept.slope(&q, &mut rates);
        let mut best = None;
        for _ in 0..STEPS {
            if margin >= ENOUGH * size {
                break;
            }
            let Some(way) = self.free_way(&q, &rates, &goal, ENOUGH * size - margin) else { break };
            let mut share = 1.0;
            let mut next = None;
            for _ in 0..HALVINGS {
                let to = q.iter().zip(&way).zip(chain.variables());
                let to: Vec<f64> =
                    to.map(|((x, d), v)| (x + share * d).max(v.lower).min(v.upper)).collect();
                let change: Vec<f64> = to.iter().zip(&q).map(|(to, from)| to - from).collect();
                share *= 0.5;
                if !accept.is_way_sure(&q, &change) {
                    continue;
                }
                let mut answers = Answers::new(1, q.len());
                let mut all = Some(answers.as_mut());
                plan.with(&copy, &to, BACK).run(level, &mut || all.take(), &mut || true);
                if answers.success(0) && accept.accepts(&answers.q) & 1 != 0 {
                    let found = accept.slope(&answers.q, &mut rates);
                    if found > margin + NOTHING * size {
                        next = Some((found, answers));
                        break;
                    }
                }
            }
            let Some((found, answers)) = next else { break };
            margin = found;
            q.copy_from_slice(&answers.q);
            best = Some(answers);
        }
        if let Some(answers) = best {
            let outcome = Outcome {
                position_error: answers.position_error[0],
                orientation_error: answers.orientation_error[0],
                ..rows.outcome(i)
            };
            rows.finish(i, outcome).copy_from_slice(&answers.q);
        }
    }

    /// The part of a slope that leaves the tool where it is, as long as it takes to gain
    /// `wanted`, but no longer than a step; none where the arm has no such freedom.
    fn free_way(
        &self,
        q: &[f64],
        rates: &[f64],
        goal: &Goal<f64>,
        wanted: f64,
    ) -> Option<Vec<f64>> {
        let (chain, size) = (self.plan.request.chain(), self.plan.setup().rotation_scale);
        // Turns in lengths, so that slides stand beside them.
        let length = |i: usize| match chain.variables()[i].kind {
            JointKind::Prismatic => 1.0,
            _ => size,
        };
        let rows = self.jacobian(q, goal);
        let mut held = vec![false; q.len()];
        // Joints that would go beyond a limit are held; those left go another way then.
        for _ in 0..=q.len() {
            let factor = |i: usize| if held[i] { 0.0 } else { 1.0 / length(i) };
            let a = DMatrix::from_fn(rows.nrows(), q.len(), |r, i| rows[(r, i)] * factor(i));
            let slope = DVector::from_fn(q.len(), |i, _| rates[i] * factor(i));
            let mut square = &a * a.transpose();
            let damping = DAMPING * (square.trace() + f64::MIN_POSITIVE);
            for r in 0..square.nrows() {
                square[(r, r)] += damping;
            }
            let multipliers = square.cholesky()?.solve(&(&a * &slope));
            let free = &slope - a.transpose() * multipliers;
            let steep = free.norm_squared();
            if steep <= 1e-6 * slope.norm_squared() || steep <= 1e-12 {
                return None;
            }
            let way: Vec<f64> =
                (0..q.len()).map(|i| free[i] * factor(i) * wanted / steep).collect();
            let outward = |i: usize| {
                let v = &chain.variables()[i];
                q[i] <= v.lower && way[i] < 0.0 || q[i] >= v.upper && way[i] > 0.0
            };
            let out: Vec<usize> = (0..q.len()).filter(|i| !held[*i] && outward(*i)).collect();
            if out.is_empty() {
                let share = |i: usize| way[i].abs() * length(i) / (LONGEST * size);
                let longest = (0..q.len()).map(share).fold(1.0, f64::max);
                return Some(way.into_iter().map(|d| d / longest).collect());
            }
            out.into_iter().for_each(|i| held[i] = true);
        }
        None
    }

    /// How the rows of the task change with each joint value.
    fn jacobian(&self, q: &[f64], goal: &Goal<f64>) -> DMatrix<f64> {
        let setup = self.plan.setup();
        match setup.aim.measure(setup.rotation_scale) {
            Measure::Position(rows) => self.columns::<_, 3>(rows, q, goal),
            Measure::Pose(rows) => self.columns::<_, 6>(rows, q, goal),
            Measure::Axis(rows) => self.columns::<_, 5>(rows, q, goal),
            Measure::Framed(rows) => self.columns::<_, 6>(rows, q, goal),
        }
    }

    fn columns<T: Rows<f64, M>, const M: usize>(
        &self,
        rows: T,
        q: &[f64],
        goal: &Goal<f64>,
    ) -> DMatrix<f64> {
        let chain = self.plan.request.chain().compiled();
        let mut workspace = Workspace::new(chain);
        forward(chain, q, &mut workspace);
        let tool = workspace.tool_point(self.plan.setup().aim.tail().translation);
        let seen = rows.look(&workspace, tool, goal);
        let mut matrix = DMatrix::zeros(M, q.len());
        columns(chain, &workspace, tool, |variable, linear, angular| {
            let column = rows.column(&seen, goal, linear, angular);
            for (r, x) in column.into_iter().enumerate() {
                matrix[(r, variable)] += x;
            }
        });
        matrix
    }
}

impl<C: Solve> Solve for Climb<'_, C> {
    fn rows(&self) -> usize {
        self.call.rows()
    }
    fn dof(&self) -> usize {
        self.call.dof()
    }
    fn run_length(&self) -> usize {
        self.call.run_length().min(64)
    }
    fn run<'b>(
        &self,
        level: Level,
        next: &mut dyn FnMut() -> Option<AnswersMut<'b>>,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> bool {
        while let Some(mut rows) = next() {
            let mut all = Some(rows.reborrow());
            if !self.call.run(level, &mut || all.take(), keep_going) {
                return false;
            }
            for i in 0..rows.len() {
                if rows.ended(i, Status::Converged) {
                    self.climb(level, &mut rows, i);
                    if !keep_going() {
                        return false;
                    }
                }
            }
        }
        true
    }
}
