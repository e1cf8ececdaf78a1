//! Vectors of 4 (AVX2) and 8 words (AVX-512) as [`Words`].
//!
//! # Safety
//!
//! The invariant of [`super::x86`]: values of these types come to be only on a processor
//! that has the instructions. Loads and stores ask the slice for its length first.

#![allow(unsafe_code)]

use std::arch::x86_64::*;

use super::words::Words;

/// Four words in an AVX register.
#[derive(Debug, Clone, Copy)]
pub struct U64x4(pub(super) __m256i);

/// Eight words in an AVX-512 register.
#[derive(Debug, Clone, Copy)]
pub struct U64x8(pub(super) __m512i);

macro_rules! words {
    (
        $width:literal, $splat:ident, $load:ident, $store:ident, $add:ident,
        $mul:ident, $xor:ident, $or:ident, $up:ident, $down:ident, $fields:ident
    ) => {
        const WIDTH: usize = $width;

        #[inline(always)]
        fn splat(word: u64) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $splat(word.cast_signed()) })
        }
        #[inline(always)]
        fn load(from: &[u64]) -> Self {
            let from = &from[..$width];
            // SAFETY: `from` is `$width` words long; they need not be aligned.
            Self(unsafe { $load(from.as_ptr().cast()) })
        }
        #[inline(always)]
        fn store(self, to: &mut [u64]) {
            let to = &mut to[..$width];
            // SAFETY: `to` is `$width` words long; they need not be aligned.
            unsafe { $store(to.as_mut_ptr().cast(), self.0) }
        }
        #[inline(always)]
        fn plus(self, other: Self) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $add(self.0, other.0) })
        }
        #[inline(always)]
        fn product(self, other: Self) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $mul(self.0, other.0) })
        }
        #[inline(always)]
        fn xor(self, other: Self) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $xor(self.0, other.0) })
        }
        #[inline(always)]
        fn or(self, other: Self) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $or(self.0, other.0) })
        }
        #[inline(always)]
        fn up<const BY: i32>(self) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $up(self.0, _mm_cvtsi32_si128(BY)) })
        }
        #[inline(always)]
        fn down<const BY: i32>(self) -> Self {
            // SAFETY: invariant of this file.
            Self(unsafe { $down(self.0, _mm_cvtsi32_si128(BY)) })
        }
        #[inline(always)]
        fn equal_fields(self, other: Self) -> Self {
            $fields!(_mm256_cmpeq_epi16, self.0, other.0)
        }
        #[inline(always)]
        fn fields_below(self, other: Self) -> Self {
            $fields!(_mm256_cmpgt_epi16, other.0, self.0)
        }
        #[inline(always)]
        fn smaller_fields(self, other: Self) -> Self {
            $fields!(_mm256_min_epi16, self.0, other.0)
        }
    };
}

/// An instruction on fields.
macro_rules! whole {
    ($instruction:ident, $a:expr, $b:expr) => {
        // SAFETY: invariant of this file.
        Self(unsafe { $instruction($a, $b) })
    };
}

/// The same on either half of a register: on the whole of it they would need AVX-512BW.
macro_rules! halves {
    ($instruction:ident, $a:expr, $b:expr) => {{
        let (a, b) = ($a, $b);
        // SAFETY: invariant of this file.
        unsafe {
            let low = $instruction(_mm512_castsi512_si256(a), _mm512_castsi512_si256(b));
            let high =
                $instruction(_mm512_extracti64x4_epi64::<1>(a), _mm512_extracti64x4_epi64::<1>(b));
            Self(_mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high))
        }
    }};
}

impl Words for U64x4 {
    words!(
        4,
        _mm256_set1_epi64x,
        _mm256_loadu_si256,
        _mm256_storeu_si256,
        _mm256_add_epi64,
        _mm256_mul_epu32,
        _mm256_xor_si256,
        _mm256_or_si256,
        _mm256_sll_epi64,
        _mm256_srl_epi64,
        whole
    );
}

impl Words for U64x8 {
    words!(
        8,
        _mm512_set1_epi64,
        _mm512_loadu_si512,
        _mm512_storeu_si512,
        _mm512_add_epi64,
        _mm512_mul_epu32,
        _mm512_xor_si512,
        _mm512_or_si512,
        _mm512_sll_epi64,
        _mm512_srl_epi64,
        halves
    );
}
