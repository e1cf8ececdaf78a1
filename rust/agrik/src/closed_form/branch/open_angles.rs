//! Singular branches whose open angles are chosen inside the limits.
//!
//! Where the first and the last axis of a wrist are in line, its first and last joint may
//! share their turn in any way; where the wrist's centre is on the first or the second axis, that
//! joint may stand at any value and the wrist turns back. The closed forms take the value that is
//! preferred. Where that puts another joint outside its limits, the value nearest to it that
//! does not is found here, one target at a time, since few need it.

use std::f64::consts::TAU;

use super::check::{least_outside, nearest_turns, wrap_one};
use super::group::Job;
use super::polish::Polished;
use crate::closed_form::families::{ClosedForm, SphericalWrist};
use crate::closed_form::geometry::candidate::{Candidate, JOINTS, value};
use crate::closed_form::geometry::limit::Limit;
use crate::closed_form::geometry::pieces::{Parts, limit_cuts, pieces};
use crate::closed_form::geometry::turn::{Meeting, Side, advance, components, identity};
use crate::lanes::{V3, hypotenuse};
use crate::task::Goal;

/// Whole turns to either side that are tried.
const TURNS: i32 = 3;
/// What rounding may do to a joint value of a singular branch, rad.
const ROUNDING: f64 = 1e-7;
/// Below this sine axes are nearly in line.
const NEARLY: f64 = 1e-4;
/// Most values of a free first joint that are tried.
const MOST: usize = 16;

/// A singular branch of a target.
pub(super) struct Open<'b> {
    /// Joint values along the chain, rad.
    pub q: [f64; JOINTS],
    /// Shoulder, elbow and wrist: which are singular.
    pub singular: [bool; 3],
    /// Which way the wrist is turned: 0 or 1.
    pub way: usize,
    /// What the joints stay near, along the chain, rad.
    pub centre: &'b [f64; JOINTS],
}

/// The branch with its open angles inside the limits; `None` where there is none within the
/// tolerances.
#[inline(never)]
pub(super) fn inside(job: &Job<'_>, goal: &Goal<f64>, open: &Open<'_>) -> Option<Polished> {
    let [shoulder, _, wrist] = open.singular;
    match job.form {
        ClosedForm::SphericalWrist(arm) => {
            let split =
                || passed(job, goal, shared(job, arm.wrist(), 3, open.q, open.centre), open.centre);
            let found = if wrist { split() } else { None };
            if found.is_some() {
                return found;
            }
            let on_second = {
                let third = open.q[2] + job.geometry.offset(2) + arm.shoulder().phase_angle();
                let [x, y, _] = arm.shoulder().seen_from_second(third.sin_cos());
                hypotenuse(x, y) < job.geometry.tolerance
            };
            let first = if shoulder { turned(arm, job, goal, open, 0) } else { None };
            first.or_else(|| if on_second { turned(arm, job, goal, open, 1) } else { None })
        }
        ClosedForm::Srs(arm) => {
            let (one, two) = arm.meetings();
            let mut q = open.q;
            if shoulder {
                q = shared(job, one, 0, q, open.centre);
            }
            if wrist {
                q = shared(job, two, 4, q, open.centre);
            }
            passed(job, goal, q, open.centre)
        }
    }
}

/// Joint values in which joints whose axes are in line, or nearly, share their turns so that
/// they are inside the limits, if there are such joints and they can.
pub(crate) fn split(
    job: &Job<'_>,
    q: &[f64; JOINTS],
    centre: &[f64; JOINTS],
) -> Option<[f64; JOINTS]> {
    let firsts: &[usize] = match job.form {
        ClosedForm::SphericalWrist(_) => &[3],
        // A stretched elbow has the third and the fifth in line.
        ClosedForm::Srs(_) => &[0, 2, 4],
    };
    let mut out = *q;
    let mut any = false;
    for &first in firsts {
        let links = &job.geometry.links;
        let meeting = Meeting { one: links[first], two: links[first + 1] };
        let second = q[first + 1] + job.geometry.offset(first + 1);
        if second.sin().abs() < NEARLY {
            out = shared(job, &meeting, first, out, centre);
            any = true;
        }
    }
    any.then_some(out)
}

/// The joint values, if they are inside the limits, but for rounding, and within the
/// tolerances.
fn passed(
    job: &Job<'_>,
    goal: &Goal<f64>,
    mut q: [f64; JOINTS],
    centre: &[f64; JOINTS],
) -> Option<Polished> {
    if least_outside(job.limits(), &mut q) > ROUNDING {
        return None;
    }
    for (x, limit) in q.iter_mut().zip(job.limits()) {
        *x = x.clamp(limit.lower, limit.upper);
    }
    nearest_turns(job.limits(), &mut q, centre);
    let (position2, chord2) = job.exact.miss(&q, goal);
    let reached = job.exact.is_near(position2, chord2) & 1 != 0;
    reached.then_some(Polished { q, inside: true, position2, chord2 })
}

