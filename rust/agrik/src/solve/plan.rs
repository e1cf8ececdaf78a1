//! A call: the targets, and the setup that they share.

use std::borrow::Cow;

use super::Settings;
use super::setup::{Setup, Tolerance};
use super::start::Sampler;
use super::targets::{Copies, Goals, Starts};
use crate::chain::{Chain, Tail};
use crate::error::{Error, Result};
use crate::kinematics::Workspace;
use crate::task::{
    AxisRows, Goal, MaskedRows, PoseRows, PositionRows, Rows, Task, axis_goal, pose_goal,
    pose_parts, unit,
};

/// Share of the tolerance that solvers themselves allow, so that rounding in a later check
/// cannot turn a reached target into a missed one.
pub(super) const INSIDE: f64 = 1.0 - 1e-6;

/// Targets and the setup that they share.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    pub(super) chain: &'a Chain,
    setup: Cow<'a, Setup>,
    pub(super) goals: Goals<'a>,
    pub(super) starts: Starts<'a>,
    pub(super) sampler: Sampler<'a>,
    /// Limits inside those of the chain that hold for this call, rad or m.
    pub(super) bounds: Option<Vec<(f64, f64)>>,
    /// A second aim: share of the way to a posture that each step tries to go.
    pub(super) pull: Option<(f64, Vec<f64>)>,
}

impl<'a> Plan<'a> {
    /// A checked call with a setup of its own. `seed` and the index of a target (its row
    /// plus `first_index`) alone decide its random starts.
    #[allow(clippy::too_many_arguments)]
    pub fn new(
        chain: &'a Chain,
        task: Task,
        settings: Settings,
        tolerance: Tolerance,
        goals: Goals<'a>,
        starts: Starts<'a>,
        tail: Option<Tail>,
        seed: u64,
        first_index: u64,
    ) -> Result<Self> {
        let setup = Setup::new(chain, task, settings, tolerance, tail)?;
        Self::checked(chain, Cow::Owned(setup), goals, starts, seed, first_index)
    }

    /// [`Plan::new`] with a setup that was made before, for the same chain; allocates nothing.
    pub fn with_setup(
        chain: &'a Chain,
        setup: &'a Setup,
        goals: Goals<'a>,
        starts: Starts<'a>,
        seed: u64,
        first_index: u64,
    ) -> Result<Self> {
        Self::checked(chain, Cow::Borrowed(setup), goals, starts, seed, first_index)
    }

    fn checked(
        chain: &'a Chain,
        setup: Cow<'a, Setup>,
        goals: Goals<'a>,
        starts: Starts<'a>,
        seed: u64,
        first_index: u64,
    ) -> Result<Self> {
        let dof = chain.dof();
        if setup.dof != dof {
            return Err(Error::argument("setup", format!("one of {dof} joint values"), setup.dof));
        }
        let (given, wanted) = match starts {
            Starts::Free => (0, 0),
            Starts::One(q) => (q.len(), dof),
            Starts::Each(q) => (q.len(), dof * goals.len()),
        };
        if given != wanted {
            return Err(Error::argument("q0", format!("{wanted} numbers"), given));
        }
        match (setup.task, goals) {
            (Task::Position, _) | (_, Goals::Poses(_)) => {}
            (Task::Axis { .. }, Goals::Positions { direction: Some(_), .. }) => {}
            (Task::Axis { .. }, _) => {
                return Err(Error::argument(
                    "direction",
                    "a direction for the tool axis, since the targets are points",
                    "none",
                ));
            }
            _ => return Err(Error::argument("targets", "poses (4x4 matrices)", "points")),
        }
        let sampler = Sampler::new(chain, setup.ranking, seed, first_index);
        Ok(Self { chain, setup, goals, starts, sampler, bounds: None, pull: None })
    }

