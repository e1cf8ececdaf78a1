//! What the benches share: two arms, reachable targets, calls of the solver.
#![allow(dead_code, reason = "each bench uses a part")]

#[path = "../../tests/common/arms.rs"]
pub mod arms;
pub mod counted;

use agrik::call::{Goals, Request, Starts, Tolerance};
use agrik::chain::Chain;
use agrik::lanes::{Kernel, Level, Real};
use agrik::solve::{Plan, Settings};
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

/// A request for full poses with the default tolerance, starts chosen by seed 0.
pub fn pose_request<'a>(chain: &'a Chain, poses: &'a [[f64; 16]]) -> Request<'a> {
    let tolerance = Tolerance::default();
    arms::request(chain, Task::Pose, tolerance, Goals::Poses(poses), Starts::Free)
}

/// The same with the default solver.
pub fn pose_plan<'a>(chain: &'a Chain, poses: &'a [[f64; 16]]) -> Plan<'a> {
    Plan::new(pose_request(chain, poses), Settings::default())
        .expect("the arguments of a bench are in range")
}
