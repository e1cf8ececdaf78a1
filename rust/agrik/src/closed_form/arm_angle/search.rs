//! The best arm angle of S-R-S arms: a quick look round for every lane, then, where it is
//! asked for, the proof (see [`super::certify`]) one target at a time.
//!
//! Elbow, shoulder and wrist each have two ways, and what one costs does not depend on the
//! others: at an arm angle the best of the eight branches is the best way of each. After a
//! rough look at arm angles all round, the best branch is followed to the least of a model
//! of its joints (values, rates and second derivatives) in a range that shrinks as the
//! model gets better.

use std::f64::consts::{PI, TAU};

use super::intervals::{elbows, intervals_of};
use super::proof::{self, Best};
use super::sweep::{Moving, Sweep, Weight, cost_of_one, joined};
use crate::closed_form::branch::choice::Choice;
use crate::closed_form::branch::group::Group;
use crate::closed_form::families::srs::{Elbow, Line, Reached, Srs};
use crate::closed_form::geometry::candidate::{JOINTS, MOST_BRANCHES};
use crate::closed_form::geometry::limit::SLACK;
use crate::closed_form::geometry::turn::{Side, Turn, minus};
use crate::lanes::{Lanes, Real, atan2};

/// Arm angles of the first look at each target.
const SAMPLES: usize = 12;
/// The same before a proof where the first look has found none.
const PROOF_SAMPLES: usize = 8;
/// Closer looks: how far from the best arm angle so far the next may be (rad), how many
/// sections narrow its place, and how far from a limit it keeps, as the model is not exact.
const LOOKS: [(f64, usize, f64); 3] = [(0.45, 6, 1e-3), (0.1, 8, 1e-5), (0.005, 13, 1e-9)];

/// What was found for the lanes of a group.
pub(crate) struct Found<R> {
    /// Lanes whose best branch is known.
    pub known: Lanes,
    /// That branch's line, elbow and sides.
    pub line: Line<R>,
    pub elbow: Elbow<R>,
    pub sides: [Side<R>; 2],
}

/// A branch at an arm angle.
#[derive(Debug, Clone, Copy)]
struct Spot<R> {
    cost: R,
    psi: R,
    /// 1 for the second elbow, else 0.
    elbow: R,
    /// 1 and -1 for the first and the second side of shoulder and wrist.
    sides: [R; 2],
}

/// Puts the best arm angle of each lane of `used` into the group. Without `proof` the best
/// of those looked at.
#[inline(always)]
pub(crate) fn search<R: Real>(
    arm: &Srs,
    group: &mut Group<'_, R>,
    choice: Choice,
    proof: bool,
    used: Lanes,
) -> Found<R> {
    let proof = proof && proof::applies(arm);
    let at = arm.reach(&group.goal, group.job.tool(), &group.near.preferred);
    let weights = weights(arm, group, choice);
    let margin = choice == Choice::Margin;
    let spot = around(arm, &at, &weights, margin, group.angle);
    let elbow = at.elbows[0].or(spot.elbow.lt(R::splat(0.5)), &at.elbows[1]);
    let (cost, mut psi) = followed(arm, &at, &elbow, &weights, margin, &spot);
    let found = R::bits(cost.lt(R::splat(f64::MAX)));
    let mut left = if proof { used } else { used & !found };
    let known = used & !left;
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        left &= left - 1;
        let mut best = Best { cost: f64::INFINITY, psi: 0.0 };
        if found >> lane & 1 != 0 {
            best = Best { cost: cost.lane(lane), psi: psi.lane(lane) };
        }
        let single = &mut group.one_lane(lane);
        if proof {
            certified(arm, single, choice, &mut best);
        } else {
            middles(arm, single, choice, &mut best);
        }
        if best.cost < f64::INFINITY {
            psi.set_lane(lane, best.psi);
        }
    }
    group.angle = psi.sin_cos();
    let sides = [Side::of(spot.sides[0]), Side::of(spot.sides[1])];
    Found { known, line: at.line, elbow, sides }
}

