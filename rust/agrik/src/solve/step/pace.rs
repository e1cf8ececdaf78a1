//! How much of the error a step is computed for: all of it, a share, or a length.

use super::squared_norm;
use crate::Allowed;
use crate::error::Result;
use crate::lanes::Real;

/// The part of the error that one step is to remove. Steps are linear in the error, so a
/// part of the error is the same part of the step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Pace {
    /// All of it: the fastest.
    #[default]
    Full,
    /// This share of it, in (0, 1]: the error then falls geometrically.
    Share(f64),
    /// At most this length of it, m: the tool moves in steps of nearly constant length.
    Length(f64),
}

impl Pace {
    /// Refuses numbers outside their ranges.
    pub(super) fn check(self) -> Result<()> {
        match self {
            Self::Full => Ok(()),
            Self::Share(share) => Allowed::up_to(1.0).check("gain", share),
            Self::Length(length) => Allowed::POSITIVE.check("step_length", length),
        }
    }

    /// Scales a step for the whole error down to the part that is wanted.
    #[inline(always)]
    pub(super) fn apply<R: Real, const M: usize>(self, error: &[R; M], change: &mut [R]) {
        let factor = match self {
            Self::Full => return,
            Self::Share(share) => R::splat(share),
            Self::Length(length) => {
                let norm = squared_norm(error).sqrt().max(R::splat(1e-300));
                (R::splat(length) / norm).min(R::splat(1.0))
            }
        };
        for dq in change {
            *dq *= factor;
        }
    }
}
