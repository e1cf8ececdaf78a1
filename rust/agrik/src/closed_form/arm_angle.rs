//! Arm angles of S-R-S arms: which of them the joint limits allow.
//!
//! The third link's orientation at the arm angle `psi` is `C + A cos(psi) + B sin(psi)`
//! with constant matrices, and so is what is left to the wrist. A joint of three whose
//! axes meet stands at a given value where one product of an axis with such a matrix has
//! a given size: an equation `k0 + k1 cos(psi) + k2 sin(psi) = 0` with at most two roots.
//! Between neighbouring roots of all limits of all joints nothing crosses a limit, so one
//! look at the middle of each piece settles it. The fourth joint does not depend on `psi`.

use std::f64::consts::{PI, TAU};

use super::check::{Limit, SLACK};
use super::settle::{Group, Job};
use super::srs::{Elbow, Reached, Srs};
use super::turn::{Meeting, Side, advance, components};
use super::{BRANCHES, ClosedForm};
use crate::chain::{Chain, Tail};
use crate::error::{Error, Result};
use crate::lanes::{V3, atan2, hypotenuse};
use crate::solve::Tolerance;
use crate::task::pose_goal;

/// Roots that neighbour one another by less are one, rad.
const SAME: f64 = 1e-12;
/// An equation that misses zero by less just touches it.
const TOUCHING: f64 = 1e-9;

/// A closed interval of arm angles, rad, `lower` in [-pi, pi), at most a turn long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// First arm angle.
    pub lower: f64,
    /// Last arm angle; above pi where the interval goes through half a turn.
    pub upper: f64,
}

/// A matrix (columns) for each of the constant, cosine and sine parts.
pub(super) type Parts = [[V3<f64>; 3]; 3];

/// An elbow that the fourth joint's limits allow, and what it leaves to the others.
pub(super) struct Bent {
    /// Which of the two.
    pub elbow: usize,
    /// The fourth joint's value, rad.
    pub fourth: f64,
    /// The rotation that the first three joints have to bring about.
    pub shoulder: Parts,
    /// The same of the last three.
    pub wrist: Parts,
}

/// The elbows that the fourth joint's limits allow.
pub(super) fn elbows(arm: &Srs, at: &Reached<f64>, limits: &[Limit]) -> Vec<Bent> {
    let mut out = Vec::with_capacity(2);
    for (i, elbow) in at.elbows.iter().enumerate() {
        if elbow.merged == 0 && allows(&limits[3], elbow.fourth) {
            out.push(bent(arm, at, i));
        }
    }
    out
}

/// One elbow, whatever the limits.
fn bent(arm: &Srs, at: &Reached<f64>, i: usize) -> Bent {
    let elbow = &at.elbows[i];
    let shoulder = third_link_parts(at, elbow);
    let wrist = shoulder.map(|m| left_parts(arm, at, elbow, m));
    Bent { elbow: i, fourth: elbow.fourth, shoulder, wrist }
}

/// Arm angles at which some joint is at a limit, or axes are as near to being in line as they
/// come: where all that the limits allow may be a single arm angle, it is one of these.
pub(super) fn corners(arm: &Srs, at: &Reached<f64>, limits: &[Limit]) -> Vec<f64> {
    let joints = |first: usize| [0, 1, 2].map(|j| (limits[first + j], arm.offset(first + j)));
    let (one, two) = arm.meetings();
    let mut out = Vec::with_capacity(64);
    for i in 0..2 {
        let bent = bent(arm, at, i);
        for (meeting, parts, first) in [(one, &bent.shoulder, 0), (two, &bent.wrist, 4)] {
            limit_cuts(meeting, parts, &joints(first), &mut out);
            let top = parts[2][2][2].atan2(parts[1][2][2]);
            out.extend([wrap(top), wrap(top + PI)]);
        }
    }
    out
}

/// The arm angles that the limits allow, for each branch.
pub(super) fn intervals_of(
    arm: &Srs,
    at: &Reached<f64>,
    limits: &[Limit],
) -> [Vec<Interval>; BRANCHES] {
    let mut out: [Vec<Interval>; BRANCHES] = Default::default();
    let joints = |first: usize| [0, 1, 2].map(|j| (limits[first + j], arm.offset(first + j)));
    let (one, two) = arm.meetings();
    for bent in elbows(arm, at, limits) {
        let last = [0, 1].map(|j| pieces(two, &bent.wrist, j, &joints(4)));
        for i in 0..2 {
            let first = pieces(one, &bent.shoulder, i, &joints(0));
            for (j, last) in last.iter().enumerate() {
                out[4 * bent.elbow + 2 * i + j] = common(&first, last);
            }
        }
    }
    out
}