/// How the joints count: the first three, the last three, and the fourth.
#[inline(always)]
fn weights<R: Real>(
    arm: &Srs,
    group: &Group<'_, R>,
    choice: Choice,
) -> ([[Weight<R>; 3]; 2], Weight<R>) {
    let (limits, centre) = (group.job.limits(), &group.near.centre);
    // The elbow's value has its offset taken off already.
    let mut all = [Weight::of(choice, &limits[3], 0.0, centre[3]); JOINTS];
    for j in [0, 1, 2, 4, 5, 6] {
        all[j] = Weight::of(choice, &limits[j], arm.offset(j), centre[j]);
    }
    let [a, b, c, fourth, d, e, f] = all;
    ([[a, b, c], [d, e, f]], fourth)
}

/// The best branch of arm angles all round, from that of the start values on.
#[inline(always)]
fn around<R: Real>(
    arm: &Srs,
    at: &Reached<R>,
    weights: &([[Weight<R>; 3]; 2], Weight<R>),
    margin: bool,
    start: Turn<R>,
) -> Spot<R> {
    let (one, infinite) = (R::splat(1.0), R::splat(f64::INFINITY));
    let base = atan2(start.0, start.1);
    let mut best = Spot { cost: infinite, psi: R::zero(), elbow: R::zero(), sides: [one; 2] };
    for (i, elbow) in at.elbows.iter().enumerate() {
        let fourth = cost_of_one(&weights.1, elbow.fourth, margin);
        let fourth = R::select(R::mask_from_bits(elbow.merged), infinite, fourth);
        let [shoulder, wrist] = Sweep::both(arm, &at.line, elbow, &weights.0);
        for k in 0..SAMPLES {
            let on = k as f64 * (TAU / SAMPLES as f64);
            let (sine, cosine) = Real::sin_cos(on);
            let angle = minus(start, (R::splat(-sine), R::splat(cosine)));
            let psi = base + R::splat(on);
            let (first, shoulder_side) = shoulder.glance(angle, margin);
            let (last, wrist_side) = wrist.glance(angle, margin);
            let cost = joined(fourth, joined(first, last, margin), margin);
            let better = cost.lt(best.cost);
            best.cost = R::select(better, cost, best.cost);
            best.psi = R::select(better, psi, best.psi);
            best.elbow = R::select(better, R::splat(i as f64), best.elbow);
            best.sides[0] = R::select(better, shoulder_side, best.sides[0]);
            best.sides[1] = R::select(better, wrist_side, best.sides[1]);
        }
    }
    best
}

/// The best arm angle near a branch, and what it costs; infinite where it is outside limits.
#[inline(always)]
fn followed<R: Real>(
    arm: &Srs,
    at: &Reached<R>,
    elbow: &Elbow<R>,
    weights: &([[Weight<R>; 3]; 2], Weight<R>),
    margin: bool,
    spot: &Spot<R>,
) -> (R, R) {
    let fourth = cost_of_one(&weights.1, elbow.fourth, margin);
    let [shoulder, wrist] = Sweep::both(arm, &at.line, elbow, &weights.0);
    let (mut cost, mut psi) = (R::splat(f64::INFINITY), spot.psi);
    let mut next = spot.psi;
    for look in 0..=LOOKS.len() {
        let angle = next.sin_cos();
        let moving = [shoulder.moving(angle, spot.sides[0]), wrist.moving(angle, spot.sides[1])];
        let here = ahead(&moving, fourth, R::zero(), R::splat(-SLACK), margin);
        let here = R::select(here.lt(R::splat(OUTSIDE)), here, R::splat(f64::INFINITY));
        let better = here.lt(cost);
        cost = R::select(better, here, cost);
        psi = R::select(better, next, psi);
        let Some(&(width, sections, room)) = LOOKS.get(look) else { break };
        let way = least(&moving, fourth, margin, width, sections, R::splat(room));
        next += way;
    }
    (cost, psi)
}

/// More than any cost.
const OUTSIDE: f64 = 1e9;

