//! Which of several valid branches is the answer.

use super::candidates::{BRANCHES, JOINTS, Lanes};
use super::check::Limit;
use super::settle::Group;
use crate::lanes::Real;

/// What the best branch is best at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Choice {
    /// Least sum of squared distances from the start values (without any: from the middle
    /// of the limits), rad^2.
    #[default]
    Nearest,
    /// Largest distance of its worst joint from a limit, as a share of half the range.
    Margin,
    /// Least sum of squared distances from the middle of the limits, as shares of half the
    /// range.
    Middle,
}

/// The best of the branches of each lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Best<R> {
    /// Its cost; infinite where no branch is valid.
    pub cost: R,
    /// Its number.
    pub branch: R,
    /// Lanes that have one.
    pub found: Lanes,
}

impl Choice {
    /// The cost of joint values along the chain, one for each lane; the least is best.
    #[inline(always)]
    pub(super) fn cost<R: Real>(
        self,
        q: &[R; JOINTS],
        centre: &[R; JOINTS],
        limits: &[Limit],
    ) -> R {
        let mut sum = R::zero();
        let mut worst = R::splat(f64::MAX);
        for (j, limit) in limits.iter().enumerate() {
            match self {
                Self::Nearest => {
                    let off = q[j] - centre[j];
                    sum = off.mul_add(off, sum);
                }
                _ if limit.half == f64::INFINITY => {}
                Self::Middle => {
                    let off =
                        (q[j] - R::splat(limit.middle)) * R::splat(1.0 / limit.half.max(1e-9));
                    sum = off.mul_add(off, sum);
                }
                Self::Margin => {
                    let off = (q[j] - R::splat(limit.middle)).abs();
                    let share = R::splat(1.0) - off * R::splat(1.0 / limit.half.max(1e-9));
                    worst = worst.min(share);
                }
            }
        }
        if self == Self::Margin { -worst } else { sum }
    }

    /// The best of the branches that are among `valid`, one mask of lanes a branch.
    #[inline(always)]
    pub(super) fn pick<R: Real>(self, group: &Group<'_, R>, valid: &[Lanes; BRANCHES]) -> Best<R> {
        let mut best = Best { cost: R::splat(f64::INFINITY), branch: R::zero(), found: 0 };
        for (b, lanes) in valid.iter().enumerate() {
            if *lanes == 0 {
                continue;
            }
            let cost = self.cost(&group.candidates[b].q, &group.near.centre, group.job.limits());
            let better = R::and(cost.lt(best.cost), R::mask_from_bits(*lanes));
            best.cost = R::select(better, cost, best.cost);
            best.branch = R::select(better, R::splat(b as f64), best.branch);
            best.found |= lanes;
        }
        best
    }
}
