//! The best arm angle of S-R-S arms: a quick look round for every lane, then, where it is
//! asked for, the proof (see [`super::certify`]) one target at a time.

use std::f64::consts::{PI, TAU};

use super::arm_angle::{elbows, intervals_of};
use super::candidates::Lanes;
use super::certify::{self, Best};
use super::choose::Choice;
use super::settle::Group;
use super::srs::{Reached, Srs};
use crate::lanes::Real;

/// Arm angles of the first look at each target.
const SAMPLES: usize = 8;
/// Closer looks, each of which narrows the place of the best; a proof needs none.
const LOOKS: usize = 3;

/// Puts the best arm angle of each lane of `used` into the group; returns the lanes for
/// which it is proven that no arm angle brings a branch inside the limits. Without `proof`
/// the best of those looked at.
#[inline(always)]
pub(super) fn search<R: Real>(
    arm: &Srs,
    group: &mut Group<'_, R>,
    choice: Choice,
    proof: bool,
    used: Lanes,
) -> Lanes {
    let proof = proof && certify::applies(arm);
    let at = arm.reach(&group.goal, group.job.tool(), &group.near.preferred);
    let step = TAU / SAMPLES as f64;
    let mut cost = R::splat(f64::INFINITY);
    let mut psi = R::zero();
    for k in 0..SAMPLES {
        look(arm, &at, group, choice, R::splat(k as f64 * step - PI), &mut cost, &mut psi);
    }
    let mut width = step;
    for _ in 0..if proof { 0 } else { LOOKS } {
        width *= 0.5;
        let middle = psi;
        look(arm, &at, group, choice, middle - R::splat(width), &mut cost, &mut psi);
        look(arm, &at, group, choice, middle + R::splat(width), &mut cost, &mut psi);
    }
    let found = R::bits(cost.lt(R::splat(f64::MAX)));
    let mut none = 0;
    let mut left = if proof { used } else { used & !found };
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        left &= left - 1;
        let mut best = Best { cost: f64::INFINITY, psi: 0.0 };
        if found >> lane & 1 != 0 {
            best = Best { cost: cost.lane(lane), psi: psi.lane(lane) };
            if choice == Choice::Margin {
                // From shares left to shares taken.
                best.cost = (1.0 + best.cost).max(0.0);
            }
        }
        if proof {
            certified(arm, group, choice, lane, &mut best);
        } else {
            middles(arm, group, choice, lane, &mut best);
        }
        if best.cost < f64::INFINITY {
            psi.set_lane(lane, best.psi);
        } else {
            none |= 1 << lane;
        }
    }
    group.angle = psi.sin_cos();
    none
}

/// Takes an arm angle for the best where it is better than the best so far.
#[inline(always)]
fn look<R: Real>(
    arm: &Srs,
    at: &Reached<R>,
    group: &mut Group<'_, R>,
    choice: Choice,
    angle: R,
    cost: &mut R,
    psi: &mut R,
) {
    group.solve_at(arm, at, angle.sin_cos());
    group.wrap();
    let mut inside = group.inside;
    for (lanes, candidate) in inside.iter_mut().zip(&group.candidates) {
        *lanes &= !candidate.merged;
    }
    let best = choice.pick(group, &inside);
    let better = best.cost.lt(*cost);
    *cost = R::select(better, best.cost, *cost);
    *psi = R::select(better, angle, *psi);
}

/// The best of one lane, proven.
#[inline(never)]
fn certified<R: Real>(
    arm: &Srs,
    group: &Group<'_, R>,
    choice: Choice,
    lane: usize,
    best: &mut Best,
) {
    let single = group.one_lane(lane);
    let limits = single.job.limits();
    let at = arm.reach(&single.goal, single.job.tool(), &single.near.preferred);
    certify::certify(arm, &elbows(arm, &at, limits), limits, &single.near.centre, choice, best);
}

/// The best of some points of the allowed intervals of one lane.
#[inline(never)]
fn middles<R: Real>(arm: &Srs, group: &Group<'_, R>, choice: Choice, lane: usize, best: &mut Best) {
    let mut single = group.one_lane(lane);
    let at = arm.reach(&single.goal, single.job.tool(), &single.near.preferred);
    for branch in intervals_of(arm, &at, single.job.limits()) {
        for interval in branch {
            for share in [0.5, 0.1, 0.9] {
                let angle = interval.lower + share * (interval.upper - interval.lower);
                let Best { cost, psi } = best;
                look(arm, &at, &mut single, choice, angle, cost, psi);
            }
        }
    }
}