/// Joint values in which joint `first` and the next but one, whose axes are in line, share
/// their turn so that both are inside the limits, the former as near to its centre as can be;
/// where they cannot be, outside as little as can be, and then held.
fn shared(
    job: &Job<'_>,
    meeting: &Meeting,
    first: usize,
    mut q: [f64; JOINTS],
    centre: &[f64; JOINTS],
) -> [f64; JOINTS] {
    let last = first + 2;
    let (one, three) = (job.limits()[first], job.limits()[last]);
    let second = q[first + 1] + job.geometry.offset(first + 1);
    let along = meeting.one.cosine * meeting.two.cosine
        - meeting.one.sine * meeting.two.sine * second.cos();
    // Axes that point the same way share a sum, opposite ones a difference.
    let sign: f64 = if along > 0.0 { 1.0 } else { -1.0 };
    let sum = sign.mul_add(q[last], q[first]);
    let near = centre[first];
    let turns = ((centre[last] - sign * (sum - near)) / TAU).round();
    let mut best = (f64::INFINITY, q[first], q[last]);
    for more in -TURNS..=TURNS {
        let whole = TAU * (turns + f64::from(more));
        // Values of the first at which the last is at its limits.
        let at = |limit: f64| sum - sign * (limit - whole);
        let (a, b) = (at(three.lower), at(three.upper));
        let (low, high) = (a.min(b).max(one.lower), a.max(b).min(one.upper));
        let gap = (low - high).max(0.0);
        let x = if gap > 0.0 { 0.5 * (low + high) } else { near.clamp(low, high) };
        let cost = 1e9f64.mul_add(gap, (x - near).abs());
        if cost < best.0 {
            best = (cost, x, sign.mul_add(sum - x, whole));
        }
    }
    q[first] = best.1.clamp(one.lower, one.upper);
    q[last] = best.2.clamp(three.lower, three.upper);
    q
}

/// A branch with another turn of one of the first two joints, on whose axis the wrist's centre
/// is.
fn turned(
    arm: &SphericalWrist,
    job: &Job<'_>,
    goal: &Goal<f64>,
    open: &Open<'_>,
    joint: usize,
) -> Option<Polished> {
    let g = job.geometry;
    let turn = |j: usize| (open.q[j] + g.offset(j)).sin_cos();
    let mut before = identity::<f64>();
    for j in 0..joint {
        before = advance(before, turn(j), &g.links[j]);
    }
    let wanted = goal.axes.map(|axis| components(before, components(g.axes, axis)));
    let mut after = advance(identity::<f64>(), (0.0, 1.0), &g.links[joint]);
    for j in joint + 1..3 {
        after = advance(after, turn(j), &g.links[j]);
    }
    // What is left to the wrist: constant, cosine and sine part in the turn.
    let part = |p: usize, [x, y, z]: V3<f64>| {
        components(after, [[0.0, 0.0, z], [x, y, 0.0], [y, -x, 0.0]][p])
    };
    let parts: Parts = [0, 1, 2].map(|p| wanted.map(|axis| part(p, axis)));
    let behind = [3, 4, 5].map(|j| (g.limits[j], g.offset(j)));
    let mut spans: Vec<(f64, f64)> = pieces(arm.wrist(), &parts, open.way, &behind)
        .iter()
        .map(|piece| (piece.lower, piece.upper))
        .collect();
    let mut cuts = Vec::with_capacity(12);
    limit_cuts(arm.wrist(), &parts, &behind, &mut cuts);
    spans.extend(cuts.into_iter().map(|cut| (cut, cut)));
    let (limit, near, offset) = (g.limits[joint], open.centre[joint], g.offset(joint));
    let mut values: Vec<f64> = spans
        .into_iter()
        .filter_map(|(lower, upper)| nearest(lower - offset, upper - offset, &limit, near))
        .collect();
    values.sort_by(|a, b| (a - near).abs().total_cmp(&(b - near).abs()));
    let side = Side::both()[open.way];
    let preferred = (open.centre[3] + g.offset(3)).sin_cos();
    values.into_iter().take(MOST).find_map(|x| {
        let (s, c) = (x + offset).sin_cos();
        let [constant, cosine, sine] = &parts;
        let at = |k: usize| [0, 1, 2].map(|i| constant[k][i] + c * cosine[k][i] + s * sine[k][i]);
        let wrist = arm.wrist().solve(at(0), at(2), preferred, side);
        let mut q = open.q;
        q[joint] = x;
        for (j, turn) in [3, 4, 5].into_iter().zip(wrist.turns) {
            q[j] = value(turn, g.offset(j));
        }
        let mut branch = Candidate { q, ..Candidate::none() };
        if wrap_one(&g.limits, &mut branch, open.centre) == 0 && wrist.singular != 0 {
            branch.q = shared(job, arm.wrist(), 3, branch.q, open.centre);
        }
        passed(job, goal, branch.q, open.centre)
    })
}

/// The value nearest to a centre that is inside the limits and, but for whole turns, between
/// two others.
fn nearest(lower: f64, upper: f64, limit: &Limit, centre: f64) -> Option<f64> {
    let turns = ((centre - lower) / TAU).floor();
    let mut best: Option<f64> = None;
    for more in -TURNS..=TURNS {
        let whole = TAU * (turns + f64::from(more));
        let (low, high) = ((lower + whole).max(limit.lower), (upper + whole).min(limit.upper));
        if low <= high {
            let x = centre.clamp(low, high);
            if best.is_none_or(|b| (x - centre).abs() < (b - centre).abs()) {
                best = Some(x);
            }
        }
    }
    best
}
