//! What a vector of gains costs on a set of training goals.

use std::f64::consts::PI;

use super::Family;
use crate::call::{Aim, Goals, Request, Starts, Status, Tolerance, solve};
use crate::chain::Chain;
use crate::error::{Error, Result};
use crate::solve::{Pace, Plan, Settings, StartRule};
use crate::task::Task;

/// Steps that count as one unit of effort.
const STEPS: f64 = 100.0;

/// What is paid per training goal; a cost is the mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Per hundred steps.
    pub effort: f64,
    /// For a goal that is missed.
    pub missed: f64,
    /// On top per metre of error left, up to `farthest`.
    pub per_metre: f64,
    /// Errors beyond count as this, m.
    pub farthest: f64,
    /// On top per radian of orientation error left, where the goals are poses.
    pub per_radian: f64,
    /// On top for numbers that grew beyond all bounds; on top of any cost where the states
    /// of a state space do not die out.
    pub broken: f64,
}

impl Default for Cost {
    fn default() -> Self {
        Self {
            effort: 0.1,
            missed: 10.0,
            per_metre: 20.0,
            farthest: 1.0,
            per_radian: 5.0,
            broken: 40.0,
        }
    }
}

/// How a vector did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Mean cost per goal.
    pub cost: f64,
    /// Goals reached.
    pub solved: usize,
    /// Mean steps over the goals reached.
    pub steps: f64,
}

/// Training goals and how they are to be reached.
#[derive(Debug, Clone)]
pub struct Problem<'a> {
    /// The arm.
    pub chain: &'a Chain,
    /// Which gains are free.
    pub family: &'a Family,
    /// Tool points (m) or poses.
    pub goals: Goals<'a>,
    /// Where every attempt starts.
    pub start: StartRule,
    /// Steps of an attempt.
    pub max_iterations: u32,
    /// Errors at which a goal counts as reached.
    pub tolerance: Tolerance,
    /// What is paid.
    pub cost: Cost,
}

/// Goals judged first, as a share: an answer whose cost on them is too high already is
/// judged no further.
const FIRST: usize = 8;

/// What a run over some goals adds up to.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    cost: f64,
    solved: usize,
    steps: f64,
}

impl Problem<'_> {
    /// Judges a vector on all goals.
    pub fn score(
        &self,
        x: &[f64],
        threads: usize,
        poll: &mut dyn FnMut() -> bool,
    ) -> Result<Score> {
        self.check()?;
        let mut sums = Sums::default();
        for cost in self.costs(x, self.goals, &mut sums, threads, poll)? {
            sums.cost += cost;
        }
        let steps = if sums.solved > 0 { sums.steps / sums.solved as f64 } else { f64::INFINITY };
        Ok(Score { cost: sums.cost / self.goals.len() as f64, solved: sums.solved, steps })
    }

    /// The mean cost of a vector, or some number from `bound` on as soon as it is certain
    /// that the cost is not below `bound`.
    pub fn cost_below(
        &self,
        x: &[f64],
        bound: f64,
        threads: usize,
        poll: &mut dyn FnMut() -> bool,
    ) -> Result<f64> {
        self.check()?;
        let count = self.goals.len() as f64;
        let (first, rest) = split(self.goals, self.goals.len() / FIRST);
        let mut sums = Sums::default();
        for goals in [first, rest].into_iter().filter(|goals| !goals.is_empty()) {
            for cost in self.costs(x, goals, &mut sums, threads, poll)? {
                sums.cost += cost;
            }
            if sums.cost / count >= bound {
                break;
            }
        }
        Ok(sums.cost / count)
    }

    /// The numbers of the goals, those that cost a vector most before the others: where most
    /// of the cost is, a poor vector shows soon.
    pub fn hardest_first(
        &self,
        x: &[f64],
        threads: usize,
        poll: &mut dyn FnMut() -> bool,
    ) -> Result<Vec<usize>> {
        self.check()?;
        let costs = self.costs(x, self.goals, &mut Sums::default(), threads, poll)?;
        let mut order: Vec<usize> = (0..self.goals.len()).collect();
        order.sort_by(|a, b| costs[*b].total_cmp(&costs[*a]));
        Ok(order)
    }

    fn check(&self) -> Result<()> {
        if self.goals.is_empty() {
            return Err(Error::argument("goals", "at least one training goal", 0));
        }
        Ok(())
    }

    /// What is paid for each of some goals; counts those reached, and their steps.
    fn costs(
        &self,
        x: &[f64],
        goals: Goals<'_>,
        sums: &mut Sums,
        threads: usize,
        poll: &mut dyn FnMut() -> bool,
    ) -> Result<Vec<f64>> {
        let settings = Settings {
            step: self.family.step(x),
            max_iterations: self.max_iterations,
            max_restarts: 0,
            max_step: 1.0,
            plain: true,
            start: self.start,
            pace: Pace::Full,
        };
        let task = match goals {
            Goals::Positions { .. } => Task::Position,
            Goals::Poses(_) => Task::Pose,
        };
        let turned = matches!(goals, Goals::Poses(_));
        let aim = Aim::new(self.chain, task, self.tolerance, None)?;
        let request = Request::new(self.chain, aim, goals, Starts::Free)?;
        let answers = solve(&Plan::new(request, settings)?, threads, poll)?;
        let pay = &self.cost;
        let unstable = if self.family.is_stable(x) { 0.0 } else { pay.broken };
        let cost = |(row, status): (usize, &u8)| {
            if *status == Status::Converged as u8 {
                let count = f64::from(answers.iterations[row]);
                sums.solved += 1;
                sums.steps += count;
                return pay.effort * count / STEPS + unstable;
            }
            let error = answers.position_error[row];
            let left = if error < pay.farthest { error } else { pay.farthest };
            let angle = if turned { answers.orientation_error[row].min(PI) } else { 0.0 };
            let effort = pay.effort * f64::from(self.max_iterations) / STEPS;
            let broken = if *status == Status::NonFinite as u8 { pay.broken } else { 0.0 };
            let distance = pay.per_metre * left + pay.per_radian * angle;
            effort + pay.missed + distance + broken + unstable
        };
        Ok(answers.status.iter().enumerate().map(cost).collect())
    }
}

/// The goals before a place, and those from it on.
fn split(goals: Goals<'_>, at: usize) -> (Goals<'_>, Goals<'_>) {
    match goals {
        Goals::Positions { points, direction } => {
            let (first, rest) = points.split_at(at);
            let some = |points| Goals::Positions { points, direction };
            (some(first), some(rest))
        }
        Goals::Poses(poses) => {
            let (first, rest) = poses.split_at(at);
            (Goals::Poses(first), Goals::Poses(rest))
        }
    }
}
