//! A plain array as [`Real`]: the portable vector, left to the compiler to put into
//! whatever registers the target has (NEON on aarch64).

use std::array::from_fn;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::Real;

/// `N` numbers processed in step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pack<const N: usize>([f64; N]);

impl<const N: usize> Pack<N> {
    #[inline(always)]
    fn zip(self, o: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(from_fn(|i| f(self.0[i], o.0[i])))
    }
}

impl<const N: usize> Add for Pack<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.zip(o, |a, b| a + b)
    }
}
impl<const N: usize> Sub for Pack<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self.zip(o, |a, b| a - b)
    }
}
impl<const N: usize> Mul for Pack<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.zip(o, |a, b| a * b)
    }
}
impl<const N: usize> Div for Pack<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        self.zip(o, |a, b| a / b)
    }
}
impl<const N: usize> Neg for Pack<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}
impl<const N: usize> AddAssign for Pack<N> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl<const N: usize> SubAssign for Pack<N> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}
impl<const N: usize> MulAssign for Pack<N> {
    #[inline(always)]
    fn mul_assign(&mut self, o: Self) {
        *self = *self * o;
    }
}

impl<const N: usize> Real for Pack<N> {
    const WIDTH: usize = N;
    type Mask = [bool; N];
    type Single = Pack<1>;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    fn lane(&self, index: usize) -> f64 {
        self.0[index]
    }
    #[inline(always)]
    fn set_lane(&mut self, index: usize, value: f64) {
        self.0[index] = value;
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        // Only aarch64 fuses without being asked at run time; see `scalar`.
        Self(from_fn(|i| {
            if cfg!(target_arch = "aarch64") {
                f64::mul_add(self.0[i], a.0[i], b.0[i])
            } else {
                self.0[i] * a.0[i] + b.0[i]
            }
        }))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, Real::min)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, Real::max)
    }
    #[inline(always)]
    fn round(self) -> Self {
        Self(self.0.map(Real::round))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> [bool; N] {
        from_fn(|i| self.0[i] < other.0[i])
    }
    #[inline(always)]
    fn le(self, other: Self) -> [bool; N] {
        from_fn(|i| self.0[i] <= other.0[i])
    }
    #[inline(always)]
    fn select(mask: [bool; N], a: Self, b: Self) -> Self {
        Self(from_fn(|i| if mask[i] { a.0[i] } else { b.0[i] }))
    }
    #[inline(always)]
    fn and(a: [bool; N], b: [bool; N]) -> [bool; N] {
        from_fn(|i| a[i] & b[i])
    }
    #[inline(always)]
    fn or(a: [bool; N], b: [bool; N]) -> [bool; N] {
        from_fn(|i| a[i] | b[i])
    }
    #[inline(always)]
    fn bits(mask: [bool; N]) -> u32 {
        mask.iter().enumerate().fold(0, |bits, (i, m)| bits | u32::from(*m) << i)
    }
    #[inline(always)]
    fn mask_from_bits(bits: u32) -> [bool; N] {
        from_fn(|i| bits >> i & 1 != 0)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let both = self.0.map(Real::sin_cos);
        (Self(from_fn(|i| both[i].0)), Self(from_fn(|i| both[i].1)))
    }
}