    /// What the targets share.
    pub(super) fn setup(&self) -> &Setup {
        &self.setup
    }
    /// How many targets.
    pub fn len(&self) -> usize {
        self.goals.len()
    }
    /// No target at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// The chain.
    pub fn chain(&self) -> &'a Chain {
        self.chain
    }
    /// What counts as reached.
    pub fn task(&self) -> Task {
        self.setup.task
    }
    /// How near is near enough.
    pub fn tolerance(&self) -> Tolerance {
        self.setup.tolerance
    }
    /// Where the first attempt of each target starts.
    pub fn starts(&self) -> Starts<'a> {
        self.starts
    }
    /// The tool in the last joint's frame.
    pub fn tail(&self) -> &Tail {
        &self.setup.tail
    }

    /// The same call with other targets, starts and step settings: a solver's own subtask.
    pub(super) fn with<'b>(
        &'b self,
        copies: &'b Copies,
        starts: &'b [f64],
        settings: Settings,
    ) -> Plan<'b> {
        let goals = match copies {
            Copies::Points(points, direction) => Goals::Positions { points, direction: *direction },
            Copies::Poses(poses) => Goals::Poses(poses),
        };
        let setup = Setup { settings, ..self.setup().clone() };
        Plan { goals, starts: Starts::Each(starts), setup: Cow::Owned(setup), ..self.clone() }
    }

    /// Target `row`, `count` times.
    pub(super) fn copies(&self, row: usize, count: usize) -> Copies {
        match self.goals {
            Goals::Positions { points, direction } => {
                Copies::Points(vec![points[row]; count], direction)
            }
            Goals::Poses(poses) => Copies::Poses(vec![poses[row]; count]),
        }
    }

    /// Squared distance (m^2) and angle (rad^2) between a posture and a goal.
    pub(super) fn errors(&self, at: &Workspace<f64>, goal: &Goal<f64>) -> (f64, f64) {
        let tool = at.tool_point(self.setup.tail.translation);
        let scale = 1.0;
        match self.setup.task {
            Task::Position => {
                let e = PositionRows.error(at, tool, goal);
                (e.position2, e.orientation2)
            }
            Task::Pose => {
                let e = PoseRows { scale, onward: None }.error(at, tool, goal);
                (e.position2, e.orientation2)
            }
            Task::Axis { tool_axis } => {
                let axis = self.setup.tail.direction(tool_axis);
                let e = AxisRows { scale, axis }.error(at, tool, goal);
                (e.position2, e.orientation2)
            }
            Task::Masked { weights, frame } => {
                let tool_axes = self.setup.tail.rotation;
                let e = MaskedRows { scale, weights, frame, tool: tool_axes }.error(at, tool, goal);
                (e.position2, e.orientation2)
            }
        }
    }

    /// Where the first attempt at target `row` starts, unless that is left to chance.
    #[inline(always)]
    pub(super) fn start(&self, row: usize) -> Option<&[f64]> {
        self.starts.row(row, self.chain.dof()).or(self.setup.usual_start.as_deref())
    }

    /// The goal of target `row`, or `None` where it or its start is not finite.
    #[inline(always)]
    pub(crate) fn goal(&self, row: usize) -> Option<Goal<f64>> {
        if let Some(q) = self.starts.row(row, self.chain.dof())
            && !all_finite(q)
        {
            return None;
        }
        match (self.goals, self.setup.task) {
            (Goals::Positions { points, direction: None }, _) => {
                let position = points[row];
                all_finite(&position).then_some(Goal { position, axes: [[0.0; 3]; 3] })
            }
            (Goals::Positions { points, direction: Some(direction) }, _) => {
                let position = points[row];
                all_finite(&position).then(|| axis_goal(position, direction))
            }
            (Goals::Poses(poses), Task::Axis { tool_axis }) => {
                if !all_finite(&poses[row]) {
                    return None;
                }
                let (position, rotation) = pose_parts(&poses[row]);
                let mut direction = [0.0; 3];
                for (column, a) in rotation.iter().zip(tool_axis) {
                    for (d, c) in direction.iter_mut().zip(column) {
                        *d += c * a;
                    }
                }
                unit(direction).map(|d| axis_goal(position, d))
            }
            (Goals::Poses(poses), _) => {
                if !all_finite(&poses[row]) {
                    return None;
                }
                let (position, rotation) = pose_parts(&poses[row]);
                Some(pose_goal(position, rotation, &self.setup.tail))
            }
        }
    }

    /// True where a bound of the reach proves that the goal cannot be met.
    #[inline(always)]
    pub(super) fn proven_unreachable(&self, goal: &Goal<f64>) -> bool {
        if !self.setup.task.fixes_position() {
            return false;
        }
        if self.setup.tool_reach.excess(goal.position) > self.setup.tolerance.position {
            return true;
        }
        let pose = self.setup.task.fixes_pose();
        let Some(wrist) = self.chain.last_joint_reach().filter(|_| pose) else { return false };
        // The tool's place and axes give the last joint's origin; an orientation error
        // within tolerance moves it by that angle times the tool's length.
        let t = self.setup.tail.translation;
        let mut p = goal.position;
        for (axis, along) in goal.axes.iter().zip(t) {
            for (x, a) in p.iter_mut().zip(axis) {
                *x -= a * along;
            }
        }
        let arm = t.iter().map(|x| x * x).sum::<f64>().sqrt();
        wrist.excess(p) > self.setup.tolerance.position + arm * self.setup.tolerance.orientation
    }
}

/// Without leaving early, which would cost more than it saves.
#[inline(always)]
fn all_finite(numbers: &[f64]) -> bool {
    numbers.iter().fold(true, |so_far, x| so_far & x.is_finite())
}
