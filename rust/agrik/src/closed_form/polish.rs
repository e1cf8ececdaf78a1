//! Last steps for branches that lost digits on the way: the roots of a general shoulder,
//! whose equation is of the fourth degree, are only as good as its coefficients.

use super::candidates::{Candidate, JOINTS};
use super::check::Exact;
use crate::kinematics::{Workspace, columns, forward};
use crate::lanes::Real;
use crate::solve::Step;
use crate::task::{Goal, PoseRows, Rows};

/// A branch that misses by more than the first and less than the second (m, rad) gets steps:
/// what misses by more is no branch. Where three roots are about to meet, they are known to
/// five digits only.
const FINE: f64 = 1e-10;
const FAR: f64 = 1e-2;
/// Most steps of a branch.
pub const STEPS: usize = 4;

/// Squared distance and squared chord of a branch that gets a step.
#[inline(always)]
pub fn is_rough<R: Real>(position2: R, chord2: R) -> R::Mask {
    // The chord counts each of three axes, two of which a rotation moves.
    let left = position2.max(R::splat(0.5) * chord2);
    R::and(R::splat(FINE * FINE).lt(left), left.lt(R::splat(FAR * FAR)))
}

/// Joint values after a step towards the goal, Newton's but for a damping that keeps it short
/// where the arm is singular.
#[inline(always)]
pub fn stepped<R: Real>(exact: &Exact<'_>, branch: &Candidate<R>, goal: &Goal<R>) -> [R; JOINTS] {
    let joints = exact.variables.len();
    let mut q = [R::zero(); JOINTS];
    for (x, variable) in branch.q.iter().zip(exact.variables) {
        q[*variable] = *x;
    }
    let mut workspace = Workspace::new(exact.compiled);
    forward(exact.compiled, &q[..joints], &mut workspace);
    let tool = workspace.tool_point(exact.tail.translation);
    let rows = PoseRows { scale: 1.0 };
    let error = rows.error(&workspace, tool, goal);
    let mut jacobian = [[R::zero(); 6]; JOINTS];
    columns(exact.compiled, &workspace, tool, |variable, linear, angular| {
        jacobian[variable] = rows.column(&workspace, goal, linear, angular);
    });
    let mut change = [R::zero(); JOINTS];
    let newton = Step::LevenbergMarquardt { damping: 0.1 };
    newton.compute(&jacobian[..joints], &error.rows, &mut change[..joints]);
    let mut out = branch.q;
    for (x, variable) in out.iter_mut().zip(exact.variables) {
        *x += change[*variable];
    }
    out
}
