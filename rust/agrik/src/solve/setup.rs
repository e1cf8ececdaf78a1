//! What stays the same from call to call of a control loop: task, step, tolerance, tool.

use super::Settings;
use super::start::Ranking;
use super::step::{Feedback, StartRule, middle};
use crate::chain::{Chain, Reach, Tail};
use crate::error::{Error, Result};
use crate::task::{Task, rotation_scale};

/// How near is near enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Distance, m.
    pub position: f64,
    /// Angle, rad.
    pub orientation: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { position: 1e-6, orientation: 1e-6 }
    }
}

impl Tolerance {
    /// Refuses what no error can be below.
    pub(crate) fn check(&self) -> Result<()> {
        for (name, value) in
            [("position_tolerance", self.position), ("orientation_tolerance", self.orientation)]
        {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::argument(name, "a finite number above 0", value));
            }
        }
        Ok(())
    }
}

/// A task and how to do it, checked and worked out for a chain. Making one may cost more
/// than solving a target: gains of feedback laws come from a singular value decomposition.
#[derive(Debug, Clone)]
pub struct Setup {
    pub(super) task: Task,
    pub(super) settings: Settings,
    pub(super) tolerance: Tolerance,
    pub(super) tail: Tail,
    pub(super) rotation_scale: f64,
    /// The feedback law of the settings, if it is one.
    pub(super) feedback: Option<Feedback>,
    /// Where first attempts start if the caller gives no start and the solver has one.
    pub(super) usual_start: Option<Vec<f64>>,
    pub(super) ranking: Ranking,
    pub(super) tool_reach: Reach,
    /// Joint values of the chain that it was made for.
    pub(super) dof: usize,
}

impl Setup {
    /// A checked setup; `tail` is a tool in place of the chain's own.
    pub fn new(
        chain: &Chain,
        task: Task,
        settings: Settings,
        tolerance: Tolerance,
        tail: Option<Tail>,
    ) -> Result<Self> {
        let task = task.checked()?;
        settings.check()?;
        tolerance.check()?;
        let compiled = chain.compiled();
        let tool_reach = match &tail {
            Some(tail) => Reach::with_tail(compiled, chain.variables(), tail),
            None => *chain.reach(),
        };
        let tail = tail.unwrap_or(compiled.tail);
        let rotation_scale = rotation_scale(chain.reach().radius);
        let feedback = Feedback::new(&settings, chain, &task, &tail, rotation_scale)?;
        let usual_start = match settings.start {
            StartRule::Sampled => None,
            StartRule::Zero => Some(chain.near_zero()),
            StartRule::Middle => Some(middle(chain)),
        };
        let ranking = ranking(&task, &compiled.tail, &tail, rotation_scale);
        Ok(Self {
            task,
            settings,
            tolerance,
            tail,
            rotation_scale,
            feedback,
            usual_start,
            ranking,
            tool_reach,
            dof: chain.dof(),
        })
    }
}

/// By what starts are compared with a goal of the task, with the chain's own tool or another.
fn ranking(task: &Task, own: &Tail, tail: &Tail, rotation_scale: f64) -> Ranking {
    let squared = rotation_scale * rotation_scale;
    let (axes, direction) = match task {
        Task::Pose => (squared, ([0.0; 3], 0.0)),
        Task::Axis { tool_axis } => (0.0, (tail.direction(*tool_axis), squared)),
        // Rows that are free make the axes a poor guide; the tool point is one if it counts.
        Task::Position | Task::Masked { .. } => (0.0, ([0.0; 3], 0.0)),
    };
    let shift = [0, 1, 2].map(|k| tail.translation[k] - own.translation[k]);
    Ranking { placed: task.fixes_position(), shift, axes, direction }
}

#[cfg(test)]
mod tests {
    use nalgebra::IsometryMatrix3;

    use super::*;
    use crate::batch;
    use crate::chain::{DhConvention, DhRow, JointKind};
    use crate::solve::{Goals, Plan, Starts};

    fn arm(joints: usize) -> Chain {
        let joints = (0..joints).map(|i| {
            let row = DhRow { a: 0.3, alpha: 1.2, d: 0.1, theta: 0.0 };
            let (kind, end) = (JointKind::Revolute, 2.0);
            row.joint(DhConvention::Standard, format!("joint_{i}"), kind, -end, end)
        });
        let none = IsometryMatrix3::identity();
        Chain::new("arm", joints.collect(), none, none, None).expect("a chain")
    }

    #[test]
    fn a_setup_serves_many_calls_of_its_chain() {
        let chain = arm(4);
        let points = [[0.4, 0.3, 0.5], [0.1, -0.5, 0.6]];
        let goals = Goals::Positions { points: &points, direction: None };
        // The state space need not get there, but has to do the same each time.
        for (settings, solves) in
            [(Settings::LEVENBERG_MARQUARDT, true), (Settings::STATE_SPACE, false)]
        {
            let (task, tolerance) = (Task::Position, Tolerance::default());
            let setup = Setup::new(&chain, task, settings.clone(), tolerance, None).expect("valid");
            let whole =
                Plan::new(&chain, task, settings, tolerance, goals, Starts::Free, None, 3, 1)
                    .expect("valid");
            let wanted = batch::solve(&whole, 1, &mut || true).expect("not interrupted");
            assert!(!solves || wanted.success(0) && wanted.success(1), "{:?}", wanted.status);
            for _ in 0..2 {
                let call = Plan::with_setup(&chain, &setup, goals, Starts::Free, 3, 1);
                let call = call.expect("valid");
                assert_eq!(batch::solve(&call, 1, &mut || true).expect("not interrupted"), wanted);
            }
            let other = Plan::with_setup(&arm(5), &setup, goals, Starts::Free, 3, 1).map(|_| ());
            let said = other.expect_err("made for another chain").to_string();
            assert!(said.contains("setup") && said.contains('4') && said.contains('5'), "{said}");
        }
    }
}
