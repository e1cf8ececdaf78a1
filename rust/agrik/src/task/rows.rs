//! Errors of tasks and their Jacobians, row by row.

use super::rotation::{angle_factor, rotation_between};
use super::{Goal, MaskFrame};
use crate::kinematics::Workspace;
use crate::lanes::{Real, V3, axpy, cross, dot, scale, sub};

/// A task's error at one configuration.
#[derive(Debug, Clone, Copy)]
pub struct TaskError<R, const M: usize> {
    /// Scaled rows: goal minus present.
    pub rows: [R; M],
    /// Squared distance over the rows that count, m^2.
    pub position2: R,
    /// Squared angle over the rows that count, rad^2.
    pub orientation2: R,
    /// The largest share of a single row's bound that is used; 0 without bounds.
    pub outside: R,
}

/// A task as `M` rows over the number type `R`.
pub trait Rows<R: Real, const M: usize>: Copy {
    /// The error depends on how the tool is turned, not on its point alone.
    const ORIENTS: bool;
    /// Single rows may have bounds.
    const BOUNDED: bool = false;
    /// What the columns of a configuration share.
    type Seen;
    /// Error of the workspace's configuration.
    fn error(&self, at: &Workspace<R>, tool: V3<R>, goal: &Goal<R>) -> TaskError<R, M>;
    /// Looks at a configuration whose columns are wanted.
    fn look(&self, at: &Workspace<R>, tool: V3<R>, goal: &Goal<R>) -> Self::Seen;
    /// A column of the 6-row Jacobian as a column of the task's Jacobian.
    fn column(&self, seen: &Self::Seen, goal: &Goal<R>, linear: V3<R>, angular: V3<R>) -> [R; M];
}

/// Rows of [`Task::Position`].
#[derive(Debug, Clone, Copy)]
pub struct PositionRows;

