//! What a vector of gains costs on a set of training goals.

use super::Family;
use crate::batch;
use crate::chain::Chain;
use crate::error::{Error, Result};
use crate::solve::{Goals, Pace, Plan, Settings, StartRule, Starts, Status, Tolerance};
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
    /// On top for numbers that grew beyond all bounds.
    pub broken: f64,
}

impl Default for Cost {
    fn default() -> Self {
        Self { effort: 0.1, missed: 10.0, per_metre: 20.0, farthest: 1.0, broken: 40.0 }
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
    /// Tool points, m.
    pub goals: &'a [[f64; 3]],
    /// Where every attempt starts.
    pub start: StartRule,
    /// Steps of an attempt.
    pub max_iterations: u32,
    /// Distance at which a goal counts as reached, m.
    pub tolerance: f64,
    /// What is paid.
    pub cost: Cost,
}

impl Problem<'_> {
    /// Judges a vector; `poll` is asked whether to go on.
    pub fn score(
        &self,
        x: &[f64],
        threads: usize,
        poll: &mut dyn FnMut() -> bool,
    ) -> Result<Score> {
        if self.goals.is_empty() {
            return Err(Error::argument("goals", "at least one training goal", 0));
        }
        let settings = Settings {
            step: self.family.step(x),
            max_iterations: self.max_iterations,
            max_restarts: 0,
            max_step: 1.0,
            plain: true,
            start: self.start,
            pace: Pace::Full,
        };
        let tolerance = Tolerance { position: self.tolerance, ..Tolerance::default() };
        let goals = Goals::Positions { points: self.goals, direction: None };
        let plan = Plan::new(
            self.chain,
            Task::Position,
            settings,
            tolerance,
            goals,
            Starts::Free,
            None,
            0,
            0,
        )?;
        let answers = batch::solve(&plan, threads, poll)?;
        let pay = &self.cost;
        let (mut cost, mut solved, mut steps) = (0.0, 0, 0.0);
        for (row, status) in answers.status.iter().enumerate() {
            if *status == Status::Converged as u8 {
                let count = f64::from(answers.iterations[row]);
                cost += pay.effort * count / STEPS;
                solved += 1;
                steps += count;
                continue;
            }
            let error = answers.position_error[row];
            let left = if error < pay.farthest { error } else { pay.farthest };
            let effort = pay.effort * f64::from(self.max_iterations) / STEPS;
            cost += effort + pay.missed + pay.per_metre * left;
            if *status == Status::NonFinite as u8 {
                cost += pay.broken;
            }
        }
        let mean = if solved > 0 { steps / solved as f64 } else { f64::INFINITY };
        Ok(Score { cost: cost / self.goals.len() as f64, solved, steps: mean })
    }
}
