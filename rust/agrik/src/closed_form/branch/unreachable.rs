//! Proofs that no posture within the limits comes within tolerance of a target.
//!
//! What is proven is meant for the chain as it was given and for any pose within the
//! tolerances of the target. Both differ from what a closed form solves, by known bounds; the
//! arcs of [`crate::closed_form::geometry::enclosure`] hold the angles of every such posture. Where on each branch
//! some joint's arc is outside its limits, there is none. Arcs grow near singularities, and
//! what they leave open is left open.

use std::f64::consts::{PI, TAU};

use super::group::Job;
use crate::closed_form::families::spherical_wrist::wrist_center;
use crate::closed_form::families::srs::{Elbow, Line, Srs};
use crate::closed_form::families::{ClosedForm, SphericalWrist};
use crate::closed_form::geometry::axes::Geometry;
use crate::closed_form::geometry::candidate::JOINTS;
use crate::closed_form::geometry::enclosure::{
    Arc, Rotation, any_outside, linear_arcs, none_inside,
};
use crate::closed_form::geometry::limit::Limit;
use crate::closed_form::geometry::range::Range;
use crate::closed_form::geometry::turn::{Turn, advance, components, identity};
use crate::lanes::{V3, dot, hypotenuse, splat3, sub};
use crate::task::Goal;

/// What rounding may do to lengths and angles, as a share of the arm's size and in rad.
const ROUNDING: f64 = 1e-11;
/// Arm angles are first looked at in so many pieces.
const PIECES: usize = 16;
/// Pieces of half this length that still may hold a posture are left open, rad.
const SHORTEST: f64 = 1e-5;
/// After so many pieces a target is left open.
const MOST_PIECES: usize = 20_000;

/// How far a wanted pose may be from the one that a closed form is solved for.
#[derive(Debug, Clone, Copy)]
struct Slack {
    /// Of the wrist's centre, m.
    center: f64,
    /// Of the orientation, rad.
    turn: f64,
    /// The part of it that is the arm's alone, rad.
    own: f64,
}

impl Slack {
    fn new(job: &Job<'_>, goal: &Goal<f64>) -> Self {
        let Geometry { misfit, links, last_shift, .. } = job.geometry;
        let [x, y, z] = job.tool();
        let arm = hypotenuse(hypotenuse(x, y), z - last_shift);
        let lengths: f64 = links.iter().map(|link| link.a.abs() + link.d.abs()).sum();
        let far = dot(goal.position, goal.position).sqrt() + arm + lengths;
        let tolerance = job.exact.tolerance;
        // An angle of the chain's own frames moves the wrist's centre as well.
        let own = misfit.orientation + ROUNDING;
        let turn = tolerance.orientation + own;
        let center = tolerance.position + misfit.position + arm * turn + ROUNDING * far;
        Self { center, turn, own }
    }
}

/// No posture within the limits comes within tolerance of the goal. Of an S-R-S arm all arm
/// angles are looked at with `all_angles`, else only what does not depend on them.
#[inline(never)]
pub(crate) fn is_out_of_reach(job: &Job<'_>, goal: &Goal<f64>, all_angles: bool) -> bool {
    let slack = Slack::new(job, goal);
    // So far away, or so loose, that nothing can be said.
    if !(slack.center.is_finite() && slack.turn < 1.0) {
        return goal_is_far(job, goal);
    }
    match job.form {
        ClosedForm::SphericalWrist(arm) => no_spherical_wrist(arm, job, goal, slack),
        ClosedForm::Srs(arm) => no_srs(arm, job, goal, slack, all_angles),
    }
}

/// The last joint is farther from the first than all lengths together.
fn goal_is_far(job: &Job<'_>, goal: &Goal<f64>) -> bool {
    let Geometry { links, last_shift, misfit, origin, .. } = job.geometry;
    let lengths: f64 = links.iter().map(|link| link.a.abs() + link.d.abs()).sum();
    let tool: f64 = job.tool().iter().map(|x| x.abs()).sum();
    let farthest = goal.position.iter().zip(origin).map(|(x, o)| (x - o).abs());
    let allowed = 2.0 * (lengths + tool + last_shift.abs() + misfit.position);
    farthest.fold(0.0, f64::max) > allowed + job.exact.tolerance.position
}

/// Limits of three joints from `first` on, with the offsets of their turns.
fn three(job: &Job<'_>, first: usize) -> [(Limit, f64); 3] {
    [0, 1, 2].map(|j| (job.limits()[first + j], job.geometry.offset(first + j)))
}

/// Columns x and z of the wanted frame seen from the first joint, and the wrist's centre.
fn seen(g: &Geometry, goal: &Goal<f64>, tool: [f64; 3]) -> (V3<f64>, V3<f64>, V3<f64>) {
    let center = sub(wrist_center(g, goal, tool), splat3(g.origin));
    let see = |v: V3<f64>| components(g.axes, v);
    (see(center), see(goal.axes[0]), see(goal.axes[2]))
}

