//! What stays the same from call to call of a control loop: the aim and the step.

use super::Settings;
use super::plan::Plan;
use super::start::Ranking;
use super::step::{Feedback, StartRule, middle};
use crate::call::{Aim, Goals, Request, Starts};
use crate::chain::{Chain, Reach, Tail};
use crate::error::{Error, Result};
use crate::task::{Task, rotation_scale};

/// An aim and how to get there, checked and worked out for a chain. Making one may cost more
/// than solving a target: gains of feedback laws come from a singular value decomposition.
#[derive(Debug, Clone)]
pub struct Setup {
    pub(super) aim: Aim,
    pub(super) settings: Settings,
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
    /// A checked setup.
    pub fn new(chain: &Chain, aim: Aim, settings: Settings) -> Result<Self> {
        settings.check()?;
        let (task, tail) = (aim.task(), *aim.tail());
        let compiled = chain.compiled();
        let tool_reach = if tail == compiled.tail {
            *chain.reach()
        } else {
            Reach::with_tail(compiled, chain.variables(), &tail)
        };
        let rotation_scale = rotation_scale(chain.reach().radius);
        let feedback = Feedback::new(&settings, chain, &task, &tail, rotation_scale)?;
        let usual_start = match settings.start {
            StartRule::Sampled => None,
            StartRule::Zero => Some(chain.near_zero()),
            StartRule::Middle => Some(middle(chain)),
        };
        let ranking = ranking(&task, &compiled.tail, &tail, rotation_scale);
        Ok(Self {
            aim,
            settings,
            rotation_scale,
            feedback,
            usual_start,
            ranking,
            tool_reach,
            dof: chain.dof(),
        })
    }

    /// A call for targets of the chain that the setup was made for; allocates nothing.
    pub fn plan<'a>(
        &'a self,
        chain: &'a Chain,
        goals: Goals<'a>,
        starts: Starts<'a>,
        seed: u64,
        first_index: u64,
    ) -> Result<Plan<'a>> {
        if self.dof != chain.dof() {
            let expected = format!("one of {} joint values", chain.dof());
            return Err(Error::argument("setup", expected, self.dof));
        }
        let request = Request::new(chain, self.aim, goals, starts)?.with_seed(seed, first_index);
        Ok(Plan::with_setup(request, self))
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
    use crate::call::{Tolerance, solve};
    use crate::chain::{DhConvention, DhRow, JointKind};

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
            let aim = Aim::new(&chain, Task::Position, Tolerance::default(), None).expect("valid");
            let setup = Setup::new(&chain, aim, settings.clone()).expect("valid");
            let request = Request::new(&chain, aim, goals, Starts::Free).expect("valid");
            let whole = Plan::new(request.with_seed(3, 1), settings).expect("valid");
            let wanted = solve(&whole, 1, &mut || true).expect("not interrupted");
            assert!(!solves || wanted.success(0) && wanted.success(1), "{:?}", wanted.status);
            for _ in 0..2 {
                let call = setup.plan(&chain, goals, Starts::Free, 3, 1).expect("valid");
                assert_eq!(solve(&call, 1, &mut || true).expect("not interrupted"), wanted);
            }
            let other = arm(5);
            let other = setup.plan(&other, goals, Starts::Free, 3, 1).map(|_| ());
            let said = other.expect_err("made for another chain").to_string();
            assert!(said.contains("setup") && said.contains('4') && said.contains('5'), "{said}");
        }
    }
}
