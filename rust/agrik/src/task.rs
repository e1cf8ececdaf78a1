//! Tasks: what counts as reached, as an error vector and as rows of the Jacobian.
//!
//! Rotation rows are rotation vectors (axis times angle) in the world frame, exact up to
//! half a turn; they are scaled by a length per radian so that they can stand beside
//! metres in one sum of squares. Tolerances apply to the unscaled errors.

use crate::allowed::{LARGEST, is_measure};
use crate::chain::Tail;
use crate::error::{Error, Result};
use crate::kinematics::Workspace;
use crate::lanes::{Real, V3, angle_over_sine, axpy, cross, dot, scale, select3, sub};

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
    /// Pose with a weight per row (x, y, z, then rotation about x, y, z); a weight of
    /// zero frees the row.
    Masked {
        /// One weight per row, none negative, at least one positive.
        weights: [f64; 6],
        /// Frame whose axes the rows refer to.
        frame: MaskFrame,
    },
}

/// Frame whose axes the rows of [`Task::Masked`] refer to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MaskFrame {
    /// World axes.
    Base,
    /// Axes of the tool as it stands.
    Tool,
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

    /// The task fixes the tool point.
    pub fn fixes_position(&self) -> bool {
        match self {
            Self::Masked { weights, .. } => weights[..3].iter().all(|w| *w > 0.0),
            _ => true,
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

/// A task's error at one configuration.
#[derive(Debug, Clone, Copy)]
pub struct TaskError<R, const M: usize> {
    /// Scaled rows: goal minus present.
    pub rows: [R; M],
    /// Squared distance over the rows that count, m^2.
    pub position2: R,
    /// Squared angle over the rows that count, rad^2.
    pub orientation2: R,
}

/// A task as `M` rows over the number type `R`.
pub trait Rows<R: Real, const M: usize>: Copy {
    /// The error depends on how the tool is turned, not on its point alone.
    const ORIENTS: bool;
    /// Error of the workspace's configuration.
    fn error(&self, at: &Workspace<R>, tool: V3<R>, goal: &Goal<R>) -> TaskError<R, M>;
    /// A column of the 6-row Jacobian as a column of the task's Jacobian.
    fn column(&self, at: &Workspace<R>, goal: &Goal<R>, linear: V3<R>, angular: V3<R>) -> [R; M];
}

/// Rows of [`Task::Position`].
#[derive(Debug, Clone, Copy)]
pub struct PositionRows;

impl<R: Real> Rows<R, 3> for PositionRows {
    const ORIENTS: bool = false;
    #[inline(always)]
    fn error(&self, _at: &Workspace<R>, tool: V3<R>, goal: &Goal<R>) -> TaskError<R, 3> {
        let rows = sub(goal.position, tool);
        TaskError { rows, position2: dot(rows, rows), orientation2: R::zero() }
    }
    #[inline(always)]
    fn column(&self, _: &Workspace<R>, _: &Goal<R>, linear: V3<R>, _: V3<R>) -> [R; 3] {
        linear
    }
}

/// Rows of [`Task::Pose`].
#[derive(Debug, Clone, Copy)]
pub struct PoseRows {
    /// Length per radian, m.
    pub scale: f64,
    /// The way from the point whose position the rows compare to the tool point whose position
    /// counts, in the last joint's frame, m; none where they are one.
    pub onward: Option<[f64; 3]>,
}

impl<R: Real> Rows<R, 6> for PoseRows {
    const ORIENTS: bool = true;
    #[inline(always)]
    fn error(&self, at: &Workspace<R>, tool: V3<R>, goal: &Goal<R>) -> TaskError<R, 6> {
        let p = sub(goal.position, tool);
        let o = rotation_between(at.joint_axes(), goal.axes);
        let s = R::splat(self.scale);
        let position2 = match self.onward {
            None => dot(p, p),
            Some(onward) => {
                let mut tool = p;
                for ((from, to), along) in at.joint_axes().iter().zip(goal.axes).zip(onward) {
                    tool = axpy(sub(to, *from), R::splat(along), tool);
                }
                dot(tool, tool)
            }
        };
        TaskError {
            rows: [p[0], p[1], p[2], s * o[0], s * o[1], s * o[2]],
            position2,
            orientation2: dot(o, o),
        }
    }
    #[inline(always)]
    fn column(&self, _: &Workspace<R>, _: &Goal<R>, l: V3<R>, a: V3<R>) -> [R; 6] {
        let s = R::splat(self.scale);
        [l[0], l[1], l[2], s * a[0], s * a[1], s * a[2]]
    }
}

/// Rows of [`Task::Axis`].
#[derive(Debug, Clone, Copy)]
pub struct AxisRows {
    /// Length per radian, m.
    pub scale: f64,
    /// The tool's axis in the last joint's frame.
    pub axis: [f64; 3],
}

impl<R: Real> Rows<R, 5> for AxisRows {
    const ORIENTS: bool = true;
    #[inline(always)]
    fn error(&self, at: &Workspace<R>, tool: V3<R>, goal: &Goal<R>) -> TaskError<R, 5> {
        let p = sub(goal.position, tool);
        let axis = at.tool_direction(self.axis);
        let sine = cross(axis, goal.axes[2]);
        let cosine = dot(axis, goal.axes[2]);
        let (factor, opposite) = angle_factor(dot(sine, sine), cosine);
        // The axis to turn about is at right angles to the wanted direction, so two rows
        // hold all of it. Opposite directions leave it open: turn about the first.
        let u = factor * dot(sine, goal.axes[0]);
        let v = factor * dot(sine, goal.axes[1]);
        let u = R::select(opposite, R::splat(std::f64::consts::PI), u);
        let v = R::select(opposite, R::zero(), v);
        let s = R::splat(self.scale);
        TaskError {
            rows: [p[0], p[1], p[2], s * u, s * v],
            position2: dot(p, p),
            orientation2: u.mul_add(u, v * v),
        }
    }
    #[inline(always)]
    fn column(&self, _: &Workspace<R>, goal: &Goal<R>, l: V3<R>, a: V3<R>) -> [R; 5] {
        let s = R::splat(self.scale);
        [l[0], l[1], l[2], s * dot(a, goal.axes[0]), s * dot(a, goal.axes[1])]
    }
}

/// Rows of [`Task::Masked`].
#[derive(Debug, Clone, Copy)]
pub struct MaskedRows {
    /// Length per radian, m.
    pub scale: f64,
    /// One weight per row.
    pub weights: [f64; 6],
    /// Frame of the rows.
    pub frame: MaskFrame,
    /// The tool's axes in the last joint's frame (columns).
    pub tool: [[f64; 3]; 3],
}

impl MaskedRows {
    #[inline(always)]
    fn in_frame<R: Real>(&self, at: &Workspace<R>, v: V3<R>) -> V3<R> {
        match self.frame {
            MaskFrame::Base => v,
            MaskFrame::Tool => {
                let axes = at.tool_axes(&self.tool);
                [dot(axes[0], v), dot(axes[1], v), dot(axes[2], v)]
            }
        }
    }
    #[inline(always)]
    fn weighted<R: Real>(&self, l: V3<R>, a: V3<R>) -> [R; 6] {
        let w = self.weights;
        let s = self.scale;
        [
            R::splat(w[0]) * l[0],
            R::splat(w[1]) * l[1],
            R::splat(w[2]) * l[2],
            R::splat(s * w[3]) * a[0],
            R::splat(s * w[4]) * a[1],
            R::splat(s * w[5]) * a[2],
        ]
    }
}

impl<R: Real> Rows<R, 6> for MaskedRows {
    const ORIENTS: bool = true;
    #[inline(always)]
    fn error(&self, at: &Workspace<R>, tool: V3<R>, goal: &Goal<R>) -> TaskError<R, 6> {
        let p = self.in_frame(at, sub(goal.position, tool));
        let o = self.in_frame(at, rotation_between(at.joint_axes(), goal.axes));
        TaskError {
            rows: self.weighted(p, o),
            position2: counted(p, &self.weights[..3]),
            orientation2: counted(o, &self.weights[3..]),
        }
    }
    #[inline(always)]
    fn column(&self, at: &Workspace<R>, _: &Goal<R>, l: V3<R>, a: V3<R>) -> [R; 6] {
        self.weighted(self.in_frame(at, l), self.in_frame(at, a))
    }
}

/// Squared length over the rows whose weight is not zero.
#[inline(always)]
fn counted<R: Real>(v: V3<R>, weights: &[f64]) -> R {
    let mut sum = R::zero();
    for (x, w) in v.iter().zip(weights) {
        if *w > 0.0 {
            sum = x.mul_add(*x, sum);
        }
    }
    sum
}

/// The factor from a rotation's sine (squared) and cosine to its angle over its sine, and
/// where the two directions are opposite, so that the sine says nothing.
#[inline(always)]
fn angle_factor<R: Real>(sine2: R, cosine: R) -> (R, R::Mask) {
    let near = angle_over_sine(cosine.abs().min(R::splat(1.0)));
    let obtuse = cosine.lt(R::zero());
    let never = R::mask_from_bits(0);
    if R::bits(obtuse) == 0 {
        return (near, never);
    }
    // angle = pi - acos(|c|) beyond a right angle.
    let sine = sine2.max(R::splat(1e-200)).sqrt();
    let far = R::splat(std::f64::consts::PI) / sine - near;
    let opposite = R::and(obtuse, sine2.lt(R::splat(1e-14)));
    (R::select(obtuse, far, near), opposite)
}

/// The rotation vector that takes the frame `from` (columns) to the frame `to`.
#[inline(always)]
pub fn rotation_between<R: Real>(from: [V3<R>; 3], to: [V3<R>; 3]) -> V3<R> {
    let half = R::splat(0.5);
    let mut twice = cross(from[0], to[0]);
    let mut trace = dot(from[0], to[0]);
    for k in 1..3 {
        let c = cross(from[k], to[k]);
        twice = [twice[0] + c[0], twice[1] + c[1], twice[2] + c[2]];
        trace += dot(from[k], to[k]);
    }
    let sine = scale(twice, half);
    let cosine = (trace - R::splat(1.0)) * half;
    let (factor, opposite) = angle_factor(dot(sine, sine), cosine);
    let vector = scale(sine, factor);
    if R::bits(opposite) == 0 {
        return vector;
    }
    let turned = scale(half_turn_axis(from, to), R::splat(std::f64::consts::PI));
    select3::<R>(opposite, turned, vector)
}

/// Axis of a rotation by half a turn: the longest column of R + 1, made unit length.
#[inline(always)]
fn half_turn_axis<R: Real>(from: [V3<R>; 3], to: [V3<R>; 3]) -> V3<R> {
    // R = sum of to_k from_k^T; column j of R is sum of to_k * from_k[j].
    let zero = [R::zero(); 3];
    let mut best = zero;
    let mut best2 = R::zero();
    for j in 0..3 {
        let mut column = zero;
        for k in 0..3 {
            column = axpy(to[k], from[k][j], column);
        }
        column[j] += R::splat(1.0);
        let length2 = dot(column, column);
        let better = best2.lt(length2);
        best2 = R::select(better, length2, best2);
        best = select3::<R>(better, column, best);
    }
    scale(best, R::splat(1.0) / best2.sqrt())
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
