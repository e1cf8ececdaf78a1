//! One number at a time as a one-lane [`Real`].

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::{Real, trig};

/// A double whose `mul_add` is one rounding, as it is in the vector types.
///
/// A single target solved with it gets, bit for bit, the answer that it would get in a
/// lane. Fast only inside a function compiled for fused multiply-add.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
#[cfg_attr(not(any(target_arch = "x86_64", target_arch = "aarch64")), allow(dead_code))]
pub(super) struct Fused(f64);

macro_rules! operator {
    ($trait:ident, $method:ident, $assign_trait:ident, $assign:ident, $op:tt) => {
        impl $trait for Fused {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Self(self.0 $op o.0)
            }
        }
        operator!(@assign $assign_trait, $assign, $op);
    };
    (@assign None, $assign:ident, $op:tt) => {};
    (@assign $assign_trait:ident, $assign:ident, $op:tt) => {
        impl $assign_trait for Fused {
            #[inline(always)]
            fn $assign(&mut self, o: Self) {
                self.0 = self.0 $op o.0;
            }
        }
    };
}

operator!(Add, add, AddAssign, add_assign, +);
operator!(Sub, sub, SubAssign, sub_assign, -);
operator!(Mul, mul, MulAssign, mul_assign, *);
operator!(Div, div, None, div_assign, /);

impl Neg for Fused {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

/// [`Real`] for a type that holds one double: how to get at it, and its multiply-add.
macro_rules! one_lane {
    ($type:ty, $make:expr, $get:expr, $mul_add:expr) => {
        impl Real for $type {
            const WIDTH: usize = 1;
            type Mask = bool;
            type Single = Self;
            type Words = u64;

            #[inline(always)]
            fn splat(value: f64) -> Self {
                $make(value)
            }
            #[inline(always)]
            fn lane(&self, _index: usize) -> f64 {
                $get(*self)
            }
            #[inline(always)]
            fn set_lane(&mut self, _index: usize, value: f64) {
                *self = $make(value);
            }
            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                $make($mul_add($get(self), $get(a), $get(b)))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $make(f64::sqrt($get(self)))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $make(f64::abs($get(self)))
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
            fn from_words(words: u64) -> Self {
                $make(f64::from_bits(words))
            }
            #[inline(always)]
            fn to_words(self) -> u64 {
                $get(self).to_bits()
            }
            #[inline(always)]
            fn highest_bits(words: u64) -> bool {
                words >> 63 != 0
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                let (sin, cos, counted) = trig::sin_cos_by_quadrant(self);
                let quadrant = $get(counted).to_bits();
                let (s, c) = if quadrant & 1 == 0 { (sin, cos) } else { (cos, sin) };
                let s = if quadrant & 2 == 0 { s } else { -s };
                let c = if quadrant.wrapping_add(1) & 2 == 0 { c } else { -c };
                (s, c)
            }
        }
    };
}

// Not `f64::mul_add`: the baseline target has no fused instruction, and the library call
// that stands in for it costs more than the loop around it.
one_lane!(f64, (|x: f64| x), (|x: f64| x), |x: f64, a: f64, b: f64| x * a + b);
one_lane!(Fused, Fused, (|x: Fused| x.0), f64::mul_add);
