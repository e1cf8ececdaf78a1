//! Vectors of 4 (AVX2 with FMA) and 8 doubles (AVX-512) as [`Real`].
//!
//! # Safety
//!
//! Invariant of this file: a value of these types comes to be only inside
//! [`super::dispatch`], in a function that is compiled for the instruction set and entered
//! only after the processor was asked whether it has it. So every instruction used here
//! exists on the processor that runs it; apart from that the intrinsics have no
//! preconditions, since all operands are plain registers.

#![allow(unsafe_code)]

use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::scalar::Fused;
use super::x86_words::{U64x4, U64x8};
use super::{Real, trig};

macro_rules! operators {
    ($name:ident, $neg_bits:ident, $add:ident, $sub:ident, $mul:ident, $div:ident) => {
        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, o: Self) -> Self {
                // SAFETY: invariant of this file.
                Self(unsafe { $add(self.0, o.0) })
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, o: Self) -> Self {
                // SAFETY: invariant of this file.
                Self(unsafe { $sub(self.0, o.0) })
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, o: Self) -> Self {
                // SAFETY: invariant of this file.
                Self(unsafe { $mul(self.0, o.0) })
            }
        }
        impl Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, o: Self) -> Self {
                // SAFETY: invariant of this file.
                Self(unsafe { $div(self.0, o.0) })
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                $neg_bits(self)
            }
        }
        impl AddAssign for $name {
            #[inline(always)]
            fn add_assign(&mut self, o: Self) {
                *self = *self + o;
            }
        }
        impl SubAssign for $name {
            #[inline(always)]
            fn sub_assign(&mut self, o: Self) {
                *self = *self - o;
            }
        }
        impl MulAssign for $name {
            #[inline(always)]
            fn mul_assign(&mut self, o: Self) {
                *self = *self * o;
            }
        }
    };
}

/// The methods of [`Real`] that differ in nothing but the names of the instructions.
macro_rules! shared_methods {
    ($width:literal, $set1:ident, $fma:ident, $fnma:ident, $sqrt:ident, $min:ident, $max:ident) => {
        const WIDTH: usize = $width;

        #[inline(always)]
        fn splat(value: f64) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $set1(value) })
        }
        #[inline(always)]
        fn lane(&self, index: usize) -> f64 {
            assert!(index < $width);
            // SAFETY: the vector is `$width` doubles without other bytes, and `index` is
            // one of them. Through a pointer, so that one lane of a vector in memory is
            // one scalar access.
            unsafe { *std::ptr::from_ref(&self.0).cast::<f64>().add(index) }
        }
        #[inline(always)]
        fn set_lane(&mut self, index: usize, value: f64) {
            assert!(index < $width);
            // SAFETY: as in `lane`, and the reference is exclusive.
            unsafe { *std::ptr::from_mut(&mut self.0).cast::<f64>().add(index) = value }
        }
        #[inline(always)]
        fn mul_add(self, a: Self, b: Self) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $fma(self.0, a.0, b.0) })
        }
        #[inline(always)]
        fn neg_mul_add(self, a: Self, b: Self) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $fnma(self.0, a.0, b.0) })
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $sqrt(self.0) })
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $min(self.0, other.0) })
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $max(self.0, other.0) })
        }
    };
}

/// Four doubles in an AVX register.
#[derive(Debug, Clone, Copy)]
pub(super) struct F64x4(__m256d);

#[inline(always)]
fn negate4(x: F64x4) -> F64x4 {
    // SAFETY: invariant of this file.
    F64x4(unsafe { _mm256_xor_pd(x.0, _mm256_set1_pd(-0.0)) })
}

operators!(F64x4, negate4, _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd);

