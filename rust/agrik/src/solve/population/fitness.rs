//! The fitness of inverse kinematics: weighted distance plus weighted angle, and a share
//! for the way from the start values.

use super::evaluator::Fitness;
use crate::call::Measure;
use crate::chain::Tail;
use crate::kinematics::Workspace;
use crate::lanes::{CHORD2, Real, V3, angle_over_sine, dot, hypotenuse, squared_angles};
use crate::task::{Goal, Rows};

/// How the distance of two orientations is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Orientation {
    /// Length of the rotation vector between them: the angle.
    #[default]
    RotationVector,
    /// Root of the summed squares of the differences of the ZYZ Euler angles, each wrapped
    /// to half a turn: uneven, and singular where the middle angle is 0 or pi. For
    /// comparison with published results.
    EulerZyz,
}

/// Below this sine of the middle angle the outer two turn about one axis.
const GIMBAL: f64 = 1e-9;

/// Cost of a task: `position_weight |dp| + orientation_weight |do| + start_weight |q - q0|`.
#[derive(Debug, Clone)]
pub(super) struct TaskFitness<'a, R> {
    pub measure: Measure,
    pub orientation: Orientation,
    pub position_weight: f64,
    pub orientation_weight: f64,
    pub tail: Tail,
    /// The tool's axes are those of the last joint.
    pub plain_tail: bool,
    pub goal: Goal<R>,
    /// ZYZ angles of the goal, as far as the cost needs them.
    pub target: EulerGoal,
    /// Weight of the way from start values, and these.
    pub start: Option<(f64, &'a [f64])>,
}

/// Cosine and sine of a target's ZYZ angles (alpha, beta, gamma).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EulerGoal {
    pub alpha: (f64, f64),
    pub beta: (f64, f64),
    pub gamma: (f64, f64),
    /// The outer two angles turn about one axis: gamma is zero by agreement.
    pub gimbal: bool,
}

impl EulerGoal {
    fn angles(&self) -> [(f64, f64); 3] {
        [self.alpha, self.beta, self.gamma]
    }

    /// Angles of a frame given by its columns.
    pub fn of(axes: [[f64; 3]; 3]) -> Self {
        let [x, y, z] = axes;
        let sine = hypotenuse(x[2], y[2]);
        let unit = |c: f64, s: f64| {
            let length = hypotenuse(c, s).max(1e-300);
            (c / length, s / length)
        };
        let beta = unit(z[2], sine);
        if sine < GIMBAL {
            let sign = if z[2] < 0.0 { -1.0 } else { 1.0 };
            let alpha = unit(sign * x[0], sign * x[1]);
            return Self { alpha, beta, gamma: (1.0, 0.0), gimbal: true };
        }
        Self { alpha: unit(z[0], z[1]), beta, gamma: unit(-x[2], y[2]), gimbal: false }
    }
}

/// Squared angle in [0, pi] of a direction (c, s) of unit length.
#[inline(always)]
fn squared_angle<R: Real>(c: R, s: R) -> R {
    let s = s.abs();
    let near = s * angle_over_sine(c.abs().min(R::splat(1.0)));
    let far = R::splat(std::f64::consts::PI) - near;
    let angle = R::select(c.lt(R::zero()), far, near);
    angle * angle
}

/// Squared difference of two angles given as directions, which wraps it for nothing.
#[inline(always)]
fn squared_difference<R: Real>((c, s): (R, R), (c0, s0): (f64, f64)) -> R {
    let (c0, s0) = (R::splat(c0), R::splat(s0));
    squared_angle(c.mul_add(c0, s * s0), s.mul_add(c0, -(c * s0)))
}

/// Sum of the squared differences of angles given as directions.
#[inline(always)]
fn summed_squares<R: Real, const N: usize>(got: [(R, R); N], wanted: [(f64, f64); N]) -> R {
    let mut chord2 = [R::zero(); N];
    let mut largest = R::zero();
    for i in 0..N {
        let (c, s) = (got[i].0 - R::splat(wanted[i].0), got[i].1 - R::splat(wanted[i].1));
        chord2[i] = c.mul_add(c, s * s);
        largest = largest.max(chord2[i]);
    }
    let mut squares = squared_angles(chord2);
    let far = R::splat(CHORD2).lt(largest);
    // Mostly a population is near its target.
    if R::bits(far) != 0 {
        for i in 0..N {
            squares[i] = R::select(far, squared_difference(got[i], wanted[i]), squares[i]);
        }
    }
    let mut sum = squares[0];
    for square in &squares[1..] {
        sum += *square;
    }
    sum
}

