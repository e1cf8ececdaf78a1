//! Limits and forward kinematics: what makes a candidate an answer.

use std::f64::consts::TAU;

use crate::call::Tolerance;
use crate::chain::{Compiled, Tail};
use crate::closed_form::geometry::candidate::{Candidate, JOINTS};
use crate::closed_form::geometry::limit::{Limit, SLACK};
use crate::kinematics::Frame;
use crate::lanes::{Lanes, Real, dot, sub};
use crate::task::Goal;

/// Brings joint values within limits by whole turns, each the nearest to its centre that
/// is inside; returns the lanes in which all are.
#[inline(always)]
fn wrap<R: Real>(limits: &[Limit], q: &mut [R], centre: &[R]) -> Lanes {
    let mut inside = R::mask_from_bits(u32::MAX);
    let (turn, slack) = (R::splat(TAU), R::splat(SLACK));
    for ((limit, q), centre) in limits.iter().zip(q).zip(centre) {
        let (lower, upper) = (R::splat(limit.lower), R::splat(limit.upper));
        let turns = ((*centre - *q) * R::splat(1.0 / TAU)).round();
        let x = turns.mul_add(turn, *q);
        // The nearest to the centre may be just outside, and the next one inside.
        let x = R::select((upper + slack).lt(x), x - turn, x);
        let x = R::select(x.lt(lower - slack), x + turn, x);
        let held = x.max(lower).min(upper);
        let near = (x - held).abs().le(slack);
        inside = R::and(inside, near);
        *q = R::select(near, held, x);
    }
    R::bits(inside)
}

/// Takes the joint values of a branch that is outside by whole turns to where they are
/// outside by the least, and says by how much the worst of them is, rad.
pub fn least_outside(limits: &[Limit], q: &mut [f64; JOINTS]) -> f64 {
    let mut worst = 0.0_f64;
    for (x, limit) in q.iter_mut().zip(limits) {
        let outside = |x: f64| (limit.lower - x).max(x - limit.upper).max(0.0);
        if outside(*x) == 0.0 {
            continue;
        }
        let off = *x - limit.middle;
        let other = *x - TAU * (off / TAU).round();
        if outside(other) < outside(*x) {
            *x = other;
        }
        worst = worst.max(outside(*x));
    }
    worst
}

/// Takes joint values inside the limits to the turns nearest to their centres that are inside.
pub fn nearest_turns(limits: &[Limit], q: &mut [f64; JOINTS], centre: &[f64; JOINTS]) {
    for ((x, limit), centre) in q.iter_mut().zip(limits).zip(centre) {
        let mut other = *x + TAU * ((centre - *x) / TAU).round();
        if other < limit.lower {
            other += TAU;
        } else if other > limit.upper {
            other -= TAU;
        }
        // Half a turn on either side is as near.
        let nearer = (other - centre).abs() < (*x - centre).abs() - SLACK;
        if nearer && limit.lower <= other && other <= limit.upper {
            *x = other;
        }
    }
}

/// Brings the joint values of a branch within limits by whole turns; returns the lanes in
/// which all are.
#[inline(always)]
pub fn wrap_one<R: Real>(limits: &[Limit], one: &mut Candidate<R>, centre: &[R; JOINTS]) -> Lanes {
    wrap(limits, &mut one.q, centre)
}

/// A branch that misses by less (m, rad) is exact, but for rounding.
const EXACT: f64 = 1e-9;

/// Of the branches of one target (a bit each) those that are branches: one that is only within
/// the tolerances, as where the arm is a little too short, is none beside an exact one, unless
/// it alone is inside the limits.
#[inline(always)]
pub fn without_rough(reached: Lanes, inside: Lanes, exact: Lanes) -> Lanes {
    let exact = exact & reached;
    if exact == 0 {
        reached
    } else if exact & inside != 0 {
        exact
    } else {
        exact | reached & inside
    }
}

/// Lanes in which what is left is nothing but rounding.
#[inline(always)]
pub fn is_exact<R: Real>(position2: R, chord2: R) -> Lanes {
    R::bits((position2 + chord2).le(R::splat(EXACT * EXACT)))
}

