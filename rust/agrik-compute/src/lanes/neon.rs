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

#![allow(unsafe_code)]

use std::arch::aarch64::*;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::scalar::Fused;
use super::{Real, Words, trig};

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
    type Words = U64x4;

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
    fn from_words(words: U64x4) -> Self {
        Self(both!(vreinterpretq_f64_u64, words.0))
    }
    #[inline(always)]
    fn to_words(self) -> U64x4 {
        U64x4(both!(vreinterpretq_u64_f64, self.0))
    }
    #[inline(always)]
    fn highest_bits(words: U64x4) -> Self::Mask {
        have_common_bits(words.0, splat_bits(1 << 63))
    }
    #[inline(always)]
    fn transpose(square: &mut [Self]) {
        let Some(rows) = square.first_chunk_mut::<4>() else { return };
        let [Self(a), Self(b), Self(c), Self(d)] = *rows;
        // SAFETY: invariant of this file.
        unsafe {
            *rows = [
                Self([vtrn1q_f64(a[0], b[0]), vtrn1q_f64(c[0], d[0])]),
                Self([vtrn2q_f64(a[0], b[0]), vtrn2q_f64(c[0], d[0])]),
                Self([vtrn1q_f64(a[1], b[1]), vtrn1q_f64(c[1], d[1])]),
                Self([vtrn2q_f64(a[1], b[1]), vtrn2q_f64(c[1], d[1])]),
            ];
        }
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

/// Four words in two NEON registers.
#[derive(Debug, Clone, Copy)]
pub struct U64x4([uint64x2_t; 2]);

/// An instruction on the 16-bit fields of both registers.
macro_rules! fields {
    ($instruction:ident, $into:ident, $back:ident, $a:expr, $b:expr) => {{
        let (a, b) = (both!($into, $a), both!($into, $b));
        let made = both!($instruction, a, b);
        U64x4(both!($back, made))
    }};
}

impl Words for U64x4 {
    const WIDTH: usize = 4;

    #[inline(always)]
    fn splat(word: u64) -> Self {
        Self(splat_bits(word))
    }
    #[inline(always)]
    fn load(from: &[u64]) -> Self {
        let from = &from[..Self::WIDTH];
        // SAFETY: `from` is four words long.
        Self(unsafe { [vld1q_u64(from.as_ptr()), vld1q_u64(from[2..].as_ptr())] })
    }
    #[inline(always)]
    fn store(self, to: &mut [u64]) {
        let to = &mut to[..Self::WIDTH];
        // SAFETY: `to` is four words long.
        unsafe {
            vst1q_u64(to.as_mut_ptr(), self.0[0]);
            vst1q_u64(to[2..].as_mut_ptr(), self.0[1]);
        }
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(both!(vaddq_u64, self.0, other.0))
    }
    #[inline(always)]
    fn product(self, other: Self) -> Self {
        let (a, b) = (both!(vmovn_u64, self.0), both!(vmovn_u64, other.0));
        Self(both!(vmull_u32, a, b))
    }
    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        Self(both!(veorq_u64, self.0, other.0))
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(both!(vorrq_u64, self.0, other.0))
    }
    #[inline(always)]
    fn up<const BY: i32>(self) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { [vshlq_n_u64::<BY>(self.0[0]), vshlq_n_u64::<BY>(self.0[1])] })
    }
    #[inline(always)]
    fn down<const BY: i32>(self) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { [vshrq_n_u64::<BY>(self.0[0]), vshrq_n_u64::<BY>(self.0[1])] })
    }
    #[inline(always)]
    fn equal_fields(self, other: Self) -> Self {
        fields!(vceqq_s16, vreinterpretq_s16_u64, vreinterpretq_u64_u16, self.0, other.0)
    }
    #[inline(always)]
    fn fields_below(self, other: Self) -> Self {
        fields!(vcltq_s16, vreinterpretq_s16_u64, vreinterpretq_u64_u16, self.0, other.0)
    }
    #[inline(always)]
    fn smaller_fields(self, other: Self) -> Self {
        fields!(vminq_s16, vreinterpretq_s16_u64, vreinterpretq_u64_s16, self.0, other.0)
    }
}
