//! Limits of a joint.

use crate::chain::{Variable, reference};

/// A joint value this far past a limit is rounding, and is put on the limit, rad.
pub const SLACK: f64 = 1e-10;

/// A joint's limits and the value that it stays near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    pub lower: f64,
    pub upper: f64,
    /// Middle of the limits; 0 where there are none.
    pub middle: f64,
    /// Half their distance; infinite where there are none.
    pub half: f64,
}

impl Limit {
    /// No limits.
    pub const FREE: Self =
        Self { lower: f64::NEG_INFINITY, upper: f64::INFINITY, middle: 0.0, half: f64::INFINITY };

    /// The limits of a joint.
    pub fn of(v: &Variable) -> Self {
        let bounded = v.lower.is_finite() && v.upper.is_finite();
        let middle = if bounded { 0.5 * (v.lower + v.upper) } else { 0.0 };
        let half = if bounded { 0.5 * (v.upper - v.lower) } else { f64::INFINITY };
        Self { lower: v.lower, upper: v.upper, middle, half }
    }

    /// The value that answers stay near, for the caller's `about`; no angle beyond `most` where
    /// that can be helped.
    #[inline(always)]
    pub fn reference(&self, about: f64, most: f64) -> f64 {
        reference(about, (self.lower, self.upper), self.half >= std::f64::consts::PI, most)
    }

    /// Shares of half the range in a radian; none where there are no limits.
    #[inline(always)]
    pub fn shares(&self) -> f64 {
        if self.half == f64::INFINITY { 0.0 } else { 1.0 / self.half.max(1e-9) }
    }
}
