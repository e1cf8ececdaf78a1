//! Vectors of 8 (AVX2 with FMA) and 16 singles (AVX-512) as [`Real32`].
//!
//! # Safety
//!
//! The invariant of [`super::x86`]: values of these types come to be only on a processor
//! that has the instructions. Loads and stores ask the slice for its length first.

#![allow(unsafe_code)]

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Arithmetic, Real32};

/// Eight singles in an AVX register.
#[derive(Debug, Clone, Copy)]
pub(super) struct F32x8(__m256);

/// Sixteen singles in an AVX-512 register.
#[derive(Debug, Clone, Copy)]
pub(super) struct F32x16(__m512);

macro_rules! operator {
    ($name:ident, $trait:ident, $method:ident, $instruction:ident) => {
        impl $trait for $name {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                // SAFETY: invariant of this file.
                Self(unsafe { $instruction(self.0, o.0) })
            }
        }
    };
}

macro_rules! operators {
    ($name:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $xor:ident, $set1:ident) => {
        operator!($name, Add, add, $add);
        operator!($name, Sub, sub, $sub);
        operator!($name, Mul, mul, $mul);
        operator!($name, Div, div, $div);
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: invariant of this file.
                Self(unsafe { $xor(self.0, $set1(-0.0)) })
            }
        }
    };
}

operators!(
    F32x8,
    _mm256_add_ps,
    _mm256_sub_ps,
    _mm256_mul_ps,
    _mm256_div_ps,
    _mm256_xor_ps,
    _mm256_set1_ps
);
operators!(
    F32x16,
    _mm512_add_ps,
    _mm512_sub_ps,
    _mm512_mul_ps,
    _mm512_div_ps,
    _mm512_xor_ps,
    _mm512_set1_ps
);

/// The methods of [`Arithmetic`] that differ in nothing but the names of the instructions.
macro_rules! shared_methods {
    ($width:literal, $set1:ident, $fma:ident, $sqrt:ident, $min:ident, $max:ident) => {
        const WIDTH: usize = $width;

        #[inline(always)]
        fn splat(value: f64) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $set1(value as f32) })
        }
        #[inline(always)]
        fn mul_add(self, a: Self, b: Self) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $fma(self.0, a.0, b.0) })
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

macro_rules! memory {
    ($name:ident, $width:literal, $load:ident, $store:ident) => {
        impl Real32 for $name {
            #[inline(always)]
            fn load(from: &[f32]) -> Self {
                let from = &from[..$width];
                // SAFETY: `from` is `$width` singles long; they need not be aligned.
                Self(unsafe { $load(from.as_ptr()) })
            }
            #[inline(always)]
            fn store(self, to: &mut [f32]) {
                let to = &mut to[..$width];
                // SAFETY: `to` is `$width` singles long; they need not be aligned.
                unsafe { $store(to.as_mut_ptr(), self.0) }
            }
        }
    };
}

memory!(F32x8, 8, _mm256_loadu_ps, _mm256_storeu_ps);
memory!(F32x16, 16, _mm512_loadu_ps, _mm512_storeu_ps);

impl Arithmetic for F32x8 {
    type Mask = __m256;
    shared_methods!(
        8,
        _mm256_set1_ps,
        _mm256_fmadd_ps,
        _mm256_sqrt_ps,
        _mm256_min_ps,
        _mm256_max_ps
    );

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> __m256 {
        // SAFETY: invariant of this file.
        unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> __m256 {
        // SAFETY: invariant of this file.
        unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn select(mask: __m256, a: Self, b: Self) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { _mm256_blendv_ps(b.0, a.0, mask) })
    }
    #[inline(always)]
    fn and(a: __m256, b: __m256) -> __m256 {
        // SAFETY: invariant of this file.
        unsafe { _mm256_and_ps(a, b) }
    }
    #[inline(always)]
    fn or(a: __m256, b: __m256) -> __m256 {
        // SAFETY: invariant of this file.
        unsafe { _mm256_or_ps(a, b) }
    }
    #[inline(always)]
    fn bits(mask: __m256) -> u32 {
        // SAFETY: invariant of this file.
        unsafe { _mm256_movemask_ps(mask).cast_unsigned() }
    }
}

impl Arithmetic for F32x16 {
    type Mask = __mmask16;
    shared_methods!(
        16,
        _mm512_set1_ps,
        _mm512_fmadd_ps,
        _mm512_sqrt_ps,
        _mm512_min_ps,
        _mm512_max_ps
    );

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { _mm512_abs_ps(self.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> __mmask16 {
        // SAFETY: invariant of this file.
        unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> __mmask16 {
        // SAFETY: invariant of this file.
        unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn select(mask: __mmask16, a: Self, b: Self) -> Self {
        // SAFETY: invariant of this file.
        Self(unsafe { _mm512_mask_blend_ps(mask, b.0, a.0) })
    }
    #[inline(always)]
    fn and(a: __mmask16, b: __mmask16) -> __mmask16 {
        a & b
    }
    #[inline(always)]
    fn or(a: __mmask16, b: __mmask16) -> __mmask16 {
        a | b
    }
    #[inline(always)]
    fn bits(mask: __mmask16) -> u32 {
        u32::from(mask)
    }
}