/// The third link's orientation as constant, cosine and sine parts.
fn third_link_parts(at: &Reached<f64>, elbow: &Elbow<f64>) -> Parts {
    let [to, zero, across] = at.line.frame;
    let [f0, f1, f2] = elbow.frame;
    let outer = |a: V3<f64>, f: V3<f64>, b: V3<f64>, g: V3<f64>| {
        [0, 1, 2].map(|k| [0, 1, 2].map(|i| a[i] * f[k] + b[i] * g[k]))
    };
    let none = [0.0; 3];
    [
        outer(to, f0, none, none),
        outer(zero, f1, across, f2),
        outer(across, f1, zero, f2.map(|x| -x)),
    ]
}

/// What is left to the wrist where the third link stands as `third`, as columns.
fn left_parts(
    arm: &Srs,
    at: &Reached<f64>,
    elbow: &Elbow<f64>,
    third: [V3<f64>; 3],
) -> [V3<f64>; 3] {
    let links = &arm.geometry().links;
    let fourth = advance(third, (0.0, 1.0), &links[2]);
    let fifth = advance(fourth, elbow.turn, &links[3]);
    [
        components(fifth, at.line.wanted[0]),
        components(fifth, at.line.wanted[1]),
        components(fifth, at.line.wanted[2]),
    ]
}

/// The pieces of the turn in which three joints keep within their limits on one of their
/// two branches; each limit comes with the offset of its joint.
pub(super) fn pieces(
    meeting: &Meeting,
    parts: &Parts,
    branch: usize,
    limits: &[(Limit, f64); 3],
) -> Vec<Interval> {
    let (s1, c1) = (meeting.one.sine, meeting.one.cosine);
    let (s2, c2) = (meeting.two.sine, meeting.two.cosine);
    let mut cuts = Vec::with_capacity(16);
    limit_cuts(meeting, parts, limits, &mut cuts);
    // The branches trade places where first and third axis are in line.
    for wanted in [c1 * c2 - s1 * s2, c1 * c2 + s1 * s2] {
        let [k0, k1, k2] = [0, 1, 2].map(|p| parts[p][2][2]);
        let size = hypotenuse(k1, k2);
        let off = (k0 - wanted).abs() - size;
        if off.abs() < 1e-9 {
            let top = k2.atan2(k1);
            cuts.push(wrap(if k0 < wanted { top } else { top + PI }));
        }
    }
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|a, b| (*a - *b).abs() < SAME);
    let inside = |psi: f64| {
        let (s, c) = psi.sin_cos();
        let column =
            |k: usize| [0, 1, 2].map(|i| parts[0][k][i] + c * parts[1][k][i] + s * parts[2][k][i]);
        let side = Side::both()[branch];
        let found = meeting.solve(column(0), column(2), (0.0, 1.0), side);
        found
            .turns
            .iter()
            .zip(limits)
            .all(|(turn, (limit, offset))| allows(limit, atan2(turn.0, turn.1) - offset))
    };
    let Some(&start) = cuts.first() else {
        let whole = Interval { lower: -PI, upper: PI };
        return if inside(0.3) { vec![whole] } else { Vec::new() };
    };
    let mut out: Vec<Interval> = Vec::new();
    for (i, &lower) in cuts.iter().enumerate() {
        let upper = cuts.get(i + 1).copied().unwrap_or(start + TAU);
        if inside(0.5 * (lower + upper)) {
            match out.last_mut() {
                Some(before) if before.upper == lower => before.upper = upper,
                _ => out.push(Interval { lower, upper }),
            }
        }
    }
    // The last piece goes over into the first.
    if out.len() > 1
        && let (Some(first), Some(last)) = (out.first().copied(), out.last_mut())
        && first.lower + TAU == last.upper
    {
        last.upper = first.upper + TAU;
        out.remove(0);
    }
    out
}

