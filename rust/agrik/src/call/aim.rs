//! What counts as reached: the task, how near is near enough, and with which tool.

use std::f64::consts::TAU;

use crate::Allowed;
use crate::allowed::check_measures;
use crate::chain::{Chain, Tail, UNLIMITED};
use crate::error::{Error, Result};
use crate::kinematics::Workspace;
use crate::task::{
    AxisRows, FramedRows, Goal, MaskFrame, PoseRows, PositionRows, Rows, Task, TaskError,
};

/// Share of the tolerance that solvers themselves allow, so that rounding in a later check
/// cannot turn a reached target into a missed one.
pub(crate) const INSIDE: f64 = 1.0 - 1e-6;

/// Roundings of an angle of 1 rad and of the sums that it enters, of all joints together, and some
/// room, rad.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// How near is near enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Distance, m; infinite where the place is free or bounded by its axes alone.
    pub position: f64,
    /// Angle, rad; infinite likewise.
    pub orientation: f64,
    /// Bounds of single axes besides.
    pub axes: Option<AxisBounds>,
}

/// Bounds of an error along and about single axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisBounds {
    /// Most along x, y, z, m, and about x, y, z (entries of the rotation vector), rad;
    /// infinite where there is none.
    pub most: [f64; 6],
    /// Whose axes.
    pub frame: MaskFrame,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { position: 1e-6, orientation: 1e-6, axes: None }
    }
}

/// One number for all axes, or one for each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Near {
    /// The length of the error.
    Whole(f64),
    /// Its entry of each axis.
    Each([f64; 3]),
}

impl Near {
    fn check(self, name: &'static str) -> Result<()> {
        match self {
            Self::Whole(most) => Allowed::POSITIVE.check(name, most),
            Self::Each(each) => bounds(name, &each),
        }
    }
    fn whole(self) -> f64 {
        match self {
            Self::Whole(most) => most,
            Self::Each(each) => each.iter().map(|x| x * x).sum::<f64>().sqrt(),
        }
    }
    fn each(self) -> [f64; 3] {
        match self {
            Self::Whole(_) => [f64::INFINITY; 3],
            Self::Each(each) => each,
        }
    }
}

impl Tolerance {
    /// Tolerances of which some are given axis by axis of a frame; infinity frees an axis.
    pub fn by_axis(position: Near, orientation: Near, frame: MaskFrame) -> Result<Self> {
        position.check("position_tolerance")?;
        orientation.check("orientation_tolerance")?;
        let ([x, y, z], [a, b, c]) = (position.each(), orientation.each());
        Ok(Self {
            position: position.whole(),
            orientation: orientation.whole(),
            axes: Some(AxisBounds { most: [x, y, z, a, b, c], frame }),
        })
    }

    /// Refuses what no error can be below.
    fn check(&self) -> Result<()> {
        match self.axes {
            None => {
                Near::Whole(self.position).check("position_tolerance")?;
                Near::Whole(self.orientation).check("orientation_tolerance")
            }
            Some(AxisBounds { most: [x, y, z, a, b, c], .. }) => {
                bounds("position_tolerance", &[self.position, x, y, z])?;
                bounds("orientation_tolerance", &[self.orientation, a, b, c])
            }
        }
    }

    /// A tolerance of the whole error that holds for no more than this one does.
    pub(crate) fn inner(&self) -> Self {
        let [x, y, z, a, b, c] = self.axes.map_or([f64::INFINITY; 6], |axes| axes.most);
        Self {
            position: self.position.min(x).min(y).min(z),
            orientation: self.orientation.min(a).min(b).min(c),
            axes: None,
        }
    }
}

/// Refuses what is no bound of an axis.
fn bounds(name: &'static str, each: &[f64]) -> Result<()> {
    match each.iter().find(|x| !Allowed::POSITIVE.contains(**x) && **x != f64::INFINITY) {
        None => Ok(()),
        Some(x) => {
            let expected = format!("{}, or infinity for a free axis", Allowed::POSITIVE);
            Err(Error::argument(name, expected, format!("{x:?}")))
        }
    }
}

/// What is left between a posture and a goal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Left {
    /// Squared distance, m^2, and angle, rad^2, over the axes that count.
    pub position2: f64,
    pub orientation2: f64,
    /// The largest share of a single axis' bound that is used; 0 where there are none.
    pub outside: f64,
}

impl Left {
    /// Nothing is known.
    pub const UNKNOWN: Self =
        Self { position2: f64::INFINITY, orientation2: f64::INFINITY, outside: f64::INFINITY };
}

impl<const M: usize> From<TaskError<f64, M>> for Left {
    #[inline(always)]
    fn from(error: TaskError<f64, M>) -> Self {
        let TaskError { position2, orientation2, outside, .. } = error;
        Self { position2, orientation2, outside }
    }
}

/// The rows by which an aim's error is measured.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Measure {
    /// Of the tool point.
    Position(PositionRows),
    /// Of the pose.
    Pose(PoseRows),
    /// Of the point and an axis.
    Axis(AxisRows),
    /// Axis by axis of a frame.
    Framed(FramedRows),
}

/// A task, its tolerances and the tool that has to fulfil it, checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aim {
    task: Task,
    tolerance: Tolerance,
    tail: Tail,
}

impl Aim {
    /// A checked aim; `tail` is a tool in place of the chain's own.
    #[inline]
    pub fn new(
        chain: &Chain,
        task: Task,
        tolerance: Tolerance,
        tail: Option<Tail>,
    ) -> Result<Self> {
        let task = task.checked()?;
        tolerance.check()?;
        if let Some(tail) = &tail {
            check_measures("tool", tail.translation)?;
        }
        let aim = Self { task, tolerance, tail: tail.unwrap_or(chain.compiled().tail) };
        match tolerance.axes {
            None => Ok(aim),
            Some(axes) => aim.by_axis(axes),
        }
    }

