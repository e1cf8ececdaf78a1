//! What goes into a call (goals, starts, settings) and what comes out of it (answers).

use super::step::{Feedback, StartRule, middle};
use super::{
    Settings,
    start::{Ranking, Sampler},
};
use crate::chain::{Chain, Reach, Tail};
use crate::error::{Error, Result};
use crate::kinematics::Workspace;
use crate::task::{
    AxisRows, Goal, MaskedRows, PoseRows, PositionRows, Rows, Task, axis_goal, pose_goal,
    pose_parts, rotation_scale, unit,
};

/// Share of the tolerance that solvers themselves allow, so that rounding in a later check
/// cannot turn a reached target into a missed one.
pub(super) const INSIDE: f64 = 1.0 - 1e-6;

/// What became of a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// Reached within tolerance and limits, by forward kinematics.
    Converged = 0,
    /// Proven to lie outside a bound of the robot's reach.
    OutOfReach = 1,
    /// No attempt ended within tolerance.
    NotFound = 2,
    /// The target or its start held NaN or infinity.
    BadInput = 3,
    /// The search came to rest before it reached the target, as in a local minimum (feedback
    /// laws, plain methods and population searches only).
    Stalled = 4,
    /// Numbers grew beyond all bounds (feedback laws only).
    NonFinite = 5,
}

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

/// Targets, in the world frame.
#[derive(Debug, Clone, Copy)]
pub enum Goals<'a> {
    /// Tool points (m), for [`Task::Position`], or for [`Task::Axis`] with one direction.
    Positions {
        /// One row a target.
        points: &'a [[f64; 3]],
        /// Direction of the tool axis, unit length, world frame.
        direction: Option<[f64; 3]>,
    },
    /// Homogeneous 4x4 matrices, row by row.
    Poses(&'a [[f64; 16]]),
}

impl Goals<'_> {
    /// How many targets.
    pub fn len(&self) -> usize {
        match self {
            Self::Positions { points, .. } => points.len(),
            Self::Poses(poses) => poses.len(),
        }
    }
    /// No target at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Where the first attempt of each target starts.
#[derive(Debug, Clone, Copy)]
pub enum Starts<'a> {
    /// Nowhere in particular: from the target's random stream.
    Free,
    /// The same joint values for all.
    One(&'a [f64]),
    /// `dof` joint values a target.
    Each(&'a [f64]),
}

impl<'a> Starts<'a> {
    /// The start of target `row`, if one was given.
    pub fn row(&self, row: usize, dof: usize) -> Option<&'a [f64]> {
        match self {
            Self::Free => None,
            Self::One(q) => Some(q),
            Self::Each(q) => Some(&q[row * dof..(row + 1) * dof]),
        }
    }
}

/// Everything that the targets of one call share.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    pub(super) chain: &'a Chain,
    pub(super) task: Task,
    pub(super) settings: Settings,
    pub(super) tolerance: Tolerance,
    pub(super) goals: Goals<'a>,
    pub(super) starts: Starts<'a>,
    pub(super) sampler: Sampler<'a>,
    pub(super) tail: Tail,
    pub(super) rotation_scale: f64,
    /// Limits inside those of the chain that hold for this call, rad or m.
    pub(super) bounds: Option<Vec<(f64, f64)>>,
    /// A second aim: share of the way to a posture that each step tries to go.
    pub(super) pull: Option<(f64, Vec<f64>)>,
    /// The feedback law of the settings, if it is one.
    pub(super) feedback: Option<Feedback>,
    /// Where first attempts start if the caller gives no start and the solver has one.
    usual_start: Option<Vec<f64>>,
    tool_reach: Reach,
    wrist_reach: Option<&'a Reach>,
}