/// Where one of three joints is at a limit, on either branch; limits as for [`pieces`].
pub(super) fn limit_cuts(
    meeting: &Meeting,
    parts: &Parts,
    limits: &[(Limit, f64); 3],
    cuts: &mut Vec<f64>,
) {
    let (s1, c1) = (meeting.one.sine, meeting.one.cosine);
    let (s2, c2) = (meeting.two.sine, meeting.two.cosine);
    for (j, (limit, offset)) in limits.iter().enumerate() {
        if 2.0 * limit.half >= TAU {
            continue;
        }
        for value in [limit.lower, limit.upper] {
            let (s, c) = (value + offset).sin_cos();
            // m[column][row]
            let product = |m: &[V3<f64>; 3]| match j {
                0 => -s1 * (c * m[2][1] - s * m[2][0]) + c1 * m[2][2],
                1 => m[2][2],
                _ => s2 * (s * m[0][2] + c * m[1][2]) + c2 * m[2][2],
            };
            let wanted = [c2, c1 * c2 - s1 * s2 * c, c1][j];
            roots(product(&parts[0]) - wanted, product(&parts[1]), product(&parts[2]), cuts);
        }
    }
}

/// Roots of `k0 + k1 cos + k2 sin`, also those that rounding has parted from the real ones.
fn roots(k0: f64, k1: f64, k2: f64, out: &mut Vec<f64>) {
    let size = hypotenuse(k1, k2);
    if size > TOUCHING && k0.abs() < size + TOUCHING {
        let (top, half) = (k2.atan2(k1), (-k0 / size).clamp(-1.0, 1.0).acos());
        out.push(wrap(top + half));
        out.push(wrap(top - half));
    }
}

pub(super) fn wrap(angle: f64) -> f64 {
    let x = angle - TAU * (angle / TAU).round();
    if x >= PI { x - TAU } else { x }
}

/// Some whole number of turns brings the value inside the limits.
fn allows(limit: &Limit, value: f64) -> bool {
    if !limit.half.is_finite() {
        return true;
    }
    let off = value - limit.middle;
    (off - TAU * (off / TAU).round()).abs() <= limit.half + SLACK
}

/// What two sets of pieces have in common.
fn common(a: &[Interval], b: &[Interval]) -> Vec<Interval> {
    let mut out: Vec<Interval> = Vec::new();
    for x in a {
        for y in b {
            for shift in [-TAU, 0.0, TAU] {
                let lower = x.lower.max(y.lower + shift);
                let upper = x.upper.min(y.upper + shift);
                // Two whole turns have just one in common.
                let seen = |o: &Interval| (o.lower - lower).rem_euclid(TAU) < SAME;
                if lower < upper && !out.iter().any(seen) {
                    out.push(Interval { lower, upper });
                }
            }
        }
    }
    for interval in &mut out {
        let turns = ((interval.lower + PI) / TAU).floor() * TAU;
        interval.lower -= turns;
        interval.upper -= turns;
    }
    out.sort_by(|x, y| x.lower.total_cmp(&y.lower));
    out
}

/// The arm angles that the limits allow for a pose (4x4, row by row) of an S-R-S chain
/// with its own tool, one list a branch in the order of [`super::all`].
pub fn intervals(
    chain: &Chain,
    pose: &[f64; 16],
    tail: Option<Tail>,
) -> Result<Vec<Vec<Interval>>> {
    let refuse = |why: &str| Error::argument("robot", "an S-R-S arm", why);
    let form = ClosedForm::of(chain).map_err(refuse)?;
    let ClosedForm::Srs(arm) = form else {
        return Err(refuse("an arm that is not redundant"));
    };
    let tail = tail.unwrap_or(chain.compiled().tail);
    let position = [pose[3], pose[7], pose[11]];
    let rotation = [0, 1, 2].map(|j| [pose[j], pose[4 + j], pose[8 + j]]);
    let mut group = Group::<f64>::new(Job::new(chain, form, tail, Tolerance::default()));
    group.goal = pose_goal(position, rotation, &tail);
    group.solve();
    let at = arm.reach(&group.goal, group.job.tool(), &group.near.preferred);
    let found = intervals_of(arm, &at, group.job.limits());
    // A wrist too far away is so at every arm angle.
    let reached = (0..BRANCHES).map(|b| group.reaches(b));
    Ok(found.into_iter().zip(reached).map(|(all, ok)| if ok { all } else { Vec::new() }).collect())
}
