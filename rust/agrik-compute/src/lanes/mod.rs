//! The number type of every hot loop: one trait, from a plain `f64` to SIMD vectors.
//!
//! Kinematics, task errors, normal matrices, factorisations and limit handling are
//! written once against [`Real`]. With `f64` a loop solves one target; with a vector
//! type it solves one target per lane. Operations never mix lanes, so a lane's result
//! does not depend on its neighbours.

mod arithmetic;
mod dispatch;
mod dispatch_singles;
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(target_arch = "aarch64")]
mod neon_singles;
mod plain_singles;
mod scalar;
mod trig;
mod vector;
mod words;
#[cfg(target_arch = "x86_64")]
mod x86;
#[cfg(target_arch = "x86_64")]
mod x86_singles;
#[cfg(target_arch = "x86_64")]
mod x86_words;

pub use arithmetic::{Arithmetic, Real32};
pub use dispatch::{Kernel, Level, VARIABLE, dispatch, dispatch_single};
pub use dispatch_singles::{Kernel32, dispatch_eights, dispatch_singles};
pub use trig::{
    CHORD2, angle_over_sine, atan2, atan2_each, atan2_rough, sin_cos_by_quadrant, squared_angles,
    turns_each,
};
pub use vector::{
    V3, axpy, blend, cross, difference, dot, negate, norm, scale, select3, splat3, sub,
};
pub use words::Words;

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// Lanes (one bit each) in which something holds.
pub type Lanes = u32;

/// Lanes of the widest vector there is.
pub const WIDEST: usize = 8;

/// A number, or a vector of numbers processed in step ("lanes").
pub trait Real:
    Copy
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// How many independent numbers one value holds.
    const WIDTH: usize;
    /// One truth value per lane.
    type Mask: Copy;
    /// One number with the roundings of this type.
    type Single: Real;
    /// The bits of the numbers, one word per lane.
    type Words: Words;

    /// The same number in every lane.
    fn splat(value: f64) -> Self;
    /// The number in lane `index` (below [`Real::WIDTH`]).
    fn lane(&self, index: usize) -> f64;
    /// Replaces the number in lane `index` (below [`Real::WIDTH`]).
    fn set_lane(&mut self, index: usize, value: f64);

    /// The first [`Real::WIDTH`] numbers of a slice, which holds at least as many.
    #[inline(always)]
    fn load(from: &[f64]) -> Self {
        let mut loaded = Self::splat(0.0);
        for (lane, x) in from[..Self::WIDTH].iter().enumerate() {
            loaded.set_lane(lane, *x);
        }
        loaded
    }

    /// Writes the numbers over the first ones of a slice, which holds at least as many.
    #[inline(always)]
    fn store(&self, to: &mut [f64]) {
        for (lane, x) in to[..Self::WIDTH].iter_mut().enumerate() {
            *x = self.lane(lane);
        }
    }

    /// `self * a + b`, fused where the hardware level has it.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// `b - self * a`, fused where the hardware level has it.
    #[inline(always)]
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        (-self).mul_add(a, b)
    }
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The smaller number; `other` where `self` is not a number.
    fn min(self, other: Self) -> Self;
    /// The larger number; `other` where `self` is not a number.
    fn max(self, other: Self) -> Self;
    /// Nearest integer.
    fn round(self) -> Self;

    /// `self < other`, false where either is not a number.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`, false where either is not a number.
    fn le(self, other: Self) -> Self::Mask;
    /// `a` where the mask holds, else `b`.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// Both masks hold.
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// At least one of the masks holds.
    fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// One bit per lane, lane 0 lowest.
    fn bits(mask: Self::Mask) -> u32;
    /// The mask whose lane `i` holds where bit `i` is set.
    fn mask_from_bits(bits: u32) -> Self::Mask;

    /// The numbers of these bits.
    fn from_words(words: Self::Words) -> Self;
    /// The bits of the numbers.
    fn to_words(self) -> Self::Words;
    /// True where the highest bit of a word is set.
    fn highest_bits(words: Self::Words) -> Self::Mask;

    /// Exchanges rows and columns of the square that the first [`Real::WIDTH`] values of a
    /// slice are; it holds at least as many.
    #[inline(always)]
    fn transpose(square: &mut [Self]) {
        for row in 1..Self::WIDTH {
            for lane in 0..row {
                let above = square[lane].lane(row);
                square[lane].set_lane(row, square[row].lane(lane));
                square[row].set_lane(lane, above);
            }
        }
    }

    /// Sine and cosine, at most 2 units in the last place off for |x| <= 1e4.
    fn sin_cos(self) -> (Self, Self);

    /// The number zero in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
}

/// `sqrt(x^2 + y^2)` of numbers whose squares neither overflow nor vanish.
///
/// The C library's `hypot` rounds differently from platform to platform, and binds a wheel
/// to a newer C library than all else here does.
#[inline(always)]
pub fn hypotenuse(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}