fn no_spherical_wrist(arm: &SphericalWrist, job: &Job<'_>, goal: &Goal<f64>, slack: Slack) -> bool {
    let (center, x, z) = seen(job.geometry, goal, job.tool());
    if !center.iter().all(|x| x.abs() < 1e100) {
        return goal_is_far(job, goal);
    }
    let (ahead, behind) = (three(job, 0), three(job, 3));
    arm.shoulder().arcs(center, slack.center).iter().all(|arcs| {
        if any_outside(arcs, &ahead) {
            return true;
        }
        let mut frame = identity::<f64>();
        for (arc, link) in arcs.iter().zip(&job.geometry.links) {
            frame = advance(frame, arc.middle.sin_cos(), link);
        }
        let off = arcs.iter().map(|arc| arc.off).sum::<f64>() + slack.turn;
        let wanted = Rotation { x: components(frame, x), z: components(frame, z), off };
        none_inside(arm.wrist(), &wanted, &behind)
    })
}

/// An elbow that the fourth joint's limits may allow.
struct Bend {
    elbow: Elbow<f64>,
    /// How far the fourth joint may be from it, rad.
    off: f64,
    /// How far, then, the direction to the wrist may be, rad.
    tilt: f64,
}

fn no_srs(arm: &Srs, job: &Job<'_>, goal: &Goal<f64>, slack: Slack, all_angles: bool) -> bool {
    let preferred = [(0.0, 1.0); JOINTS];
    let at = arm.reach(goal, job.tool(), &preferred);
    let length = at.line.length;
    if !(length.is_finite() && length < 1e100) {
        return goal_is_far(job, goal);
    }
    let [a, b, fixed] = arm.elbow_equation();
    let (low, high) = ((length - slack.center).max(0.0), length + slack.center);
    let c = Range { low: low * low - fixed, high: high * high - fixed };
    let Some(turns) = linear_arcs(a, b, 0.0, c) else { return true };
    let line_off = Arc::toward(length, 0.0, slack.center).off;
    let mut bends = Vec::with_capacity(2);
    for (turn, elbow) in turns.iter().zip(at.elbows) {
        // The elbow's own turn is that from the common normal.
        let fourth = turn.turned(-arm.phase());
        if fourth.turned(-arm.offset(3)).is_outside(&job.limits()[3]) {
            continue;
        }
        let here = elbow.fourth + arm.offset(3);
        let apart = fourth.middle - here;
        let off = fourth.off + (apart - TAU * (apart / TAU).round()).abs();
        let least = (length - slack.center).max(0.0);
        let tilt = line_off + Arc::toward(least, 0.0, arm.radius() * off.min(2.0)).off;
        bends.push(Bend { elbow, off, tilt });
    }
    if bends.is_empty() {
        return true;
    }
    if !all_angles {
        return false;
    }
    let limits = [three(job, 0), three(job, 4)];
    bends.iter().all(|bend| no_angle(arm, &at.line, bend, slack, &limits))
}

/// At every arm angle the shoulder or the wrist is outside its limits.
fn no_angle(
    arm: &Srs,
    line: &Line<f64>,
    bend: &Bend,
    slack: Slack,
    limits: &[[(Limit, f64); 3]; 2],
) -> bool {
    let half = PI / PIECES as f64;
    let mut open: Vec<(f64, f64)> =
        (0..PIECES).map(|i| (half * (2 * i + 1) as f64 - PI, half)).collect();
    let mut looks = 0;
    while let Some((psi, half)) = open.pop() {
        looks += 1;
        if no_piece(arm, line, bend, (psi.sin_cos(), half), slack, limits) {
            continue;
        }
        if half < SHORTEST || looks > MOST_PIECES {
            return false;
        }
        let quarter = 0.5 * half;
        open.extend([(psi - quarter, quarter), (psi + quarter, quarter)]);
    }
    true
}

/// Within `half` of an arm angle the shoulder or the wrist is outside its limits.
fn no_piece(
    arm: &Srs,
    line: &Line<f64>,
    bend: &Bend,
    (angle, half): (Turn<f64>, f64),
    slack: Slack,
    limits: &[[(Limit, f64); 3]; 2],
) -> bool {
    let third = arm.third_link(line, &bend.elbow, angle);
    let off = half + bend.tilt + slack.own;
    let (shoulder, wrist) = arm.meetings();
    if none_inside(shoulder, &Rotation { x: third[0], z: third[2], off }, &limits[0]) {
        return true;
    }
    let [x, z] = arm.left_to_wrist(line, &bend.elbow, third);
    let off = off + bend.off + slack.turn;
    none_inside(wrist, &Rotation { x, z, off }, &limits[1])
}
