//! Last steps for branches that lost digits on the way: the roots of a general shoulder,
//! whose equation is of the fourth degree, are only as good as its coefficients.

use super::candidates::{Candidate, JOINTS};
use super::check::{Exact, Limit, wrap_one};
use crate::kinematics::{Workspace, columns, forward};
use crate::lanes::Real;
use crate::solve::{Lengths, Step};
use crate::task::{Goal, PoseRows, Rows};

/// A branch that misses by more than the first and less than the second (m, rad) gets steps:
/// what misses by more is no branch. Where three roots are about to meet, they are known to
/// five digits only.
const FINE: f64 = 1e-10;
const FAR: f64 = 1e-2;
/// Most steps of a branch.
const STEPS: usize = 4;

/// Squared distance and squared chord of a branch that gets a step.
#[inline(always)]
pub fn is_rough<R: Real>(position2: R, chord2: R) -> R::Mask {
    // The chord counts each of three axes, two of which a rotation moves.
    let left = position2.max(R::splat(0.5) * chord2);
    R::and(R::splat(FINE * FINE).lt(left), left.lt(R::splat(FAR * FAR)))
}

/// A branch after its steps.
pub struct Polished {
    /// Joint values along the chain, rad, within limits where that can be.
    pub q: [f64; JOINTS],
    /// They are.
    pub inside: bool,
    /// Squared distance and squared chord left.
    pub position2: f64,
    pub chord2: f64,
}

/// A branch of one target after a few steps, each kept if it brings the branch nearer.
///
/// One target at a time, since few need it: in lanes, every kernel would hold a copy.
#[inline(never)]
pub fn polished(
    exact: &Exact<'_>,
    limits: &[Limit],
    q: [f64; JOINTS],
    goal: &Goal<f64>,
    centre: &[f64; JOINTS],
) -> Polished {
    let checked = |q: [f64; JOINTS]| {
        let mut branch = Candidate { q, ..Candidate::none() };
        let inside = wrap_one(limits, &mut branch, centre) != 0;
        let (position2, chord2) = exact.miss(&branch.q, goal);
        Polished { q: branch.q, inside, position2, chord2 }
    };
    let mut best = checked(q);
    for _ in 0..STEPS {
        if !is_rough(best.position2, best.chord2) {
            break;
        }
        let next = checked(stepped(exact, &best.q, goal));
        if next.position2 + next.chord2 < best.position2 + best.chord2 {
            best = next;
        } else {
            break;
        }
    }
    best
}

/// Joint values after a step towards the goal, Newton's but for a damping that keeps it short
/// where the arm is singular.
fn stepped(exact: &Exact<'_>, q: &[f64; JOINTS], goal: &Goal<f64>) -> [f64; JOINTS] {
    let joints = exact.variables.len();
    let mut ordered = [0.0; JOINTS];
    for (x, variable) in q.iter().zip(exact.variables) {
        ordered[*variable] = *x;
    }
    let mut workspace = Workspace::new(exact.compiled);
    forward(exact.compiled, &ordered[..joints], &mut workspace);
    let tool = workspace.tool_point(exact.tail.translation);
    let rows = PoseRows { scale: 1.0, onward: None };
    let error = rows.error(&workspace, tool, goal);
    let mut jacobian = [[0.0; 6]; JOINTS];
    columns(exact.compiled, &workspace, tool, |variable, linear, angular| {
        jacobian[variable] = rows.column(&workspace, goal, linear, angular);
    });
    let mut change = [0.0; JOINTS];
    let newton = Step::LevenbergMarquardt { damping: 0.1 };
    newton.compute(
        &jacobian[..joints],
        &error.rows,
        &Lengths::new(1.0, false),
        &mut change[..joints],
    );
    let mut out = *q;
    for (x, variable) in out.iter_mut().zip(exact.variables) {
        *x += change[*variable];
    }
    out
}