impl<'a> Plan<'a> {
    /// A checked call. `seed` and the index of a target (its row plus `first_index`)
    /// alone decide its random starts.
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
        let task = task.checked()?;
        settings.check()?;
        tolerance.check()?;
        let dof = chain.dof();
        let (given, wanted) = match starts {
            Starts::Free => (0, 0),
            Starts::One(q) => (q.len(), dof),
            Starts::Each(q) => (q.len(), dof * goals.len()),
        };
        if given != wanted {
            return Err(Error::argument("q0", format!("{wanted} numbers"), given));
        }
        match (task, goals) {
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
        let compiled = chain.compiled();
        let tool_reach = match &tail {
            Some(tail) => Reach::with_tail(compiled, chain.variables(), tail),
            None => *chain.reach(),
        };
        let tail = tail.unwrap_or(compiled.tail);
        let rotation_scale = rotation_scale(chain.reach().radius);
        let ranking = ranking(&task, &compiled.tail, &tail, rotation_scale);
        let wrist_reach = if task.fixes_pose() { chain.last_joint_reach() } else { None };
        let feedback = Feedback::new(&settings, chain, &task, &tail, rotation_scale)?;
        let usual_start = match settings.start {
            StartRule::Sampled => None,
            StartRule::Zero => {
                Some(chain.variables().iter().map(|v| 0.0f64.clamp(v.lower, v.upper)).collect())
            }
            StartRule::Middle => Some(middle(chain)),
        };
        Ok(Self {
            chain,
            task,
            settings,
            tolerance,
            goals,
            starts,
            sampler: Sampler::new(chain, ranking, seed, first_index),
            rotation_scale,
            bounds: None,
            pull: None,
            feedback,
            usual_start,
            tail,
            tool_reach,
            wrist_reach,
        })
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
        self.task
    }
    /// How near is near enough.
    pub fn tolerance(&self) -> Tolerance {
        self.tolerance
    }
    /// Where the first attempt of each target starts.
    pub fn starts(&self) -> Starts<'a> {
        self.starts
    }
    /// The tool in the last joint's frame.
    pub fn tail(&self) -> &Tail {
        &self.tail
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
        Plan { goals, starts: Starts::Each(starts), settings, ..self.clone() }
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
        let tool = at.tool_point(self.tail.translation);
        let scale = 1.0;
        match self.task {
            Task::Position => {
                let e = PositionRows.error(at, tool, goal);
                (e.position2, e.orientation2)
            }
            Task::Pose => {
                let e = PoseRows { scale }.error(at, tool, goal);
                (e.position2, e.orientation2)
            }
            Task::Axis { tool_axis } => {
                let axis = self.tail.direction(tool_axis);
                let e = AxisRows { scale, axis }.error(at, tool, goal);
                (e.position2, e.orientation2)
            }
            Task::Masked { weights, frame } => {
                let tool_axes = self.tail.rotation;
                let e = MaskedRows { scale, weights, frame, tool: tool_axes }.error(at, tool, goal);
                (e.position2, e.orientation2)
            }
        }
    }

    /// Where the first attempt at target `row` starts, unless that is left to chance.
    #[inline(always)]
    pub(super) fn start(&self, row: usize) -> Option<&[f64]> {
        self.starts.row(row, self.chain.dof()).or(self.usual_start.as_deref())
    }

    /// The goal of target `row`, or `None` where it or its start is not finite.
    pub(crate) fn goal(&self, row: usize) -> Option<Goal<f64>> {
        if let Some(q) = self.starts.row(row, self.chain.dof())
            && !q.iter().all(|x| x.is_finite())
        {
            return None;
        }
        match self.goals {
            Goals::Positions { points, direction } => {
                let p = points[row];
                p.iter().all(|x| x.is_finite()).then(|| match direction {
                    Some(d) => axis_goal(p, d),
                    None => Goal { position: p, axes: [[0.0; 3]; 3] },
                })
            }
            Goals::Poses(poses) => {
                let m = &poses[row];
                if !m.iter().all(|x| x.is_finite()) {
                    return None;
                }
                let (position, rotation) = pose_parts(m);
                match self.task {
                    Task::Axis { tool_axis } => {
                        let mut direction = [0.0; 3];
                        for (column, a) in rotation.iter().zip(tool_axis) {
                            for (d, c) in direction.iter_mut().zip(column) {
                                *d += c * a;
                            }
                        }
                        unit(direction).map(|d| axis_goal(position, d))
                    }
                    _ => Some(pose_goal(position, rotation, &self.tail)),
                }
            }
        }
    }

    /// True where a bound of the reach proves that the goal cannot be met.
    pub(super) fn proven_unreachable(&self, goal: &Goal<f64>) -> bool {
        if !self.task.fixes_position() {
            return false;
        }
        if self.tool_reach.excess(goal.position) > self.tolerance.position {
            return true;
        }
        let Some(wrist) = self.wrist_reach else { return false };
        // The tool's place and axes give the last joint's origin; an orientation error
        // within tolerance moves it by that angle times the tool's length.
        let t = self.tail.translation;
        let mut p = goal.position;
        for (axis, along) in goal.axes.iter().zip(t) {
            for (x, a) in p.iter_mut().zip(axis) {
                *x -= a * along;
            }
        }
        let arm = t.iter().map(|x| x * x).sum::<f64>().sqrt();
        wrist.excess(p) > self.tolerance.position + arm * self.tolerance.orientation
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

/// Copies of one target, for a subtask that tries several starts at once.
#[derive(Debug, Clone)]
pub(super) enum Copies {
    /// Tool points, with the direction of all.
    Points(Vec<[f64; 3]>, Option<[f64; 3]>),
    /// Poses.
    Poses(Vec<[f64; 16]>),
}

/// The answers of a call, one entry a target (`dof` entries of `q`).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answers {
    /// Joint values, rad or m; the best found where the target was not reached.
    pub q: Vec<f64>,
    /// What became of each target.
    pub status: Vec<u8>,
    /// Distance left, m (infinite for bad input).
    pub position_error: Vec<f64>,
    /// Angle left, rad (infinite for bad input).
    pub orientation_error: Vec<f64>,
    /// Steps taken over all attempts.
    pub iterations: Vec<u32>,
    /// Attempts after the first.
    pub restarts: Vec<u32>,
}