impl<R: Real> TaskFitness<'_, R> {
    #[inline(always)]
    fn weighted(&self, position2: R, orientation2: R) -> R {
        let position = R::splat(self.position_weight) * position2.sqrt();
        R::splat(self.orientation_weight).mul_add(orientation2.sqrt(), position)
    }

    /// Squared length of the wrapped differences of the ZYZ angles.
    #[inline(always)]
    fn euler2(&self, at: &Workspace<R>) -> R {
        let [x, y, z]: [V3<R>; 3] =
            if self.plain_tail { at.joint_axes() } else { at.tool_axes(&self.tail.rotation) };
        let sine2 = x[2].mul_add(x[2], y[2] * y[2]);
        let sine = sine2.sqrt();
        let inverse = R::splat(1.0) / sine.max(R::splat(1e-300));
        let mut alpha = (z[0] * inverse, z[1] * inverse);
        let mut gamma = (-x[2] * inverse, y[2] * inverse);
        let gimbal = sine.lt(R::splat(GIMBAL));
        if R::bits(gimbal) != 0 {
            let sign = R::select(z[2].lt(R::zero()), R::splat(-1.0), R::splat(1.0));
            alpha.0 = R::select(gimbal, sign * x[0], alpha.0);
            alpha.1 = R::select(gimbal, sign * x[1], alpha.1);
            gamma.0 = R::select(gimbal, R::splat(1.0), gamma.0);
            gamma.1 = R::select(gimbal, R::zero(), gamma.1);
        }
        summed_squares([alpha, (z[2], sine), gamma], self.target.angles())
    }
}

impl<R: Real> Fitness<R> for TaskFitness<'_, R> {
    #[inline(always)]
    fn cost(&self, q: &[R], at: &Workspace<R>) -> R {
        let tool = at.tool_point(self.tail.translation);
        let goal = &self.goal;
        let error = match (&self.measure, self.orientation) {
            (Measure::Position(rows), _) => {
                self.weighted(rows.error(at, tool, goal).position2, R::zero())
            }
            (Measure::Pose(_), Orientation::EulerZyz) => {
                let p = crate::lanes::sub(goal.position, tool);
                self.weighted(dot(p, p), self.euler2(at))
            }
            (Measure::Pose(rows), Orientation::RotationVector) => {
                let e = rows.error(at, tool, goal);
                self.weighted(e.position2, e.orientation2)
            }
            (Measure::Axis(rows), _) => {
                let e = rows.error(at, tool, goal);
                self.weighted(e.position2, e.orientation2)
            }
            (Measure::Framed(rows), _) => {
                let e = rows.error(at, tool, goal);
                self.weighted(e.position2, e.orientation2)
            }
        };
        let Some((weight, start)) = self.start else { return error };
        let mut way2 = R::zero();
        for (x, s) in q.iter().zip(start) {
            let d = *x - R::splat(*s);
            way2 = d.mul_add(d, way2);
        }
        R::splat(weight).mul_add(way2.sqrt(), error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn differences_of_angles_are_wrapped_and_squared() {
        let turn = |angle: f64| (angle.cos(), angle.sin());
        for i in -60..=60 {
            for j in [-3.1, -1.0, 0.0, 0.4, 2.9] {
                for tiny in [0.0, 1e-9, 0.02] {
                    let (got, wanted) = (f64::from(i) * 0.05 + tiny, j);
                    let apart = |a: f64, b: f64| (a - b) - TAU * ((a - b) / TAU).round();
                    let expected = apart(got, wanted).powi(2) + tiny * tiny;
                    let sum =
                        summed_squares([turn(got), turn(0.3 + tiny)], [turn(wanted), turn(0.3)]);
                    let off = (sum.sqrt() - expected.sqrt()).abs();
                    assert!(off < 1e-14, "{got} and {wanted}: off by {off:e}");
                }
            }
        }
        // Half a turn is the farthest there is.
        let half = summed_squares([turn(PI)], [turn(0.0)]);
        assert!((half.sqrt() - PI).abs() < 1e-14);
    }
}
