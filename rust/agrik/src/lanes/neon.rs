//! Vectors of 4 doubles in two NEON registers as [`Real`].
//!
//! Two registers and not one: the chains of dependent operations of one register leave the
//! arithmetic units idle half of the time, and four targets a step is what AVX2 does.
//!
//! # Safety
//!
//! Invariant of this file: it is compiled for aarch64 alone, where NEON is part of the
//! baseline, so every instruction used here exists on the processor that runs it. Apart
//! from that the intrinsics have no preconditions, since all operands are plain registers.

use std::arch::aarch64::*;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::scalar::Fused;
use super::{Real, trig};

/// Four doubles in two NEON registers.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub(super) struct F64x4([float64x2_t; 2]);

/// The same instruction on both registers.
macro_rules! both {
    ($instruction:ident, $($operand:expr),+) => {
        // SAFETY: invariant of this file.
        unsafe { [$instruction($($operand[0]),+), $instruction($($operand[1]),+)] }
    };
}

macro_rules! operator {
    ($trait:ident, $method:ident, $instruction:ident) => {
        impl $trait for F64x4 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Self(both!($instruction, self.0, o.0))
            }
        }
    };
    ($trait:ident, $method:ident, $instruction:ident, $assign_trait:ident, $assign:ident) => {
        operator!($trait, $method, $instruction);
        impl $assign_trait for F64x4 {
            #[inline(always)]
            fn $assign(&mut self, o: Self) {
                self.0 = both!($instruction, self.0, o.0);
            }
        }
    };
}

operator!(Add, add, vaddq_f64, AddAssign, add_assign);
operator!(Sub, sub, vsubq_f64, SubAssign, sub_assign);
operator!(Mul, mul, vmulq_f64, MulAssign, mul_assign);
operator!(Div, div, vdivq_f64);

impl Neg for F64x4 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(both!(vnegq_f64, self.0))
    }
}

/// The bits 0 to 3, one in each lane.
#[inline(always)]
fn weights() -> [uint64x2_t; 2] {
    // SAFETY: invariant of this file.
    unsafe {
        [vcombine_u64(vcreate_u64(1), vcreate_u64(2)), vcombine_u64(vcreate_u64(4), vcreate_u64(8))]
    }
}

#[inline(always)]
fn splat_bits(bits: u64) -> [uint64x2_t; 2] {
    // SAFETY: invariant of this file.
    unsafe { [vdupq_n_u64(bits); 2] }
}

/// All bits of a lane are set where two numbers have a bit in common.
#[inline(always)]
fn have_common_bits(a: [uint64x2_t; 2], b: [uint64x2_t; 2]) -> [uint64x2_t; 2] {
    both!(vtstq_u64, a, b)
}

/// `x` with the sign changed where bit 1 of `count` is set.
#[inline(always)]
fn negate_by_bit_1(x: F64x4, count: [uint64x2_t; 2]) -> F64x4 {
    let bit = both!(vandq_u64, count, splat_bits(2));
    // SAFETY: invariant of this file.
    let sign = unsafe { [vshlq_n_u64::<62>(bit[0]), vshlq_n_u64::<62>(bit[1])] };
    let bits = both!(vreinterpretq_u64_f64, x.0);
    let flipped = both!(veorq_u64, bits, sign);
    F64x4(both!(vreinterpretq_f64_u64, flipped))
}

impl Real for F64x4 {
    const WIDTH: usize = 4;
    type Mask = [uint64x2_t; 2];
    type Single = Fused;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { [vdupq_n_f64(value); 2] })
    }
    #[inline(always)]
    fn lane(&self, index: usize) -> f64 {
        assert!(index < Self::WIDTH);
        // SAFETY: the two vectors are four doubles without other bytes, and `index` is one
        // of them. Through a pointer, so that one lane of a vector in memory is one scalar
        // access.
        unsafe { *std::ptr::from_ref(&self.0).cast::<f64>().add(index) }
    }
    #[inline(always)]
    fn set_lane(&mut self, index: usize, value: f64) {
        assert!(index < Self::WIDTH);
        // SAFETY: as in `lane`, and the reference is exclusive.
        unsafe { *std::ptr::from_mut(&mut self.0).cast::<f64>().add(index) = value }
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(both!(vfmaq_f64, b.0, self.0, a.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(both!(vsqrtq_f64, self.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(both!(vabsq_f64, self.0))
    }
    // Not the instructions of that name: of two zeros, and where one is no number, they
    // take another one than the other levels do.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }
    #[inline(always)]
    fn round(self) -> Self {
        trig::round_small(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        both!(vcltq_f64, self.0, other.0)
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        both!(vcleq_f64, self.0, other.0)
    }
    #[inline(always)]
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
        Self(both!(vbslq_f64, mask, a.0, b.0))
    }
    #[inline(always)]
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        both!(vandq_u64, a, b)
    }
    #[inline(always)]
    fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        both!(vorrq_u64, a, b)
    }
    #[inline(always)]
    fn bits(mask: Self::Mask) -> u32 {
        let set = both!(vandq_u64, mask, weights());
        // SAFETY: invariant of this file.
        unsafe { vaddvq_u64(vorrq_u64(set[0], set[1])) as u32 }
    }
    #[inline(always)]
    fn mask_from_bits(bits: u32) -> Self::Mask {
        have_common_bits(splat_bits(u64::from(bits)), weights())
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos, counted) = trig::sin_cos_by_quadrant(self);
        let count = both!(vreinterpretq_u64_f64, counted.0);
        let odd = have_common_bits(count, splat_bits(1));
        let next = both!(vaddq_u64, count, splat_bits(1));
        let (s, c) = (Self::select(odd, cos, sin), Self::select(odd, sin, cos));
        (negate_by_bit_1(s, count), negate_by_bit_1(c, next))
    }
}
