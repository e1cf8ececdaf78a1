//! Which of several valid branches is the answer.

use crate::closed_form::geometry::candidate::JOINTS;
use crate::closed_form::geometry::limit::Limit;
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

impl Choice {
    /// The cost of joint values along the chain, one for each lane; the least is best.
    #[inline(always)]
    pub(crate) fn cost<R: Real>(
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
                    let off = (q[j] - R::splat(limit.middle)) * R::splat(limit.shares());
                    sum = off.mul_add(off, sum);
                }
                Self::Margin => {
                    let off = (q[j] - R::splat(limit.middle)).abs();
                    let share = R::splat(1.0) - off * R::splat(limit.shares());
                    worst = worst.min(share);
                }
            }
        }
        if self == Self::Margin { -worst } else { sum }
    }
}
