//! What the benches share: two arms, reachable targets, calls of the solver.
#![allow(dead_code, reason = "each bench uses a part")]

pub mod arms;
pub mod counted;

use agrik::chain::Chain;
use agrik::lanes::{Kernel, Level, Real};
use agrik::solve::{Goals, Plan, Settings, Starts, Tolerance};
use agrik::task::Task;

/// The instruction sets of this machine, lowest first.
pub fn levels() -> Vec<Level> {
    Level::ALL.into_iter().filter(|level| level.is_available()).collect()
}

/// How many lanes a level has.
pub struct Width;

impl Kernel for Width {
    type Output = usize;
    #[inline(always)]
    fn run<R: Real>(self) -> usize {
        R::WIDTH
    }
}

/// A call for full poses with the default solver and tolerance, starts chosen by seed 0.
pub fn pose_plan<'a>(chain: &'a Chain, poses: &'a [[f64; 16]]) -> Plan<'a> {
    plan(chain, Task::Pose, Goals::Poses(poses))
}

/// The same for any task.
pub fn plan<'a>(chain: &'a Chain, task: Task, goals: Goals<'a>) -> Plan<'a> {
    let settings = Settings::default();
    Plan::new(chain, task, settings, Tolerance::default(), goals, Starts::Free, None, 0, 0)
        .expect("the arguments of a bench are in range")
}