impl Real for F64x4 {
    type Mask = __m256d;
    type Single = Fused;
    type Words = U64x4;
    shared_methods!(
        4,
        _mm256_set1_pd,
        _mm256_fmadd_pd,
        _mm256_fnmadd_pd,
        _mm256_sqrt_pd,
        _mm256_min_pd,
        _mm256_max_pd
    );

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }
    #[inline(always)]
    fn round(self) -> Self {
        trig::round_small(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> __m256d {
        // SAFETY: invariant of this file.
        unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> __m256d {
        // SAFETY: invariant of this file.
        unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn select(mask: __m256d, a: Self, b: Self) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { _mm256_blendv_pd(b.0, a.0, mask) })
    }
    #[inline(always)]
    fn and(a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: invariant of this file.
        unsafe { _mm256_and_pd(a, b) }
    }
    #[inline(always)]
    fn or(a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: invariant of this file.
        unsafe { _mm256_or_pd(a, b) }
    }
    #[inline(always)]
    fn bits(mask: __m256d) -> u32 {
        // SAFETY: invariant of this file.
        unsafe { _mm256_movemask_pd(mask) as u32 }
    }
    #[inline(always)]
    fn mask_from_bits(bits: u32) -> __m256d {
        // SAFETY: invariant of this file.
        unsafe {
            let weights = _mm256_setr_epi64x(1, 2, 4, 8);
            let chosen = _mm256_and_si256(_mm256_set1_epi64x(i64::from(bits)), weights);
            _mm256_castsi256_pd(_mm256_cmpeq_epi64(chosen, weights))
        }
    }
    #[inline(always)]
    fn from_words(words: U64x4) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { _mm256_castsi256_pd(words.0) })
    }
    #[inline(always)]
    fn to_words(self) -> U64x4 {
        // SAFETY: invariant of this file.
        U64x4(unsafe { _mm256_castpd_si256(self.0) })
    }
    #[inline(always)]
    fn highest_bits(words: U64x4) -> __m256d {
        // Blends and masks look at no other bit.
        // SAFETY: invariant of this file.
        unsafe { _mm256_castsi256_pd(words.0) }
    }
    #[inline(always)]
    fn transpose(square: &mut [Self]) {
        let Some(rows) = square.first_chunk_mut::<4>() else { return };
        let [Self(a), Self(b), Self(c), Self(d)] = *rows;
        // SAFETY: invariant of this file.
        unsafe {
            // Pairs of lanes 0 and 2, and of lanes 1 and 3; then halves of the registers.
            let (ab02, ab13) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
            let (cd02, cd13) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
            *rows = [
                Self(_mm256_permute2f128_pd::<0x20>(ab02, cd02)),
                Self(_mm256_permute2f128_pd::<0x20>(ab13, cd13)),
                Self(_mm256_permute2f128_pd::<0x31>(ab02, cd02)),
                Self(_mm256_permute2f128_pd::<0x31>(ab13, cd13)),
            ];
        }
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos, counted) = trig::sin_cos_by_quadrant(self);
        // SAFETY: invariant of this file.
        unsafe {
            let n = _mm256_castpd_si256(counted.0);
            let odd = _mm256_castsi256_pd(_mm256_slli_epi64::<63>(n));
            let sign = |n| {
                let bit = _mm256_and_si256(n, _mm256_set1_epi64x(2));
                _mm256_castsi256_pd(_mm256_slli_epi64::<62>(bit))
            };
            let s = _mm256_blendv_pd(sin.0, cos.0, odd);
            let c = _mm256_blendv_pd(cos.0, sin.0, odd);
            let next = _mm256_add_epi64(n, _mm256_set1_epi64x(1));
            (Self(_mm256_xor_pd(s, sign(n))), Self(_mm256_xor_pd(c, sign(next))))
        }
    }
}

/// Eight doubles in an AVX-512 register.
#[derive(Debug, Clone, Copy)]
pub(super) struct F64x8(__m512d);

#[inline(always)]
fn negate8(x: F64x8) -> F64x8 {
    // SAFETY: invariant of this file.
    F64x8(unsafe { _mm512_xor_pd(x.0, _mm512_set1_pd(-0.0)) })
}

