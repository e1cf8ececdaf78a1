//! Targets of which no branch is inside the limits: a last search for a posture within the
//! tolerances.
//!
//! A posture counts when it is inside the limits and within the tolerances. Where a joint
//! stands at a limit and the arm is singular, or nearly so, the branch that solves the target
//! exactly may be outside by the root of the tolerance and more. So branches that are outside
//! by little are held at the limits and brought near again by steps.

use std::f64::consts::TAU;

use crate::closed_form::arm_angle::intervals::corners;
use crate::closed_form::branch::check::least_outside;
use crate::closed_form::branch::group::{Group, Job};
use crate::closed_form::branch::open_angles::split;
use crate::closed_form::branch::polish::{Polished, held};
use crate::closed_form::families::Srs;
use crate::closed_form::geometry::candidate::{JOINTS, MOST_BRANCHES};
use crate::task::Goal;

/// A branch that is farther outside its limits is not looked at, rad; and how many times the
/// tolerances more.
const FAR: f64 = 0.03;
const TIMES: f64 = 4.0;
/// Most branches that get steps.
const MOST: usize = 4;
/// The same of branches at all arm angles.
const MOST_AT_ALL: usize = 12;
/// Most steps of a branch.
const STEPS: usize = 24;
/// Arm angles all round that are looked at besides the corners.
const SAMPLES: usize = 24;

fn farthest(job: &Job<'_>) -> f64 {
    let size: f64 = job.geometry.links.iter().map(|link| link.a.abs() + link.d.abs()).sum();
    let tolerance = job.exact.inner;
    FAR + TIMES * (tolerance.orientation.min(TAU) + tolerance.position.min(size) / size)
}

/// A posture from one of some branches (values along the chain), and from which.
#[inline(never)]
pub(super) fn found(
    job: &Job<'_>,
    goal: &Goal<f64>,
    centre: &[f64; JOINTS],
    branches: &[[f64; JOINTS]],
) -> Option<(usize, Polished)> {
    let (far, limits) = (farthest(job), job.limits());
    let mut near: Vec<(f64, usize, [f64; JOINTS])> = Vec::new();
    for (b, branch) in branches.iter().enumerate() {
        let mut q = *branch;
        let off = least_outside(limits, &mut q);
        if off < far {
            near.push((off, b, q));
        } else if job.steps
            && let Some(q) = split(job, &q, centre)
        {
            near.push((far, b, q));
        }
    }
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.truncate(if branches.len() > MOST_BRANCHES { MOST_AT_ALL } else { MOST });
    let steps = if job.steps { STEPS } else { 0 };
    let posture = |q| held(&job.exact, limits, q, (goal, centre), steps);
    near.into_iter().find_map(|(_, b, q)| posture(q).map(|posture| (b, posture)))
}

/// A posture at any arm angle of a single target.
#[inline(never)]
pub(super) fn found_at_any_angle(arm: &Srs, single: &mut Group<'_, f64>) -> Option<Polished> {
    let at = arm.reach(&single.goal, single.job.tool(), &single.near.preferred);
    if !at.line.length.is_finite() {
        return None;
    }
    let mut angles = corners(arm, &at, single.job.limits());
    angles.extend((0..SAMPLES).map(|k| k as f64 * (TAU / SAMPLES as f64)));
    let mut branches = Vec::with_capacity(angles.len() * MOST_BRANCHES);
    for psi in angles {
        single.solve_at(arm, &at, psi.sin_cos());
        single.wrap();
        branches.extend(single.candidates.iter().map(|candidate| candidate.q));
    }
    found(&single.job, &single.goal, &single.near.centre, &branches).map(|(_, posture)| posture)
}
