//! Among the branches of a target one that the call's guard accepts: free of collisions, say.
//!
//! The best branch by the call's own choice comes first. Where it is refused, or the guard
//! prefers others, all branches are looked at, of an arm with a free arm angle at angles all
//! round.

use std::f64::consts::TAU;
use std::ops::Range;

use super::all_branches::fill;
use super::arm_angle::ArmAngle;
use super::branches::Branches;
use super::query::{FEW, Query};
use crate::call::{AnswersMut, Guard, Outcome, Prefer, Status, TOGETHER};
use crate::closed_form::branch::choice::Choice;
use crate::closed_form::branch::group::{Job, Near};
use crate::closed_form::geometry::candidate::JOINTS;
use crate::lanes::Level;

/// Branches of a target that are asked about at a time.
const AT_ONCE: usize = 8;

/// Arm angles all round that are looked at where one is free.
const ANGLES: usize = 24;

/// Puts accepted branches in place of the answers `range` of a run that are not, or less
/// preferred.
pub(super) fn guarded(
    query: &Query<'_>,
    guard: Guard<'_>,
    level: Level,
    rows: &mut AnswersMut<'_>,
    range: Range<usize>,
) {
    let reached: Vec<usize> = range.filter(|i| rows.ended(*i, Status::Converged)).collect();
    // The answer of a call without a guard is the first, and often the nearest.
    let best_first = match guard.prefer {
        Prefer::First => true,
        Prefer::Near => query.choice == Choice::Nearest,
        Prefer::Clearance => false,
    };
    for some in reached.chunks(TOGETHER) {
        let mut accepted = 0;
        if best_first {
            let q: Vec<f64> = some.iter().flat_map(|i| rows.q(*i)).copied().collect();
            accepted = guard.accept.accepts(&q);
        }
        for (lane, i) in some.iter().enumerate() {
            if accepted >> lane & 1 == 0 {
                choose(query, guard, level, rows, *i);
            }
        }
    }
}

/// Postures that reach one target, row by row, and what each costs.
struct Candidates {
    q: Vec<f64>,
    cost: Vec<f64>,
}

/// Chooses among all branches of row `i` of a run.
fn choose(query: &Query<'_>, guard: Guard<'_>, level: Level, rows: &mut AnswersMut<'_>, i: usize) {
    let (job, dof) = (query.job(), query.chain().dof());
    let found = candidates(query, guard, level, rows.first + i, rows.q(i));
    let mut order: Vec<usize> = (0..found.cost.len()).collect();
    // Of equal ones the lower branch stays first.
    let before = |a: &usize, b: &usize| found.cost[*a].total_cmp(&found.cost[*b]).then(a.cmp(b));
    let posture = |candidate: usize| &found.q[candidate * dof..(candidate + 1) * dof];
    let mut accepted = Vec::new();
    // Mostly one of the first few is accepted: the rest is neither asked about nor sorted then.
    let mut left = &mut order[..];
    while !left.is_empty() {
        if left.len() > AT_ONCE {
            left.select_nth_unstable_by(AT_ONCE, before);
        }
        let (some, rest) = left.split_at_mut(left.len().min(AT_ONCE));
        some.sort_unstable_by(before);
        let q: Vec<f64> = some.iter().flat_map(|c| posture(*c)).copied().collect();
        let lanes = guard.accept.accepts(&q);
        let each = some.iter().enumerate().filter(|(lane, _)| lanes >> lane & 1 != 0);
        accepted.extend(each.map(|(_, candidate)| *candidate));
        if guard.prefer != Prefer::Clearance && !accepted.is_empty() {
            break;
        }
        left = rest;
    }
    let best_margin = |among: &[usize]| among[guard.best_margin(among.iter().map(|c| posture(*c)))];
    let (status, chosen) = match (&accepted[..], guard.prefer) {
        // The answer so far is a candidate, so there are some.
        ([], _) => (Status::InCollision, best_margin(&order)),
        (_, Prefer::Clearance) => (Status::Converged, best_margin(&accepted)),
        ([first, ..], _) => (Status::Converged, *first),
    };
    let q = posture(chosen);
    let (position_error, orientation_error) = errors(&job, query, rows.first + i, q);
    let outcome = Outcome { position_error, orientation_error, ..Outcome::unanswered(status) };
    rows.finish(i, outcome).copy_from_slice(q);
}

/// The answer so far, and all valid branches besides.
fn candidates(
    query: &Query<'_>,
    guard: Guard<'_>,
    level: Level,
    row: usize,
    answer: &[f64],
) -> Candidates {
    let (form, dof) = (query.form, query.chain().dof());
    let mut angles = Vec::new();
    if let Some(arm) = query.free() {
        let first = arm.arm_angle(answer);
        angles = (0..ANGLES).map(|k| first + TAU * k as f64 / ANGLES as f64).collect();
    } else if !matches!(query.angle, ArmAngle::Free) {
        angles.push(query.angle(row));
    }
    let copies = query.request.copies(row, angles.len().max(1));
    let request = query.request.with_copies(&copies, row);
    let angle = if angles.is_empty() { ArmAngle::Free } else { ArmAngle::Each(&angles) };
    let all = Query { request, angle, reached: true, ..query.clone() };
    let (targets, count) = (request.len(), form.branches());
    let mut branches = Branches::new(targets, count);
    let mut q = vec![0.0; targets * count * dof];
    fill(level, &all, &mut branches.as_mut_with(&mut q), targets <= FEW);
    let valid = branches.valid.iter().filter(|valid| **valid).count();
    let mut found = Candidates { q: Vec::with_capacity((1 + valid) * dof), cost: Vec::new() };
    found.q.extend_from_slice(answer);
    for (q, _) in q.chunks_exact(dof).zip(&branches.valid).filter(|(_, valid)| **valid) {
        found.q.extend_from_slice(q);
    }
    let job = query.job();
    let choice = if guard.prefer == Prefer::Near { Choice::Nearest } else { query.choice };
    let mut near = Near::<f64>::to(job.geometry, &query.request, row);
    near.judged_by(choice, job.geometry);
    let cost = |q: &[f64]| {
        let mut along = [0.0; JOINTS];
        for (x, variable) in along.iter_mut().zip(job.variables()) {
            *x = q[*variable];
        }
        choice.cost(&along, &near.centre, job.limits())
    };
    found.cost = found.q.chunks_exact(dof).map(cost).collect();
    found
}

/// Distance and angle between a posture and a target.
fn errors(job: &Job<'_>, query: &Query<'_>, row: usize, q: &[f64]) -> (f64, f64) {
    let Some(goal) = query.request.goal(row) else { return (f64::INFINITY, f64::INFINITY) };
    let left = query.request.left(&job.at(q), &goal);
    (left.position2.sqrt(), left.orientation2.sqrt())
}