    /// The aim with a bound for each axis that counts.
    #[inline(never)]
    fn by_axis(mut self, mut axes: AxisBounds) -> Result<Self> {
        if let Task::Masked { frame, .. } = self.task {
            if axes.frame != frame && axes.most.iter().any(|x| x.is_finite()) {
                return Err(Error::argument(
                    "tolerance_frame",
                    format!("{}, the frame of the mask", frame.name()),
                    axes.frame.name(),
                ));
            }
            axes.frame = frame;
        }
        for (most, weight) in axes.most.iter_mut().zip(self.task.weights()) {
            if weight == 0.0 {
                *most = f64::INFINITY;
            }
        }
        if self.task == Task::PositionFirst {
            // From one number on a better orientation is of no account.
            self.tolerance.orientation = self.tolerance.inner().orientation;
            axes.most[3..].fill(f64::INFINITY);
        }
        self.tolerance.axes = Some(axes);
        if self.weights() == [0.0; 6] {
            return Err(Error::argument(
                "position_tolerance",
                "a finite tolerance of some axis that the task counts",
                "infinity for all",
            ));
        }
        Ok(self)
    }

    /// Weights of the errors along and about the axes: 0 for those that are free.
    pub(crate) fn weights(&self) -> [f64; 6] {
        let mut weights = self.task.weights();
        if let Some(axes) = self.tolerance.axes {
            for (k, weight) in weights.iter_mut().enumerate() {
                let whole =
                    if k < 3 { self.tolerance.position } else { self.tolerance.orientation };
                if whole.min(axes.most[k]).is_infinite() {
                    *weight = 0.0;
                }
            }
        }
        weights
    }

    /// What counts as reached.
    pub fn task(&self) -> Task {
        self.task
    }
    /// How near is near enough.
    pub fn tolerance(&self) -> Tolerance {
        self.tolerance
    }
    /// The tool in the last joint's frame.
    pub fn tail(&self) -> &Tail {
        &self.tail
    }

    /// The aim fixes the tool point.
    pub fn fixes_position(&self) -> bool {
        self.weights()[..3].iter().all(|w| *w > 0.0)
    }

    /// The aim fixes the full pose, without a word on single axes.
    pub fn fixes_pose(&self) -> bool {
        self.task.fixes_pose() && self.tolerance.axes.is_none()
    }

    /// Largest angle, rad, that is known well enough to reach a place with an arm of a size, m: of
    /// larger ones the last digit moves the tool too far.
    #[inline(always)]
    pub(crate) fn well_known(&self, size: f64, place: [f64; 3]) -> f64 {
        let Tolerance { position, orientation, .. } = self.tolerance.inner();
        let far = place.iter().fold(size, |far, x| far.max(x.abs())).max(f64::MIN_POSITIVE);
        // Within a turn there is none that is known better.
        ((position / far).min(orientation) / ROUNDING).clamp(TAU, UNLIMITED)
    }

    /// What is left is near enough, for solvers.
    #[inline(always)]
    pub(crate) fn is_met(&self, left: &Left) -> bool {
        if !self.puts_position_first() {
            return self.is_best(left);
        }
        left.position2 <= (self.tolerance.position * INSIDE).powi(2) && left.outside <= INSIDE
    }

    /// Nothing nearer is looked for.
    #[inline(always)]
    pub(crate) fn is_best(&self, left: &Left) -> bool {
        left.position2 <= (self.tolerance.position * INSIDE).powi(2)
            && left.orientation2 <= (self.tolerance.orientation * INSIDE).powi(2)
            && left.outside <= INSIDE
    }

    /// An orientation is wanted only as far as the position allows it.
    pub(crate) fn puts_position_first(&self) -> bool {
        self.task == Task::PositionFirst
    }

    /// What is left between a posture and a goal.
    pub(crate) fn left(&self, at: &Workspace<f64>, goal: &Goal<f64>) -> Left {
        let tool = at.tool_point(self.tail.translation);
        match self.measure(1.0) {
            Measure::Position(rows) => rows.error(at, tool, goal).into(),
            Measure::Pose(rows) => rows.error(at, tool, goal).into(),
            Measure::Axis(rows) => rows.error(at, tool, goal).into(),
            Measure::Framed(rows) => rows.error(at, tool, goal).into(),
        }
    }

    /// How its error is measured, rotations by a length per radian.
    #[inline(always)]
    pub(crate) fn measure(&self, scale: f64) -> Measure {
        match (self.task, self.tolerance.axes) {
            (Task::Position, None) => Measure::Position(PositionRows),
            (Task::Pose | Task::PositionFirst, None) => {
                Measure::Pose(PoseRows { scale, onward: None })
            }
            (Task::Axis { tool_axis }, None) => {
                Measure::Axis(AxisRows { scale, axis: self.tail.direction(tool_axis) })
            }
            (Task::Masked { frame, .. }, axes) => self.framed(scale, frame, axes),
            (_, Some(axes)) => self.framed(scale, axes.frame, Some(axes)),
        }
    }

    #[inline(never)]
    fn framed(&self, scale: f64, frame: MaskFrame, axes: Option<AxisBounds>) -> Measure {
        let axis = match self.task {
            Task::Axis { tool_axis } => Some(self.tail.direction(tool_axis)),
            _ => None,
        };
        Measure::Framed(FramedRows {
            scale,
            weights: self.weights(),
            frame,
            tool: self.tail.rotation,
            axis,
            inverse: axes.map(|axes| axes.most.map(|x| 1.0 / x)),
        })
    }
}