/// Two branches that differ in the last three joints alone.
pub type Pair<R> = [Candidate<R>; 2];

/// Brings the joint values of a pair of branches within limits by whole turns; returns, for
/// each, the lanes in which all are.
#[inline(always)]
pub fn wrap_pair<R: Real>(
    limits: &[Limit],
    [one, two]: &mut Pair<R>,
    centre: &[R; JOINTS],
) -> [Lanes; 2] {
    let shared = limits.len() - 3;
    let ahead = wrap(&limits[..shared], &mut one.q[..shared], centre);
    two.q[..shared].copy_from_slice(&one.q[..shared]);
    // No closure for both: it would not be compiled for the lanes' instructions.
    let (limits, centre) = (&limits[shared..], &centre[shared..]);
    let first = wrap(limits, &mut one.q[shared..], centre);
    let second = wrap(limits, &mut two.q[shared..], centre);
    [ahead & first, ahead & second]
}

/// The chain as it was given, and how near is near enough.
#[derive(Clone, Copy)]
pub struct Exact<'a> {
    pub compiled: &'a Compiled,
    /// Which entry of `q` each joint along the chain is.
    pub variables: &'a [usize],
    pub tail: Tail,
    /// What no solution is beyond.
    pub tolerance: Tolerance,
    /// The whole errors that branches may have, which hold for each axis.
    pub inner: Tolerance,
    position2: f64,
    chord2: f64,
}

impl<'a> Exact<'a> {
    /// A chain with a tool.
    pub fn new(
        compiled: &'a Compiled,
        variables: &'a [usize],
        tail: Tail,
        tolerance: Tolerance,
    ) -> Self {
        let inner = tolerance.inner();
        Self {
            compiled,
            variables,
            tail,
            tolerance,
            inner,
            position2: inner.position * inner.position,
            // A rotation by x moves the three unit axes by 2 sin(x / 2) sqrt(2) in all.
            chord2: 8.0 * (0.5 * inner.orientation.min(3.0)).sin().powi(2),
        }
    }

    /// Squared distance (m^2) and squared chord between the axes that are left to a goal,
    /// for each branch of a pair.
    #[inline(always)]
    pub fn miss_pair<R: Real>(&self, pair: &Pair<R>, goal: &Goal<R>) -> [(R, R); 2] {
        let (joints, shared) = (self.variables.len(), self.variables.len() - 3);
        let mut ordered = [R::zero(); JOINTS];
        for (x, variable) in pair[0].q.iter().zip(self.variables) {
            ordered[*variable] = *x;
        }
        let start = Frame::start(self.compiled).after(self.compiled, 0..shared, &ordered);
        let one = start.after(self.compiled, shared..joints, &ordered);
        for (x, variable) in pair[1].q.iter().zip(self.variables).skip(shared) {
            ordered[*variable] = *x;
        }
        let two = start.after(self.compiled, shared..joints, &ordered);
        [self.left(&one, goal), self.left(&two, goal)]
    }

    /// The same for one branch.
    #[inline(always)]
    pub fn miss<R: Real>(&self, q: &[R; JOINTS], goal: &Goal<R>) -> (R, R) {
        let mut ordered = [R::zero(); JOINTS];
        for (x, variable) in q.iter().zip(self.variables) {
            ordered[*variable] = *x;
        }
        let all = 0..self.variables.len();
        self.left(&Frame::start(self.compiled).after(self.compiled, all, &ordered), goal)
    }

    #[inline(always)]
    fn left<R: Real>(&self, frame: &Frame<R>, goal: &Goal<R>) -> (R, R) {
        let mut chord2 = R::zero();
        for (axis, wanted) in frame.axes().iter().zip(&goal.axes) {
            let d = sub(*axis, *wanted);
            chord2 += dot(d, d);
        }
        let d = sub(frame.point(self.tail.translation), goal.position);
        (dot(d, d), chord2)
    }

    /// Lanes in which what is left is within the tolerances.
    #[inline(always)]
    pub fn is_near<R: Real>(&self, position2: R, chord2: R) -> Lanes {
        R::bits(R::and(position2.le(R::splat(self.position2)), chord2.le(R::splat(self.chord2))))
    }
}