/// Cost of a branch a little way on; above [`OUTSIDE`] and growing where joints are past
/// their limits.
#[inline(always)]
fn ahead<R: Real>(moving: &[Moving<R>; 2], fourth: R, way: R, room: R, margin: bool) -> R {
    let (first, past_first) = moving[0].ahead(way, room, margin);
    let (last, past_last) = moving[1].ahead(way, room, margin);
    let past = past_first.max(past_last);
    let cost = joined(fourth, joined(first, last, margin), margin);
    let outside = past.mul_add(R::splat(OUTSIDE), R::splat(OUTSIDE));
    R::select(past.le(R::zero()), cost, outside)
}

/// The way of at most `width` to where the cost is least, by golden section.
#[inline(always)]
fn least<R: Real>(
    moving: &[Moving<R>; 2],
    fourth: R,
    margin: bool,
    width: f64,
    sections: usize,
    room: R,
) -> R {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut a, mut b) = (R::splat(-width), R::splat(width));
    let mut size = 2.0 * width * RATIO;
    let (mut c, mut d) = (b - R::splat(size), a + R::splat(size));
    let mut at_c = ahead(moving, fourth, c, room, margin);
    let mut at_d = ahead(moving, fourth, d, room, margin);
    for _ in 0..sections {
        size *= RATIO;
        let lower = at_c.le(at_d);
        a = R::select(lower, a, c);
        b = R::select(lower, d, b);
        let new = R::select(lower, b - R::splat(size), a + R::splat(size));
        let here = ahead(moving, fourth, new, room, margin);
        (c, d) = (R::select(lower, new, d), R::select(lower, c, new));
        (at_c, at_d) = (R::select(lower, here, at_d), R::select(lower, at_c, here));
    }
    R::select(at_c.le(at_d), c, d)
}

/// The best of one target, proven; returns how far its cost may be above the least.
#[inline(never)]
fn certified(arm: &Srs, single: &mut Group<'_, f64>, choice: Choice, best: &mut Best) -> f64 {
    single.solve();
    // A wrist too far away is so at every arm angle.
    if !(0..MOST_BRANCHES).any(|b| single.reaches(b)) {
        return proof::TOLERANCE;
    }
    let limits = single.job.limits();
    let at = arm.reach(&single.goal, single.job.tool(), &single.near.preferred);
    // Exact costs to begin with: those of the rough look may be too low where joints are in
    // line, and one that is too high leaves the proof much to do.
    let looked = *best;
    *best = Best { cost: f64::INFINITY, psi: 0.0 };
    let mut consider = |psi: f64| {
        let cost = cost_at(arm, &at, single, choice, psi);
        // From shares of a margin that are left to shares that are taken.
        let cost = if choice == Choice::Margin { (1.0 + cost).max(0.0) } else { cost };
        if cost < best.cost {
            *best = Best { cost, psi };
        }
    };
    if looked.cost < f64::INFINITY {
        consider(looked.psi);
    } else {
        (0..PROOF_SAMPLES).for_each(|k| consider(k as f64 * (TAU / PROOF_SAMPLES as f64) - PI));
    }
    let bent = elbows(arm, &at, limits);
    let tolerance = proof::certify(arm, &bent, limits, &single.near.centre, choice, best);
    if tolerance == f64::INFINITY && best.cost == f64::INFINITY {
        middles(arm, single, choice, best);
    }
    tolerance
}

/// The least cost of the branches at an arm angle; infinite where none is inside the limits.
fn cost_at(
    arm: &Srs,
    at: &Reached<f64>,
    single: &mut Group<'_, f64>,
    choice: Choice,
    psi: f64,
) -> f64 {
    single.solve_at(arm, at, psi.sin_cos());
    single.wrap();
    let mut inside = single.inside;
    for (lanes, candidate) in inside.iter_mut().zip(&single.candidates) {
        *lanes &= !candidate.merged;
    }
    single.pick(choice, &inside).cost
}

