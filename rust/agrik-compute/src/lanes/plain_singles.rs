//! Eight plain singles as [`Real32`], for the level without vectors of its own.
//!
//! Eight and not one: what is stored in groups of eight has one kernel at every level, and
//! the compiler makes of these loops what the baseline has.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Arithmetic, Real32};

/// Eight singles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plain8([f32; 8]);

impl Plain8 {
    #[inline(always)]
    fn each(self, other: Self, mut of: impl FnMut(f32, f32) -> f32) -> Self {
        let mut made = self.0;
        for (x, y) in made.iter_mut().zip(other.0) {
            *x = of(*x, y);
        }
        Self(made)
    }

    #[inline(always)]
    fn holds(self, other: Self, mut of: impl FnMut(f32, f32) -> bool) -> u32 {
        let mut bits = 0;
        for lane in 0..Self::WIDTH {
            bits |= u32::from(of(self.0[lane], other.0[lane])) << lane;
        }
        bits
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Plain8 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                self.each(o, |x, y| x $op y)
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Neg for Plain8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(self, |x, _| -x)
    }
}

impl Arithmetic for Plain8 {
    const WIDTH: usize = 8;
    /// One bit a lane.
    type Mask = u32;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value as f32; Self::WIDTH])
    }
    // Not fused, as with plain doubles.
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.each(self, |x, _| x.sqrt())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.each(self, |x, _| x.abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.each(other, |x, y| if x < y { x } else { y })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.each(other, |x, y| if x > y { x } else { y })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        self.holds(other, |x, y| x < y)
    }
    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        self.holds(other, |x, y| x <= y)
    }
    #[inline(always)]
    fn select(mask: u32, a: Self, b: Self) -> Self {
        let mut lane = 0;
        a.each(b, |x, y| {
            lane += 1;
            if mask >> (lane - 1) & 1 != 0 { x } else { y }
        })
    }
    #[inline(always)]
    fn and(a: u32, b: u32) -> u32 {
        a & b
    }
    #[inline(always)]
    fn or(a: u32, b: u32) -> u32 {
        a | b
    }
    #[inline(always)]
    fn bits(mask: u32) -> u32 {
        mask
    }
}

impl Real32 for Plain8 {
    #[inline(always)]
    fn load(from: &[f32]) -> Self {
        let mut loaded = [0.0; Self::WIDTH];
        loaded.copy_from_slice(&from[..Self::WIDTH]);
        Self(loaded)
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        to[..Self::WIDTH].copy_from_slice(&self.0);
    }
}
