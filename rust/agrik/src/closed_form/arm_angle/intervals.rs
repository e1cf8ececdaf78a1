//! Arm angles of S-R-S arms: which of them the joint limits allow.
//!
//! The third link's orientation at the arm angle `psi` is `C + A cos(psi) + B sin(psi)`
//! with constant matrices, and so is what is left to the wrist: each triple of joints has its
//! pieces of the turn (see [`crate::closed_form::geometry::pieces`]). The fourth joint does not
//! depend on `psi`.

use std::f64::consts::{PI, TAU};

use crate::call::Request;
use crate::closed_form::branch::group::{Group, Job};
use crate::closed_form::families::ClosedForm;
use crate::closed_form::families::srs::{Elbow, Reached, Srs};
use crate::closed_form::geometry::candidate::MOST_BRANCHES;
use crate::closed_form::geometry::limit::Limit;
use crate::closed_form::geometry::pieces::{
    Interval, Parts, SAME, allows, limit_cuts, pieces, wrap,
};
use crate::closed_form::geometry::turn::{advance, components};
use crate::error::{Error, Result};
use crate::lanes::V3;

/// An elbow that the fourth joint's limits allow, and what it leaves to the others.
pub(crate) struct Bent {
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
pub(crate) fn elbows(arm: &Srs, at: &Reached<f64>, limits: &[Limit]) -> Vec<Bent> {
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
pub(crate) fn corners(arm: &Srs, at: &Reached<f64>, limits: &[Limit]) -> Vec<f64> {
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
pub(crate) fn intervals_of(
    arm: &Srs,
    at: &Reached<f64>,
    limits: &[Limit],
) -> [Vec<Interval>; MOST_BRANCHES] {
    let mut out: [Vec<Interval>; MOST_BRANCHES] = Default::default();
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

/// The arm angles that the limits allow for the first target of a request to an S-R-S
/// chain, one list a branch in the order of [`super::all`].
pub fn intervals(request: &Request<'_>) -> Result<Vec<Vec<Interval>>> {
    let refuse = |why: &str| Error::argument("robot", "an S-R-S arm", why);
    let form = ClosedForm::of(request.chain()).map_err(refuse)?;
    let ClosedForm::Srs(arm) = form else {
        return Err(refuse("an arm that is not redundant"));
    };
    let Some(goal) = request.goal(0) else {
        return Err(Error::argument("target", "finite numbers", "NaN or infinity"));
    };
    let mut group = Group::<f64>::new(Job::new(form, request));
    group.goal = goal;
    group.solve();
    let at = arm.reach(&group.goal, group.job.tool(), &group.near.preferred);
    let found = intervals_of(arm, &at, group.job.limits());
    // A wrist too far away is so at every arm angle.
    let reached = (0..MOST_BRANCHES).map(|b| group.reaches(b));
    Ok(found.into_iter().zip(reached).map(|(all, ok)| if ok { all } else { Vec::new() }).collect())
}
