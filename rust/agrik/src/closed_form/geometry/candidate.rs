//! The branches of one lane group: joint values, and what is known of each branch.

use super::turn::Turn;
use crate::lanes::{Lanes, Real, atan2, atan2_each};

/// Most branches of any family here.
pub const MOST_BRANCHES: usize = 8;
/// Most joints of any closed form here.
pub const JOINTS: usize = 7;

/// The first joints sit on the first axis or at the rim of their ring.
pub const SHOULDER: u8 = 1;
/// The arm is stretched or folded.
pub const ELBOW: u8 = 2;
/// The first and the last axis of the wrist are in line.
pub const WRIST: u8 = 4;

/// A branch of one closed form, one target a lane.
#[derive(Debug, Clone, Copy)]
pub struct Candidate<R> {
    /// Joint values along the chain, rad, not yet within limits.
    pub q: [R; JOINTS],
    /// Lanes where this branch is an earlier one over again.
    pub merged: Lanes,
    /// Lanes near a shoulder, an elbow and a wrist singularity.
    pub singular: [Lanes; 3],
}

impl<R: Real> Candidate<R> {
    /// No branch in any lane.
    #[inline(always)]
    pub fn none() -> Self {
        Self { q: [R::zero(); JOINTS], merged: Lanes::MAX, singular: [0; 3] }
    }

    /// Singularity flags of one lane.
    #[inline(always)]
    pub fn flags(&self, lane: usize) -> u8 {
        let bit = |lanes: Lanes, flag: u8| if lanes >> lane & 1 != 0 { flag } else { 0 };
        let [shoulder, elbow, wrist] = self.singular;
        bit(shoulder, SHOULDER) | bit(elbow, ELBOW) | bit(wrist, WRIST)
    }
}

/// The joint values of three turns that are counted from offsets.
#[inline(always)]
pub fn values<R: Real>(turns: &[Turn<R>; 3], offsets: [f64; 3]) -> [R; 3] {
    let [a, b, c] = *turns;
    let [x, y, z] = atan2_each([a.0, b.0, c.0], [a.1, b.1, c.1]);
    [x - R::splat(offsets[0]), y - R::splat(offsets[1]), z - R::splat(offsets[2])]
}

/// The joint value of a turn that is counted from `offset`.
#[inline(always)]
pub fn value<R: Real>(turn: Turn<R>, offset: f64) -> R {
    atan2(turn.0, turn.1) - R::splat(offset)
}
