//! The axes of an arm as lines in the base frame, and what can be done with the list of them:
//! lock a joint, read the arm backwards, move and scale it.

use std::fmt;

use super::rigid::{Rigid, turn_about};
use crate::lanes::{V3, axpy, cross, dot, norm, scale, sub};

/// Axes whose directions differ by less count as parallel; lines that miss a common point by
/// less of the arm's length count as meeting.
pub const EXACT: f64 = 1e-7;

/// A joint's axis at `q = 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screw {
    /// Direction, unit length.
    pub axis: V3<f64>,
    /// A point on it, m.
    pub point: V3<f64>,
}

impl Screw {
    /// The turn about it.
    pub fn turn(&self, angle: f64) -> Rigid<f64> {
        turn_about(self.axis, self.point, angle.sin_cos())
    }

    /// The same line after a motion.
    pub fn moved(&self, by: &Rigid<f64>) -> Self {
        Self { axis: by.turn(self.axis), point: by.apply(self.point) }
    }
}

/// Joints that turn, from the base on, and the tool at `q = 0`.
#[derive(Clone, PartialEq)]
pub struct Screws {
    /// The axes.
    pub joints: Vec<Screw>,
    /// Tool frame in the base frame.
    pub tool: Rigid<f64>,
}

impl fmt::Debug for Screws {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(&self.joints).finish()
    }
}

impl Screws {
    /// Tool pose at joint values along the chain, rad.
    pub fn pose(&self, q: &[f64]) -> Rigid<f64> {
        let mut pose = self.tool;
        for (screw, x) in self.joints.iter().zip(q).rev() {
            pose = screw.turn(*x).after(&pose);
        }
        pose
    }

    /// A length of the arm's size, m: a third of its span.
    pub fn length(&self) -> f64 {
        let span = self.span();
        if span > 0.0 { span / 3.0 } else { 1.0 }
    }

    /// The way from point to point, m; the tool is never farther from the first one. Of gathered
    /// axes it moves with no choice of points on them that comes from a file.
    pub fn span(&self) -> f64 {
        let mut sum = 0.0;
        for pair in self.joints.windows(2) {
            sum += norm(sub(pair[1].point, pair[0].point));
        }
        if let Some(last) = self.joints.last() {
            sum += norm(sub(self.tool.shift, last.point));
        }
        sum
    }

    /// The arm with one joint held at a value, which moves all behind it.
    pub fn locked(&self, joint: usize, value: f64) -> Self {
        let turn = self.joints[joint].turn(value);
        let (before, behind) = (&self.joints[..joint], &self.joints[joint + 1..]);
        let moved = behind.iter().map(|screw| screw.moved(&turn));
        let joints = before.iter().copied().chain(moved).collect();
        Self { joints, tool: turn.after(&self.tool) }
    }

    /// The arm from its tool to its base: `pose` is the inverse for the values in reverse order.
    pub fn reversed(&self) -> Self {
        // The inverse is tool^-1 e_n^-1 ... e_1^-1: axes as the tool sees them, turned round.
        let seen = self.tool.inverse();
        let back = |screw: &Screw| {
            let screw = screw.moved(&seen);
            Screw { axis: scale(screw.axis, -1.0), point: screw.point }
        };
        Self { joints: self.joints.iter().rev().map(back).collect(), tool: seen }
    }

    /// Another base frame.
    pub fn moved(&self, by: &Rigid<f64>) -> Self {
        let joints = self.joints.iter().map(|screw| screw.moved(by)).collect();
        Self { joints, tool: by.after(&self.tool) }
    }

    /// All lengths times a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        let far = |screw: &Screw| Screw { axis: screw.axis, point: scale(screw.point, factor) };
        let joints = self.joints.iter().map(far).collect();
        let tool = Rigid { axes: self.tool.axes, shift: scale(self.tool.shift, factor) };
        Self { joints, tool }
    }

    /// How far neighbouring axes are from parallel: sine of the angle.
    pub fn tilt(&self, one: usize, two: usize) -> f64 {
        norm(cross(self.joints[one].axis, self.joints[two].axis))
    }

    /// The point nearest to all lines of a range, and how far they pass by it at most, m;
    /// `None` where they are all parallel.
    pub fn meeting(&self, range: std::ops::Range<usize>) -> Option<(V3<f64>, f64)> {
        // Sum of (1 - w w^T) over the lines; the point solves it.
        let lines = &self.joints[range];
        let mut m = nalgebra::Matrix3::<f64>::zeros();
        let mut b = nalgebra::Vector3::<f64>::zeros();
        for line in lines {
            let w = nalgebra::Vector3::from(line.axis);
            let across = nalgebra::Matrix3::identity() - w * w.transpose();
            m += across;
            b += across * nalgebra::Vector3::from(line.point);
        }
        // A common direction leaves the place along it open.
        let least = m.symmetric_eigenvalues().min();
        if least < 1e-10 {
            return None;
        }
        let x: V3<f64> = m.try_inverse().map(|inverse| (inverse * b).into())?;
        let off = |line: &Screw| norm(cross(sub(x, line.point), line.axis));
        Some((x, lines.iter().map(off).fold(0.0, f64::max)))
    }

    /// Neighbours of a range that pass one another by so much that no point is within a gap (m) of
    /// all lines: a quick look before [`Self::meeting`], which some that do not meet pass.
    pub fn pass_by(&self, range: std::ops::Range<usize>, gap: f64) -> bool {
        self.joints[range].windows(2).any(|pair| {
            let across = cross(pair[0].axis, pair[1].axis);
            let way = sub(pair[1].point, pair[0].point);
            dot(way, across).abs() > 2.0 * gap * norm(across)
        })
    }

    /// Points on the axes that are near one another: feet of common normals, where there are
    /// such. What is computed from them loses fewer digits than from points far away.
    pub fn gathered(&self) -> Self {
        let mut out = self.clone();
        for i in 1..out.joints.len() {
            let (before, here) = (out.joints[i - 1].point, out.joints[i]);
            let along = dot(sub(before, here.point), here.axis);
            out.joints[i].point = axpy(here.axis, along, here.point);
        }
        out
    }
}
