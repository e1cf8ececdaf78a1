//! A request: targets of a chain, what counts as reaching them, and where to start from.

use super::accept::Guard;
use super::aim::{Aim, Left, Tolerance};
use super::second::Second;
use super::targets::{Copies, Goals, Starts};
use crate::allowed::is_measure;
use crate::chain::{Chain, Tail};
use crate::error::{Error, Result};
use crate::kinematics::Workspace;
use crate::task::{Goal, Task, axis_goal, pose_goal, pose_parts, unit};

/// What every solver is given.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    chain: &'a Chain,
    aim: Aim,
    goals: Goals<'a>,
    starts: Starts<'a>,
    seed: u64,
    first_index: u64,
    guard: Option<Guard<'a>>,
    second: Option<&'a Second>,
}

impl<'a> Request<'a> {
    /// A checked request; its random streams are those of seed 0 and first index 0.
    #[inline]
    pub fn new(chain: &'a Chain, aim: Aim, goals: Goals<'a>, starts: Starts<'a>) -> Result<Self> {
        let dof = chain.dof();
        let (given, wanted) = match starts {
            Starts::Free => (0, 0),
            Starts::One(q) => (q.len(), dof),
            Starts::Each(q) => (q.len(), dof * goals.len()),
        };
        if given != wanted {
            return Err(Error::argument("q0", format!("{wanted} numbers"), given));
        }
        match (aim.task(), goals) {
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
        Ok(Self { chain, aim, goals, starts, seed: 0, first_index: 0, guard: None, second: None })
    }

    /// The same request with other random streams: `seed` and the index of a target (its
    /// row plus `first_index`) alone decide them.
    pub fn with_seed(self, seed: u64, first_index: u64) -> Self {
        Self { seed, first_index, ..self }
    }

    /// The same request, whose answers have to be accepted as well.
    pub fn with_guard(self, guard: Guard<'a>) -> Self {
        Self { guard: Some(guard), ..self }
    }

    /// The same request, whose answers are moved to where a second aim is best.
    pub fn with_second(self, second: &'a Second) -> Self {
        Self { second: Some(second), ..self }
    }

    /// The same request without a second aim.
    pub(crate) fn without_second(self) -> Self {
        Self { second: None, ..self }
    }

    /// The same request for other targets, with a start for each: a solver's own subtask, whose
    /// answers nobody has to accept.
    pub(crate) fn with<'b>(&self, copies: &'b Copies, starts: &'b [f64]) -> Request<'b>
    where
        'a: 'b,
    {
        Request {
            goals: copies.goals(),
            starts: Starts::Each(starts),
            guard: None,
            second: None,
            ..*self
        }
    }

    /// The same request for copies of target `row`, with the start of that one: a subtask whose
    /// answers nobody has to accept.
    pub(crate) fn with_copies<'b>(&self, copies: &'b Copies, row: usize) -> Request<'b>
    where
        'a: 'b,
    {
        let starts = self.start(row).map_or(Starts::Free, Starts::One);
        Request { goals: copies.goals(), starts, guard: None, second: None, ..*self }
    }

    /// The same request for `count` of its targets from `first` on.
    pub(crate) fn part(&self, first: usize, count: usize) -> Self {
        let dof = self.chain.dof();
        let goals = match self.goals {
            Goals::Positions { points, direction } => {
                Goals::Positions { points: &points[first..first + count], direction }
            }
            Goals::Poses(poses) => Goals::Poses(&poses[first..first + count]),
        };
        let starts = match self.starts {
            Starts::Each(q) => Starts::Each(&q[first * dof..(first + count) * dof]),
            other => other,
        };
        let first_index = self.first_index.wrapping_add(first as u64);
        Self { goals, starts, first_index, ..*self }
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
    /// What counts as reached, how near, and with which tool.
    pub fn aim(&self) -> &Aim {
        &self.aim
    }
    /// What counts as reached.
    pub fn task(&self) -> Task {
        self.aim.task()
    }
    /// How near is near enough.
    pub fn tolerance(&self) -> Tolerance {
        self.aim.tolerance()
    }
    /// The tool in the last joint's frame.
    pub fn tail(&self) -> &Tail {
        self.aim.tail()
    }
    /// The targets.
    pub fn goals(&self) -> Goals<'a> {
        self.goals
    }
    /// Where the first attempt of each target starts.
    pub fn starts(&self) -> Starts<'a> {
        self.starts
    }
    /// What alone decides the random streams besides a target's index.
    pub fn seed(&self) -> u64 {
        self.seed
    }
    /// Index of the first target.
    pub fn first_index(&self) -> u64 {
        self.first_index
    }

    /// What answers have to be besides reaching their targets, if anything.
    #[inline(always)]
    pub fn guard(&self) -> Option<Guard<'a>> {
        self.guard
    }

    /// What answers are moved to be best at, if anything.
    #[inline(always)]
    pub fn second(&self) -> Option<&'a Second> {
        self.second
    }

    /// Where target `row` is to start from, if the caller says so.
    #[inline(always)]
    pub(crate) fn start(&self, row: usize) -> Option<&'a [f64]> {
        self.starts.row(row, self.chain.dof())
    }

    /// The goal of target `row`, or `None` where it or its start holds a number that is no
    /// measure: NaN, infinity, or one too large to count with.
    #[inline(always)]
    pub(crate) fn goal(&self, row: usize) -> Option<Goal<f64>> {
        if let Some(q) = self.start(row)
            && !all_measures(q)
        {
            return None;
        }
        match (self.goals, self.aim.task()) {
            (Goals::Positions { points, direction: None }, _) => {
                let position = points[row];
                all_measures(&position).then_some(Goal { position, axes: [[0.0; 3]; 3] })
            }
            (Goals::Positions { points, direction: Some(direction) }, _) => {
                let position = points[row];
                all_measures(&position).then(|| axis_goal(position, direction))
            }
            (Goals::Poses(poses), Task::Axis { tool_axis }) => {
                if !all_measures(&poses[row]) {
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
                if !all_measures(&poses[row]) {
                    return None;
                }
                let (position, rotation) = pose_parts(&poses[row]);
                Some(pose_goal(position, rotation, self.aim.tail()))
            }
        }
    }

    /// Largest angle, rad, that is known well enough to reach target `row`.
    #[inline(always)]
    pub(crate) fn well_known(&self, row: usize) -> f64 {
        let place = match self.goals {
            Goals::Positions { points, .. } => points[row],
            Goals::Poses(poses) => [3, 7, 11].map(|k| poses[row][k]),
        };
        self.aim.well_known(self.chain.reach().size, place)
    }

    /// Target `row`, `count` times.
    pub(crate) fn copies(&self, row: usize, count: usize) -> Copies {
        self.chosen(std::iter::repeat_n(row, count))
    }

    /// Some of the targets.
    pub(crate) fn chosen(&self, rows: impl Iterator<Item = usize>) -> Copies {
        match self.goals {
            Goals::Positions { points, direction } => {
                Copies::Points(rows.map(|row| points[row]).collect(), direction)
            }
            Goals::Poses(poses) => Copies::Poses(rows.map(|row| poses[row]).collect()),
        }
    }

    /// What is left between a posture and a goal.
    pub(crate) fn left(&self, at: &Workspace<f64>, goal: &Goal<f64>) -> Left {
        self.aim.left(at, goal)
    }
}

/// Without leaving early, which would cost more than it saves.
#[inline(always)]
fn all_measures(numbers: &[f64]) -> bool {
    numbers.iter().fold(true, |so_far, x| so_far & is_measure(*x))
}
