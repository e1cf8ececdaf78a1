//! The plain `f64` as a one-lane [`Real`].

use super::{Real, trig};

impl Real for f64 {
    const WIDTH: usize = 1;
    type Mask = bool;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn lane(&self, _index: usize) -> f64 {
        *self
    }
    #[inline(always)]
    fn set_lane(&mut self, _index: usize, value: f64) {
        *self = value;
    }
    // Not `f64::mul_add`: the baseline target has no fused instruction, and the
    // library call that stands in for it costs more than the whole loop body.
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn round(self) -> Self {
        trig::round_small(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
    #[inline(always)]
    fn and(a: bool, b: bool) -> bool {
        a & b
    }
    #[inline(always)]
    fn or(a: bool, b: bool) -> bool {
        a | b
    }
    #[inline(always)]
    fn bits(mask: bool) -> u32 {
        u32::from(mask)
    }
    #[inline(always)]
    fn mask_from_bits(bits: u32) -> bool {
        bits & 1 != 0
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (quarter_turns, counted) = trig::quarter_turns(self);
        let (sin, cos) = trig::reduced_sin_cos(trig::reduce(self, quarter_turns));
        let quadrant = counted.to_bits();
        let (s, c) = if quadrant & 1 == 0 { (sin, cos) } else { (cos, sin) };
        let s = if quadrant & 2 == 0 { s } else { -s };
        let c = if quadrant.wrapping_add(1) & 2 == 0 { c } else { -c };
        (s, c)
    }
}
