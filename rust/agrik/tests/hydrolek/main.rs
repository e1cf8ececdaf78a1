//! Feedback solvers on the arms of their paper: traces, success counts and statuses of
//! the specification.

mod arms;
#[path = "../common/mod.rs"]
mod common;
mod counts;
mod singular;
mod traces;
mod tuning;

use agrik::batch;
use agrik::chain::Chain;
use agrik::solve::{Answers, Goals, Plan, Settings, Starts, Tolerance};
use agrik::task::Task;

/// Solves positions, m.
fn solve(chain: &Chain, goals: &[[f64; 3]], settings: Settings, tolerance: f64) -> Answers {
    let tolerance = Tolerance { position: tolerance, ..Tolerance::default() };
    let goals = Goals::Positions { points: goals, direction: None };
    let plan =
        Plan::new(chain, Task::Position, settings, tolerance, goals, Starts::Free, None, 0, 0)
            .expect("a plan");
    batch::solve(&plan, 0, &mut || true).expect("answers")
}
