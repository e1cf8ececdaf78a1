//! Tasks: what counts as reached, as an error vector and as rows of the Jacobian.
//!
//! Rotation rows are rotation vectors (axis times angle) in the world frame, exact up to
//! half a turn; they are scaled by a length per radian so that they can stand beside
//! metres in one sum of squares. Tolerances apply to the unscaled errors.

mod rotation;
mod rows;

pub use rotation::rotation_between;
pub use rows::{AxisRows, FramedRows, PoseRows, PositionRows, Rows, TaskError};

use crate::allowed::{LARGEST, is_measure};
use crate::chain::Tail;
use crate::error::{Error, Result};
use crate::lanes::{Real, V3, axpy, cross, dot};

/// What a solver has to bring about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Task {
    /// Tool point at a position (3 rows).
    Position,
    /// Tool frame at a pose (6 rows).
    Pose,
    /// Tool point at a position and a tool axis along a direction, free about it (5 rows).
    Axis {
        /// Unit vector in the tool frame.
        tool_axis: [f64; 3],
    },
    /// Tool point at a position, and the tool turned as near to an orientation as that allows.
    PositionFirst,
    /// Pose with a weight per row (x, y, z, then rotation about x, y, z); a weight of
    /// zero frees the row.
    Masked {
        /// One weight per row, none negative, at least one positive.
        weights: [f64; 6],
        /// Frame whose axes the rows refer to.
        frame: MaskFrame,
    },
}

/// Frame whose axes the rows of [`Task::Masked`], and bounds of single axes, refer to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MaskFrame {
    /// World axes.
    Base,
    /// Axes of the tool as it stands.
    Tool,
}

impl MaskFrame {
    /// The name that users know it by.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Base => "base",
            Self::Tool => "tool",
        }
    }
}

impl Task {
    /// The task, with its vectors checked and made unit length.
    pub fn checked(self) -> Result<Self> {
        match self {
            Self::Axis { tool_axis } => {
                let unit = unit(tool_axis).ok_or_else(|| {
                    Error::argument("tool_axis", "a direction of non-zero length", "zero or NaN")
                })?;
                Ok(Self::Axis { tool_axis: unit })
            }
            Self::Masked { weights, .. }
                if weights.iter().any(|w| !is_measure(*w) || *w < 0.0)
                    || weights.iter().all(|w| *w == 0.0) =>
            {
                Err(Error::argument(
                    "weights",
                    format!("six numbers, 0 to {LARGEST:e}, at least one positive"),
                    format!("{weights:?}"),
                ))
            }
            other => Ok(other),
        }
    }

    /// The task fixes the full orientation, so that the wrist's place follows from it.
    pub fn fixes_pose(&self) -> bool {
        matches!(self, Self::Pose)
    }

    /// Weights of the errors along and about x, y, z; 0 for those that are free.
    pub fn weights(&self) -> [f64; 6] {
        match self {
            Self::Position => [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
            Self::Pose | Self::PositionFirst | Self::Axis { .. } => [1.0; 6],
            Self::Masked { weights, .. } => *weights,
        }
    }
}

/// `v` with length 1, if it has a length.
pub fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length.is_finite() && length > 1e-12).then(|| v.map(|x| x / length))
}

/// Where a lane's tool has to go: position, and axes of the last joint's frame (pose) or
/// a frame whose z is the wanted direction (axis task).
#[derive(Debug, Clone, Copy)]
pub struct Goal<R> {
    /// Tool point, m, world.
    pub position: V3<R>,
    /// Columns of a rotation, world.
    pub axes: [V3<R>; 3],
}

impl<R: Real> Goal<R> {
    /// A goal at the origin.
    pub fn zero() -> Self {
        Self { position: [R::zero(); 3], axes: [[R::zero(); 3]; 3] }
    }

    /// The goal of one lane.
    #[inline(always)]
    pub fn of_lane(&self, lane: usize) -> Goal<f64> {
        let mut one = Goal::zero();
        for k in 0..3 {
            one.position[k] = self.position[k].lane(lane);
            for (to, axis) in one.axes.iter_mut().zip(&self.axes) {
                to[k] = axis[k].lane(lane);
            }
        }
        one
    }

    /// Writes one lane.
    #[inline(always)]
    pub fn set_lane(&mut self, lane: usize, goal: &Goal<f64>) {
        for (to, from) in self.position.iter_mut().zip(goal.position) {
            to.set_lane(lane, from);
        }
        for (to, from) in self.axes.iter_mut().flatten().zip(goal.axes.iter().flatten()) {
            to.set_lane(lane, *from);
        }
    }
}

/// Position and axes (columns) of a pose given row by row.
#[inline(always)]
pub fn pose_parts(m: &[f64; 16]) -> ([f64; 3], [[f64; 3]; 3]) {
    let column = |j: usize| [m[j], m[4 + j], m[8 + j]];
    ([m[3], m[7], m[11]], [column(0), column(1), column(2)])
}

/// The goal of a pose target: `axes` are those that the last joint's frame must take.
#[inline(always)]
pub fn pose_goal(position: [f64; 3], rotation: [[f64; 3]; 3], tail: &Tail) -> Goal<f64> {
    // R_joint = R_target * R_tail^T.
    let mut axes = [[0.0; 3]; 3];
    for (j, column) in axes.iter_mut().enumerate() {
        for (r, t) in rotation.iter().zip(&tail.rotation) {
            *column = axpy(*r, t[j], *column);
        }
    }
    Goal { position, axes }
}

/// The goal of an axis target: a frame whose z is `direction` (unit length).
pub fn axis_goal(position: [f64; 3], direction: [f64; 3]) -> Goal<f64> {
    let helper = if direction[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let u = cross(helper, direction);
    let length = dot(u, u).sqrt();
    let u = u.map(|x| x / length);
    Goal { position, axes: [u, cross(direction, u), direction] }
}

/// A length per radian that puts rotation rows beside metres: a share of the robot's size.
pub fn rotation_scale(reach: f64) -> f64 {
    0.3 * reach
}