impl Answers {
    /// Room for `rows` targets of a chain with `dof` joint values.
    pub fn new(rows: usize, dof: usize) -> Self {
        Self {
            q: vec![0.0; rows * dof],
            status: vec![Status::NotFound as u8; rows],
            position_error: vec![f64::INFINITY; rows],
            orientation_error: vec![f64::INFINITY; rows],
            iterations: vec![0; rows],
            restarts: vec![0; rows],
        }
    }

    /// How many targets.
    pub fn len(&self) -> usize {
        self.status.len()
    }
    /// No target at all.
    pub fn is_empty(&self) -> bool {
        self.status.is_empty()
    }
    /// True where target `row` was reached.
    pub fn success(&self, row: usize) -> bool {
        self.status[row] == Status::Converged as u8
    }
    /// All rows, writable.
    pub fn as_mut(&mut self) -> AnswersMut<'_> {
        AnswersMut {
            first: 0,
            q: &mut self.q,
            status: &mut self.status,
            position_error: &mut self.position_error,
            orientation_error: &mut self.orientation_error,
            iterations: &mut self.iterations,
            restarts: &mut self.restarts,
        }
    }
}

/// A run of consecutive rows of [`Answers`], owned by one thread while it is filled.
#[derive(Debug)]
pub struct AnswersMut<'a> {
    /// Row of the first entry in the whole call.
    pub first: usize,
    q: &'a mut [f64],
    status: &'a mut [u8],
    position_error: &'a mut [f64],
    orientation_error: &'a mut [f64],
    iterations: &'a mut [u32],
    restarts: &'a mut [u32],
}

/// One finished target.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outcome {
    pub status: Status,
    pub position_error: f64,
    pub orientation_error: f64,
    pub iterations: u32,
    pub restarts: u32,
}

impl<'a> AnswersMut<'a> {
    /// How many rows.
    pub fn len(&self) -> usize {
        self.status.len()
    }
    /// No row at all.
    pub fn is_empty(&self) -> bool {
        self.status.is_empty()
    }

    /// The rows in runs of at most `size`.
    pub fn split(self, size: usize) -> Vec<AnswersMut<'a>> {
        let dof = if self.status.is_empty() { 1 } else { self.q.len() / self.status.len() };
        self.q
            .chunks_mut((size * dof).max(1))
            .zip(self.status.chunks_mut(size))
            .zip(self.position_error.chunks_mut(size))
            .zip(self.orientation_error.chunks_mut(size))
            .zip(self.iterations.chunks_mut(size))
            .zip(self.restarts.chunks_mut(size))
            .enumerate()
            .map(
                |(
                    i,
                    (((((q, status), position_error), orientation_error), iterations), restarts),
                )| {
                    AnswersMut {
                        first: self.first + i * size,
                        q,
                        status,
                        position_error,
                        orientation_error,
                        iterations,
                        restarts,
                    }
                },
            )
            .collect()
    }

    /// Writes row `i` of this run and returns its joint values to be filled.
    pub(crate) fn finish(&mut self, i: usize, outcome: Outcome) -> &mut [f64] {
        self.status[i] = outcome.status as u8;
        self.position_error[i] = outcome.position_error;
        self.orientation_error[i] = outcome.orientation_error;
        self.iterations[i] = outcome.iterations;
        self.restarts[i] = outcome.restarts;
        let dof = self.q.len() / self.status.len();
        &mut self.q[i * dof..(i + 1) * dof]
    }
}