/// The best of some points of the allowed intervals of one target.
#[inline(never)]
fn middles(arm: &Srs, single: &mut Group<'_, f64>, choice: Choice, best: &mut Best) {
    let at = arm.reach(&single.goal, single.job.tool(), &single.near.preferred);
    for branch in intervals_of(arm, &at, single.job.limits()) {
        for interval in branch {
            for share in [0.5, 0.1, 0.9] {
                let angle = interval.lower + share * (interval.upper - interval.lower);
                let cost = cost_at(arm, &at, single, choice, angle);
                if cost < best.cost {
                    *best = Best { cost, psi: angle };
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::call::{Aim, Goals, Request, Starts, Tolerance};
    use crate::chain::{Chain, DhConvention, DhRow, JointKind};
    use crate::closed_form::ClosedForm;
    use crate::closed_form::branch::group::{Job, Near};
    use crate::closed_form::branch::unreachable::is_out_of_reach;
    use crate::random::Sequence;
    use crate::task::{Goal, Task};

    /// A 7R arm of the common kind.
    fn arm(limit: f64) -> Chain {
        let twists = [-1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 0.0].map(|x| x * FRAC_PI_2);
        let lengths = [0.34, 0.0, 0.4, 0.0, 0.4, 0.0, 0.126];
        let joints = twists.iter().zip(lengths).enumerate().map(|(i, (&alpha, d))| {
            let row = DhRow { a: 0.0, alpha, d, theta: 0.0 };
            let name = format!("q{i}");
            row.joint(DhConvention::Standard, name, JointKind::Revolute, -limit, limit)
        });
        let none = nalgebra::IsometryMatrix3::identity();
        Chain::new("arm", joints.collect(), none, none, None).expect("a chain")
    }

    /// Proofs end, at the tolerance that is promised, also where axes are in line or the
    /// arm is stretched, where many arm angles cost the same or nearly so.
    #[test]
    fn proofs_end_within_the_tolerance() {
        let mut stream = Sequence::new(11);
        for limit in [1.2, 2.1, 2.9] {
            let chain = arm(limit);
            let form = ClosedForm::of(&chain).expect("a closed form");
            let ClosedForm::Srs(srs) = form else { panic!("an S-R-S arm") };
            assert!(proof::applies(srs));
            let aim = Aim::new(&chain, Task::Pose, Tolerance::default(), None).expect("valid");
            let request = Request::new(&chain, aim, Goals::Poses(&[]), Starts::Free);
            let request = request.expect("valid");
            for case in 0..240 {
                let mut draw = || limit * (2.0 * stream.uniform() - 1.0);
                let mut q = [0.0; JOINTS].map(|_| draw());
                let near = [0.0; JOINTS].map(|_| draw());
                for (j, tiny) in [(1, 1), (3, 2), (5, 4), (2, 8)] {
                    // One in three of them almost.
                    if case & tiny != 0 {
                        q[j] = if case % 3 == 0 { 1e-6 } else { 0.0 };
                    }
                }
                let mut single = Group::<f64>::new(Job::new(form, &request));
                let at = single.job.at(&q);
                let (axes, position) = (at.joint_axes(), at.tool_point(single.job.tool()));
                single.goal = Goal { position, axes };
                for choice in [Choice::Nearest, Choice::Middle, Choice::Margin] {
                    single.near = Near::middle(single.job.geometry);
                    single.near.set(single.job.geometry, 0, &near, f64::INFINITY);
                    single.near.turn(single.job.geometry);
                    single.near.judged_by(choice, single.job.geometry);
                    let mut best = Best { cost: f64::INFINITY, psi: 0.0 };
                    let tolerance = certified(srs, &mut single, choice, &mut best);
                    // In line at every arm angle: no proof. In line at this one: the only
                    // postures inside the limits may be those that arm angles do not tell.
                    let in_line = q[3] == 0.0 && (q[1] == 0.0 || q[5] == 0.0);
                    let told = q[1] != 0.0 && q[5] != 0.0;
                    assert_eq!(tolerance == f64::INFINITY, in_line, "{limit} {case} {choice:?}");
                    // Almost in line, angles may jump within less than a millionth of a turn.
                    let most = if case % 3 == 0 { 64.0 } else { 1.0 } * proof::TOLERANCE;
                    assert!(in_line || tolerance <= most, "{limit} {case} {choice:?} {tolerance}");
                    let found = best.cost < f64::INFINITY;
                    assert!(found || !told, "{limit} {case} {choice:?}");
                    let none = is_out_of_reach(&single.job, &single.goal, true);
                    assert!(!none, "{limit} {case} {choice:?}");
                }
            }
        }
    }
}
