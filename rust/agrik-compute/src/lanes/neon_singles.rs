//! Vectors of 8 singles in two NEON registers as [`Real32`].
//!
//! # Safety
//!
//! The invariant of [`super::neon`]: compiled for aarch64 alone, where NEON is part of the
//! baseline. Loads and stores ask the slice for its length first.

#![allow(unsafe_code)]

use std::arch::aarch64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Arithmetic, Real32};

/// Eight singles in two NEON registers.
#[derive(Debug, Clone, Copy)]
pub(super) struct F32x8([float32x4_t; 2]);

/// The same instruction on both registers.
macro_rules! both {
    ($instruction:ident, $($operand:expr),+) => {
        // SAFETY: invariant of this file.
        unsafe { [$instruction($($operand[0]),+), $instruction($($operand[1]),+)] }
    };
}

macro_rules! operator {
    ($trait:ident, $method:ident, $instruction:ident) => {
        impl $trait for F32x8 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Self(both!($instruction, self.0, o.0))
            }
        }
    };
}

operator!(Add, add, vaddq_f32);
operator!(Sub, sub, vsubq_f32);
operator!(Mul, mul, vmulq_f32);
operator!(Div, div, vdivq_f32);

impl Neg for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(both!(vnegq_f32, self.0))
    }
}

/// The bits 0 to 7, one in each lane.
#[inline(always)]
fn weights() -> [uint32x4_t; 2] {
    let pair = |low: u64, high: u64| low | high << 32;
    // SAFETY: invariant of this file.
    unsafe {
        let four = |a, b| vreinterpretq_u32_u64(vcombine_u64(vcreate_u64(a), vcreate_u64(b)));
        [four(pair(1, 2), pair(4, 8)), four(pair(16, 32), pair(64, 128))]
    }
}

impl Arithmetic for F32x8 {
    const WIDTH: usize = 8;
    type Mask = [uint32x4_t; 2];

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { [vdupq_n_f32(value as f32); 2] })
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(both!(vfmaq_f32, b.0, self.0, a.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(both!(vsqrtq_f32, self.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(both!(vabsq_f32, self.0))
    }
    // Not the instructions of that name: see `super::neon`.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        both!(vcltq_f32, self.0, other.0)
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        both!(vcleq_f32, self.0, other.0)
    }
    #[inline(always)]
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
        Self(both!(vbslq_f32, mask, a.0, b.0))
    }
    #[inline(always)]
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        both!(vandq_u32, a, b)
    }
    #[inline(always)]
    fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        both!(vorrq_u32, a, b)
    }
    #[inline(always)]
    fn bits(mask: Self::Mask) -> u32 {
        let set = both!(vandq_u32, mask, weights());
        // SAFETY: invariant of this file.
        unsafe { vaddvq_u32(vorrq_u32(set[0], set[1])) }
    }
}

impl Real32 for F32x8 {
    #[inline(always)]
    fn load(from: &[f32]) -> Self {
        let from = &from[..Self::WIDTH];
        // SAFETY: `from` is eight singles long.
        Self(unsafe { [vld1q_f32(from.as_ptr()), vld1q_f32(from[4..].as_ptr())] })
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        let to = &mut to[..Self::WIDTH];
        // SAFETY: `to` is eight singles long.
        unsafe {
            vst1q_f32(to.as_mut_ptr(), self.0[0]);
            vst1q_f32(to[4..].as_mut_ptr(), self.0[1]);
        }
    }
}
