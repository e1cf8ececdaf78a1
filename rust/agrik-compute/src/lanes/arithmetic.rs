//! What the numbers of both precisions can do: one trait below [`Real`] and [`Real32`].
//!
//! A formula written against [`Arithmetic`] works on a plain `f64`, on doubles in lanes and
//! on singles in lanes.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Real;

/// A number, or a vector of numbers processed in step ("lanes"), of either precision.
pub trait Arithmetic:
    Copy
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// How many independent numbers one value holds.
    const WIDTH: usize;
    /// One truth value per lane.
    type Mask: Copy;

    /// The same number in every lane, rounded to the precision of the type.
    fn splat(value: f64) -> Self;
    /// `self * a + b`, fused where the hardware level has it.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The smaller number; `other` where `self` is not a number.
    fn min(self, other: Self) -> Self;
    /// The larger number; `other` where `self` is not a number.
    fn max(self, other: Self) -> Self;
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
}

/// Singles in lanes, for what is only weighed up and not answered: twice as many to a
/// register as doubles, and about 7 digits.
pub trait Real32: Arithmetic {
    /// The first [`Arithmetic::WIDTH`] numbers of a slice, which holds at least as many.
    fn load(from: &[f32]) -> Self;
    /// Writes the numbers over the first ones of a slice, which holds at least as many.
    fn store(self, to: &mut [f32]);
}

impl<R: Real> Arithmetic for R {
    const WIDTH: usize = <R as Real>::WIDTH;
    type Mask = <R as Real>::Mask;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        <R as Real>::splat(value)
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Real::mul_add(self, a, b)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Real::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Real::abs(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Real::min(self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Real::max(self, other)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> <R as Real>::Mask {
        Real::lt(self, other)
    }
    #[inline(always)]
    fn le(self, other: Self) -> <R as Real>::Mask {
        Real::le(self, other)
    }
    #[inline(always)]
    fn select(mask: <R as Real>::Mask, a: Self, b: Self) -> Self {
        <R as Real>::select(mask, a, b)
    }
    #[inline(always)]
    fn and(a: <R as Real>::Mask, b: <R as Real>::Mask) -> <R as Real>::Mask {
        <R as Real>::and(a, b)
    }
    #[inline(always)]
    fn or(a: <R as Real>::Mask, b: <R as Real>::Mask) -> <R as Real>::Mask {
        <R as Real>::or(a, b)
    }
    #[inline(always)]
    fn bits(mask: <R as Real>::Mask) -> u32 {
        <R as Real>::bits(mask)
    }
}