operators!(F64x8, negate8, _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd);

impl Real for F64x8 {
    type Mask = __mmask8;
    type Single = Fused;
    type Words = U64x8;
    shared_methods!(
        8,
        _mm512_set1_pd,
        _mm512_fmadd_pd,
        _mm512_fnmadd_pd,
        _mm512_sqrt_pd,
        _mm512_min_pd,
        _mm512_max_pd
    );

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { _mm512_abs_pd(self.0) })
    }
    #[inline(always)]
    fn round(self) -> Self {
        trig::round_small(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> __mmask8 {
        // SAFETY: invariant of this file.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> __mmask8 {
        // SAFETY: invariant of this file.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn select(mask: __mmask8, a: Self, b: Self) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { _mm512_mask_blend_pd(mask, b.0, a.0) })
    }
    #[inline(always)]
    fn and(a: __mmask8, b: __mmask8) -> __mmask8 {
        a & b
    }
    #[inline(always)]
    fn or(a: __mmask8, b: __mmask8) -> __mmask8 {
        a | b
    }
    #[inline(always)]
    fn bits(mask: __mmask8) -> u32 {
        u32::from(mask)
    }
    #[inline(always)]
    fn mask_from_bits(bits: u32) -> __mmask8 {
        bits as __mmask8
    }
    #[inline(always)]
    fn from_words(words: U64x8) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { _mm512_castsi512_pd(words.0) })
    }
    #[inline(always)]
    fn to_words(self) -> U64x8 {
        // SAFETY: invariant of this file.
        U64x8(unsafe { _mm512_castpd_si512(self.0) })
    }
    #[inline(always)]
    fn highest_bits(words: U64x8) -> __mmask8 {
        // SAFETY: invariant of this file.
        unsafe { _mm512_movepi64_mask(words.0) }
    }
    #[inline(always)]
    fn transpose(square: &mut [Self]) {
        let Some(rows) = square.first_chunk_mut::<8>() else { return };
        let mut r = *rows;
        // SAFETY: invariant of this file.
        unsafe {
            // Lanes of neighbouring rows beside each other, then pairs, then fours.
            for i in [0, 2, 4, 6] {
                let (a, b) = (r[i].0, r[i + 1].0);
                r[i] = Self(_mm512_unpacklo_pd(a, b));
                r[i + 1] = Self(_mm512_unpackhi_pd(a, b));
            }
            for i in [0, 1, 4, 5] {
                let (a, b) = (r[i].0, r[i + 2].0);
                r[i] = Self(_mm512_shuffle_f64x2::<0b10_00_10_00>(a, b));
                r[i + 2] = Self(_mm512_shuffle_f64x2::<0b11_01_11_01>(a, b));
            }
            for i in 0..4 {
                let (a, b) = (r[i].0, r[i + 4].0);
                rows[i] = Self(_mm512_shuffle_f64x2::<0b10_00_10_00>(a, b));
                rows[i + 4] = Self(_mm512_shuffle_f64x2::<0b11_01_11_01>(a, b));
            }
        }
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos, counted) = trig::sin_cos_by_quadrant(self);
        // SAFETY: invariant of this file.
        unsafe {
            let n = _mm512_castpd_si512(counted.0);
            let two = _mm512_set1_epi64(2);
            let odd = _mm512_test_epi64_mask(n, _mm512_set1_epi64(1));
            let sign = |n| _mm512_slli_epi64::<62>(_mm512_and_epi64(n, two));
            let flip =
                |x, sign| _mm512_castsi512_pd(_mm512_xor_epi64(_mm512_castpd_si512(x), sign));
            let s = _mm512_mask_blend_pd(odd, sin.0, cos.0);
            let c = _mm512_mask_blend_pd(odd, cos.0, sin.0);
            let next = _mm512_add_epi64(n, _mm512_set1_epi64(1));
            (Self(flip(s, sign(n))), Self(flip(c, sign(next))))
        }
    }
}
