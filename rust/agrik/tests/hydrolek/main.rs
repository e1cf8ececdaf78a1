//! Feedback solvers on the arms of their paper: traces, success counts and statuses of
//! the specification.

mod arms;
#[path = "../common/mod.rs"]
mod common;
mod counts;
mod singular;
mod traces;
mod tuning;

use agrik::call::{Answers, Goals, Starts, Tolerance};
use agrik::chain::Chain;
use agrik::solve::{Plan, Settings};
use agrik::task::Task;

/// Solves positions, m.
fn solve(chain: &Chain, goals: &[[f64; 3]], settings: Settings, tolerance: f64) -> Answers {
    let tolerance = Tolerance { position: tolerance, ..Tolerance::default() };
    let goals = Goals::Positions { points: goals, direction: None };
    let request = common::arms::request(chain, Task::Position, tolerance, goals, Starts::Free);
    let plan = Plan::new(request, settings).expect("settings in range");
    agrik::call::solve(&plan, 0, &mut || true).expect("answers")
}