impl<R: Real> Rows<R, 3> for PositionRows {
    type Seen = ();
    const ORIENTS: bool = false;
    #[inline(always)]
    fn error(&self, _at: &Workspace<R>, tool: V3<R>, goal: &Goal<R>) -> TaskError<R, 3> {
        let rows = sub(goal.position, tool);
        let (position2, none) = (dot(rows, rows), R::zero());
        TaskError { rows, position2, orientation2: none, outside: none }
    }
    #[inline(always)]
    fn look(&self, _: &Workspace<R>, _: V3<R>, _: &Goal<R>) {}
    #[inline(always)]
    fn column(&self, (): &(), _: &Goal<R>, linear: V3<R>, _: V3<R>) -> [R; 3] {
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
    type Seen = ();
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
            outside: R::zero(),
        }
    }
    #[inline(always)]
    fn look(&self, _: &Workspace<R>, _: V3<R>, _: &Goal<R>) {}
    #[inline(always)]
    fn column(&self, (): &(), _: &Goal<R>, l: V3<R>, a: V3<R>) -> [R; 6] {
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

/// The turn that takes `axis` to a goal's direction, about the goal's first two axes. It is at
/// right angles to the direction, so that two numbers hold all of it.
#[inline(always)]
fn turn_between<R: Real>(axis: V3<R>, goal: &Goal<R>) -> (R, R) {
    let sine = cross(axis, goal.axes[2]);
    let cosine = dot(axis, goal.axes[2]);
    let (factor, opposite) = angle_factor(dot(sine, sine), cosine);
    let u = factor * dot(sine, goal.axes[0]);
    let v = factor * dot(sine, goal.axes[1]);
    // Opposite directions leave it open: turn about the first.
    let u = R::select(opposite, R::splat(std::f64::consts::PI), u);
    (u, R::select(opposite, R::zero(), v))
}

impl<R: Real> Rows<R, 5> for AxisRows {
    type Seen = ();
    const ORIENTS: bool = true;
    #[inline(always)]
    fn error(&self, at: &Workspace<R>, tool: V3<R>, goal: &Goal<R>) -> TaskError<R, 5> {
        let p = sub(goal.position, tool);
        let (u, v) = turn_between(at.tool_direction(self.axis), goal);
        let s = R::splat(self.scale);
        TaskError {
            rows: [p[0], p[1], p[2], s * u, s * v],
            position2: dot(p, p),
            orientation2: u.mul_add(u, v * v),
            outside: R::zero(),
        }
    }
    #[inline(always)]
    fn look(&self, _: &Workspace<R>, _: V3<R>, _: &Goal<R>) {}
    #[inline(always)]
    fn column(&self, (): &(), goal: &Goal<R>, l: V3<R>, a: V3<R>) -> [R; 5] {
        let s = R::splat(self.scale);
        [l[0], l[1], l[2], s * dot(a, goal.axes[0]), s * dot(a, goal.axes[1])]
    }
}

/// Rows along and about the axes of a frame, each with a weight and, perhaps, a bound.
#[derive(Debug, Clone, Copy)]
pub struct FramedRows {
    /// Length per radian, m.
    pub scale: f64,
    /// One weight per row.
    pub weights: [f64; 6],
    /// Frame of the rows.
    pub frame: MaskFrame,
    /// The tool's axes in the last joint's frame (columns).
    pub tool: [[f64; 3]; 3],
    /// The tool's axis in the last joint's frame where it alone has to be turned.
    pub axis: Option<[f64; 3]>,
    /// The inverse of each row's bound, 1/m and 1/rad.
    pub inverse: Option<[f64; 6]>,
}

/// What columns of [`FramedRows`] share.
#[derive(Debug, Clone, Copy)]
pub struct Seen<R> {
    /// Axes of the tool, where the rows are along these.
    axes: Option<[V3<R>; 3]>,
    /// The way and the turn to the goal, world frame.
    way: V3<R>,
    turn: V3<R>,
    /// The factor of the turn's second order.
    bend: R,
}

impl<R: Real> Seen<R> {
    #[inline(always)]
    fn in_frame(&self, v: V3<R>) -> V3<R> {
        match &self.axes {
            None => v,
            Some(axes) => [dot(axes[0], v), dot(axes[1], v), dot(axes[2], v)],
        }
    }

    /// What a velocity of the tool takes off the way, whose entries are those of a frame that
    /// the tool turns: as if the goal were fixed to it.
    #[inline(always)]
    fn nearer(&self, linear: V3<R>, angular: V3<R>) -> V3<R> {
        if self.axes.is_none() {
            return linear;
        }
        let turned = cross(angular, self.way);
        [linear[0] + turned[0], linear[1] + turned[1], linear[2] + turned[2]]
    }

    /// What it takes off the turn: the derivative of the rotation vector, which matters where
    /// some entry is free and may be large.
    #[inline(always)]
    fn turned(&self, angular: V3<R>) -> V3<R> {
        let across = cross(self.turn, angular);
        let twice = cross(self.turn, across);
        let half = R::splat(if self.axes.is_some() { -0.5 } else { 0.5 });
        axpy(twice, self.bend, axpy(across, half, angular))
    }
}

impl FramedRows {
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
    /// The turn to the goal, or of the axis alone, about the world's axes.
    #[inline(always)]
    fn turn<R: Real>(&self, at: &Workspace<R>, goal: &Goal<R>) -> V3<R> {
        let Some(axis) = self.axis else {
            return rotation_between(at.joint_axes(), goal.axes);
        };
        let (u, v) = turn_between(at.tool_direction(axis), goal);
        axpy(goal.axes[0], u, scale(goal.axes[1], v))
    }
    #[inline(always)]
    fn outside<R: Real>(&self, p: V3<R>, o: V3<R>) -> R {
        let Some(inverse) = self.inverse else { return R::zero() };
        let mut most = R::zero();
        for (x, share) in p.iter().chain(&o).zip(inverse) {
            most = most.max((*x * R::splat(share)).abs());
        }
        most
    }
}

impl<R: Real> Rows<R, 6> for FramedRows {
    type Seen = Seen<R>;
    const ORIENTS: bool = true;
    const BOUNDED: bool = true;
    #[inline(always)]
    fn error(&self, at: &Workspace<R>, tool: V3<R>, goal: &Goal<R>) -> TaskError<R, 6> {
        let p = self.in_frame(at, sub(goal.position, tool));
        let o = self.in_frame(at, self.turn(at, goal));
        TaskError {
            rows: self.weighted(p, o),
            position2: counted(p, &self.weights[..3]),
            orientation2: counted(o, &self.weights[3..]),
            outside: self.outside(p, o),
        }
    }
    #[inline(always)]
    fn look(&self, at: &Workspace<R>, tool: V3<R>, goal: &Goal<R>) -> Seen<R> {
        let turn = self.turn(at, goal);
        let axes = match self.frame {
            MaskFrame::Base => None,
            MaskFrame::Tool => Some(at.tool_axes(&self.tool)),
        };
        // 1/x^2 - cot(x/2) / (2 x) to within a hundredth, for angles up to half a turn.
        let [c0, c1, c2] = [1.0 / 12.0, 1.0 / 720.0, 1.0 / 30240.0].map(R::splat);
        let squared = dot(turn, turn);
        let bend = squared.mul_add(squared.mul_add(c2, c1), c0);
        Seen { axes, way: sub(goal.position, tool), turn, bend }
    }
    #[inline(always)]
    fn column(&self, seen: &Seen<R>, goal: &Goal<R>, l: V3<R>, a: V3<R>) -> [R; 6] {
        let turned = match self.axis {
            None => seen.turned(a),
            // Turns about the wanted direction are free.
            Some(_) => axpy(goal.axes[2], -dot(a, goal.axes[2]), a),
        };
        self.weighted(seen.in_frame(seen.nearer(l, a)), seen.in_frame(turned))
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
