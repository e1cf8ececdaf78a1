//! A number type that counts floating-point operations while it computes.

use std::cell::Cell;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use agrik::lanes::{Real, sin_cos_by_quadrant};

thread_local! {
    static OPERATIONS: Cell<u64> = const { Cell::new(0) };
}

/// Floating-point operations of this thread since the last call: additions, subtractions,
/// multiplications, divisions and square roots count one each, a fused multiply-add two.
/// Signs, comparisons and choices between numbers count nothing.
pub fn take_operations() -> u64 {
    OPERATIONS.replace(0)
}

fn count(operations: u64) {
    OPERATIONS.set(OPERATIONS.get() + operations);
}

/// A double with the roundings of the vector types, so that a solver takes the same steps.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Counted(f64);

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Counted {
            type Output = Self;
            fn $method(self, o: Self) -> Self {
                count(1);
                Self(self.0 $op o.0)
            }
        }
    };
}
macro_rules! assignment {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Counted {
            fn $method(&mut self, o: Self) {
                *self = *self $op o;
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);
assignment!(AddAssign, add_assign, +);
assignment!(SubAssign, sub_assign, -);
assignment!(MulAssign, mul_assign, *);

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Real for Counted {
    const WIDTH: usize = 1;
    type Mask = bool;
    type Single = Self;
    type Words = u64;

    fn splat(value: f64) -> Self {
        Self(value)
    }
    fn lane(&self, _index: usize) -> f64 {
        self.0
    }
    fn set_lane(&mut self, _index: usize, value: f64) {
        self.0 = value;
    }
    fn mul_add(self, a: Self, b: Self) -> Self {
        count(2);
        Self(self.0.mul_add(a.0, b.0))
    }
    fn sqrt(self) -> Self {
        count(1);
        Self(self.0.sqrt())
    }
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    fn round(self) -> Self {
        // The vector types add and subtract a large number.
        count(2);
        Self(self.0.round_ties_even())
    }
    fn lt(self, other: Self) -> bool {
        self < other
    }
    fn le(self, other: Self) -> bool {
        self <= other
    }
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
    fn and(a: bool, b: bool) -> bool {
        a & b
    }
    fn or(a: bool, b: bool) -> bool {
        a | b
    }
    fn bits(mask: bool) -> u32 {
        u32::from(mask)
    }
    fn mask_from_bits(bits: u32) -> bool {
        bits & 1 != 0
    }
    fn from_words(words: u64) -> Self {
        Self(f64::from_bits(words))
    }
    fn to_words(self) -> u64 {
        self.0.to_bits()
    }
    fn highest_bits(words: u64) -> bool {
        words >> 63 != 0
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos, counted) = sin_cos_by_quadrant(self);
        let quadrant = counted.0.to_bits();
        let (s, c) = if quadrant & 1 == 0 { (sin, cos) } else { (cos, sin) };
        let s = if quadrant & 2 == 0 { s } else { -s };
        let c = if quadrant.wrapping_add(1) & 2 == 0 { c } else { -c };
        (s, c)
    }
}
