//! Last steps for branches that lost digits on the way: the roots of a general shoulder,
//! whose equation is of the fourth degree, are only as good as its coefficients.

use super::check::{Exact, nearest_turns, wrap_one};
use crate::closed_form::geometry::candidate::{Candidate, JOINTS};
use crate::closed_form::geometry::limit::Limit;
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
/// Joint values that are held inside the limits may begin so far from the goal (m, rad).
const FARTHEST: f64 = 0.2;
/// Share of half the squared error in a step's damping.
const DAMPING: f64 = 0.1;

/// Squared distance and squared chord of a branch that gets a step.
#[inline(always)]
pub fn is_rough<R: Real>(position2: R, chord2: R) -> R::Mask {
    // The chord counts each of three axes, two of which a rotation moves.
    let left = position2.max(R::splat(0.5) * chord2);
    R::and(R::splat(FINE * FINE).lt(left), left.lt(R::splat(FAR * FAR)))
}

/// A branch after its steps.
#[derive(Debug, Clone, Copy)]
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
    mut best: Polished,
    goal: &Goal<f64>,
    centre: &[f64; JOINTS],
) -> Polished {
    let checked = |q: [f64; JOINTS]| {
        let mut branch = Candidate { q, ..Candidate::none() };
        let inside = wrap_one(limits, &mut branch, centre) != 0;
        let (position2, chord2) = exact.miss(&branch.q, goal);
        Polished { q: branch.q, inside, position2, chord2 }
    };
    for _ in 0..STEPS {
        if !is_rough(best.position2, best.chord2) {
            break;
        }
        let next = checked(stepped(exact, None, DAMPING, &best.q, goal));
        if next.position2 + next.chord2 < best.position2 + best.chord2 {
            best = next;
        } else {
            break;
        }
    }
    best
}

/// Joint values inside the limits after steps, in which joints at a limit that would leave it
/// stand still, at the turns nearest to a centre; `None` where they are not within the tolerances
/// then.
#[inline(never)]
pub fn held(
    exact: &Exact<'_>,
    limits: &[Limit],
    q: [f64; JOINTS],
    (goal, centre): (&Goal<f64>, &[f64; JOINTS]),
    steps: usize,
) -> Option<Polished> {
    let checked = |mut q: [f64; JOINTS]| {
        for (x, limit) in q.iter_mut().zip(limits) {
            *x = x.clamp(limit.lower, limit.upper);
        }
        let (position2, chord2) = exact.miss(&q, goal);
        Polished { q, inside: true, position2, chord2 }
    };
    let reached = |at: &Polished| exact.is_near(at.position2, at.chord2) & 1 != 0;
    let mut best = checked(q);
    let mut damping = DAMPING;
    for _ in 0..steps {
        // Within the tolerances is enough, but a few digits more cost little.
        if reached(&best) && !is_rough(best.position2, best.chord2) {
            break;
        }
        if best.position2 + best.chord2 > FARTHEST * FARTHEST {
            return None;
        }
        let next = checked(stepped(exact, Some(limits), damping, &best.q, goal));
        let (before, after) = (best.position2 + best.chord2, next.position2 + next.chord2);
        if after < before {
            best = next;
            damping = (0.1 * damping).max(DAMPING);
            // Creeping: no solution here.
            if after > 0.98 * before {
                damping *= 100.0;
            }
        } else {
            damping *= 100.0;
        }
        if damping > 1e9 {
            break;
        }
    }
    if !reached(&best) {
        return None;
    }
    let mut turned = best.q;
    nearest_turns(limits, &mut turned, centre);
    let turned = checked(turned);
    Some(if reached(&turned) { turned } else { best })
}

/// Joint values after a step towards the goal, Newton's but for a damping that keeps it short
/// where the arm is singular. With `held` limits joints stand still that would leave them.
fn stepped(
    exact: &Exact<'_>,
    held: Option<&[Limit]>,
    damping: f64,
    q: &[f64; JOINTS],
    goal: &Goal<f64>,
) -> [f64; JOINTS] {
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
        jacobian[variable] = rows.column(&(), goal, linear, angular);
    });
    for (limit, variable) in held.into_iter().flatten().zip(exact.variables) {
        let (x, column) = (ordered[*variable], &mut jacobian[*variable]);
        let downhill: f64 = column.iter().zip(&error.rows).map(|(a, b)| a * b).sum();
        if x <= limit.lower && downhill < 0.0 || x >= limit.upper && downhill > 0.0 {
            *column = [0.0; 6];
        }
    }
    let mut change = [0.0; JOINTS];
    let newton = Step::LevenbergMarquardt { damping };
    let lengths = Lengths::new(1.0, false);
    newton.compute(&jacobian[..joints], &error.rows, &lengths, &mut change[..joints]);
    let mut out = *q;
    for (x, variable) in out.iter_mut().zip(exact.variables) {
        *x += change[*variable];
    }
    out
}
